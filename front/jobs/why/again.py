"""A program runs again on recorded inputs, and the scans in question are traced.

    recorded inputs ---> a fresh instance of the program ---> outputs, compared with the recorded ones
                                   |
                                   +--> in the scans in question: which line changed what, after which reads

The program is loaded again, so the one on the bench is not disturbed. It answers as before if it depends on
its inputs and its time alone; from the first scan in which it does not, its lines explain nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from types import FrameType
from typing import Any

from ...runtime.config.rackspec import RackSpec
from ...runtime.loop.rack import Slot
from ...runtime.loop.scan import Scan, ScanLogic
from ...traces.replay import Recording
from ..record.wrapped import LogicWrapper
from ..trust.attachments import forget_imported
from .following import InputReplay
from .source.conditions import Stands, stands_in, values_of
from .source.lines import Line, Lines
from .source.reads import Reads
from .source.senders import Sender, senders

LOOKED_AT = 20_000
"""Lines of a scan whose names are looked up; a loop that runs longer is explained without values."""


@dataclass(frozen=True, slots=True)
class Load:
    """How the program is loaded again.

    Attributes:
        program: its file; modules imported from its folder are imported again, too.
        logic: returns a fresh instance.
    """

    program: Path
    logic: Callable[[], ScanLogic]

    @property
    def folder(self) -> Path:
        """The folder of the program."""
        return self.program.parent


@dataclass(frozen=True, slots=True)
class TracedChange:
    """A change that a line made.

    Attributes:
        line: the line; number 0 if no line of the user's program made it.
        before: what is watched, before.
        after: what is watched, after.
        stands: the conditions around the line.
        values: values of the names in them and in the line, as the line began.
        masks: what the program had read by then, see `Reads.masks`.
        senders: if no line made it: what the axes of the program send.
    """

    line: Line
    before: Any
    after: Any
    stands: Stands
    values: Mapping[str, str]
    masks: Mapping[tuple[int, int], int]
    senders: Sequence[Sender] = ()


@dataclass(slots=True)
class Again:
    """The result of a repeated run.

    Attributes:
        changes: row of a scan in question -> the changes in it, in order.
        departs: row of the first scan whose outputs are not the recorded ones; None if all are.
        watched: row of the last scan in which the watched value changed; None if it did not.
        value: the watched value at the end.
    """

    changes: dict[int, list[TracedChange]] = field(default_factory=dict)
    departs: int | None = None
    watched: int | None = None
    value: Any = None

    def explains(self, row: int) -> bool:
        """Return whether the program did as recorded, up to a scan and in it."""
        return self.departs is None or row < self.departs


Watched = Callable[[ScanLogic], Callable[[], Any]]
"""Makes a function that returns a value of a fresh program."""


def run_again(
    recording: Recording,
    spec: RackSpec,
    load: Load,
    rows: frozenset[int],
    last: int,
    watched: Watched | None = None,
) -> Again:
    """Run a program again on the inputs of a recording.

    Args:
        recording: its inputs, and the outputs that are expected.
        load: how the program is loaded.
        rows: the scans to trace.
        last: row of the last scan to run.
        watched: something else than outputs to watch.
    """
    with fresh(load) as logic:
        read = None if watched is None else watched(logic)
        traced = _TracedLogic(logic, rows, read, load.program)
        following = InputReplay(recording, spec, last)
        traced.following = following
        following.play(traced)
        traced.found.departs = following.departs
    return traced.found


@contextmanager
def fresh(load: Load) -> Iterator[ScanLogic]:
    """Load a program again, and give it modules of its own; what it prints is dropped."""
    before = dict(sys.modules)
    forget_imported(load.folder.resolve())
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            yield load.logic()
    finally:
        forget_imported(load.folder.resolve())
        sys.modules.update(before)


class _TracedLogic(LogicWrapper):
    """A logic that is traced in some scans.

    Attributes:
        following: the run that it is a part of.
    """

    def __init__(
        self, logic: ScanLogic, rows: frozenset[int], read: Callable[[], Any] | None, program: Path
    ) -> None:
        super().__init__(logic)
        self._rows, self._read, self._program = rows, read, program
        self._reads = Reads()
        self._lines = Lines(self._watch, self._changed, self._begins)
        self._reads.counts = lambda: self._lines.in_program
        self._values: dict[Line, dict[str, str]] = {}
        self._looked = 0
        self.following: InputReplay
        self.found = Again(value=None if read is None else read())

    def __call__(self, scan: Scan) -> None:
        self._reads.watch(scan.slot)
        if self.following.row not in self._rows:
            self._logic(scan)
        else:
            self._reads.on, self._looked = True, 0
            self._values.clear()
            self._reads.masks.clear()
            self.found.changes[self.following.row] = []
            try:
                self._lines.call(self._logic, scan)
            finally:
                self._reads.on = False
        self._look_at_value()

    def __attach_logic__(self, slots: Mapping[int, Slot]) -> None:
        """Attach the logic to watched images, see `AttachedLogic`."""
        self._reads.watch(slots)
        super().__attach_logic__(slots)

    def _look_at_value(self) -> None:
        if self._read is not None:
            value = self._read()
            if value != self.found.value:
                self.found.value, self.found.watched = value, self.following.row

    def _watch(self) -> tuple[bytes, Any]:
        return self.following.outputs(), None if self._read is None else self._read()

    def _begins(self, line: Line, frame: FrameType) -> None:
        self._looked += 1
        if self._looked <= LOOKED_AT:
            stands = stands_in(line.file, line.number)
            names = [name for _, each in stands.inside for name in each]
            self._reads.on = False
            self._values[line] = values_of((*names, *stands.names), frame)
            self._reads.on = True

    def _changed(self, line: Line, before: Any, after: Any) -> None:
        stands = stands_in(line.file, line.number)
        masks = dict(self._reads.masks)
        sent = () if line.number else senders(self._logic, self._program)
        change = TracedChange(line, before, after, stands, self._values.get(line, {}), masks, sent)
        self.found.changes[self.following.row].append(change)
