"""Reads single values from text: whole numbers in any radix, reals, characters, dates and durations."""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Callable

from scanrack.ladder.model.arithmetic import real, wrap
from scanrack.ladder.model.quoting import unquoted
from scanrack.ladder.model.types import Elementary

_RADIX = re.compile(r"(16|8|2)#([0-9A-Fa-f_]+)")
_DATE = re.compile(
    r"L?DT#(\d{4})-(\d\d)-(\d\d)-(\d\d):(\d\d):(\d\d)(?:\.([\d_]+))?"
    r"(?:Z|\(UTC([+-])(\d\d):(\d\d)\))?",
    re.IGNORECASE,
)
_DURATION = re.compile(
    r"(LT|T|T32|LTIME|TIME|TIME32)#([+-]?)((?:_?\d{1,19}(?:\.\d{1,9})?(?:d|h|ms|m|us|ns|s))++)", re.IGNORECASE
)
_PART = re.compile(r"(\d+)(?:\.(\d+))?([a-z]+)")
_NANOSECONDS = {
    "d": 86_400_000_000_000,
    "h": 3_600_000_000_000,
    "m": 60_000_000_000,
    "s": 1_000_000_000,
    "ms": 1_000_000,
    "us": 1000,
    "ns": 1,
}

TRUTH = {"true": "1", "false": "0"}
"""Texts of BOOLs, in lowercase."""


class ValueTextError(ValueError):
    """The text of a value can't be read."""


def ignored(_text: str) -> None:
    """Ignore a remark."""


def value_of(text: str, kind: Elementary, remark: Callable[[str], None] = ignored) -> bool | int | float:
    """Return a value from text in any radix, truncated to the type's bits.

    Raises:
        ValueTextError: the text is not a value of the type.
    """
    if kind.is_double:
        return _real_of(text)
    if kind.is_real:
        return _single_of(text, kind, remark)
    is_pattern = False  # whether the text gives the bits, so that 16#FFFF is -1 as an INT
    try:
        number = int(text)
    except ValueError:
        is_pattern = "#" in text or "'" in text
        number = _integer_of(text.strip())
    if kind.is_bool:
        if number not in (0, 1):
            remark(f"{text} is not a BOOL: it starts with {number & 1}")
        return bool(number & 1)
    if kind.lowest <= number <= kind.highest:
        return number
    truncated = wrap(number, kind.wraps)
    if not is_pattern or number >> kind.bits not in (0, -1):
        remark(f"{text} does not fit {kind.name}: it starts with {truncated}")
    return truncated


def _single_of(text: str, kind: Elementary, remark: Callable[[str], None]) -> float:
    """Return a REAL, rounded to single precision."""
    value = _real_of(text)
    if math.isfinite(value) and math.isinf(real(value)):
        remark(f"{text} does not fit {kind.name}: it starts as infinite")
    return real(value)


def _integer_of(text: str) -> int:
    """Return an integer from a radix, characters, a date, a duration, a Boolean or a rounded number."""
    radix = _RADIX.fullmatch(text)
    if radix:
        try:
            return int(radix[2].replace("_", ""), int(radix[1]))
        except ValueError:
            raise ValueTextError(f"{text!r} has digits that radix {radix[1]} lacks") from None
    if text[:1] == "'" == text[-1:] and len(text) > 1:
        return int.from_bytes(unquoted_or_raise(text).encode("latin-1", "replace"), "big")
    date = _DATE.fullmatch(text)
    if date:
        return _date_of(date)
    duration = _DURATION.fullmatch(text)
    if duration:
        return _duration_of(duration)
    if text.lower() in TRUTH:
        return int(TRUTH[text.lower()])
    value = _real_of(text)
    if math.isfinite(value):
        return round(value)
    raise ValueTextError(f"{text!r} is not a whole number")


def unquoted_or_raise(text: str) -> str:
    """Return the characters of a literal with or without quotes.

    Raises:
        ValueTextError: an escape is invalid.
    """
    if text[:1] == "'" == text[-1:] and len(text) > 1:
        text = text[1:-1]
    try:
        return unquoted(text)
    except ValueError as error:
        raise ValueTextError(str(error)) from None


def _date_of(date: re.Match[str]) -> int:
    """Return the time from 1970 to a date, in µs for DT# and in ns for LDT#."""
    try:
        moment = datetime.datetime(*(int(group) for group in date.groups()[:6]))  # type: ignore[arg-type]
    except ValueError:
        raise ValueTextError(f"{date.group()!r} is not a date") from None
    seconds = round((moment - datetime.datetime(1970, 1, 1)).total_seconds())
    fraction, offset_sign, offset_hours, offset_minutes = date.groups()[6:]
    if offset_sign:
        offset = int(offset_hours) * 3600 + int(offset_minutes) * 60
        seconds -= offset if offset_sign == "+" else -offset
    digits = 9 if date.group()[0] in "Ll" else 6
    fraction_digits = (fraction or "").replace("_", "").ljust(digits, "0")[:digits]
    return seconds * int(10**digits) + int(fraction_digits)


def _duration_of(duration: re.Match[str]) -> int:
    """Return a duration, in µs for T# and T32# and in ns for LT#."""
    prefix, sign, parts = duration.groups()
    total_ns = 0
    for whole, fraction, unit in _PART.findall(parts.lower()):
        unit_ns = _NANOSECONDS[unit]
        total_ns += int(whole) * unit_ns + int(fraction.ljust(9, "0")) * unit_ns // 10**9
    amount = total_ns if prefix[0] in "Ll" else total_ns // 1000
    return -amount if sign == "-" else amount


def _real_of(text: str) -> float:
    """Return a real number, including infinity and not-a-number in Logix notation, such as `1.$`."""
    text = text.strip()
    try:
        return float(text)
    except ValueError:
        pass
    unsigned = text.upper().lstrip("+-")
    if unsigned.startswith(("1.$", "1.#INF")):
        return -math.inf if text.startswith("-") else math.inf
    if unsigned.startswith("1.#"):
        return math.nan
    if _RADIX.fullmatch(text):
        return float(_integer_of(text))
    raise ValueTextError(f"{text!r} is not a number")
