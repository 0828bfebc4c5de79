"""Keywords of motion and safety operands."""

from __future__ import annotations

from . import motion_words, safety_types


def plain(word: str) -> str:
    """Return a keyword in capitals without spaces or hyphens, as structured text writes it.

    >>> plain("Units per sec2"), plain("S-Curve")
    ('UNITSPERSEC2', 'SCURVE')
    """
    return word.upper().replace(" ", "").replace("-", "")


KEYWORDS = frozenset(plain(word) for words in (*motion_words.LISTS, safety_types.WORDS) for word in words)
"""All keywords, as `plain` returns them."""
