"""The blocks of an axis: what the module waits for while one is busy, and which rule caused an error."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from typing import Protocol

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.debug import CauseLink, Chains
from scanrack.ladder.state.lowered import AddOnCall, LoweredProgram
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.replay import PackedTrace

from ..past import Past, SlotPast
from ..waits import waits

MODULE = "AMCI3601"
"""The instruction that binds an axis to the words of a slot."""


class Chain(Protocol):
    """The part of a rack's chain that the blocks use."""

    recording: PackedTrace

    @property
    def chains(self) -> Chains:
        """Makes the chains of the ladder program."""

    def lost(self, slot: int, name: str, row: int) -> CauseLink | None:
        """Return the link for a lost connection to a module."""

    def of_status(self, slot: int, bit: StatusMsw, row: int) -> CauseLink | None:
        """Return the chain of a status bit."""

    def slot(self, number: int) -> SlotInfo:
        """Return a slot of the recording."""


@dataclass(frozen=True, slots=True)
class AxisBlocks:
    """Explains the blocks of the axes in a rack."""

    chain: Chain

    def waiting(self, path: str, scan: int) -> CauseLink | None:
        """Return what a busy block waits for; None for any other structure."""
        slot = slot_of(self.chain.chains.lowered, path)
        recording = self.chain.recording
        row = bisect_left(recording.numbers, scan)
        if slot is None or row >= len(recording.numbers):
            return None
        lost = self.chain.lost(slot, path, row)
        if lost is not None:
            return lost
        past = SlotPast(Past(recording, row), self.chain.slot(slot))
        changed = past.past.last_change(slot, "in", 0) or 0
        text = f"busy: slot {slot}: {'; '.join(waits(past)[:2])}"
        return CauseLink("module", path, None, recording.numbers[changed], recording.times[changed], text)

    def failed(self, path: str, since: int, scan: int) -> CauseLink | None:
        """Return the module's bit that caused a block's error, with its rule; None if there is none."""
        slot = slot_of(self.chain.chains.lowered, path)
        if slot is None:
            return None
        recording = self.chain.recording
        rows = bisect_left(recording.numbers, since), bisect_right(recording.numbers, scan) - 1
        errors = (
            StatusMsw.COMMAND_ERROR
            | StatusMsw.INVALID_PROFILE
            | StatusMsw.INPUT_ERROR
            | StatusMsw.HOME_INVALID
        )
        now = Past(recording, rows[1]).words(slot, "in", rows[1])[0]
        for bit in (StatusMsw.CONFIG_ERROR, *errors):
            if now & bit:
                return self.chain.of_status(slot, bit, rows[1])
        return None


def slot_of(lowered: LoweredProgram, path: str) -> int | None:
    """Return the slot of the module that a block's axis is bound to; None for any other structure."""
    calls = list(_calls(lowered))
    own = next((each for each in calls if each.instance.path.upper() == path.upper()), None)
    axis = own.handed.get("AXIS") if own is not None else None
    if axis is None:
        return None
    for each in calls:
        inputs = each.handed.get("INPUTS")
        if (
            each.name == MODULE
            and each.handed["AXIS"].text.upper() == axis.text.upper()
            and inputs is not None
        ):
            return getattr(getattr(inputs, "leaf", None), "slot", None)
    return None


def _calls(lowered: LoweredProgram) -> Iterator[AddOnCall]:
    for routine in lowered.routines.values():
        for line in routine.lines if not routine.frame else ():
            for step in line.steps:
                if step.operands and isinstance(step.operands[0], AddOnCall):
                    yield step.operands[0]
