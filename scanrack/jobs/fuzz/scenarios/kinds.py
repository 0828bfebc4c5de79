"""The kinds of random events, and the buttons, sensors and signals that they affect."""

from __future__ import annotations

from enum import Enum

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.modules.record import Trait


class Kind(Enum):
    """A kind of random event."""

    INPUTS = "inputs"
    """Buttons are pressed, sensors stick or break, a panel writes tags."""
    MACHINE = "machine"
    """Switches are displaced, motors lose steps, master encoders turn."""
    LINK = "link"
    """Modules stop answering for a time."""
    POWER = "power"
    """Modules lose power for a moment."""
    MODE = "mode"
    """The CPU's key is turned to program and back."""
    TORN = "torn"
    """Outputs are updated in the middle of a scan, and some words are late."""
    FIRMWARE = "firmware"
    """Modules have a different firmware version."""
    LINE = "line"
    """The line between an adapter and its controller fails, or the controller's power fails."""


def possible_kinds(spec: RackSpec) -> frozenset[Kind]:
    """Return the kinds that are possible in a rack. Some need a 3601, others need an adapter."""
    possible = frozenset(kind for kind in Kind if kind not in _NEEDS or with_trait(spec, _NEEDS[kind]))
    if card_buttons(spec) or card_signals(spec):
        possible |= {Kind.INPUTS}
    return possible


def card_buttons(spec: RackSpec) -> list[tuple[int, str]]:
    """Return the slot and name of each card contact that a person operates."""
    return [(slot.number, name) for slot in spec.slot for name in slot.record.buttons(slot.options)]


def card_signals(spec: RackSpec) -> list[tuple[int, str, float]]:
    """Return the slot and name of each analog card input, with each of its test values."""
    return [
        (slot.number, name, value)
        for slot in spec.slot
        for name, values in slot.record.signals(slot.options).items()
        for value in values
    ]


def masters(spec: RackSpec) -> list[tuple[int, int]]:
    """Return the slot and the maximum speed of each master encoder, counts/s."""
    speeds = [(slot.number, slot.machine.master_speed) for slot in spec.slot]
    return [(number, speed) for number, speed in speeds if speed is not None]


_NEEDS = {
    Kind.INPUTS: Trait.MACHINE,
    Kind.MACHINE: Trait.MACHINE,
    Kind.LINK: Trait.STOPS_ANSWERING,
    Kind.FIRMWARE: Trait.FIRMWARE,
    Kind.LINE: Trait.LINE,
}
"""For each kind, the trait that at least one module must have."""


def kinds_for(spec: RackSpec) -> frozenset[Kind]:
    """Return the possible kinds. Torn updates need exchanges that do not wait for the end of the scan."""
    possible = possible_kinds(spec)
    return possible if spec.controller == "compactlogix" else possible - {Kind.TORN}


def with_trait(spec: RackSpec, trait: Trait) -> list[int]:
    """Return the numbers of the slots with a trait."""
    return [slot.number for slot in spec.slot if slot.has(trait)]


def sensors(slot: SlotSpec) -> list[InputBit]:
    """Return the inputs that the machine energizes."""
    fed = {bit for bit in InputBit if slot.machine.fed_inputs & bit.value}
    return sorted(fed | {entry.input for entry in slot.machine.timeline})


def buttons(slot: SlotSpec) -> list[InputBit]:
    """Return the inputs that only a person energizes."""
    return [bit for bit in InputBit if bit not in sensors(slot)]
