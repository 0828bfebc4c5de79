"""Requests that look: frames, scopes, values, expressions, and commands; and those that set values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.times import seconds
from scanrack.ladder.debug.executed import LineRun
from scanrack.ladder.debug.watched import shown
from scanrack.ladder.model.operands import Calculation, Group, Place
from scanrack.ladder.model.tags import program_of
from scanrack.ladder.model.types import HIDDEN
from scanrack.ladder.run.view import Tags
from scanrack.ladder.state.lowered import AddOnCall, LoweredLine
from scanrack.runtime.live import actions

from .conditions import ExpressionError, Surroundings, compiled
from .executed_scan import callers
from .protocol import DebugError, Json, text, whole
from .subject import Images
from .variables import Modules, Names, Parts, Tree, tags_of, value_in

if TYPE_CHECKING:
    from .adapter import Adapter

SCAN_FRAME = 10_000
"""Number of the outermost frame."""

NOWHERE = {"line": 0, "column": 0}
"""The place of a frame without a file."""

COMPLETIONS_MOST = 200


def threads(_adapter: Adapter, _said: Json) -> Json:
    """Name the thread."""
    return {"threads": [{"id": 1, "name": "scan"}]}


# --- frames


def stack(adapter: Adapter, said: Json) -> Json:
    """List the frames, innermost first: rung, callers, task, scan."""
    frames = list(_frames(adapter))
    start, levels = whole(said, "startFrame", 0), whole(said, "levels", 0)
    return {"stackFrames": frames[start : start + levels if levels else None], "totalFrames": len(frames)}


def _frames(adapter: Adapter) -> Iterator[Json]:
    cursor, subject = adapter.place(), adapter.the_subject()
    places, scan = subject.places(cursor.scan), cursor.scan
    runs = _runs(adapter)
    for number, run in enumerate(runs, 1):
        unit = cursor.view.engine.lowered.routines[run.routine].unit
        name = f"{_spelled(adapter, run.routine)}, {unit} {run.line.number}"
        name = f"{name} of {run.instance}" if run.instance else name
        yield {"id": number, "name": name, **NOWHERE, **places.source(run.line.origin)}
    task = _task(adapter, runs[-1]) if runs else ""
    if task:
        yield {
            "id": SCAN_FRAME - 1,
            "name": f"task {task}",
            "line": 0,
            "column": 0,
            "presentationHint": "label",
        }
    at = "scan" if cursor.stop is not None else "end of scan"
    where = f"{at} {scan:,}, {seconds(subject.now_ns(scan))} s"
    past = " (past)" if adapter.in_past() else ""
    last = _last_line(adapter) if not runs else None
    more = {} if last is None else places.source(last.origin)
    yield {"id": SCAN_FRAME, "name": where + past, **NOWHERE, **more}


def _runs(adapter: Adapter) -> list[LineRun]:
    """Return the rung and those that call its routine, innermost first."""
    stop = adapter.place().stop
    return [] if stop is None else [stop.run, *(each.run for each in callers(stop.run))]


def _last_line(adapter: Adapter) -> LoweredLine | None:
    """Return the last rung of the main routine, which is shown at the end of a scan."""
    lowered = adapter.place().view.engine.lowered
    tasks = () if lowered.schedule is None else lowered.schedule.tasks
    mains = [lowered.main, *(each.main or "" for task in tasks for each in task.programs)]
    routine = next((lowered.routines[each] for each in mains if each in lowered.routines), None)
    return None if routine is None or not routine.lines else routine.lines[-1]


def _spelled(adapter: Adapter, routine: str) -> str:
    """Return the name of a routine as the program writes it."""
    lowered = adapter.place().view.engine.lowered
    found: str = lowered.routines[routine].name
    return found


def _program(adapter: Adapter, run: LineRun | None) -> str:
    """Return the program of a rung; "" in a program without tasks, and outside of rungs."""
    return "" if run is None else program_of(_spelled(adapter, run.routine))


def _task(adapter: Adapter, run: LineRun) -> str:
    """Return the task of a routine; "" without one."""
    schedule = adapter.place().view.engine.lowered.schedule
    program = program_of(run.routine).upper()
    for each in () if schedule is None else schedule.tasks:
        if any(one.name.upper() == program for one in each.programs):
            return str(each.task.name)
    return ""


def _run_of(adapter: Adapter, frame: int) -> LineRun | None:
    """Return the rung of a frame; None for a frame outside of rungs; a DebugError for one that is gone."""
    runs = _runs(adapter)
    if 1 <= frame <= len(runs):
        return runs[frame - 1]
    if frame in (SCAN_FRAME, SCAN_FRAME - 1):
        return None
    raise DebugError(f"frame {frame} is gone: the program has moved on")


# --- scopes


def tree_of(adapter: Adapter) -> Tree:
    """Return the opened values of the place where the client stands."""
    if adapter.tree is None:
        cursor = adapter.place()
        adapter.tree = Tree(cursor.view.engine, tuple(adapter.the_subject().forced(cursor.scan)))
    return adapter.tree


def scopes(adapter: Adapter, said: Json) -> Json:
    """List the scopes of a frame."""
    run = _run_of(adapter, whole(said, "frameId"))
    tree = tree_of(adapter)
    engine = tree.engine
    found: list[Json] = []

    def add(name: str, node: object, *, expensive: bool = False, hint: str = "") -> None:
        more = {"presentationHint": hint} if hint else {}
        reference = tree.add(node)  # type: ignore[arg-type]  # a node
        found.append({"name": name, "variablesReference": reference, "expensive": expensive, **more})

    program = _program(adapter, run)
    if run is not None:
        add("Rung", Names(tree, lambda: _named_in(adapter, run)))
        if run.instance and run.instance in engine.tags:
            where = engine.tags.where(run.instance)
            assert isinstance(where, Group)
            add("Locals", Parts(tree, run.instance, where), hint="locals")
    counted = tags_of(engine, program, counted=True) + (tags_of(engine, "", counted=True) if program else [])
    if counted:
        add("Timers", Names(tree, lambda: counted))
    if program and tags_of(engine, program):
        add(f"Tags of {program}", Names(tree, lambda: tags_of(engine, program)))
    add("Tags", Names(tree, lambda: tags_of(engine, "")))
    words = dict(adapter.the_subject().words)
    for name, image in (("Inputs", "I"), ("Outputs", "O")):
        add(name, Modules(words, image, word_reader(adapter)))
    return {"scopes": found}


def _named_in(adapter: Adapter, run: LineRun) -> list[tuple[str, str]]:
    """Return the tags that a rung names, by the name in the rung and the full one."""
    tags, program = adapter.place().view.engine.tags, _program(adapter, run)
    found: dict[str, str] = {}
    for step in run.line.all_steps:
        for operand in step.operands:
            for name in _texts(operand):
                scoped = f"\\{program}.{name}" if program else name
                full = scoped if scoped in tags else name
                if full in tags and HIDDEN not in name:
                    found[name] = full
    return list(found.items())


def _texts(operand: object) -> Iterator[str]:
    if isinstance(operand, AddOnCall):
        yield operand.instance.text
        yield from (each.text for each in operand.handed.values())
    elif isinstance(operand, Place | Group):
        if not operand.frame:  # locals are their own scope
            yield operand.text
    elif isinstance(operand, Calculation):
        for each in operand.operands:
            yield from _texts(each)


def word_reader(adapter: Adapter) -> Callable[[int, str, int], int]:
    """Return what reads words of images: of a program's own images at the place, of others after the scan."""
    cursor, subject = adapter.place(), adapter.the_subject()
    images, memory = Images(subject.words), cursor.view.engine.memory
    leaves = {(leaf.slot, "O" if leaf.output else "I"): leaf for leaf in memory.layout.images}

    def read(slot: int, image: str, number: int) -> int:
        leaf = leaves.get((slot, image))
        if leaf is not None and memory.has(leaf):
            return int(memory.read(leaf, number))
        return images.word(subject.memory(cursor.scan), slot, image, number)

    return read


def variables(adapter: Adapter, said: Json) -> Json:
    """Open one level of values."""
    start, count = whole(said, "start", 0), whole(said, "count", 0)
    if start < 0 or count < 0:
        raise DebugError(f"start {start}, count {count}: must not be negative")
    return {"variables": tree_of(adapter).variables(whole(said, "variablesReference"), start, count)}


# --- setting


def set_variable(adapter: Adapter, said: Json) -> Json:
    """Set a value of a node."""
    tag = tree_of(adapter).node(whole(said, "variablesReference")).tag(text(said, "name"))
    return {"value": _set(adapter, tag, text(said, "value"))}


def set_expression(adapter: Adapter, said: Json) -> Json:
    """Set a tag."""
    return {"value": _set(adapter, text(said, "expression").strip(), text(said, "value"))}


def _set(adapter: Adapter, tag: str, said: str) -> str:
    """Set a tag before the next scan; a word or bit of an image is forced, since scans write it."""
    _refuse_past(adapter)
    tags = adapter.place().view.engine.tags
    if tag not in tags and ":" not in tag:
        raise DebugError(f"no tag {tag}")
    value = value_in(said, _present(tags, tag))
    image = ":" in tag
    adapter.the_driver().give(actions.Force(tag, value) if image else actions.Write(tag, value))
    if not image:
        _show_set(adapter, tag, value)
    return shown(value)


def _show_set(adapter: Adapter, tag: str, value: object) -> None:
    """Show a value that was set between two scans, wherever in the latest scan the client stands."""
    adapter.place().view.set(tag, value)


def _refuse_past(adapter: Adapter) -> None:
    if adapter.in_past():
        scan = adapter.place().scan
        raise DebugError(f"scan {scan:,} is past: evaluate `branch` to go on from it with other values")


def _present(tags: Tags, tag: str) -> object:
    return tags[tag] if tag in tags else 0  # noqa: SIM401 - tags have no get


# --- expressions


def evaluate(adapter: Adapter, said: Json) -> Json:
    """Evaluate a tag, an expression, or a command."""
    asked = text(said, "expression").strip()
    context = said.get("context")
    word, _, rest = asked.partition(" ")
    command = COMMANDS.get(word.lower())
    if command is not None and context in ("repl", None):
        return {"result": command(adapter, rest.strip()), "variablesReference": 0}
    name = _tag_named(adapter, asked, said.get("frameId"))
    if name is not None:
        found = tree_of(adapter).value(asked, name)
        node = found.pop("node", None)
        reference = 0 if node is None else tree_of(adapter).add(node)
        hover = _hover(adapter, name, found["value"]) if context == "hover" else found["value"]
        return {"result": hover, "type": found["type"], "variablesReference": reference}
    value = _expression(adapter, asked)()
    return {"result": shown(value), "type": type(value).__name__, "variablesReference": 0}


def _tag_named(adapter: Adapter, name: str, frame: object) -> str | None:
    """Return the full name of a tag as a rung of the frame names it; None for anything else."""
    tags = adapter.place().view.engine.tags
    run = _run_of(adapter, frame) if type(frame) is int else None
    program = _program(adapter, run)
    scoped = [f"\\{program}.{name}"] if program else []
    own = [f"{run.instance}.{name}"] if run is not None and run.instance else []
    return next((each for each in (*own, *scoped, name) if each in tags), None)


def _expression(adapter: Adapter, asked: str) -> Callable[[], object]:
    cursor, subject = adapter.place(), adapter.the_subject()
    around = Surroundings(
        subject.words, word_reader(adapter), lambda: subject.now_ns(cursor.scan), lambda: cursor.scan
    )
    try:
        return compiled(asked, cursor.view.engine, around)
    except ExpressionError as error:
        raise DebugError(str(error)) from error


def _hover(adapter: Adapter, tag: str, value: str) -> str:
    """Return what a hover says of a tag: its value, address and last change."""
    from .setting import last_change

    layout = adapter.place().view.engine.lowered.layout
    declared = layout.declarations.get(tag.upper())
    target = getattr(declared, "target", None)
    comment = getattr(declared, "comment", "")
    changed = last_change(adapter, tag)
    parts = [
        f"{tag} = {value}",
        "" if target is None else f"alias of {target}",
        comment,
        "not changed yet" if changed is None else f"since scan {changed:,}",
    ]
    return "; ".join(filter(None, parts))


# --- commands of the console


def _assigned(rest: str) -> tuple[str, str]:
    name, sign, value = rest.partition("=")
    if not sign or not name.strip() or not value.strip():
        raise DebugError("write TAG = VALUE")
    return name.strip().removesuffix(":").strip(), value.strip()


def _set_command(adapter: Adapter, rest: str) -> str:
    tag, value = _assigned(rest)
    return f"{tag} is set to {_set(adapter, tag, value)}"


def _force_command(adapter: Adapter, rest: str) -> str:
    _refuse_past(adapter)
    tag, said = _assigned(rest)
    tags = adapter.place().view.engine.tags
    value = value_in(said, _present(tags, tag))
    adapter.the_driver().give(actions.Force(tag, value))
    if tag in tags and ":" not in tag:
        _show_set(adapter, tag, value)
    adapter.tree = None
    return f"{tag} is forced to {shown(value)}"


def _release_command(adapter: Adapter, rest: str) -> str:
    _refuse_past(adapter)
    if not rest:
        raise DebugError("write release TAG, or release all")
    adapter.the_driver().give(actions.Unforce(rest))
    adapter.tree = None
    return "all forces are released" if rest == actions.ALL else f"{rest} is released"


def _why_command(adapter: Adapter, rest: str) -> str:
    from .causes import why

    return why(adapter, rest)


def _branch_command(adapter: Adapter, _rest: str) -> str:
    scan = adapter.place().scan + 1
    adapter.the_driver().branch(scan)
    return f"a new session goes on from scan {scan:,}"


def _reload_command(adapter: Adapter, _rest: str) -> str:
    adapter.the_driver().give(actions.Reload())
    return "the saved program is loaded, and goes on from the present values"


COMMANDS: Mapping[str, Callable[[Adapter, str], str]] = {
    "set": _set_command,
    "force": _force_command,
    "release": _release_command,
    "why": _why_command,
    "branch": _branch_command,
    "reload": _reload_command,
}
"""Commands of the console, by their first word."""


# --- further


def exception_info(adapter: Adapter, _said: Json) -> Json:
    """Say what the stop was."""
    says = adapter.reason.get("text") or "no exception"
    return {"exceptionId": adapter.reason.get("reason", ""), "description": says, "breakMode": "always"}


def sources(adapter: Adapter, _said: Json) -> Json:
    """List the files of the program."""
    files = adapter.the_subject().places(adapter.the_subject().extent[1]).lines
    return {"sources": [{"name": Path(each).name, "path": str(each)} for each in files]}


def completions(adapter: Adapter, said: Json) -> Json:
    """Complete the name before the cursor."""
    line, column = text(said, "text"), whole(said, "column")
    before = line[: max(0, column - 1)]
    word = before[len(before.rstrip("".join(_LETTERS))) :]
    head, dot, _ = word.rpartition(".")
    engine = adapter.place().view.engine
    names: list[str] = []
    if dot and head in engine.tags and isinstance(where := engine.tags.where(head), Group):
        tree = tree_of(adapter)
        names = [f"{head}.{each['name']}" for each in Parts(tree, head, where).children()]
    else:
        stop = adapter.place().stop
        program = _program(adapter, None if stop is None else stop.run)
        own = tags_of(engine, program) if program else []
        names = [short for short, _full in own + tags_of(engine, "")] + list(COMMANDS)
    fitting = [each for each in names if each.lower().startswith(word.lower())]
    start = column - 1 - len(word)
    return {
        "targets": [
            {"label": each, "start": start, "length": len(word)} for each in fitting[:COMPLETIONS_MOST]
        ]
    }


_LETTERS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.:[]\\"
