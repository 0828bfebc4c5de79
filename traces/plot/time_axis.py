"""Ticks and labels of a time axis."""

from __future__ import annotations

_S = 1_000_000_000
_MIN, _H = 60 * _S, 3600 * _S

STEPS_NS: tuple[int, ...] = (
    *(factor * 10**power for power in range(9) for factor in (1, 2, 5)),
    *(seconds * _S for seconds in (1, 2, 5, 10, 15, 30)),
    *(minutes * _MIN for minutes in (1, 2, 5, 10, 15, 30)),
    *(hours * _H for hours in (1, 2, 4, 6, 12, 24, 48, 96, 240, 720, 2400)),
)
"""Distances between ticks, ns, in decimal units below a second and clock units above."""


def tick_step(start_ns: int, end_ns: int, most: int) -> int:
    """Return the smallest distance between ticks, ns, with at most `most` ticks after the first.

    >>> tick_step(0, 2_000_000_000, 10), tick_step(0, 7_200_000_000_000, 10)
    (200000000, 900000000000)
    """
    span_ns = end_ns - start_ns
    return next((step for step in STEPS_NS if span_ns // step <= most), STEPS_NS[-1])


def ticks(start_ns: int, end_ns: int, most: int) -> list[int]:
    """Return the ticks between two times.

    >>> ticks(0, 2_000_000_000, 4)
    [0, 500000000, 1000000000, 1500000000, 2000000000]
    """
    step = tick_step(start_ns, end_ns, most)
    return list(range(-(-start_ns // step) * step, end_ns + 1, step))


def unit(start_ns: int, end_ns: int) -> str:
    """Return the unit of an axis's labels.

    >>> unit(0, 50_000_000), unit(0, 90 * 10**9), unit(0, 7200 * 10**9)
    ('s', 's', 'h:min:s')
    """
    return "s" if end_ns < 2 * _MIN else "min:s" if end_ns < _H else "h:min:s"


def label(time_ns: int, step_ns: int, unit: str) -> str:
    """Return a tick's label, with as many decimals as the distance between ticks needs.

    >>> label(1_500_000_000, 500_000_000, "s"), label(5_400_000_000_000, 900_000_000_000, "h:min:s")
    ('1.5', '1:30:00')
    """
    decimals = next((power for power in range(9) if step_ns % 10 ** (9 - power) == 0), 9)
    seconds, fraction_ns = divmod(time_ns, _S)
    fraction = f".{fraction_ns:09d}"[: decimals + 1] if decimals else ""
    if unit == "s":
        return f"{seconds}{fraction}"
    minutes, seconds = divmod(seconds, 60)
    if unit == "min:s":
        return f"{minutes}:{seconds:02d}{fraction}"
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}{fraction}"


def about(first: int, last: int, start_ns: int, end_ns: int) -> str:
    """Return the range of an axis as text.

    >>> about(700, 1700, 1_400_000_000, 3_400_000_000)
    'scans 700 to 1,700, 1.400 to 3.400 s of machine time'
    >>> about(0, 3_600_000, 0, 7_200_000_000_000)
    'scans 0 to 3,600,000, 0:00:00.000 to 2:00:00.000 h:min:s of machine time'
    """
    shown_unit = unit(start_ns, end_ns)
    start, end = (label(time_ns, 1_000_000, shown_unit) for time_ns in (start_ns, end_ns))
    return f"scans {first:,} to {last:,}, {start} to {end} {shown_unit} of machine time"
