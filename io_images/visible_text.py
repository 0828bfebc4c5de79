"""Makes control characters visible, for terminals and pages.

Names, messages and metadata come from files and serial lines. An escape sequence in them could move
the cursor, overwrite earlier output, or type at the prompt; a text direction override could reverse a name.
Therefore a character without a visible form is printed as a Python escape.
"""

from __future__ import annotations

import unicodedata

LAYOUT = "\n\t"
"""Control characters that are printed unchanged."""

_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Unicode categories: controls, formats, surrogates, private use, unassigned, line separators."""


def visible(text: str, keep: str = LAYOUT) -> str:
    r"""Return text with its control characters made visible.

    >>> visible("\x1b[2Jline\u202e\n")
    '\\x1b[2Jline\\u202e\n'
    """
    if text.isprintable():
        return text
    return "".join(character if character in keep else _visible(character) for character in text)


def _visible(character: str) -> str:
    if unicodedata.category(character) in _INVISIBLE:
        return character.encode("unicode_escape").decode("ascii")
    return character
