"""Replaces the line numbers in compiled Python with line numbers of the source file.

Replacing them in the code takes a fraction of the time and memory that an `ast` tree would need. A code
object stores them as a table of entries, each for up to eight two-byte units:

    1 kkkk nnn    kind k and n + 1 units; then the data of the kind
    kind 13       no columns: the difference to the line before, signed, six bits a byte
    kind 15       no line

[CPython 3.11 to 3.14, InternalDocs/locations.md]
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from types import CodeType

_MOST_UNITS = 8
_BYTES_OF_UNIT = 2
_LINE, _NO_LINE = 13, 15


def relocated(code: CodeType, lines: Sequence[int]) -> CodeType:
    """Return code, including nested code, with new line numbers: line `n` gets `lines[n - 1]`."""
    first = line = lines[code.co_firstlineno - 1]
    table = bytearray()
    offset = 0
    for new, until in _stretches(code, lines):
        table += _entries((until - offset) // _BYTES_OF_UNIT, None if new is None else new - line)
        offset, line = until, line if new is None else new
    inner = tuple(
        relocated(constant, lines) if isinstance(constant, CodeType) else constant
        for constant in code.co_consts
    )
    return code.replace(co_linetable=bytes(table), co_firstlineno=first, co_consts=inner)


def _stretches(code: CodeType, lines: Sequence[int]) -> Iterator[tuple[int | None, int]]:
    """Yield the new line number and the end offset of each stretch of code."""
    line, until = None, 0
    for start, end, old in code.co_lines():
        new = None if old is None else lines[old - 1]
        if new != line and start:
            yield line, until
        line, until = new, end
    yield line, until


def _entries(units: int, difference: int | None) -> bytes:
    """Return the line table entries for code units of one line.

    >>> _entries(2, 3).hex(), _entries(9, -1).hex(), _entries(1, None).hex(), _entries(1, 40).hex()
    ('e906', 'ef03e800', 'f8', 'e85001')
    """
    encoded = bytearray()
    while units > 0:
        count = min(units, _MOST_UNITS)
        kind = _NO_LINE if difference is None else _LINE
        encoded.append(0x80 | kind << 3 | count - 1)
        if difference is not None:
            encoded += _signed(difference)
            difference = 0
        units -= count
    return bytes(encoded)


def _signed(number: int) -> bytes:
    """Encode a number with six bits per byte, lowest bits first and the sign in the lowest bit."""
    zigzag = -number << 1 | 1 if number < 0 else number << 1
    encoded = bytearray()
    while zigzag > 0x3F:
        encoded.append(0x40 | zigzag & 0x3F)
        zigzag >>= 6
    encoded.append(zigzag)
    return bytes(encoded)
