"""The string instructions, for both back ends.

They record minor faults. A result of None leaves the destination unchanged.

| code | fault |
|---|---|
| 4/51 | LEN is above the size of DATA; the result is longer than the destination and is truncated |
| 4/52 | a number as a string is longer than the destination |
| 4/53 | the number in a string does not fit its destination |
| 4/56 | a start or a quantity is outside the string |
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any

from ..model import arithmetic
from ..model.errors import SHORT_STRING_CODE, STRING_CODE, STRING_NUMBER_CODE, STRING_PLACE_CODE
from ..model.types import Elementary
from .fault_log import FaultLog
from .regions import converted

_WHOLE = re.compile(rb"-?\d+")
_DECIMAL = re.compile(rb"-?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def record_long_string(faults: FaultLog, site: int, tag: str, length: int, capacity: int) -> None:
    """Record a LEN above the size of DATA."""
    faults.record(site, f"LEN of {tag} is {length!r}, DATA has {capacity} characters", STRING_CODE)


def read_string(
    faults: FaultLog, site: int, tag: Any, first_byte: int, capacity: int, name: str
) -> bytes | None:
    """Return the characters of a STRING in bytes; if LEN exceeds the size of DATA, fault and return None."""
    length = tag.i[first_byte >> 2]
    if length > capacity:
        record_long_string(faults, site, name, length, capacity)
        return None
    return tag.B[first_byte + 4 : first_byte + 4 + length].tobytes() if length > 0 else b""


def store_string(
    faults: FaultLog, site: int, tag: Any, first_byte: int, capacity: int, name: str, value: bytes, code: int
) -> None:
    """Set a STRING in bytes to a result; `code` is the fault for a result that is too long."""
    length = len(value)
    if length > capacity:
        if not check_length(faults, site, name, value, capacity, code):
            return
        value, length = value[:capacity], capacity
    tag.i[first_byte >> 2] = length
    tag.B[first_byte + 4 : first_byte + 4 + capacity] = value.ljust(capacity, b"\0")


def check_length(faults: FaultLog, site: int, name: str, value: bytes, capacity: int, code: int) -> bool:
    """Record a fault if a result does not fit; return whether to store it, truncated if necessary."""
    if size(value) <= capacity:
        return True
    faults.record(site, f"{size(value)!r} characters do not fit {name}, {capacity} do", code)
    return code != SHORT_STRING_CODE


def size(text: bytes) -> int:
    """Return the number of characters; in a proof this is a term, which `len` would not accept."""
    return text.__len__()


# --- CONCAT, INSERT: one string with another


def concat(_faults: FaultLog, _site: int, a: bytes, b: bytes) -> bytes:
    """Return the concatenation of two strings."""
    return a + b


def insert(faults: FaultLog, site: int, into: bytes, inserted: bytes, start: int) -> bytes | None:
    """Return a string with another string inserted at a position, counted from 1."""
    if not 1 <= start <= size(into) + 1:
        _record_place_fault(faults, site, f"start {start!r} is out of range; must be 1 to {size(into) + 1!r}")
        return None
    return into[: start - 1] + inserted + into[start - 1 :]


# --- MID, DELETE: a part of a string


def mid(faults: FaultLog, site: int, text: bytes, count: int, start: int) -> bytes | None:
    """Return `count` characters from a position on, counted from 1."""
    if not _check_part(faults, site, text, count, start):
        return None
    return text[start - 1 : start - 1 + count]


def delete(faults: FaultLog, site: int, text: bytes, count: int, start: int) -> bytes | None:
    """Return a string without `count` characters from a position on, counted from 1."""
    if not _check_part(faults, site, text, count, start):
        return None
    return text[: start - 1] + text[start - 1 + count :]


def _check_part(faults: FaultLog, site: int, text: bytes, count: int, start: int) -> bool:
    """Return whether `count` characters from `start` on are inside the text; record a fault if not."""
    length = size(text)
    if 1 <= start <= length and count >= 0 and start - 1 + count <= length:
        return True
    message = f"{count!r} characters from {start!r} on are not inside of {length!r} characters"
    _record_place_fault(faults, site, message)
    return False


def _record_place_fault(faults: FaultLog, site: int, message: str) -> None:
    faults.record(site, message, STRING_PLACE_CODE)


# --- FIND: the position of a string in another, 0 if it is not there


def find(faults: FaultLog, site: int, text: bytes, searched: bytes, start: int) -> int | None:
    """Return the position, from 1, of a string in another one, searching from `start`; 0 if not found."""
    if not 1 <= start <= size(text):
        _record_place_fault(faults, site, f"start {start!r} is out of range; must be 1 to {size(text)!r}")
        return None
    return text.find(searched, start - 1) + 1


# --- UPPER, LOWER


def upper(_faults: FaultLog, _site: int, text: bytes) -> bytes:
    """Return a string in capitals."""
    return text.upper()


def lower(_faults: FaultLog, _site: int, text: bytes) -> bytes:
    """Return a string in lowercase."""
    return text.lower()


# --- DTOS, RTOS: a number as a string


def dtos(_faults: FaultLog, _site: int, value: int | float) -> bytes:
    """Return an integer as text."""
    return b"%d" % (arithmetic.whole(value) if isinstance(value, float) else value)


def rtos(_faults: FaultLog, _site: int, value: float) -> bytes:
    """Return a REAL as text."""
    text = b"%.9g" % value
    return text if b"." in text or b"e" in text else real_text(float(value)).encode()


def real_text(value: float) -> str:
    """Return a REAL as text with up to nine digits, which are enough to identify it; infinity is `1.$`.

    >>> [real_text(arithmetic.real(value)) for value in (15.3001, 0.5, -2.0, 1e20, 1e39)]
    ['15.3001003', '0.5', '-2.0', '1.00000002e+20', '1.$']
    """
    if value != value:
        return "1.#QNAN"
    if not arithmetic.finite(value):
        return "1.$" if value > 0 else "-1.$"
    text = f"{value:.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


# --- STOD, STOR: the first number in a string


def stod(faults: FaultLog, site: int, text: bytes, kind: Elementary, name: str) -> int | float | None:
    """Return the first integer as a value of a type; None for an empty string."""
    return _number(faults, site, _WHOLE, text, kind, name)


def stor(faults: FaultLog, site: int, text: bytes, kind: Elementary, name: str) -> int | float | None:
    """Return the first decimal number as a value of a type; None for an empty string."""
    return _number(faults, site, _DECIMAL, text, kind, name)


def _number(
    faults: FaultLog, site: int, pattern: re.Pattern[bytes], text: bytes, kind: Elementary, name: str
) -> int | float | None:
    """Return the first number in a text, 0 if none, None for b""; record a fault if it does not fit."""
    if not text:
        return None
    match = pattern.search(text)
    digits = match.group() if match else b"0"
    if kind.is_integer:
        exact = int(digits) if pattern is _WHOLE else int(Decimal(digits.decode()))
        stored: int | float = converted(kind, exact)
        fit = stored == exact
    else:
        stored = converted(kind, float(digits))
        fit = arithmetic.finite(stored)
    if not fit:
        faults.record(site, f"{Decimal(digits.decode())} does not fit {name}", STRING_NUMBER_CODE)
    return stored


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    function.__name__.upper(): function
    for function in (concat, delete, dtos, find, insert, lower, mid, rtos, stod, stor, upper)
}
"""Functions that implement the instructions, by name."""
