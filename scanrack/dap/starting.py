"""Requests that begin and end a session: a rack that runs, or a trace."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .protocol import DebugError, Json, text

if TYPE_CHECKING:
    from scanrack.jobs.load.loading import LoadedRack

    from .adapter import Adapter

LAUNCH = {
    "program": (str, "rack file, export or trace"),
    "pytest": (str, "in place of a program: arguments of pytest, such as test_line.py::test_round"),
    "stopOnEntry": (bool, "stop before the first scan; false = run to the first breakpoint"),
    "speed": (str, "times real time, 0.01 to 1000, or max"),
    "record": (str, "trace file; without it a temporary one"),
    "page": (bool, "also open the session to the browser"),
    "live": (bool, "real ports may move real motors; pausing is refused"),
    "scan": (int, "of a trace: the scan to begin with"),
    "trust": (bool, "run Python that came with a trace"),
}
"""Arguments of launch and attach: their types and meanings."""

_OF_CLIENTS = ("name", "type", "request", "noDebug", "restart", "presentation", "cwd", "preLaunchTask")


def launch(adapter: Adapter, said: Json) -> None:
    """Run a rack, or open a trace."""
    from scanrack.jobs.load.loading import load_job, runs

    wanted = _checked(adapter, said)
    adapter.stop_on_entry = wanted.get("stopOnEntry", True) is True
    if adapter.waits:
        adapter.waits = False
        return
    if "pytest" in wanted:
        from .in_test import run_tests

        adapter.start = lambda adapter: run_tests(adapter, wanted["pytest"])
        return
    program = text(said, "program")
    if not runs(program):
        attach(adapter, said)
        return
    job = load_job(program)
    adapter.start = lambda adapter: _play(adapter, job, wanted)


def attach(adapter: Adapter, said: Json) -> None:
    """Open a trace, or a test that waits."""
    if adapter.waits:
        launch(adapter, said)
        return
    from .recorded import debug_trace

    wanted = _checked(adapter, said)
    path = Path(text(said, "program"))
    if not path.is_file():
        raise DebugError(f"{path}: no such file")
    adapter.stop_on_entry = True
    adapter.start = lambda adapter: debug_trace(
        adapter, path, wanted.get("scan"), trust=wanted.get("trust") is True
    )


def _checked(adapter: Adapter, said: Json) -> Json:
    """Return the arguments; refuse unknown ones, and a second launch."""
    if adapter.subject is not None or adapter.start is not None:
        raise DebugError("something is debugged already: disconnect first")
    for name, value in said.items():
        if name.startswith("__") or name in _OF_CLIENTS:
            continue
        if name not in LAUNCH:
            raise DebugError(f"no argument {name!r}: there are {', '.join(LAUNCH)}")
        kind = LAUNCH[name][0]
        if type(value) is not kind:
            raise DebugError(f"{name} {value!r}: must be {_KINDS[kind]}")
    return said


_KINDS = {str: "a text", bool: "true or false", int: "a whole number"}


def _play(adapter: Adapter, job: LoadedRack, wanted: Json) -> None:
    """Run a rack in a session of `scanrack watch`, until the client ends it."""
    from scanrack.jobs.run.build import check_ports
    from scanrack.watch.command import speed_of
    from scanrack.watch.play import watch_job
    from scanrack.watch.watch_options import WatchArguments, WatchOptions

    from .live import REMEMBERED, Live

    live = wanted.get("live") is True
    check_ports(job.spec, realtime=True, live=live)
    record = wanted.get("record")
    page = wanted.get("page") is True
    asked = WatchArguments(
        rack=str(wanted["program"]),
        speed=str(wanted.get("speed", "1")),
        paused=not live,
        live=live,
        control=live,
        record=None if record is None else Path(record),
    )
    watch_job(
        job,
        WatchOptions(
            asked,
            speed_of(asked.speed),
            page=page,
            door=lambda session, run: Live(adapter, session, run, job, page=page),
            remembered=REMEMBERED,
        ),
    )


def configured(adapter: Adapter, _said: Json) -> None:
    """Begin: all breakpoints are set."""
    adapter.configured = True
    adapter.after_response(lambda: adapter.the_driver().begin(stop=adapter.stop_on_entry))


def disconnect(adapter: Adapter, _said: Json) -> None:
    """End the session."""
    adapter.over = True
    if adapter.driver is not None:
        adapter.driver.end()
