"""Times as text, in nanoseconds."""

from __future__ import annotations

import re

from ....io_images.times import UNITS_NS

_TIME = re.compile(rf"(\d+)(?:\.(\d+))? ?({'|'.join(UNITS_NS)})")


def duration_ns(text: str) -> int:
    """Return a time in whole nanoseconds from a number and its unit.

    >>> duration_ns("2 s"), duration_ns("1.5ms"), duration_ns("250 ns")
    (2000000000, 1500000, 250)

    Raises:
        ValueError: no number, no unit, or a part of a nanosecond.
    """
    match = _TIME.fullmatch(str(text))
    if match is None:
        units = ", ".join(UNITS_NS)
        raise ValueError(
            f'{text!r} is not a time: write a number and its unit, such as "2 s"; units are {units}'
        )
    whole, decimals, unit = match[1], match[2] or "", UNITS_NS[match[3]]
    ns, rest = divmod(int(whole + decimals) * unit, int("1" + "0" * len(decimals)))
    if rest:
        raise ValueError(f"{text!r} is not a whole number of nanoseconds")
    return ns
