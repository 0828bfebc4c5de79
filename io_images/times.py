"""Reads and writes times as text, for rack files, queries, programs, options and messages.

A time is a decimal number with a unit, such as `10 s`, `1.5ms` or `250 us`: digits with or without a
fraction, optional spaces, and a unit of `UNITS_NS`. Spaces around a time are ignored. A time must be a whole
number of nanoseconds, at most `LONGEST_NS`; nothing is rounded.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Clamped, Context, Decimal, Inexact, InvalidOperation, Overflow

from .site import SettingError
from .text_limits import shortened

UNITS_NS: Mapping[str, int] = {
    "ns": 1,
    "us": 1_000,
    "µs": 1_000,
    "ms": 1_000_000,
    "s": 1_000_000_000,
    "min": 60_000_000_000,
    "h": 3_600_000_000_000,
}
"""Length of each unit, ns."""

LONGEST_NS = 2**62
"""Longest time, ns: 146 years."""

_NUMBER, _UNIT = r"[0-9]+(?:\.[0-9]+)?", "|".join(UNITS_NS)
TIME = rf"{_NUMBER}\s*(?:{_UNIT})"
"""Pattern of a time, for use in grammars."""

DEFAULT_RUN = "10 s"
"""Default length of a run in virtual time."""

_TIME = re.compile(rf"({_NUMBER})\s*({_UNIT})")
_EXACT = Context(prec=100, traps=[Clamped, Inexact, InvalidOperation, Overflow])
_UNITS_OF_TEXTS = ("s", "ms", "µs", "ns")


def parse_time(text: str) -> int:
    """Return a time in ns, 0 or more.

    >>> parse_time("0 s"), parse_time("250us"), parse_time("1.5 min")
    (0, 250000, 90000000000)

    Raises:
        ValueError: the text is not a number and a unit, or the time is not a whole number of ns, or is longer
            than `LONGEST_NS`.
    """
    match = _TIME.fullmatch(str(text).strip())
    if match is None:
        units = ", ".join(UNITS_NS)
        raise ValueError(
            f"{shortened(str(text))!r} is not a time: write a number and a unit ({units}), such as '10 s'"
        )
    return _whole_ns(Decimal(match[1]), match[2], repr(shortened(str(text))))


def parse_duration(text: str) -> int:
    """Return a duration of a run in ns, 1 or more.

    >>> parse_duration("10 s"), parse_duration("2.5ms"), parse_duration("1 min")
    (10000000000, 2500000, 60000000000)

    Raises:
        ValueError: as in `parse_time`, or the duration is 0.
    """
    duration = parse_time(text)
    if duration < 1:
        raise ValueError(f"{text!r} is not a time to run for: it must be more than 0")
    return duration


def exact_ns(value: Decimal | float, unit: str, key: str = "time") -> int:
    """Convert a number in a unit to ns; a float counts as its shortest decimal.

    >>> exact_ns(Decimal("0.25"), "ms"), exact_ns(600, "s"), exact_ns(0.1, "ms")
    (250000, 600000000000, 100000)

    Raises:
        SettingError: it is not a whole number of ns, or is longer than `LONGEST_NS`.
    """
    number = value if isinstance(value, Decimal) else Decimal(str(value))
    try:
        return _whole_ns(number, unit, f"{key} of {value} {unit}")
    except ValueError as error:
        raise SettingError(key, str(error)) from None


def _whole_ns(number: Decimal, unit: str, name: str) -> int:
    """Return a number in a unit as ns; raise a ValueError if it is not a whole number or is too long."""
    try:
        time_ns = _EXACT.multiply(number, UNITS_NS[unit])
        if time_ns > LONGEST_NS:
            raise ValueError(f"{name} is longer than 146 years, the longest time")
        return int(_EXACT.quantize(time_ns, Decimal(1)))
    except (Clamped, Inexact, InvalidOperation, Overflow):
        raise ValueError(f"{name} is not a whole number of nanoseconds") from None


def time_text(time_ns: int) -> str:
    """Return a time as exact text for `parse_time`, in the largest unit with the shortest text.

    >>> time_text(9_422_000_000), time_text(250_000), time_text(400), time_text(0)
    ('9.422 s', '250 µs', '400 ns', '0 s')
    """
    unit = next((unit for unit in _UNITS_OF_TEXTS if abs(time_ns) >= UNITS_NS[unit]), "s")
    return f"{_in_unit(time_ns, UNITS_NS[unit])} {unit}"


def seconds(time_ns: int) -> str:
    """Return a time since power-up as exact text, in seconds.

    >>> seconds(1_498_174_000_000), seconds(5), seconds(0)
    ('1498.174', '0.000000005', '0')
    """
    return _in_unit(time_ns, 1_000_000_000)


def seconds_column(time_ns: int) -> str:
    """Return a time as `seconds` does, but with at least three decimals, for use in a column.

    >>> seconds_column(12_000_000), seconds_column(1_000_250_000)
    ('0.012', '1.00025')
    """
    whole_seconds, _, decimals = seconds(time_ns).partition(".")
    return f"{whole_seconds}.{decimals:0<3}"


def milliseconds(time_ns: int) -> str:
    """Return a time as exact text, in milliseconds.

    >>> milliseconds(20_000_000), milliseconds(400)
    ('20', '0.0004')
    """
    return _in_unit(time_ns, 1_000_000)


def _in_unit(time_ns: int, unit_ns: int) -> str:
    """Return a time in a unit as an exact decimal number, without trailing zeros."""
    whole_units, fraction_ns = divmod(abs(time_ns), unit_ns)
    decimals = f".{fraction_ns:0{len(str(unit_ns)) - 1}d}".rstrip("0") if fraction_ns else ""
    return f"{'-' * (time_ns < 0)}{whole_units}{decimals}"
