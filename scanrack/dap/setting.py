"""Requests that set breakpoints. Each replaces all breakpoints of its kind, or of its file."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from .breakpoints import FILTERS, Breakpoint, described
from .protocol import DebugError, Json, objects, text, whole

if TYPE_CHECKING:
    from .adapter import Adapter


def lines(adapter: Adapter, arguments: Json) -> Json:
    """Set the breakpoints of a file."""
    path = _path_in(arguments)
    return _replace(adapter, f"line {path}", objects(arguments, "breakpoints"), partial(_line, path))


def functions(adapter: Adapter, arguments: Json) -> Json:
    """Set the function breakpoints, which are given by name."""
    return _replace(adapter, "function", objects(arguments, "breakpoints"), _function)


def data(adapter: Adapter, arguments: Json) -> Json:
    """Set the data breakpoints, which stop on changes of values."""
    return _replace(adapter, "data", objects(arguments, "breakpoints"), _data)


def exceptions(adapter: Adapter, arguments: Json) -> Json:
    """Set the active exception filters."""
    names = arguments.get("filters") or []
    if not isinstance(names, list):
        raise DebugError("filters must be a list of names")
    filters = [{"filterId": name} for name in names] + objects(arguments, "filterOptions")
    return _replace(adapter, "exception", filters, _exception)


def locations(adapter: Adapter, arguments: Json) -> Json:
    """List the lines of a file on which a breakpoint can be set."""
    path, line = _path_in(arguments), whole(arguments, "line")
    last = whole(arguments, "endLine", line)
    places = adapter.the_subject().places(_current_scan(adapter))
    rows: list[Json] = []
    with suppress(DebugError):  # no further line has an instruction
        while (line := places.first_line_from(path, line)[0]) <= last:
            rows.append({"line": line})
            line += 1
    return {"breakpoints": rows}


def _path_in(arguments: Json) -> str:
    source = arguments.get("source")
    return text(source if isinstance(source, dict) else {}, "path")


def data_info(adapter: Adapter, arguments: Json) -> Json:
    """Return whether a value can have a breakpoint, and its last change."""
    name = text(arguments, "name")
    if "variablesReference" in arguments and whole(arguments, "variablesReference"):
        tag = adapter.the_tree().tag(whole(arguments, "variablesReference"), name)
    else:
        tag = name
    if tag not in adapter.place().view.tags:
        return {"dataId": None, "description": f"{name} is not a tag of the program"}
    change_scan = adapter.last_change(tag)
    last_changed = "has not changed yet" if change_scan is None else f"changed last in scan {change_scan:,}"
    return {
        "dataId": tag,
        "description": f"{tag} {last_changed}",
        "accessTypes": ["write"],
        "canPersist": True,
    }


# --- one breakpoint


def _line(path: str, adapter: Adapter, arguments: Json) -> Breakpoint:
    """Return a breakpoint on the first line with an instruction at or after the requested line."""
    line = whole(arguments, "line")
    places = adapter.the_subject().places(_current_scan(adapter))
    actual_line, keys = places.first_line_from(path, line)
    point = _new_breakpoint(adapter, "line", f"{path}:{actual_line}", arguments)
    point.keys, point.line, point.path = tuple(keys), actual_line, path
    point.log = text(arguments, "logMessage", "")
    return point


def _function(adapter: Adapter, arguments: Json) -> Breakpoint:
    point = _new_breakpoint(adapter, "function", text(arguments, "name").strip(), arguments)
    keys = adapter.the_subject().places(_current_scan(adapter)).named(point.name)
    point.keys = tuple(keys or ())
    return point


def _data(adapter: Adapter, arguments: Json) -> Breakpoint:
    return _new_breakpoint(adapter, "data", text(arguments, "dataId"), arguments)


def _exception(adapter: Adapter, arguments: Json) -> Breakpoint:
    name = text(arguments, "filterId")
    if name not in FILTERS:
        raise DebugError(f"no filter {name!r}: choose from {', '.join(FILTERS)}")
    return _new_breakpoint(adapter, "exception", name, arguments)


def _new_breakpoint(adapter: Adapter, kind: str, name: str, arguments: Json) -> Breakpoint:
    """Return a breakpoint with the next id; refuse a hit count that can't be read."""
    adapter.breakpoint_count += 1
    condition, hits = text(arguments, "condition", ""), text(arguments, "hitCondition", "")
    point = Breakpoint(adapter.breakpoint_count, kind, name, condition=condition, hits=hits)
    point.check_hits()
    return point


def _current_scan(adapter: Adapter) -> int:
    return adapter.the_subject().extent[1] if adapter.cursor is None else adapter.cursor.scan


def _replace(adapter: Adapter, kind: str, requested: list[Json], make: Maker) -> Json:
    """Replace the breakpoints of a kind; the row of an unusable breakpoint states the reason."""
    rows: list[Json] = []
    new_points: list[Breakpoint] = []
    adapter.breakpoints[kind] = []
    other_points = adapter.all_breakpoints()
    for request in requested:
        try:
            point = make(adapter, request)
            adapter.the_driver().set_breakpoints([*other_points, *new_points, point])
        except ValueError as error:
            rows.append({"verified": False, "message": str(error)})
        else:
            new_points.append(point)
            rows.append(described(point))
    adapter.the_driver().set_breakpoints([*other_points, *new_points])
    adapter.breakpoints[kind] = new_points
    return {"breakpoints": rows}


if TYPE_CHECKING:
    from collections.abc import Callable

    Maker = Callable[[Adapter, Json], Breakpoint]
