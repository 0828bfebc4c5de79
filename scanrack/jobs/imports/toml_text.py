"""Escapes text from an export for a printed rack file, so that it can't end the string, key or comment."""

from __future__ import annotations

import json
import re

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def text(value: str) -> str:
    r"""Return a text as a TOML basic string.

    >>> print(text('a "name"\x85'))
    "a \"name\"\u0085"
    """
    return escaped(json.dumps(value, ensure_ascii=False))


def key(name: str) -> str:
    r"""Return a name as a TOML key.

    >>> print(key("Main"), key('a = "b"'))
    Main "a = \"b\""
    """
    return name if _BARE.fullmatch(name) else text(name)


def comment(line: str) -> str:
    r"""Return a TOML comment on one line.

    >>> print(comment("slot 1\n[stubs]"))
    # slot 1\u000a[stubs]
    """
    return f"# {escaped(line)}"


def escaped(value: str) -> str:
    r"""Return a text with every unprintable character as a TOML escape."""
    return value if value.isprintable() else "".join(map(_escaped, value))


def _escaped(character: str) -> str:
    if character.isprintable():
        return character
    number = ord(character)
    return f"\\u{number:04x}" if number < 1 << 16 else f"\\U{number:08x}"
