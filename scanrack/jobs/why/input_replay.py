"""Runs a program on recorded inputs up to a scan, and compares its outputs with the recorded ones."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.faults import Cause, CpuFault
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.pace import Watchdog
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.replay import PackedTrace

from ..replay.replaying import recorded_rack, score_of
from ..replay.tag_orders import TagOrders
from ..run.build import build_playback
from ..run.playback import RecordedInputs


class InputReplay(QuietListener):
    """A run of a program on the inputs of a recording, which listens to its own scan loop.

    Args:
        recording: the inputs, and the expected outputs.
        last: row of the last scan to run.
        over: called after each scan; returns whether it was the last one.
    """

    def __init__(
        self, recording: PackedTrace, spec: RackSpec, last: int, over: Callable[[], object] = bool
    ) -> None:
        self._recording, self._spec, self._last, self._over = recording, spec, last, over
        self._recorded = recording.memory
        self._rack = recorded_rack(recording, spec)
        self._memory = self._rack.memory
        self._spans = [places.outputs for places in self._rack.layout.places.values()]
        self._stop: Callable[[], None] = lambda: None
        self.row = 0  # the present scan; after the run the next one
        self.departs: int | None = None  # row of the first scan with other outputs than recorded, or None
        self.met = False  # whether `over` has ended it

    def play(self, logic: ScanLogic, orders: TagOrders | None = None) -> list[str]:
        """Run a program, and return the refused orders. A fault ends the run, as in the recording.

        Args:
            orders: recorded orders on the program's tags, to be repeated.
        """
        watchdog = None if self._watchdog_ended_it else Watchdog(0)
        score = score_of(self._recording)
        cpu = build_playback(self._spec, score, logic, self._rack, listeners=[self], watchdog=watchdog)
        repeated = None if orders is None else orders.give(cpu, self._rack, logic)
        self._stop = cpu.stop
        with cpu, suppress(CpuFault):
            cpu.play()
        return [] if repeated is None else repeated.refused

    @property
    def _watchdog_ended_it(self) -> bool:
        """Whether the watchdog ended the recorded run; a traced run may take longer."""
        return any(each.fields.get("cause") == Cause.WATCHDOG.value for each in self._recording.events)

    def hold(self, slot: int, image: bytes) -> None:
        """From the next scan on, show the program this input image of a slot instead of the recorded one."""
        module = self._rack.slots[slot].module
        assert isinstance(module, RecordedInputs)
        module.hold(image)

    def block(self) -> bytes:
        """Return the rack's present memory block, with the outputs as the program has written them so far."""
        return bytes(self._memory)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Compare a scan, and end the run with the last one."""
        row = self.row
        if self.departs is None and self._differ(self._recorded[row]):
            self.departs = row
        self.row = row + 1
        self.met = bool(self._over())
        if self.met or row >= self._last:
            self._stop()

    def _differ(self, recorded: bytes) -> bool:
        memory = self._memory
        return recorded != memory and any(recorded[span] != memory[span] for span in self._spans)
