"""Runs a Python program or a list of steps again, to observe its lines in some scans.

    scans     0 ............ 7,999    8,000 ...... 8,999
    program   runs                    runs, and its lines are observed

A program can't be copied in the middle of a run, so going back means starting again with the first scan.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from io import StringIO
from types import FrameType

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.python.line_marks import WATCH, Observer
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.replay import PackedTrace
from typing_extensions import override

from ..load.program import lines_marked
from ..load.recorded_scans import RecordedScan, recorded_scans
from ..replay.input_replay import InputReplay
from .traced_run import Load, fresh


class _Silent(StringIO):
    """Discards the program's output during a rerun."""

    @override
    def write(self, text: str) -> int:
        return len(text)


_SILENT = _Silent()


class ProgramRerun:
    """A program that runs again on recorded inputs.

    Args:
        recording: returns the recording of the scans so far.

    Attributes:
        replay: the current run; see `rewind`.
    """

    replay: InputReplay

    def __init__(self, load: Load, spec: RackSpec, recording: Callable[[], PackedTrace]) -> None:
        self._load, self._spec, self._recording = load, spec, recording
        self._begun = False

    @property
    def at(self) -> int:
        """Number of the last scan that was run; -1 before the first one."""
        return self.replay.scan if self._begun else -1

    @property
    def logic(self) -> ScanLogic:
        """The program after that scan."""
        return self.replay.logic

    @property
    def departs(self) -> int | None:
        """The first scan whose outputs differ from the recorded ones; None if there is none."""
        return self.replay.departs if self._begun else None

    def rewind(self, first: int) -> None:
        """Start again if scan `first` has already run.

        Raises:
            ValueError: the recording does not begin with scan 0.
        """
        if self._begun and self.at < first:
            return
        recording = self._recording()
        if begins := recording.numbers[0]:
            raise ValueError(f"the program can't be run again: the recording begins with scan {begins:,}")
        with lines_marked(), fresh(self._load) as logic:
            self._watch = WATCH.get()
        edited = None if self._load.edited is None else self._edited
        self.replay = InputReplay(self._spec, recording.slots, edited=edited)
        self.replay.attach(logic)
        self._begun = True

    def walk(
        self, first: int, last: int, observer: Callable[[ScanLogic], Observer | None]
    ) -> Iterator[tuple[int, Observer | None]]:
        """Run scans up to `last`; yield each one from `first` on, with its observer.

        Args:
            observer: returns the observer of a scan, given the program before the scan; None for no observer.

        Raises:
            ValueError: the scans can't be repeated.
        """
        self.rewind(first)
        recording, replay = self._recording(), self.replay
        replay.read_events(recording)
        self._watch.only()
        _run_silently(replay, recorded_scans(recording, self.at + 1, first - 1))
        for scan in recorded_scans(recording, self.at + 1, last):
            replay.give_orders(scan)
            observed = observer(replay.logic)
            if observed is not None and self._watch.observers != [observed]:
                self._watch.only(observed)
            _run_silently(replay, (scan,))
            yield scan.number, observed

    def _edited(self, number: int) -> ScanLogic:
        assert self._load.edited is not None
        with lines_marked(self._watch):
            return self._load.edited(number)


def _run_silently(replay: InputReplay, scans: Iterable[RecordedScan]) -> None:
    """Run scans, and discard the program's output."""
    streams = sys.stdout, sys.stderr
    sys.stdout = sys.stderr = _SILENT
    try:
        for scan in scans:
            replay.run(scan)
    finally:
        sys.stdout, sys.stderr = streams


@dataclass(frozen=True, slots=True)
class ExecutedLines:
    """The lines that ran in the requested scans.

    Attributes:
        lines: the sorted line numbers of each scan.
        departs: the first scan whose outputs differ from the recorded ones; None if there is none.
    """

    lines: dict[int, tuple[int, ...]]
    departs: int | None


def executed_lines(recording: PackedTrace, spec: RackSpec, load: Load, rows: range) -> ExecutedLines:
    """Run a program again on the inputs of a recording; return the lines of its file that ran in some scans.

    Args:
        rows: the rows of the scans in the recording.

    Raises:
        ValueError: the recording does not begin with scan 0.
    """
    rerun = ProgramRerun(load, spec, lambda: recording)
    observer = _LinesOfFile(load.program.name)
    lines_by_scan: dict[int, tuple[int, ...]] = {}
    for scan, _ in rerun.walk(rows[0], rows[-1], lambda _logic: observer):
        lines_by_scan[scan] = tuple(sorted(observer.numbers))
        observer.numbers.clear()
    return ExecutedLines(lines_by_scan, rerun.departs)


class _LinesOfFile(Observer):
    """Notes the lines of a file that begin to run."""

    def __init__(self, file: str) -> None:
        self._file = file
        self.numbers: set[int] = set()

    @override
    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        if file == self._file:
            self.numbers.add(line)
