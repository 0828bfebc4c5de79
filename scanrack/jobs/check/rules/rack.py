"""Rules about the machine and its wiring: the rack file compared with the program."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.amci3601 import ALL_INPUTS, Configuration, InputBit
from scanrack.io_images.module_words import BitPlace
from scanrack.runtime.config.rackspec import SlotSpec
from scanrack.runtime.machine import MachineSpec
from scanrack.runtime.machine.spec import Switch, input_name

from ...record.tag_source import tags_of
from ...run.hints import not_configured, wired_inputs
from ..facts import FileLine, Violation
from ..subject import Subject

SIGN_BIT = 15


def wired_but_not_configured(subject: Subject) -> Iterator[Violation]:
    """Find inputs that are wired but that no configuration uses."""
    for index, slot in subject.steppers:
        configurations = subject.sent_to(slot.number, subject.facts.configurations)
        inputs_used = 0
        for configuration in configurations:
            inputs_used |= configuration.words[0] & ALL_INPUTS
        for bit in InputBit if configurations else ():
            if bit.value & wired_inputs(slot.machine) & ~inputs_used:
                yield Violation(_wiring(subject, index, slot, bit), not_configured(slot.number, bit))


def _wiring(subject: Subject, index: int, slot: SlotSpec, bit: InputBit) -> FileLine:
    """Return the line of the first machine part that operates an input."""
    for key in ("switches", "stations", "timeline"):
        for number, part in enumerate(getattr(slot.machine, key)):
            if part.input == bit:
                return subject.place("slot", index, "machine", key, number)
    return subject.place("slot", index, "machine")


LEVELS = (InputBit.HOME, InputBit.ESTOP, InputBit.CW_LIMIT, InputBit.CCW_LIMIT)
"""Inputs that are active only at a position or in an emergency. They must not be active at rest."""


_AT_REST = {True: ("normally closed", "high"), False: ("normally open", "low")}
"""Each kind of contact and its level at rest, by whether that level is high."""


def active_at_rest(subject: Subject) -> Iterator[Violation]:
    """Find inputs that are active at rest, because the contact does not match the configured level."""
    for index, slot in subject.steppers:
        configurations = subject.configurations(slot.number)
        for bit in LEVELS if configurations else ():
            is_high = _level_at_rest(slot.machine, bit)
            is_wired = wired_inputs(slot.machine) & bit.value
            is_missing = not is_wired and bit is InputBit.HOME  # search_without_switch reports it
            is_active = all(
                _is_active(configuration, bit, is_high=is_high) for configuration in configurations
            )
            if is_active and not is_missing:
                contact, level = _AT_REST[is_high]
                state = f"{input_name(bit)} is {contact if is_wired else 'not wired'}"
                text = f"{state}, but it is configured as active {level}: it is active at rest"
                yield Violation(_wiring(subject, index, slot, bit), f"slot {slot.number}: {text}")


def _is_active(configuration: Configuration, bit: InputBit, *, is_high: bool) -> bool:
    """Whether a module uses an input and reads a level as active."""
    is_used = bool(configuration.inputs_used & bit.value)
    return is_used and bool(configuration.active_high & bit.value) == is_high


def _level_at_rest(machine: MachineSpec, bit: InputBit) -> bool:
    """Return whether an input is energized while its contact is not operated."""
    for switch in machine.switches:
        if switch.input == bit:
            return switch.normally_closed  # all switches of an input are of the same kind
    at_start = [event.energized for event in machine.timeline if event.input == bit and event.at_ns == 0]
    return bool(at_start and at_start[-1])


def search_without_switch(subject: Subject) -> Iterator[Violation]:
    """Find home searches on a machine without a home switch."""
    yield from _beyond_limit(subject)
    slots = [slot for _, slot in subject.steppers]
    without_home = [slot.number for slot in slots if not _has_home(slot.machine)]
    unknown_slot = [None] if without_home and len(without_home) == len(slots) else []
    for search in subject.facts.searches:
        if search.slot in (*without_home, *unknown_slot):
            machine = f"slot {search.slot}" if search.slot is not None else "the machine"
            text = f"a home search starts here, but {machine} has neither home switch nor encoder"
            yield Violation(search.place, text)


def _has_home(machine: MachineSpec) -> bool:
    return bool(wired_inputs(machine) & InputBit.HOME.value) or machine.encoder is not None


def _beyond_limit(subject: Subject) -> Iterator[Violation]:
    """Find home switches within the range of a limit switch, which ends the search first."""
    searched = {search.slot for search in subject.facts.searches}
    for index, slot in subject.steppers:
        switches = list(enumerate(slot.machine.switches))
        homes = [(number, switch) for number, switch in switches if switch.input == InputBit.HOME]
        if len(homes) != 1 or not searched & {None, slot.number}:
            continue
        number, home = homes[0]
        limit = _limit_over(slot.machine, home)
        if limit is not None:
            place = subject.place("slot", index, "machine", "switches", number)
            text = f"slot {slot.number}: home lies where {input_name(limit.input)} is operated"
            yield Violation(place, f"{text}: the limit ends the search first")


def _limit_over(machine: MachineSpec, home: Switch) -> Switch | None:
    """Return the limit switch that is operated wherever the home switch is; None if none is."""
    for switch in machine.switches:
        if switch.input in (InputBit.CW_LIMIT, InputBit.CCW_LIMIT) and _covers(switch, home):
            return switch
    return None


def _covers(limit: Switch, home: Switch) -> bool:
    """Whether a limit switch is operated wherever the home switch is."""
    begins_before = limit.first is None or (home.first is not None and home.first >= limit.first)
    ends_after = limit.last is None or (home.last is not None and home.last <= limit.last)
    return begins_before and ends_after


def unused_terminals(subject: Subject) -> Iterator[Violation]:
    """Find wired terminals that the program never uses."""
    uses = subject.facts.uses_bit
    for index, slot in enumerate(subject.job.spec.slot if uses is not None and not subject.alone else ()):
        for group, verb, name, terminal in terminals(slot):
            if uses is not None and not uses(slot.number, terminal.image, name, terminal.word, terminal.bit):
                place = subject.place("slot", index, "options", f"{group}s", name)
                yield Violation(place, f"slot {slot.number}: the program never {verb} {group} {name}")


def terminals(slot: SlotSpec) -> Iterator[tuple[str, str, str, BitPlace]]:
    """Yield the wired terminals of a card: group, verb for a message, name and bit.

    The sign bit represents an analog channel, because a use of the word is a use of the bit.
    """
    words = slot.words
    for group, verb, image, names in (
        ("input", "reads", "I", words.inputs),
        ("output", "writes", "O", words.outputs),
    ):
        for name, terminal in words.groups.get(group, {}).items():
            yield group, verb, name, terminal
        for channel_image, word in words.profile_words.values():
            if channel_image == image and names[word] != f"ch{word}_data":  # the rack file names the channel
                yield group, verb, names[word], BitPlace(image, word, SIGN_BIT)


def unknown_tags(subject: Subject) -> Iterator[Violation]:
    """Find patterns for recorded tags that match no tag."""
    for index, pattern in enumerate(subject.job.spec.tags):
        try:
            tags_of(subject.job.logic, [pattern], bytearray(subject.job.spec.layout.size))
        except ValueError as error:
            yield Violation(subject.place("tags", index), str(error))
