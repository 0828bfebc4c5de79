"""The PCL601 as data: registers, terminals, command codes, error bits and serial messages.

Each row in the manual's tables is one row here; brackets contain sections of the manual. This package does no
timing or I/O. Stored programs are in the package `program`.
"""

from .commands import NEEDS_IDLE, Code
from .errors import CAUSES, NO_ERROR, Error
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
from .talk import COMMANDS

__all__ = [
    "CAUSES",
    "COMMANDS",
    "FIRMWARE",
    "MAP",
    "NEEDS_IDLE",
    "NO_ERROR",
    "POSITION_LIMIT",
    "ROWS",
    "WORDS",
    "WORD_COUNT",
    "Code",
    "Error",
    "Register",
    "Row",
    "with_word",
    "word_of",
]
