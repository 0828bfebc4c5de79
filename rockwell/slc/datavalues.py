"""Reads values of data files in the notation of RSLogix 500.

| file | an element |
|---|---|
| B, N, S, A, I, O | `-3`, `0XFFF0`, `0FFF0h`, `16#FFF0`, sixteen binary digits |
| L | the same with 32 bits |
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

from .addresses import STRUCTURED, WORDS
from .records import DataRecord, DataRow

TEXT_LENGTH = 82
"""Maximum number of characters in an element of a string file (ST)."""

_HEX = re.compile(r"(?:0X|16#)([0-9A-F]{1,16})|([0-9A-F]{1,16})H", re.IGNORECASE)
_DECIMAL = re.compile(r"[+-]?[0-9]{1,18}")


def placed_rows(record: DataRecord, words: int) -> Iterator[tuple[int, DataRow]]:
    """Yield lines of values, each with the number of its first element; an element has `words` values."""
    element = record.first_element(words)
    for row in _joined(record.rows, words):
        element = element if row.element is None else row.element
        yield element, row
        element += -(-len(row.values) // words)


def _joined(rows: Iterable[DataRow], words: int) -> list[DataRow]:
    """Return lines of values; a line that continues an element is joined to the previous line."""
    joined: list[DataRow] = []
    for row in rows:
        if joined and row.element is None and len(joined[-1].values) % words:
            joined[-1] = replace(joined[-1], values=joined[-1].values + row.values)
        else:
            joined.append(row)
    return joined


def value_of(letters: str, words: Sequence[str]) -> Any:
    """Return the value of an element from the texts of its words; raise a ValueError if they are invalid."""
    if letters in STRUCTURED:
        flags, first, second = (_integer(word, 16) for word in words)
        bits = {name: True for bit, name in STRUCTURED[letters].items() if flags >> bit & 1}
        return {**bits, **dict(zip(WORDS[letters], (first, second), strict=True))}
    if letters == "ST":
        return _text(words[0])
    return _real(words[0]) if letters == "F" else _integer(words[0], 32 if letters == "L" else 16)


def _text(word: str) -> str:
    """Return the text between quotation marks; raise a ValueError if it lacks them or is too long."""
    if not word.startswith('"'):
        raise ValueError(f"{word} is not a text in quotation marks")
    if len(word) - 2 > TEXT_LENGTH:
        raise ValueError(f"the text has {len(word) - 2} characters; {TEXT_LENGTH} fit")
    return word[1:-1]


def _real(word: str) -> float:
    """Return a value of an F file, including the Windows notations `1.#INF` and `1.#QNAN`."""
    unsigned = word.lower().lstrip("+-")
    if unsigned.startswith("1.#"):
        value = math.inf if unsigned.startswith("1.#inf") else math.nan
        return -value if word.startswith("-") else value
    try:
        return real(float(word))
    except ValueError:
        raise ValueError(f"{word} is not a number") from None


def _integer(word: str, bits: int) -> int:
    """Return a signed value such as -3, 0XFF, 0FFh, 16#FF or sixteen binary digits.

    Raises:
        ValueError: the text is not an integer value, or the value does not fit.
    """
    if len(word) == 16 and set(word) <= {"0", "1"}:
        value = int(word, 2)
    elif match := _HEX.fullmatch(word):
        value = int(match[1] or match[2], 16)
    else:
        if not _DECIMAL.fullmatch(word):
            raise ValueError(f"{word} is not an integer")
        value = int(word)
        if value >= 1 << bits - 1:
            raise ValueError(f"{word} does not fit {bits} bits")
    if not -(1 << bits - 1) <= value < 1 << bits:
        raise ValueError(f"{word} does not fit {bits} bits")
    return value - (1 << bits) if value >= 1 << bits - 1 else value
