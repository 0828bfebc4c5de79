"""The PCL601 as data: registers, terminals, command codes, error bits and serial messages.

Each row of the manual is one literal row here; sections in brackets are
the manual's. There is no time and no I/O. Stored programs have their own package,
`program`.
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
