"""Hints about a run: actions of a program that a 3601 ignores without an error bit.

wired, not configured       an input of the machine that the accepted configuration does not use
changed without an edge     parameters changed while their move's bit stayed on; no move followed
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from scanrack.io_images.amci3601 import ALL_INPUTS, CommandLsw, CommandMsw, InputBit, StatusMsw
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.listeners import ROWS_AT_ONCE, QuietListener
from scanrack.runtime.loop.rack import Rack, Slot
from scanrack.runtime.machine import MachineSpec
from scanrack.runtime.machine.spec import input_name

STARTED_BY_AN_EDGE = (
    CommandMsw.ABSOLUTE_MOVE,
    CommandMsw.RELATIVE_MOVE,
    CommandMsw.FIND_HOME_CW,
    CommandMsw.FIND_HOME_CCW,
)
"""Commands whose parameters are read only when their bit rises [chapter 4]."""

_EDGES = sum(STARTED_BY_AN_EDGE)
_MODE_CONFIG = StatusMsw.MODE_CONFIG.value
_CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
_OTHER_USE = (CommandLsw.BLEND_PROGRAM | CommandLsw.ENC_FOLLOWER).value
_FIRST_PARAMETER = 2


@dataclass(frozen=True, slots=True)
class IgnoredParameters:
    """Parameters that changed while the bit of a move stayed on."""

    scan: int
    words: tuple[int, ...]
    bit: str

    def __str__(self) -> str:
        several = len(self.words) > 1
        words = f"word{'s' if several else ''} {', '.join(map(str, self.words))}"
        return (
            f"output {words} changed in scan {self.scan:,} while {self.bit} stayed on, and no move followed: "
            f"a move starts when its bit goes from 0 to 1"
        )


class SlotHints:
    """Watches one module for actions that it ignores.

    Args:
        wired: mask of the inputs that the machine operates.
        warn: called with hints about them.

    Attributes:
        ignored: the latest parameters that changed while a move's bit stayed on; None if a move may have
            read them since.
    """

    def __init__(self, slot: Slot, wired: int, warn: Callable[[str], object]) -> None:
        self.number = slot.number
        self.ignored: IgnoredParameters | None = None
        self._slot, self._wired, self._warn = slot, wired, warn
        self._raw = slot.outputs.raw
        self._last_outputs = bytes(self._raw)
        self._last_words: list[int] = list(slot.outputs)
        self._configures = False  # whether the last outputs are a configuration

    @property
    def needs_look(self) -> bool:
        """Whether the next scan must be checked even if the outputs do not change."""
        return self._configures or self._raw != self._last_outputs

    def look(self, scan: int) -> None:
        """Check the images of a scan."""
        if self._configures:  # these inputs answer the configuration sent in the previous scan
            self._look_for_configuration()
        if self._raw != self._last_outputs:
            self._last_outputs = bytes(self._raw)
            self._outputs_changed(scan)

    def _outputs_changed(self, scan: int) -> None:
        """Note parameters that changed while the bit of a move stayed on, or forget earlier ones."""
        last, words = self._last_words, list(self._slot.outputs)
        self._last_words = words
        self._configures = bool(words[0] & _MODE_CONFIG)
        moves_on = last[0] & words[0] & _EDGES
        if self._configures or (last[0] ^ words[0]) & _EDGES or words[1] & _OTHER_USE:
            self.ignored = None
        elif moves_on:
            changed = tuple(word for word in range(_FIRST_PARAMETER, 8) if last[word] != words[word])
            if changed:
                first_move = CommandMsw(moves_on & -moves_on)  # the lowest bit
                self.ignored = IgnoredParameters(scan, changed, str(first_move.name))

    def _look_for_configuration(self) -> None:
        """Warn about unused inputs when the module mirrors, and so accepts, a configuration [chapter 3]."""
        msw = self._slot.inputs[0]
        if msw & _MODE_CONFIG and not msw & _CONFIG_ERROR:
            self._configures = False
            for bit in InputBit:
                if bit.value & self._wired & ~msw & ALL_INPUTS:
                    self._warn(not_configured(self.number, bit))


class Hints(QuietListener):
    """A listener that watches all modules with 3601 words.

    Args:
        declarations: the line of the program that declares the axis, by slot.
    """

    def __init__(
        self,
        rack: Rack,
        spec: RackSpec,
        warn: Callable[[str], object],
        declarations: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        machines = {slot.number: slot.machine for slot in spec.slot}
        self.slots = [
            SlotHints(
                slot,
                wired_inputs(machines[slot.number]),
                _warn_with_place(declarations.get(slot.number), warn),
            )
            for slot in rack.slots.values()
            if is_stepper(slot.words)
        ]

    look = None

    def begin_rows(self, scan: int) -> int:
        """Return how many scans may be skipped; 0 while a configuration waits for its response."""
        return 0 if any(slot.needs_look for slot in self.slots) else ROWS_AT_ONCE

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Do nothing, since the outputs are the same as in the previous scan."""

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Check the images of a scan."""
        for slot in self.slots:
            slot.look(scan)

    def sentences(self) -> list[str]:
        """Return the hints of a finished run."""
        return [f"slot {slot.number}: {slot.ignored}" for slot in self.slots if slot.ignored is not None]


def _warn_with_place(line: str | None, warn: Callable[[str], object]) -> Callable[[str], object]:
    """Return a warning function that appends a line of the program."""
    return warn if line is None else lambda hint: warn(f"{hint} [{line}]")


def not_configured(slot: int, bit: InputBit) -> str:
    """Return the sentence about a wired input that the configuration does not use."""
    return (
        f"slot {slot}: {input_name(bit)} is wired to the machine, but the configuration does not use it: "
        f"it has no effect"
    )


def wired_inputs(machine: MachineSpec) -> int:
    """Return the mask of the inputs that switches, stations or the timeline drive."""
    mask = machine.fed_inputs
    for entry in machine.timeline:
        mask |= entry.input.value
    return mask
