"""Requests that inspect and set values, and the console commands."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scanrack.io_images.times import seconds
from scanrack.ladder.debug.watched import shown
from scanrack.runtime.live import actions

from .conditions import compiled
from .executed_scan import callers
from .protocol import DebugError, Json, text, whole
from .variables import ReadWord, modules_in, value_in
from .view import Node

if TYPE_CHECKING:
    from .adapter import Adapter

SCAN_FRAME = 10_000
"""Id of the outermost frame, the scan."""

NOWHERE = {"line": 0, "column": 0}
"""Line and column of a frame without a file."""

COMPLETIONS_MOST = 200


def threads(_adapter: Adapter, _arguments: Json) -> Json:
    """Return the name of the thread."""
    return {"threads": [{"id": 1, "name": "scan"}]}


# --- frames


def stack(adapter: Adapter, arguments: Json) -> Json:
    """List the frames, innermost first: rung, callers, task, scan."""
    frames = list(_frames(adapter))
    start, levels = whole(arguments, "startFrame", 0), whole(arguments, "levels", 0)
    end = start + levels if levels else None
    return {"stackFrames": frames[start:end], "totalFrames": len(frames)}


def _frames(adapter: Adapter) -> Iterator[Json]:
    """Yield the frames: the rung or line and its callers, the task if it is known, and the scan."""
    cursor, subject = adapter.place(), adapter.the_subject()
    places, scan, view = subject.places(cursor.scan), cursor.scan, cursor.view
    runs = _runs(adapter)
    for number, run in enumerate(runs, 1):
        yield {"id": number, "name": view.frame(run), **NOWHERE, **places.source(run.line.origin)}
    task = view.task(runs[-1]) if runs else ""
    if task:
        yield {"id": SCAN_FRAME - 1, "name": f"task {task}", **NOWHERE, "presentationHint": "label"}
    moment = "scan" if cursor.stop is not None else "end of scan"
    location = f"{moment} {scan:,}, {seconds(subject.now_ns(scan))} s"
    suffix = " (past)" if adapter.in_past() else ""
    last = None if runs else view.last_origin()
    source = {} if last is None else places.source(last)
    yield {"id": SCAN_FRAME, "name": location + suffix, **NOWHERE, **source}


def _runs(adapter: Adapter) -> list[Any]:
    """Return the rung or line, and the callers of its routine, innermost first."""
    stop = adapter.place().stop
    return [] if stop is None else [stop.run, *(caller.run for caller in callers(stop.run))]


def _run_of(adapter: Adapter, frame: int) -> Any:
    """Return a frame's rung or line, or None for other frames; raise DebugError for an outdated frame."""
    runs = _runs(adapter)
    if 1 <= frame <= len(runs):
        return runs[frame - 1]
    if frame in (SCAN_FRAME, SCAN_FRAME - 1):
        return None
    raise DebugError(f"frame {frame}: no longer exists, since the program has continued")


# --- scopes


def scopes(adapter: Adapter, arguments: Json) -> Json:
    """List the scopes of a frame."""
    run = _run_of(adapter, whole(arguments, "frameId"))
    tree, words = adapter.the_tree(), dict(adapter.the_subject().words)
    nodes: list[tuple[str, Node]] = list(adapter.place().view.scopes(tree, run))
    for name, image in (("Inputs", "I"), ("Outputs", "O")):
        nodes.append((name, partial(modules_in, words, image, _word_reader(adapter))))
    rows: list[Json] = []
    for name, node in nodes:
        hint = {"presentationHint": "locals"} if name == "Locals" else {}
        rows.append({"name": name, "variablesReference": tree.add(node), "expensive": False, **hint})
    return {"scopes": rows}


def _word_reader(adapter: Adapter) -> ReadWord:
    """Return a reader of image words: images of the program at the position, other images after the scan."""
    cursor, subject = adapter.place(), adapter.the_subject()
    after_scan = subject.words_in(lambda: subject.memory(cursor.scan))

    def read(slot: int, image: str, number: int) -> int:
        word = cursor.view.own_word(slot, image, number)
        return after_scan(slot, image, number) if word is None else word

    return read


def variables(adapter: Adapter, arguments: Json) -> Json:
    """List one level of values."""
    start, count = whole(arguments, "start", 0), whole(arguments, "count", 0)
    if start < 0 or count < 0:
        raise DebugError(f"start {start}, count {count}: must not be negative")
    return {"variables": adapter.the_tree().variables(whole(arguments, "variablesReference"), start, count)}


# --- setting


def set_variable(adapter: Adapter, arguments: Json) -> Json:
    """Set a value at a node."""
    tag = adapter.the_tree().tag(whole(arguments, "variablesReference"), text(arguments, "name"))
    return {"value": _set(adapter, tag, text(arguments, "value"))}


def set_expression(adapter: Adapter, arguments: Json) -> Json:
    """Set a tag."""
    return {"value": _set(adapter, text(arguments, "expression").strip(), text(arguments, "value"))}


def _set(adapter: Adapter, tag: str, written: str) -> str:
    """Set a tag before the next scan; force a word or bit of an image, because scans overwrite it."""
    _refuse_past(adapter)
    view, is_image = adapter.place().view, ":" in tag
    if tag not in view.tags and not is_image:
        raise DebugError(f"no tag {tag}")
    value = value_in(written, _present(view.tags, tag))
    adapter.the_driver().apply(actions.Force(tag, value) if is_image else actions.Write(tag, value))
    if not is_image:
        view.set(tag, value)
    return shown(value)


def _refuse_past(adapter: Adapter) -> None:
    if adapter.in_past():
        scan = adapter.place().scan
        raise DebugError(f"scan {scan:,} is past: evaluate `branch` to continue from it with other values")


def _present(tags: Any, tag: str) -> object:
    return tags[tag] if tag in tags else 0  # noqa: SIM401 - tags have no get


# --- expressions


def evaluate(adapter: Adapter, arguments: Json) -> Json:
    """Evaluate a tag, an expression, or a command."""
    expression = text(arguments, "expression").strip()
    context = arguments.get("context")
    word, _, argument_text = expression.partition(" ")
    command = COMMANDS.get(word.lower())
    if command is not None and context in ("repl", None):
        return {"result": command(adapter, argument_text.strip()), "variablesReference": 0}
    name = _tag_named(adapter, expression, arguments.get("frameId"))
    if name is not None:
        result = adapter.the_tree().value(expression, name)
        node = result.pop("node", None)
        reference = 0 if node is None else adapter.the_tree().add(node)
        hover = _hover(adapter, name, result["value"]) if context == "hover" else result["value"]
        return {"result": hover, "type": result["type"], "variablesReference": reference}
    value = _expression(adapter, expression)()
    return {"result": shown(value), "type": type(value).__name__, "variablesReference": 0}


def _tag_named(adapter: Adapter, name: str, frame: object) -> str | None:
    """Return the full name of a tag from its name in a frame's rung, or None for other expressions."""
    run = _run_of(adapter, frame) if type(frame) is int else None
    return adapter.place().view.full_name(name, run)


def _expression(adapter: Adapter, expression: str) -> Callable[[], object]:
    cursor = adapter.place()
    around = adapter.the_subject().around(lambda: cursor.scan, _word_reader(adapter))
    return compiled(expression, cursor.view.values, around)


def _hover(adapter: Adapter, tag: str, value: str) -> str:
    """Return the hover text of a tag, with its value, address and last change."""
    change_scan = adapter.last_change(tag)
    since = "not changed yet" if change_scan is None else f"since scan {change_scan:,}"
    return "; ".join(filter(None, [f"{tag} = {value}", *adapter.place().view.described(tag), since]))


# --- commands of the console


def _assignment(text: str) -> tuple[str, str]:
    """Return the tag and the value in `TAG = VALUE` or `TAG := VALUE`."""
    name, sign, value = text.partition("=")
    if not sign or not name.strip() or not value.strip():
        raise DebugError("write TAG = VALUE")
    return name.strip().removesuffix(":").strip(), value.strip()


def _set_command(adapter: Adapter, text: str) -> str:
    tag, value = _assignment(text)
    return f"{tag} is set to {_set(adapter, tag, value)}"


def _force_command(adapter: Adapter, text: str) -> str:
    """Force a tag, or a word or bit of an image; return the answer for the console."""
    _refuse_past(adapter)
    tag, value_text = _assignment(text)
    tags = adapter.place().view.tags
    value = value_in(value_text, _present(tags, tag))
    adapter.the_driver().apply(actions.Force(tag, value))
    if tag in tags and ":" not in tag:
        adapter.place().view.set(tag, value)
    adapter.tree = None
    return f"{tag} is forced to {shown(value)}"


def _release_command(adapter: Adapter, tag: str) -> str:
    """Release the force of a tag, or all forces; return the answer for the console."""
    _refuse_past(adapter)
    if not tag:
        raise DebugError("write release TAG, or release all")
    adapter.the_driver().apply(actions.Unforce(tag))
    adapter.tree = None
    return "all forces are released" if tag == actions.ALL else f"{tag} is released"


def _why_command(adapter: Adapter, tag: str) -> str:
    """Return why a tag has its value after the scan; print the causes, each with its line."""
    subject, scan = adapter.the_subject(), adapter.place().scan
    if tag not in adapter.place().view.tags:
        raise DebugError(f"no tag {tag!r}: write why TAG")
    links = adapter.look_elsewhere(lambda: subject.why(tag, scan))
    for cause, origin in links[1:]:
        adapter.output(f"  <- {cause}\n", more=subject.places(scan).source(origin))
    return links[0][0]


def _branch_command(adapter: Adapter, _text: str) -> str:
    scan = adapter.place().scan + 1
    adapter.the_driver().branch(scan)
    return f"a new session continues from scan {scan:,}"


def _return_command(adapter: Adapter, _text: str) -> str:
    """Return the console answer, and then move from a past scan to the latest one."""
    if not adapter.in_past():
        raise DebugError("this is the latest scan of the session")
    last = adapter.the_subject().extent[1]

    def back() -> None:
        adapter.look_at(last, "end")
        adapter.stopped("pause")

    adapter.after_response(back)
    return f"back at scan {last:,}"


def _reload_command(adapter: Adapter, _text: str) -> str:
    adapter.the_driver().apply(actions.Reload())
    return "the saved program continues with the present values"


def _edit_command(step: str) -> Callable[[Adapter, str], str]:
    """Return a command that tests, accepts or cancels the saved program; see `Driver.edit`."""

    def command(adapter: Adapter, _text: str) -> str:
        adapter.the_driver().edit(step)
        return "the program is checked"

    return command


COMMANDS: Mapping[str, Callable[[Adapter, str], str]] = {
    "set": _set_command,
    "force": _force_command,
    "release": _release_command,
    "why": _why_command,
    "branch": _branch_command,
    "return": _return_command,
    "test": _edit_command("try"),
    "accept": _edit_command("take"),
    "cancel": _edit_command("cancel"),
    "reload": _reload_command,
}
"""Console commands, by first word."""


# --- other requests


def exception_info(adapter: Adapter, _arguments: Json) -> Json:
    """Return the reason for the stop."""
    description = adapter.reason.get("text") or "no exception"
    return {
        "exceptionId": adapter.reason.get("reason", ""),
        "description": description,
        "breakMode": "always",
    }


def sources(adapter: Adapter, _arguments: Json) -> Json:
    """List the files of the program."""
    files = adapter.the_subject().places(adapter.the_subject().extent[1]).lines
    return {"sources": [{"name": Path(file).name, "path": str(file)} for file in files]}


def _names_for(adapter: Adapter, word: str) -> list[str]:
    """Return the members of the structure before a word's last dot; otherwise all tags and commands."""
    owner, dot, _ = word.rpartition(".")
    view, stop, tree = adapter.place().view, adapter.place().stop, adapter.the_tree()
    members = view.value(tree, owner, owner).get("node") if dot and owner in view.tags else None
    if members is not None:
        return [f"{owner}.{row['name']}" for row in members()]
    return [short for short, _full in view.names(None if stop is None else stop.run)] + list(COMMANDS)


def completions(adapter: Adapter, arguments: Json) -> Json:
    """Return completions for the name before the cursor."""
    line, column = text(arguments, "text"), whole(arguments, "column")
    match = _NAME_AT_END.search(line[: max(0, column - 1)])
    word = match[0] if match else ""
    matches = [name for name in _names_for(adapter, word) if name.lower().startswith(word.lower())][
        :COMPLETIONS_MOST
    ]
    start = column - 1 - len(word)
    return {"targets": [{"label": name, "start": start, "length": len(word)} for name in matches]}


_NAME_AT_END = re.compile(r"[\w.:\[\]\\]+$", re.ASCII)
