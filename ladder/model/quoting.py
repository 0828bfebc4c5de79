"""Characters of string literals: `$` begins an escape, as in Logix.

| text | characters |
|---|---|
| `$$`, `$'`, `$"` | the character itself |
| `$L` | line feed, 0A |
| `$N` | new line, 0D 0A |
| `$P` | form feed, 0C |
| `$R` | carriage return, 0D |
| `$T` | tab, 09 |
| `$` and two hexadecimal digits | the character with that code |
"""

from __future__ import annotations

import re

_ESCAPE = re.compile(r"\$(\$|'|\"|[LNPRTlnprt]|[0-9A-Fa-f]{2})?")
_NAMED = {"$": "$", "'": "'", '"': '"', "L": "\n", "N": "\r\n", "P": "\f", "R": "\r", "T": "\t"}
_SPECIAL = re.compile(r"[$'\x00-\x1f\x7f]")


def unquoted(text: str) -> str:
    r"""Replace the escapes in a string literal's text, without its quotes.

    >>> unquoted("It$'s 5$$$0A")
    "It's 5$\n"

    Raises:
        ValueError: a `$` does not begin an escape; the message shows it.
    """
    return _ESCAPE.sub(_character, text)


def _character(match: re.Match[str]) -> str:
    """Return the characters of an escape; raise a ValueError if the escape is invalid."""
    name = match.group(1)
    if name is None:
        escape = match.string[match.start() : match.start() + 3]
        raise ValueError(
            f"{escape} is not an escape; must be $$, $', $L, $N, $P, $R, $T or two digits as in $0D"
        )
    return _NAMED.get(name.upper()) or chr(int(name, 16))


def quoted(value: str) -> str:
    r"""Return a value's characters as the text of a string literal.

    >>> print(quoted("It's 5$\n"))
    'It$'s 5$$$0A'
    """
    return f"'{_SPECIAL.sub(_escape, value)}'"


def _escape(match: re.Match[str]) -> str:
    sign = match.group()
    return f"${sign}" if sign in "$'" else f"${ord(sign):02X}"
