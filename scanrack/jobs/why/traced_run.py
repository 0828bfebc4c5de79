"""Runs a program again on recorded inputs, and traces some of its scans.

    recorded inputs ---> a fresh instance of the program ---> outputs, compared with the recorded ones
                                   |
                                   +--> in the traced scans: the line of each change, and the reads before it

The program is reloaded, so that the program of the bench is not disturbed. The run repeats the recording if
the program depends only on its inputs and its time. It explains only scans before the first difference.
"""

from __future__ import annotations

import sys
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import field
from io import StringIO
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.python.line_marks import WATCH, LineWatch
from scanrack.ladder.state.memory import same
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.scan import LogicScan, ScanLogic
from scanrack.traces.replay import PackedTrace

from ..replay.input_replay import InputReplay
from ..trust.attachments import forget_imported
from .past import ALL_BITS, Past
from .source.conditions import Stands, stands_in, values_of
from .source.input_reads import Reads
from .source.lines import Line, Lines
from .source.senders import Sender, senders

MOST_LINES_WITH_VALUES = 20_000
"""Maximum number of lines in a scan for which the values of names are kept."""


@dataclass(frozen=True, slots=True)
class Load:
    """Reloads the program."""

    program: Path  # its file; modules imported from its folder are also reloaded
    logic: Callable[[], ScanLogic]  # returns a fresh instance
    edited: Callable[[int], ScanLogic] | None = None  # the same for an edit by number; None without edits

    @property
    def folder(self) -> Path:
        """The folder of the program."""
        return self.program.parent


class LineState(NamedTuple):
    """The memory block and the watched value at a line of a traced scan."""

    block: bytes  # the memory block
    value: Any  # the watched value


@dataclass(frozen=True, slots=True)
class TracedChange:
    """A change in the memory block or the watched value, made by a line."""

    line: Line  # number 0 if no line of the user's program made it
    before: LineState
    after: LineState
    stands: Stands  # the conditions around the line
    values: Mapping[str, str]  # values of the names in the conditions and the line when the line began
    masks: Mapping[tuple[int, int], int]  # the program's reads up to the change, see `Reads.masks`
    senders: Sequence[Sender] = ()  # the commands of the program's axes, if no line made the change

    def affects(self, offset: int, mask: int = ALL_BITS) -> bool:
        """Return whether masked bits of the word at an offset of the memory block changed."""
        before, after = (
            int.from_bytes(state.block[offset : offset + 2], "little") for state in (self.before, self.after)
        )
        return bool((before ^ after) & mask)


@dataclass(slots=True)
class TracedRun:
    """The result of a repeated run.

    Attributes:
        changes: the changes in each traced scan, in order, by row.
        departs: row of the first scan whose outputs differ from the recorded ones; None if there is none.
        lost: row of the first scan of an edited program that can't be reloaded; None if there is none.
        value: the watched value after the run.
    """

    changes: dict[int, list[TracedChange]] = field(default_factory=dict)
    departs: int | None = None
    lost: int | None = None
    value: Any = None

    def explains(self, row: int) -> bool:
        """Return whether the program repeated the recording up to and including a scan."""
        return all(end is None or row < end for end in (self.departs, self.lost))

    def no_line(self, past: Past) -> str:
        """Return the reason why the line of a change is unknown, as a sentence."""
        if self.lost is not None and (self.departs is None or self.lost <= self.departs):
            edit = past.when(self.lost)
            return (
                f"no line can be named: the program was edited before {edit}, and the edit can't be repeated"
            )
        assert self.departs is not None
        when = past.when(self.departs)
        reason = f"run again on the recorded inputs, the program writes other words from {when} on"
        return f"no line can be named: {reason}; it depends on more than its inputs and its time"


Values = Callable[[], dict[str, Any]]
"""Reads values of a program, by name."""

Watched = Callable[[ScanLogic], Callable[[], Any]]
"""Makes a function that reads a value of a freshly loaded program."""


def unwatched(_logic: ScanLogic) -> Callable[[], None]:
    """Watch no value."""
    return lambda: None


Look = Callable[[Line, FrameType, Reads], None]
"""Receives each line of a traced scan when it begins, with its frame."""


def run_again(
    recording: PackedTrace,
    spec: RackSpec,
    load: Load,
    rows: frozenset[int],
    last: int,
    watched: Watched = unwatched,
    look: Look | None = None,
) -> TracedRun:
    """Run a program again on the inputs of a recording; return its changes in some scans.

    Args:
        recording: the inputs, and the expected outputs.
        rows: the scans to trace.
        last: row of the last scan to run.
        watched: makes a reader of a value to watch besides the outputs.
        look: receives the lines of the traced scans.
    """
    with fresh(load) as logic:
        traced = _Tracer(rows, watched(logic), load.program, look)
        replay = InputReplay(spec, recording.slots, call=traced.call, edited=load.edited)
        traced.begin(replay, logic)
        for _row in replay.play(recording, last):
            pass
        outcome, numbers = traced.outcome, recording.numbers
        outcome.value = traced.read()
    outcome.departs = None if replay.departs is None else bisect_left(numbers, replay.departs)
    lost_scans = [*replay.orders.lost, *replay.lost]
    outcome.lost = bisect_left(numbers, min(lost_scans)) if lost_scans else None
    return outcome


def last_changes(
    recording: PackedTrace, spec: RackSpec, load: Load, last: int, watched: Callable[[ScanLogic], Values]
) -> tuple[dict[str, int], dict[str, Any]]:
    """Run a program again; return the row in which each value last changed, and the values after the run.

    Args:
        watched: makes a function that reads the values of a freshly loaded program.
    """
    changes: dict[str, int] = {}
    with fresh(load) as logic:
        read = watched(logic)
        values, replay = read(), InputReplay(spec, recording.slots, edited=load.edited)
        replay.attach(logic)
        for row in replay.play(recording, last):
            now = read()
            changes |= {name: row for name, value in now.items() if not same(value, values[name])}
            values = now
    return changes, values


@contextmanager
def fresh(load: Load) -> Iterator[ScanLogic]:
    """Reload a program with its own modules. Its lines are not observed, and its output is discarded."""
    modules, watch = dict(sys.modules), WATCH.set(LineWatch())
    forget_imported(load.folder.resolve())
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            yield load.logic()
    finally:
        forget_imported(load.folder.resolve())
        sys.modules.update(modules)
        WATCH.reset(watch)


class _Tracer:
    """Traces a program in some scans of its replay.

    Args:
        rows: the rows of the scans to trace.
        read: reads the watched value.
        look: receives the lines of these scans.

    Attributes:
        outcome: the changes so far.
    """

    def __init__(
        self, rows: frozenset[int], read: Callable[[], Any], program: Path, look: Look | None
    ) -> None:
        self._rows, self.read, self._program, self._look = rows, read, program, look
        self._reads = Reads()
        self._lines = Lines(self._watch, self._changed, self._begins)
        self._reads.counts = lambda: self._lines.in_program  # not those that scanrack makes between lines
        self._values: dict[Line, dict[str, str]] = {}
        self._lines_begun = 0
        self._replay: InputReplay
        self.outcome = TracedRun()

    def begin(self, replay: InputReplay, logic: ScanLogic) -> None:
        """Attach a program to watched images."""
        self._replay = replay
        self._reads.watch(replay.view.slot)
        replay.attach(logic)

    def call(self, logic: ScanLogic, scan: LogicScan) -> None:
        """Run a scan; trace it if its row was requested."""
        if self._replay.row not in self._rows:
            logic(scan)
            return
        self._reads.on, self._lines_begun = True, 0
        self._values.clear()
        self._reads.masks.clear()
        self.outcome.changes[self._replay.row] = []
        try:
            self._lines.call(logic, scan)
        finally:
            self._reads.on = False

    def _watch(self) -> LineState:
        return LineState(self._replay.block(), self.read())

    def _begins(self, line: Line, frame: FrameType) -> None:
        """Keep the values of the names of a line that begins, and pass the line to `look`."""
        self._lines_begun += 1
        if self._lines_begun <= MOST_LINES_WITH_VALUES:
            stands = stands_in(line.file, line.number)
            names = [name for _, inner in stands.inside for name in inner]
            self._reads.on = False  # looking up the values is not a read by the program
            self._values[line] = values_of((*names, *stands.names), frame)
            self._reads.on = True
        if self._look is not None:
            self._look(line, frame, self._reads)

    def _changed(self, line: Line, before: Any, after: Any) -> None:
        """Add a change by a line to the outcome, with the values and reads that led to it."""
        stands = stands_in(line.file, line.number)
        change = TracedChange(
            line,
            before,
            after,
            stands,
            values=self._values.get(line, {}),
            masks=dict(self._reads.masks),
            senders=() if line.number else senders(self._replay.logic, self._program),
        )
        self.outcome.changes[self._replay.row].append(change)
