"""Reruns of a recorded program with regular snapshots, so that any scan can be shown quickly.

scan      0 ... 4,095   4,096 ...   8,192 ...
values    *             *           *            from here the replica reaches any scan within 60 ms
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from scanrack.io_images.module_words import ModuleWords
from scanrack.jobs.replay.input_replay import InputReplay
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.ring import Rows
from scanrack.traces.format.layout import SlotInfo

from .event_log import LAST_SCAN
from .program_replica import scans_in
from .recorded_events import RecordedEvents
from .stretch import Stretch
from .watched_program import Inputs, LadderNotes, Values

EVERY = 512
"""Scans between two snapshots."""

SLICE = 1000
"""Scans per step."""


def indexable(stretches: Sequence[Stretch]) -> tuple[list[LadderLogic], int]:
    """Return the programs whose scans can be repeated, and the last repeatable scan."""
    programs: list[LadderLogic] = []
    for stretch in stretches:
        if not isinstance(stretch.logic, LadderLogic) or stretch.logic.functions:
            return programs, stretch.first - 1
        programs.append(stretch.logic)
    return programs, LAST_SCAN


class Indexer:
    """A rerun of a program with recorded images, starting from the first scan.

    Args:
        programs: the program and its edited versions, without routines in Python.
        slots: the word names of the modules, by slot.
        recorded: the events of the recording, which include its actions and lost connections.
        keep: receives the snapshots of the program's values.
    """

    def __init__(
        self,
        programs: Sequence[LadderLogic],
        slots: Mapping[int, ModuleWords],
        spec: RackSpec,
        recorded: RecordedEvents,
        keep: Callable[[Values | Inputs], None],
    ) -> None:
        program, *editions = programs
        modules = [SlotInfo(number, "", words=words) for number, words in slots.items()]
        self._replay = InputReplay(spec, modules, edited=lambda _number: editions.pop(0))  # in order
        self._debugger = Debugger(program, remembered=0)
        self._replay.attach(self._debugger)
        self._notes = LadderNotes(self._debugger, keep, EVERY)
        self._slots, self._recorded = slots, recorded

    @property
    def next(self) -> int:
        """Number of the next scan."""
        return self._replay.scan + 1

    def run(self, rows: Rows) -> bool:
        """Run successive scans from `next` on; return whether a snapshot was stored."""
        latest_snapshot, first, last = self._notes.sent_scan, self.next, int(rows["scan"][-1])
        links = {slot: self._recorded.links(slot, first, last) for slot in self._slots}
        self._replay.set_pending(self._recorded.orders(first, last), links)
        for scan in scans_in(rows):
            edits = len(self._debugger.edits)
            self._replay.give_orders(scan)
            if not scan.number or edits != len(self._debugger.edits):
                self._notes.send_values(scan.number)
            self._replay.run(scan)
            self._notes.note(scan.number)
        return self._notes.sent_scan != latest_snapshot
