"""The kinds of the words of a Python program, for a page that colors them."""

from __future__ import annotations

import keyword
import tokenize
from collections.abc import Iterator, Sequence

Span = tuple[int, int, str]
"""From, to, and kind of a stretch of a line; both count UTF-16 units, as a browser does."""

_KINDS = {tokenize.COMMENT: "comment", tokenize.NUMBER: "number", tokenize.STRING: "string"}
_F_STRING = {
    number for name in ("START", "MIDDLE", "END") if (number := getattr(tokenize, f"FSTRING_{name}", None))
}
"""Tokens of an f-string from Python 3.12 on."""


def spans_of(lines: Sequence[str]) -> dict[int, list[Span]]:
    """Return the spans of each line by number, from 1; of a text that can't be read, those up to there."""
    found: dict[int, list[Span]] = {}
    for token, kind in _tokens(lines):
        (first, begin), (last, end) = token.start, token.end
        for number in range(first, last + 1):
            text = lines[number - 1]
            left = _units(text, begin) if number == first else 0
            right = _units(text, end) if number == last else _units(text, len(text))
            if left < right:
                found.setdefault(number, []).append((left, right, kind))
    return found


def _tokens(lines: Sequence[str]) -> Iterator[tuple[tokenize.TokenInfo, str]]:
    before = ""
    try:
        for token in tokenize.generate_tokens((f"{line}\n" for line in lines).__next__):
            kind = "string" if token.type in _F_STRING else _KINDS.get(token.type, "")
            if token.type == tokenize.NAME:
                known = keyword.iskeyword(token.string)
                kind = "keyword" if known else "defined" if before in ("def", "class") else ""
            if kind:
                yield token, kind
            before = token.string
    except (tokenize.TokenError, SyntaxError):
        return


def _units(text: str, letters: int) -> int:
    """Return how many UTF-16 units the first letters of a text take."""
    return len(text[:letters].encode("utf-16-le", "surrogatepass")) // 2
