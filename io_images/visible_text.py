"""Control characters made visible, for terminals and pages.

Names, messages and metadata come out of files and off lines. An escape sequence in them could move
the cursor, overwrite earlier output, or type at the prompt; an override of the writing
direction reverses a name. A character without a glyph is therefore printed as in Python.
"""

from __future__ import annotations

import unicodedata

LAYOUT = "\n\t"
"""Control characters that are printed unchanged."""

_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Categories of Unicode: controls, formats, surrogates, private, unassigned, separators of lines."""


def visible(text: str, keep: str = LAYOUT) -> str:
    r"""Return a text with visible control characters.

    >>> visible("\x1b[2Jline\u202e\n")
    '\\x1b[2Jline\\u202e\n'
    """
    if text.isprintable():
        return text
    return "".join(each if each in keep else _visible(each) for each in text)


def _visible(character: str) -> str:
    if unicodedata.category(character) in _INVISIBLE:
        return character.encode("unicode_escape").decode("ascii")
    return character
