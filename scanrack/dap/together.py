"""Breakpoints that are shared by the editor and the page.

| breakpoint of an editor | on the page |
|---|---|
| on a line, `becomes true`, `changes` | `Main.3 executes`, `Main.3`, `Main.3 changes` |
| on a change of a tag | the tag |
| in an add-on instruction; with another condition, a hit count or a log message | none |
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from .breakpoints import BECOMES_TRUE, CHANGES, Breakpoint
from .places import Places

RoutineName = Callable[[str], str]
"""A function that returns the name of a routine on pages, or "" if they have no name for it."""

_RUNG = re.compile(r"(?P<rung>.+\.\d+)(?: (?P<when>changes|executes))?")
_WHEN = {"": " executes", BECOMES_TRUE: "", CHANGES: " changes"}


def _is_plain(point: Breakpoint) -> bool:
    """Return whether the page supports a breakpoint, that is, one without counts, logs or exceptions."""
    return not point.hits and not point.log and point.kind != "exception"


def _page_names(point: Breakpoint, page_routine: RoutineName) -> list[str]:
    """Return the page's names for a breakpoint; empty if the page does not support it."""
    when = _WHEN.get(point.condition.strip().lower())
    if when is None or not _is_plain(point):
        return []
    if point.keys:
        names = [(page_routine(routine), number) for routine, number in point.keys]
        return [f"{name}.{number}{when}" for name, number in names if name]
    return [point.changing_tag] if point.changing_tag and not point.condition else []


def on_page(points: Sequence[Breakpoint], page_routine: RoutineName) -> dict[str, Breakpoint]:
    """Return the breakpoints that the page supports, by their names on the page."""
    return {name: point for point in points for name in _page_names(point, page_routine)}


def from_page(name: str, number: int, places: Places) -> Breakpoint:
    """Return the breakpoint that a page has set, with its line if it has one."""
    rung = _RUNG.fullmatch(name)
    keys = None if rung is None else places.named(rung["rung"])
    if rung is None or keys is None:
        return Breakpoint(number, "data", name)
    condition = {None: BECOMES_TRUE, "changes": CHANGES, "executes": ""}[rung["when"]] if places.power else ""
    path, line = places.of(keys[0])
    return Breakpoint(number, "line", name, tuple(keys), condition, line=line, path=path)
