"""Requests that set breakpoints. Each replaces all of its kind, or of its file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .breakpoints import FILTERS, Breakpoint, described
from .causes import last_change
from .protocol import DebugError, Json, objects, text, whole

if TYPE_CHECKING:
    from .adapter import Adapter


def lines(adapter: Adapter, said: Json) -> Json:
    """Set the breakpoints of a file."""
    source = said.get("source")
    path = text(source if isinstance(source, dict) else {}, "path")
    return _replace(
        adapter, f"line {path}", objects(said, "breakpoints"), lambda each: _line(adapter, path, each)
    )


def functions(adapter: Adapter, said: Json) -> Json:
    """Set the breakpoints by name."""
    return _replace(adapter, "function", objects(said, "breakpoints"), lambda each: _function(adapter, each))


def data(adapter: Adapter, said: Json) -> Json:
    """Set the breakpoints on values."""

    def one(each: Json) -> Breakpoint:
        return _made(adapter, "data", text(each, "dataId"), each)

    return _replace(adapter, "data", objects(said, "breakpoints"), one)


def exceptions(adapter: Adapter, said: Json) -> Json:
    """Set the filters that stop."""
    names = said.get("filters") or []
    if not isinstance(names, list):
        raise DebugError("filters must be a list of names")
    wanted = [{"filterId": each} for each in names] + objects(said, "filterOptions")

    def one(each: Json) -> Breakpoint:
        name = each.get("filterId")
        if name not in FILTERS:
            raise DebugError(f"no filter {name!r}: there are {', '.join(FILTERS)}")
        return _made(adapter, "exception", str(name), each)

    return _replace(adapter, "exception", wanted, one)


def locations(adapter: Adapter, said: Json) -> Json:
    """List the lines of a file that can have a breakpoint."""
    source = said.get("source")
    path = text(source if isinstance(source, dict) else {}, "path")
    first = whole(said, "line")
    last = whole(said, "endLine", first)
    places = adapter.the_subject().places(_scan(adapter))
    found: list[Json] = []
    at = first
    while at <= last:
        try:
            at = places.at(path, at)[0]
        except DebugError:
            break
        if at <= last:
            found.append({"line": at})
        at += 1
    return {"breakpoints": found}


def data_info(adapter: Adapter, said: Json) -> Json:
    """Say whether a value can have a breakpoint, and what changed it last."""
    name = text(said, "name")
    if "variablesReference" in said and whole(said, "variablesReference"):
        tag = adapter.the_tree().node(whole(said, "variablesReference")).tag(name)
    else:
        tag = name
    if tag not in adapter.place().view.tags:
        return {"dataId": None, "description": f"{name} is no tag of the program"}
    changed = last_change(adapter, tag)
    says = "has not changed yet" if changed is None else f"changed last in scan {changed:,}"
    return {"dataId": tag, "description": f"{tag} {says}", "accessTypes": ["write"], "canPersist": True}


# --- one breakpoint


def _line(adapter: Adapter, path: str, said: Json) -> Breakpoint:
    line = whole(said, "line")
    at, keys = adapter.the_subject().places(_scan(adapter)).at(path, line)
    made = _made(adapter, "line", f"{path}:{at}", said)
    made.keys, made.line, made.path = tuple(keys), at, path
    made.log = text(said, "logMessage", "")
    return made


def _function(adapter: Adapter, said: Json) -> Breakpoint:
    made = _made(adapter, "function", text(said, "name").strip(), said)
    keys = adapter.the_subject().places(_scan(adapter)).named(made.name)
    made.keys = tuple(keys or ())
    return made


def _made(adapter: Adapter, kind: str, name: str, said: Json) -> Breakpoint:
    adapter.numbers += 1
    condition, hits = text(said, "condition", ""), text(said, "hitCondition", "")
    made = Breakpoint(adapter.numbers, kind, name, condition=condition, hits=hits)
    made.check_hits()
    return made


def _scan(adapter: Adapter) -> int:
    return adapter.the_subject().extent[1] if adapter.cursor is None else adapter.cursor.scan


def _replace(adapter: Adapter, kind: str, wanted: list[Json], make: Maker) -> Json:
    """Replace the breakpoints of a kind; one that can't be used is answered with the reason."""
    answers: list[Json] = []
    good: list[Breakpoint] = []
    others = [each for name, some in adapter.breakpoints.items() if name != kind for each in some]
    for each in wanted:
        try:
            made = make(each)
            adapter.the_driver().set_breakpoints([*others, *good, made])
        except ValueError as error:
            answers.append({"verified": False, "message": str(error)})
        else:
            good.append(made)
            answers.append(described(made))
    adapter.the_driver().set_breakpoints([*others, *good])
    adapter.breakpoints[kind] = good
    return {"breakpoints": answers}


if TYPE_CHECKING:
    from collections.abc import Callable

    Maker = Callable[[Json], Breakpoint]
