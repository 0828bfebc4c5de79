"""Requests that set breakpoints. Each replaces all breakpoints of its kind, or of its file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .breakpoints import FILTERS, Breakpoint, described
from .causes import last_change
from .protocol import DebugError, Json, objects, text, whole

if TYPE_CHECKING:
    from .adapter import Adapter


def lines(adapter: Adapter, arguments: Json) -> Json:
    """Set the breakpoints of a file."""
    source = arguments.get("source")
    path = text(source if isinstance(source, dict) else {}, "path")
    return _replace(
        adapter, f"line {path}", objects(arguments, "breakpoints"), lambda each: _line(adapter, path, each)
    )


def functions(adapter: Adapter, arguments: Json) -> Json:
    """Set the breakpoints by name."""
    return _replace(
        adapter, "function", objects(arguments, "breakpoints"), lambda each: _function(adapter, each)
    )


def data(adapter: Adapter, arguments: Json) -> Json:
    """Set the breakpoints on values."""

    def one(each: Json) -> Breakpoint:
        return _made(adapter, "data", text(each, "dataId"), each)

    return _replace(adapter, "data", objects(arguments, "breakpoints"), one)


def exceptions(adapter: Adapter, arguments: Json) -> Json:
    """Set the active exception filters."""
    names = arguments.get("filters") or []
    if not isinstance(names, list):
        raise DebugError("filters must be a list of names")
    filters = [{"filterId": name} for name in names] + objects(arguments, "filterOptions")

    def one(each: Json) -> Breakpoint:
        name = text(each, "filterId")
        if name not in FILTERS:
            raise DebugError(f"no filter {name!r}: there are {', '.join(FILTERS)}")
        return _made(adapter, "exception", name, each)

    return _replace(adapter, "exception", filters, one)


def locations(adapter: Adapter, arguments: Json) -> Json:
    """List the lines of a file that can have a breakpoint."""
    source = arguments.get("source")
    path = text(source if isinstance(source, dict) else {}, "path")
    first = whole(arguments, "line")
    last = whole(arguments, "endLine", first)
    places = adapter.the_subject().places(_scan(adapter))
    rows: list[Json] = []
    line = first
    while line <= last:
        try:
            line = places.at(path, line)[0]
        except DebugError:
            break
        if line <= last:
            rows.append({"line": line})
        line += 1
    return {"breakpoints": rows}


def data_info(adapter: Adapter, arguments: Json) -> Json:
    """Return whether a value can have a breakpoint, and its last change."""
    name = text(arguments, "name")
    if "variablesReference" in arguments and whole(arguments, "variablesReference"):
        tag = adapter.the_tree().tag(whole(arguments, "variablesReference"), name)
    else:
        tag = name
    if tag not in adapter.place().view.tags:
        return {"dataId": None, "description": f"{name} is no tag of the program"}
    change_scan = last_change(adapter, tag)
    last_changed = "has not changed yet" if change_scan is None else f"changed last in scan {change_scan:,}"
    return {
        "dataId": tag,
        "description": f"{tag} {last_changed}",
        "accessTypes": ["write"],
        "canPersist": True,
    }


# --- one breakpoint


def _line(adapter: Adapter, path: str, arguments: Json) -> Breakpoint:
    line = whole(arguments, "line")
    actual_line, keys = adapter.the_subject().places(_scan(adapter)).at(path, line)
    point = _made(adapter, "line", f"{path}:{actual_line}", arguments)
    point.keys, point.line, point.path = tuple(keys), actual_line, path
    point.log = text(arguments, "logMessage", "")
    return point


def _function(adapter: Adapter, arguments: Json) -> Breakpoint:
    point = _made(adapter, "function", text(arguments, "name").strip(), arguments)
    keys = adapter.the_subject().places(_scan(adapter)).named(point.name)
    point.keys = tuple(keys or ())
    return point


def _made(adapter: Adapter, kind: str, name: str, arguments: Json) -> Breakpoint:
    adapter.numbers += 1
    condition, hits = text(arguments, "condition", ""), text(arguments, "hitCondition", "")
    point = Breakpoint(adapter.numbers, kind, name, condition=condition, hits=hits)
    point.check_hits()
    return point


def _scan(adapter: Adapter) -> int:
    return adapter.the_subject().extent[1] if adapter.cursor is None else adapter.cursor.scan


def _replace(adapter: Adapter, kind: str, requested: list[Json], make: Maker) -> Json:
    """Replace the breakpoints of a kind; the answer to an unusable one has the reason."""
    answers: list[Json] = []
    good: list[Breakpoint] = []
    adapter.breakpoints[kind] = []
    points = adapter.all_breakpoints()
    for request in requested:
        try:
            point = make(request)
            adapter.the_driver().set_breakpoints([*points, *good, point])
        except ValueError as error:
            answers.append({"verified": False, "message": str(error)})
        else:
            good.append(point)
            answers.append(described(point))
    adapter.the_driver().set_breakpoints([*points, *good])
    adapter.breakpoints[kind] = good
    return {"breakpoints": answers}


if TYPE_CHECKING:
    from collections.abc import Callable

    Maker = Callable[[Json], Breakpoint]
