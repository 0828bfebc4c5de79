"""The PCL601 as data: its registers, outputs and inputs, command codes, error bits, its two protocols.

Everything is one literal row per row of the manual; sections in brackets are
the manual's. No time, no I/O.
"""

from .registers import (
    FIRMWARE,
    MAP,
    POSITION_LIMIT,
    ROWS,
    WORD_COUNT,
    WORDS,
    Register,
    Row,
    with_word,
    word_of,
)

__all__ = [
    "FIRMWARE",
    "MAP",
    "POSITION_LIMIT",
    "ROWS",
    "WORDS",
    "WORD_COUNT",
    "Register",
    "Row",
    "with_word",
    "word_of",
]
