"""Recordings in the monitor of `scanrack watch`, in this process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.traces import Trace, open_trace
from scanrack.traces.read import reader
from scanrack.watch.monitors.page import Page
from scanrack.watch.monitors.questions import handle_message as ask
from scanrack.watch.monitors.trace_monitor import TraceMonitor
from scanrack.watch.recorded_session import OpenedRecording, TracePlace

COUNTING = """
PROGRAM count
TAG Count : DINT
TAG Even : BOOL
TAG Step : DINT := 1
ROUTINE Main
ADD(Count,Step,Count);
XIO(Even)OTE(Even);
END
"""
"""A program that counts its scans: values depend on all scans before. Even is on in scans 0, 2, 4, ..."""

RACK = 'name = "count"\nprogram = "count.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


def recorded(folder: Path, scans: int, program: str = COUNTING, *, more: str = "") -> Path:
    """Record a run of a ladder program; `more` goes into the rack file."""
    (folder / "count.rung").write_text(program, encoding="utf-8")
    (folder / "count.toml").write_text(RACK + more, encoding="utf-8")
    with ExitStack() as ports:
        run = JobRun(load_job(str(folder / "count.toml")), ports, RunOptions(trace=folder / "count.mcap"))
        run.run(scans)
    return folder / "count.mcap"


class Opened:
    """A recording with one page.

    Attributes:
        frame: what the page shows.
    """

    def __init__(self, path: Path, folder: Path, scan: int | None = None, *, trust: bool = False) -> None:
        self.trace: Trace = open_trace(path)
        self.recording = OpenedRecording(self.trace, TracePlace(path, scan, ""), folder, trust=trust)
        self.monitor: TraceMonitor = self.recording.monitor(lambda *_given, **_more: None)
        self.page = Page()
        self.frame: dict[str, Any] = {}
        self.monitor.join(self.page)
        self.hear()

    def hear(self) -> dict[str, Any]:
        """Take a frame."""
        self.frame |= self.monitor.frame(self.page)
        return self.frame

    def look(self, scan: int) -> dict[str, Any]:
        """Look at a scan."""
        ask(self.monitor, self.page, {"id": 1, "do": "look", "scan": scan})
        return self.hear()

    def settle(self) -> dict[str, Any]:
        """Let all be read that is left out at first."""
        while self.monitor.tick():
            pass
        return self.hear()


@contextmanager
def opened(path: Path, folder: Path, scan: int | None = None, *, trust: bool = False) -> Iterator[Opened]:
    """Open a recording."""
    found = Opened(path, folder, scan, trust=trust)
    with found.trace:
        yield found


def chunks_read(patch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that gets the place of every chunk that is read from now on."""
    read: list[int] = []
    whole = reader.take_apart

    def noted(file: Any, section: Any, shape: Any) -> Any:
        read.append(section.span.offset)
        return whole(file, section, shape)

    patch.setattr(reader, "take_apart", noted)
    return read
