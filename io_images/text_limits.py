"""Limits for untrusted texts, checked before a parser reads them.

Parsing some texts takes far more time than their size suggests: a TOML key with many parts, nested brackets,
or a long run of spaces that a pattern tries at each length. This check takes time proportional to the size
and refuses such texts. The size of a file is limited when it is read, see `input_files`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import StrEnum
from functools import cache

from .dataclass import dataclass

KIB, MIB = 1 << 10, 1 << 20


class TextKind(StrEnum):
    """The language of a text."""

    TOML = "a rack file"
    PLAN = "a plan"
    RUNGS = "rungs"
    STRUCTURED = "structured text"
    STEPS = "steps"
    STORED = "a stored program"
    RETAINED = "retained tags"
    MEMORY = "the memory of a controller"
    SCENARIO = "a scenario"
    STATE = "the state of a campaign"
    PYTHON = "Python"
    EXPORT = "an export"
    RESULT = "a result"


@dataclass(frozen=True, slots=True)
class TextLimits:
    """Limits of a text."""

    size: int  # bytes of a file, and characters of a text
    nesting: int = 1000  # depth of brackets
    parts: int = 64  # parts of a dotted name
    token: int = 4 * KIB  # characters of a name, a number, a string or a run of blanks


LIMITS: Mapping[TextKind, TextLimits] = {
    TextKind.TOML: TextLimits(1 * MIB, nesting=32, parts=16),
    TextKind.PLAN: TextLimits(1 * MIB, nesting=32, parts=16, token=128 * KIB),
    TextKind.RUNGS: TextLimits(8 * MIB),
    TextKind.STRUCTURED: TextLimits(8 * MIB),
    TextKind.STEPS: TextLimits(1 * MIB),
    TextKind.STORED: TextLimits(1 * MIB),
    TextKind.RETAINED: TextLimits(64 * MIB, nesting=64, token=128 * KIB),
    TextKind.MEMORY: TextLimits(1 * MIB, nesting=8),
    TextKind.SCENARIO: TextLimits(16 * MIB, nesting=64),
    TextKind.STATE: TextLimits(256 * MIB, nesting=64, token=128 * KIB),
    TextKind.PYTHON: TextLimits(16 * MIB),
    TextKind.EXPORT: TextLimits(64 * MIB),
    TextKind.RESULT: TextLimits(256 * MIB, nesting=16),
}
"""Limits by language. Python and exports are limited only in size here; their parsers have other limits."""

DIGITS_MAX = 4300
"""Maximum decimal digits of a number that Python converts; see `sys.get_int_max_str_digits`."""
_DIGITS = re.compile(r"[+-]?[0-9_]+")

_COUNTED_TOKENS = (
    r"|(?P<open>[\[({])|(?P<close>[\])}])|(?P<token>[\w$%\\+-]+)"
    r"|(?P<dot>[ \t]*\.[ \t]*)|(?P<blanks>[ \t\r]{2,})"
)
_TOML = r"""(?P<comment>\#[^\n]*)|(?P<string>\"\"\"(?:[^"\\]|\\.|"(?!""))*+(?:\"\"\"|\\?\Z)|'''.*?(?:'''|\Z)
|"(?:[^"\\\n]++|\\.)*+"?|'[^'\n]*'?)"""
_LOGIX = r"""(?P<comment>//[^\n]*|\(\*.*?(?:\*\)|\Z)|/\*.*?(?:\*/|\Z))
|(?P<string>'(?:[^'$\n]++|\$.)*+'?|"(?:[^"\\\n]++|\\.)*+"?)"""
_JSON = r"""(?P<string>"(?:[^"\\\n]++|\\.)*+"?)"""
_HASH = r"(?P<comment>[#;][^\n]*)"


_COMMENTS_AND_STRINGS: Mapping[TextKind, str] = {
    TextKind.TOML: _TOML,
    TextKind.PLAN: _TOML,
    TextKind.RUNGS: _LOGIX,
    TextKind.STRUCTURED: _LOGIX,
    TextKind.STEPS: _HASH,
    TextKind.STORED: _HASH,
    TextKind.RETAINED: _JSON,
    TextKind.MEMORY: _JSON,
    TextKind.SCENARIO: _JSON,
    TextKind.STATE: _JSON,
    TextKind.RESULT: _JSON,
}
"""Patterns for comments and strings; no alternative backtracks far."""


@cache
def _pattern(comments_and_strings: str) -> re.Pattern[str]:
    """Return the pattern of comments, strings and counted tokens."""
    return re.compile(comments_and_strings.replace("\n", "") + _COUNTED_TOKENS, re.DOTALL)


class TextLimitError(ValueError):
    """The text exceeds its limits; lines count from 1."""

    def __init__(self, line: int, problem: str) -> None:
        self.line = line
        super().__init__(problem)


def check_text(text: str, kind: TextKind) -> None:
    r"""Raise a TextLimitError if a text exceeds its limits.

    >>> check_text("a.b = [[1]]", TextKind.TOML)
    >>> check_text("x = 1\n" + "a." * 16 + "a = 1", TextKind.TOML)
    Traceback (most recent call last):
    ...
    scanrack.io_images.text_limits.TextLimitError: a name of more than 16 parts
    """
    limits = LIMITS[kind]
    if len(text) > limits.size:
        raise TextLimitError(1, f"{kind} of more than {limits.size:,} characters")
    depth = parts = 0
    previous = None
    for match in _pattern(_COMMENTS_AND_STRINGS[kind]).finditer(text):
        token = match.lastgroup
        if token == "open":
            depth += 1
        elif token == "close":
            depth -= 1
        elif token in ("token", "string"):
            parts = parts + 1 if previous == "dot" else 1
        previous = token
        size = match.end() - match.start()
        if depth > limits.nesting:
            problem = f"brackets that are nested deeper than {limits.nesting}"
        elif parts > limits.parts:
            problem = f"a name of more than {limits.parts} parts"
        elif token != "comment" and size > limits.token:
            problem = f"a name, number, text or blank of more than {limits.token:,} characters"
        elif token == "token" and size > DIGITS_MAX and _DIGITS.fullmatch(text, match.start(), match.end()):
            problem = f"a number of more than {DIGITS_MAX:,} digits"
        else:
            continue
        raise TextLimitError(text.count("\n", 0, match.start()) + 1, problem)


SHOWN = 2_000
"""Maximum characters of a displayed or recorded text: an error, a name, a cell of a table."""


def shortened(text: str, most: int = SHOWN) -> str:
    """Return a text; if it is longer than `most`, truncate it and append its length.

    >>> shortened("short"), shortened("a" * 5_000_000, 5)
    ('short', 'aaaaa... (5,000,000 characters)')
    """
    return text if len(text) <= most else f"{text[:most]}... ({len(text):,} characters)"


EXPORT_MIB, EXPORT_MIB_MOST = 128, 4096
"""Memory limit for the tags of an export, MiB: the default, and the largest allowed."""
