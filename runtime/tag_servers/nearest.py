"""Suggestions of the closest tag names for an unknown name in a rack file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from itertools import islice

from scanrack.io_images.enip.listing import Kind, PlainKind

from .database import Database, Writable

NAMES_MOST, NEAREST_MOST = 20_000, 3
"""Maximum numbers of names compared and names suggested."""


def nearest(database: Database, name: str) -> str:
    """Return a text such as `: did you mean Run, Runs?`, or "" if no name is similar."""
    names = {tag_name.upper(): tag_name for tag_name in islice(_names(database), NAMES_MOST)}
    close_names = [names[upper_name] for upper_name in get_close_matches(name.upper(), names, NEAREST_MOST)]
    return f": did you mean {', '.join(close_names)}?" if close_names else ""


def unknown_patterns(database: Database, patterns: Sequence[str]) -> list[str]:
    """Return a sentence for each pattern in `[server] writable` that does not match any tag or member.

    A pattern that names an alias is also reported, because access belongs to tags; its sentence names the
    tag.
    """
    symbols = [symbol for scope in database.scopes.values() for symbol in scope]
    problems = []
    for text in patterns:
        matches = Writable([text]).any_of
        matching = [symbol for symbol in symbols if matches(symbol.tag.path, symbol.tag.kind)]
        if not matching:
            problems.append(f"[server] writable: no tag {text!r}{nearest(database, text)}")
        elif all(symbol.target for symbol in matching):
            target = database.resolve(matching[0].target).name
            problems.append(f"[server] writable: {text} is an alias; list its tag, {target}")
    return problems


def _names(database: Database) -> Iterator[str]:
    for scope in database.scopes.values():
        for symbol in scope:
            yield from _with_members(symbol.tag.path, symbol.tag.kind)


def _with_members(name: str, kind: Kind) -> Iterator[str]:
    yield name
    if not isinstance(kind, PlainKind):
        for member in kind.by_name.values():
            yield from _with_members(f"{name}.{member.name}", member.kind)
