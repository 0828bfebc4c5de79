"""Requests that begin and end a session with a running rack or a trace."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .protocol import DebugError, Json, text

if TYPE_CHECKING:
    from scanrack.jobs.load.loading import LoadedRack

    from .adapter import Adapter

LAUNCH = {
    "program": (str, "rack file, export or trace"),
    "pytest": (str, "arguments of pytest, such as test_line.py::test_round; replaces `program`"),
    "stopOnEntry": (bool, "whether to stop before the first scan, instead of at the first breakpoint"),
    "speed": (str, "speed relative to real time, 0.01 to 1000, or max"),
    "record": (str, "trace file; a temporary file if omitted"),
    "page": (bool, "whether to open the session in the browser as well"),
    "live": (bool, "whether real ports can move real motors; pausing is then refused"),
    "scan": (int, "the scan of a trace to start at"),
    "trust": (bool, "whether to run Python code that is stored in a trace"),
}
"""Arguments of launch and attach, with their types and meanings."""

_OF_CLIENTS = ("name", "type", "request", "noDebug", "restart", "presentation", "cwd", "preLaunchTask")


def launch(adapter: Adapter, arguments: Json) -> None:
    """Choose what runs after the response: pytest, a rack or a trace; or let a waiting test continue."""
    from scanrack.jobs.load.loading import load_job, runs

    requested = _checked(adapter, arguments)
    adapter.stop_on_entry = requested.get("stopOnEntry", True) is True
    if adapter.waits:
        adapter.waits = False
        return
    if "pytest" in requested:
        from .in_test import run_tests

        adapter.start = lambda adapter: run_tests(adapter, requested["pytest"])
        return
    program = text(arguments, "program")
    if not runs(program):
        attach(adapter, arguments)
        return
    job = load_job(program)
    adapter.start = lambda adapter: _play(adapter, job, requested)


def attach(adapter: Adapter, arguments: Json) -> None:
    """Open a trace, or connect to a waiting test."""
    if adapter.waits:
        launch(adapter, arguments)
        return
    from .recorded import debug_trace

    requested = _checked(adapter, arguments)
    path = Path(text(arguments, "program"))
    if not path.is_file():
        raise DebugError(f"{path}: no such file")
    adapter.stop_on_entry = True
    adapter.start = lambda adapter: debug_trace(
        adapter, path, requested.get("scan"), trust=requested.get("trust") is True
    )


def _checked(adapter: Adapter, arguments: Json) -> Json:
    """Return the arguments; refuse unknown arguments and a second launch."""
    if adapter.subject is not None or adapter.start is not None:
        raise DebugError("a session is already open: disconnect first")
    for name, value in arguments.items():
        if name.startswith("__") or name in _OF_CLIENTS:
            continue
        if name not in LAUNCH:
            raise DebugError(f"no argument {name!r}: choose from {', '.join(LAUNCH)}")
        kind = LAUNCH[name][0]
        if type(value) is not kind:
            raise DebugError(f"{name} {value!r}: must be {_KINDS[kind]}")
    return arguments


_KINDS = {str: "a text", bool: "true or false", int: "a whole number"}


_SAVED = "evaluate `test` to test it, `accept` or `reload` to continue with it"


def _play(adapter: Adapter, job: LoadedRack, requested: Json) -> None:
    """Run a rack in a session of `scanrack watch`, until the client ends it."""
    from scanrack.jobs.run.build import check_ports
    from scanrack.watch.command import speed_of
    from scanrack.watch.play import watch_job
    from scanrack.watch.watch_options import WatchArguments, WatchOptions

    from .live import REMEMBERED, Live

    is_live = requested.get("live") is True
    check_ports(job.spec, realtime=True, live=is_live)
    record = requested.get("record")
    page = requested.get("page") is True
    watched = WatchArguments(
        rack=str(requested["program"]),
        speed=str(requested.get("speed", "1")),
        paused=not is_live,
        live=is_live,
        control=is_live,
        record=None if record is None else Path(record),
    )
    watch_job(
        job,
        WatchOptions(
            watched,
            speed_of(watched.speed),
            page=page,
            door=lambda session, run: Live(adapter, session, run, job, page=page),
            saved=lambda name: adapter.output(f"{name} was saved: {_SAVED}\n"),
            remembered=REMEMBERED,
        ),
    )


def configured(adapter: Adapter, _arguments: Json) -> None:
    """Begin the session, because all breakpoints have been set."""
    adapter.configured = True
    adapter.after_response(lambda: adapter.the_driver().begin(stop=adapter.stop_on_entry))


def disconnect(adapter: Adapter, _arguments: Json) -> None:
    """End the session."""
    adapter.over = True
    if adapter.driver is not None:
        adapter.driver.end()
