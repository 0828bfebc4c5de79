"""Keeps the breakpoints of the editor and of the page the same, if both support their kind.

| breakpoint of an editor | on the page |
|---|---|
| on a line, `becomes true`, `changes` | `Main.3 executes`, `Main.3`, `Main.3 changes` |
| on a change of a tag | the tag |
| in an add-on instruction; with another condition, a hit count, a log message | not there |
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

from .breakpoints import BECOMES_TRUE, CHANGES, Breakpoint
from .places import Places

Spelled = Callable[[str], str]
"""Returns the name of a routine on pages, "" if they have no name for it."""

_RUNG = re.compile(r"(?P<rung>.+\.\d+)(?: (?P<when>changes|executes))?")
_WHEN = {"": " executes", BECOMES_TRUE: "", CHANGES: " changes"}


def page_names(one: Breakpoint, spelled: Spelled) -> list[str]:
    """Return the page's names of a breakpoint; empty if the page does not support it."""
    when = _WHEN.get(one.condition.strip().lower())
    if when is None or one.hits or one.log or one.kind == "exception":
        return []
    if one.keys:
        return [f"{name}.{number}{when}" for routine, number in one.keys if (name := spelled(routine))]
    return [one.changing_tag] if one.changing_tag and not one.condition else []


def of_page(name: str, number: int, places: Places) -> Breakpoint:
    """Return the breakpoint that a page has set, with its line if it has one."""
    rung = _RUNG.fullmatch(name)
    keys = None if rung is None else places.named(rung["rung"])
    if rung is None or keys is None:
        return Breakpoint(number, "data", name)
    condition = {None: BECOMES_TRUE, "changes": CHANGES, "executes": ""}[rung["when"]] if places.power else ""
    path, line = places.of(keys[0])
    return Breakpoint(number, "line", name, tuple(keys), condition, line=line, path=path)


def foreign(
    there: Sequence[str], own: Sequence[Breakpoint], spelled: Spelled
) -> tuple[list[str], Mapping[str, Breakpoint]]:
    """Return the breakpoints of pages that an editor lacks, and the editor's by their names on pages."""
    names = {name: point for point in own for name in page_names(point, spelled)}
    return [row for row in there if row not in names], names
