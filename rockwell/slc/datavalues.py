"""Values of data files as RSLogix 500 prints them.

| file | an element |
|---|---|
| B, N, S, A, I, O | `-3`, `0XFFF0`, `0FFF0h`, `16#FFF0`, sixteen binary digits |
| L | the same, of 32 bits |
| F | `0.01666667`, `-1.5e+010`, `1.#INF` |
| T, C, R | three words: bits, PRE or LEN, ACC or POS |
| ST | `"a text"` |
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from scanrack.ladder.model.arithmetic import real

from .addresses import STRUCTURED
from .addresses import WORDS as INNER
from .records import DataRecord, DataRow

TEXT_LENGTH = 82
"""Maximum characters of an element in a file of strings (ST)."""

_HEX = re.compile(r"(?:0X|16#)([0-9A-F]{1,16})|([0-9A-F]{1,16})H", re.IGNORECASE)
_DECIMAL = re.compile(r"[+-]?[0-9]{1,18}")


def placed_rows(record: DataRecord, words: int) -> Iterator[tuple[int, DataRow]]:
    """Yield lines of values, each with the number of its first element; an element has `words` values."""
    place = record.begin(words)
    for row in _joined(record.rows, words):
        place = place if row.place is None else row.place
        yield place, row
        place += -(-len(row.values) // words)


def _joined(rows: Iterable[DataRow], words: int) -> Iterator[DataRow]:
    """Yield lines of values; lines of one element are joined."""
    before: DataRow | None = None
    for row in rows:
        if before is not None and row.place is None and len(before.values) % words:
            before = replace(before, values=before.values + row.values)
            continue
        if before is not None:
            yield before
        before = row
    if before is not None:
        yield before


def value_of(letters: str, words: Sequence[str]) -> Any:
    """Return an element from its values; raise a ValueError if they do not fit the file."""
    if letters in STRUCTURED:
        flags, first, second = (_integer(word, 16) for word in words)
        bits = {name: True for bit, name in STRUCTURED[letters].items() if flags >> bit & 1}
        return {**bits, **dict(zip(INNER[letters], (first, second), strict=True))}
    if letters == "ST":
        return _text(words[0])
    return _real(words[0]) if letters == "F" else _integer(words[0], 32 if letters == "L" else 16)


def _text(word: str) -> str:
    if not word.startswith('"'):
        raise ValueError(f"{word} is not a text in quotation marks")
    if len(word) - 2 > TEXT_LENGTH:
        raise ValueError(f"the text has {len(word) - 2} characters; {TEXT_LENGTH} fit")
    return word[1:-1]


def _real(word: str) -> float:
    """Return a value of a file F; Windows prints `1.#INF` and `1.#QNAN`."""
    unsigned = word.lower().lstrip("+-")
    if unsigned.startswith("1.#"):
        value = math.inf if unsigned.startswith("1.#inf") else math.nan
        return -value if word.startswith("-") else value
    try:
        return real(float(word))
    except ValueError:
        raise ValueError(f"{word} is not a number") from None


def _integer(word: str, bits: int) -> int:
    """Read a value such as -3, 0XFF, 0FFh, 16#FF or sixteen binary digits, or raise a ValueError."""
    if len(word) == 16 and set(word) <= {"0", "1"}:
        value = int(word, 2)
    elif match := _HEX.fullmatch(word):
        value = int(match[1] or match[2], 16)
    else:
        if not _DECIMAL.fullmatch(word):
            raise ValueError(f"{word} is not a whole number")
        value = int(word)
        if value >= 1 << bits - 1:
            raise ValueError(f"{word} does not fit {bits} bits")
    if not -(1 << bits - 1) <= value < 1 << bits:
        raise ValueError(f"{word} does not fit {bits} bits")
    return value - (1 << bits) if value >= 1 << bits - 1 else value
