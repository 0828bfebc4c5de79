"""A program runs again on recorded inputs, and the scans in question are traced.

    recorded inputs ---> a fresh instance of the program ---> outputs, compared with the recorded ones
                                   |
                                   +--> in the scans in question: which line changed what, after which reads

The program is loaded anew, so the one on the bench goes on undisturbed. It answers as it did if it depends on
its inputs and its time alone; from the first scan in which it does not, its lines explain nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from types import FrameType
from typing import Any

from ....traces.replay import Recording
from ...config.rackspec import RackSpec
from ...loop.events import JsonValue
from ...loop.faults import CpuFault
from ...loop.rack import SLOT_BYTES, Slot
from ...loop.scan import Logic, Scan
from ..attachments import forget_imported
from ..build import build_playback
from ..replaying import recorded_rack, score_of
from ..wrapped import Wrapped
from .conditions import Stands, stands_in, values_of
from .lines import Line, Lines
from .reads import Reads
from .senders import Sender, senders

LOOKED_AT = 20_000
"""Lines of a scan whose names are looked up; a loop that runs longer is explained without values."""


@dataclass(frozen=True, slots=True)
class Load:
    """How the program is loaded anew.

    Attributes:
        folder: its folder; modules imported from there are imported anew, too.
        logic: returns a fresh instance.
    """

    folder: Path
    logic: Callable[[], Logic]


@dataclass(frozen=True, slots=True)
class Changed:
    """A change that a line made.

    Attributes:
        line: the line; number 0 if no line of the user's program made it.
        before: what is watched, before.
        after: what is watched, after.
        stands: the conditions that the line stands in.
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
    """What a program did when it ran again.

    Attributes:
        changes: row of a scan in question -> the changes in it, in order.
        departs: row of the first scan whose outputs are not the recorded ones; None if all are.
        watched: row of the last scan in which the watched value changed; None if it did not.
        value: the watched value at the end.
    """

    changes: dict[int, list[Changed]] = field(default_factory=dict)
    departs: int | None = None
    watched: int | None = None
    value: Any = None

    def explains(self, row: int) -> bool:
        """Return whether the program did as recorded, up to a scan and in it."""
        return self.departs is None or row < self.departs


Watched = Callable[[Logic], Callable[[], Any]]
"""Makes, of a fresh program, what returns the value of something in it."""


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
        spec: the rack.
        load: how the program is loaded.
        rows: the scans to trace.
        last: row of the last scan to run.
        watched: something else than outputs to watch.
    """
    with fresh(load) as logic:
        read = None if watched is None else watched(logic)
        traced = _Traced(logic, rows, read)
        rack = recorded_rack(recording, spec)
        follower = _Outputs(recording, rack.memory, traced, last)
        traced.outputs = follower.of_the_rack
        cpu = build_playback(spec, score_of(recording), traced, rack, listeners=[follower])
        follower.stop = cpu.stop
        with cpu, suppress(CpuFault):  # a fault as recorded; another one shows in the outputs
            cpu.play()
        traced.found.departs = follower.departs
    return traced.found


@contextmanager
def fresh(load: Load) -> Iterator[Logic]:
    """Load a program anew, and give it modules of its own; what it prints goes nowhere."""
    before = dict(sys.modules)
    forget_imported(load.folder.resolve())
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            yield load.logic()
    finally:
        forget_imported(load.folder.resolve())
        sys.modules.update(before)


class _Traced(Wrapped):
    """A logic that is traced in some scans.

    Attributes:
        row: the present scan.
        outputs: returns all output images.
        found: what was found.
    """

    def __init__(self, logic: Logic, rows: frozenset[int], read: Callable[[], Any] | None) -> None:
        super().__init__(logic)
        self._rows, self._read = rows, read
        self._reads = Reads()
        self._lines = Lines(self._watch, self._changed, self._begins)
        self._reads.counts = lambda: self._lines.in_program
        self._values: dict[Line, dict[str, str]] = {}
        self._looked = 0
        self.row = 0
        self.outputs: Callable[[], bytes] = bytes
        self.found = Again(value=None if read is None else read())

    def __call__(self, scan: Scan) -> None:
        self._reads.watch(scan.slot)
        if self.row not in self._rows:
            self._logic(scan)
        else:
            self._reads.on, self._looked = True, 0
            self._values.clear()
            self._reads.masks.clear()
            self.found.changes[self.row] = []
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
                self.found.value, self.found.watched = value, self.row

    def _watch(self) -> tuple[bytes, Any]:
        return self.outputs(), None if self._read is None else self._read()

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
        sent = () if line.number else senders(self._logic)
        change = Changed(line, before, after, stands, self._values.get(line, {}), masks, sent)
        self.found.changes[self.row].append(change)


class _Outputs:
    """A listener that compares the outputs with the recorded ones, and ends the run.

    Attributes:
        departs: row of the first scan whose outputs are others.
        stop: ends the run.
    """

    def __init__(self, recording: Recording, memory: bytearray, traced: _Traced, last: int) -> None:
        self._recorded = recording.memory
        self._memory, self._traced, self._last = memory, traced, last
        half = SLOT_BYTES // 2
        self._spans = [slice(place, place + half) for place in range(0, len(memory), SLOT_BYTES)]
        self.departs: int | None = None
        self.stop: Callable[[], None] = lambda: None

    def of_the_rack(self) -> bytes:
        """Return all output images."""
        return b"".join([self._memory[span] for span in self._spans])

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Ignore events."""

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Compare a scan."""
        row = self._traced.row
        if self.departs is None and self._differ(self._recorded[row]):
            self.departs = row
        self._traced.row = row + 1
        if row >= self._last:
            self.stop()

    def _differ(self, recorded: bytes) -> bool:
        memory = self._memory
        return recorded != memory and any(recorded[span] != memory[span] for span in self._spans)

    def close(self) -> None:
        """Nothing is open."""
