"""A scenario: what surrounds a program in one run, laid over the rack as its file describes it.

It is data: the same scenario gives the same run, it can be written to a file and read again, and
each part of it can be left out, which is what shrinking does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

from ....io_images.amci3601.bits import InputBit
from ....io_images.amci3601.firmware import Firmware
from ....io_images.image import WORDS
from ...config.machine_tables import input_name
from ...config.rackspec import IncidentSpec, RackSpec, SlotSpec
from ...loop.incidents import FaultKind, Incident
from ...machine import MachineSpec, Slip, TimelineEntry


@dataclass(frozen=True, slots=True)
class Press:
    """Somebody holds an input at a level for a time; on an input with a switch that is a fault of it.

    Attributes:
        slot: of which module.
        input: which.
        energised: the level.
        at_ns: from when on, ns since power-up.
        for_ns: how long.
    """

    slot: int
    input: InputBit
    energised: bool
    at_ns: int
    for_ns: int


@dataclass(frozen=True, slots=True)
class Shift:
    """A machine whose switches are not where the drawing has them.

    Attributes:
        slot: of which module.
        steps: by how much all of them are moved.
    """

    slot: int
    steps: int


@dataclass(frozen=True, slots=True)
class Lost:
    """Steps that a motor loses.

    Attributes:
        slot: of which module.
        at: shaft position, steps.
        steps: how many, 1 or more.
    """

    slot: int
    at: int
    steps: int


@dataclass(frozen=True, slots=True)
class Scenario:
    """What surrounds a program in one run.

    Attributes:
        firmware: versions of modules, by slot number, where they differ from the rack file.
        presses: what people do to the inputs.
        incidents: what happens to modules and CPU.
        shifts: switches that are elsewhere.
        lost: steps that are lost.
    """

    firmware: tuple[tuple[int, str], ...] = ()
    presses: tuple[Press, ...] = ()
    incidents: tuple[Incident, ...] = ()
    shifts: tuple[Shift, ...] = ()
    lost: tuple[Lost, ...] = ()

    def laid_over(self, spec: RackSpec) -> RackSpec:
        """Return a rack with this scenario in it."""
        slots = tuple(self._slot(slot) for slot in spec.slot)
        incidents = tuple(_incident_spec(each) for each in self.incidents)
        return spec.model_copy(update={"slot": slots, "incident": (*spec.incident, *incidents)})

    def _slot(self, slot: SlotSpec) -> SlotSpec:
        firmware = dict(self.firmware).get(slot.number, slot.firmware)
        machine = slot.machine
        for shift in self.shifts:
            if shift.slot == slot.number:
                machine = shifted(machine, shift.steps)
        slips = tuple(Slip(each.at, each.steps) for each in self.lost if each.slot == slot.number)
        presses = [each for each in self.presses if each.slot == slot.number]
        entries = tuple(entry for each in presses for entry in entries_of(each, machine))
        if slips or entries:
            machine = replace(machine, slips=(*machine.slips, *slips), timeline=(*machine.timeline, *entries))
        return slot.model_copy(update={"firmware": firmware, "machine": machine})

    def to_json(self) -> dict[str, Any]:
        """Return the scenario as JSON can hold it; `from_json` is the way back."""
        return {
            "firmware": {str(slot): version for slot, version in self.firmware},
            "presses": [
                {
                    "slot": each.slot,
                    "input": input_name(each.input),
                    "energised": each.energised,
                    "at_ns": each.at_ns,
                    "for_ns": each.for_ns,
                }
                for each in self.presses
            ],
            "incidents": [
                {
                    "at_ns": each.at_ns,
                    "what": each.what.value,
                    "slot": each.slot,
                    "for_ns": each.for_ns,
                    "late_words": list(each.late_words),
                }
                for each in self.incidents
            ],
            "shifts": [{"slot": each.slot, "steps": each.steps} for each in self.shifts],
            "lost": [{"slot": each.slot, "at": each.at, "steps": each.steps} for each in self.lost],
        }

    @classmethod
    def from_json(cls, given: Mapping[str, Any]) -> Scenario:
        """Return the scenario that `to_json` wrote.

        Raises:
            ValueError: it is none; the message names the key.
        """
        known = ("firmware", "presses", "incidents", "shifts", "lost")
        if not isinstance(given, Mapping):
            raise ValueError(f"a scenario is an object with {', '.join(known)}, not {given!r:.40}")
        unknown = sorted(set(given) - set(known))
        if unknown:
            raise ValueError(f"scenario: unknown key {unknown[0]}; allowed are {', '.join(known)}")
        try:
            return cls(
                tuple((int(slot), _version(text)) for slot, text in given.get("firmware", {}).items()),
                tuple(_press(each) for each in given.get("presses", ())),
                tuple(_incident(each) for each in given.get("incidents", ())),
                tuple(Shift(**_whole(each)) for each in given.get("shifts", ())),
                tuple(Lost(**_whole(each)) for each in given.get("lost", ())),
            )
        except KeyError as error:
            raise ValueError(f"scenario: key {error} is missing") from None
        except (TypeError, AttributeError) as error:
            raise ValueError(f"scenario: {error}") from None

    def check(self, spec: RackSpec) -> None:
        """Refuse a scenario that does not belong to a rack.

        Raises:
            ValueError: it is about a slot that the rack does not have.
        """
        have = [slot.number for slot in spec.slot]
        parts: Sequence[Press | Incident | Shift | Lost] = (
            *self.presses,
            *(each for each in self.incidents if each.what is not FaultKind.PROGRAM_MODE),
            *self.shifts,
            *self.lost,
        )
        for slot in (*dict(self.firmware), *(part.slot for part in parts)):
            if slot not in have:
                slots = ", ".join(map(str, have))
                raise ValueError(f"scenario: there is no slot {slot}; the rack has {slots}")

    def is_possible(self, spec: RackSpec) -> bool:
        """Return whether no module has an older firmware here than the rack's program needs."""
        needed = {slot.number: Firmware.parse(slot.needs_firmware) for slot in spec.slot}
        return all(
            Firmware.parse(version) >= needed[slot] for slot, version in self.firmware if slot in needed
        )

    @property
    def size(self) -> int:
        """How much there is of it: number of parts."""
        parts: Sequence[Sequence[object]] = (
            self.firmware,
            self.presses,
            self.incidents,
            self.shifts,
            self.lost,
        )
        return sum(map(len, parts))


def _version(given: object) -> str:
    return str(Firmware.parse(str(given)))


def _whole(given: Mapping[str, Any], *others: str) -> Mapping[str, Any]:
    """Return a part whose values are whole numbers, 0 or more where they are times; but for `others`."""
    for key, value in given.items():
        if key not in others and (type(value) is not int or (key.endswith("_ns") and value < 0)):
            raise ValueError(f"scenario: {key} = {value!r:.40}: a whole number is needed")
    return given


def _press(given: Mapping[str, Any]) -> Press:
    name = str(given["input"]).upper()
    if name not in InputBit.__members__:
        inputs = ", ".join(map(input_name, InputBit))
        raise ValueError(f"scenario: there is no input {given['input']!r}; allowed are {inputs}")
    if type(given.get("energised")) is not bool:
        raise ValueError(f"scenario: energised = {given.get('energised')!r:.40}: true or false is needed")
    return Press(**{**_whole(given, "input", "energised"), "input": InputBit[name]})


def _incident(given: Mapping[str, Any]) -> Incident:
    what, words = FaultKind(given["what"]), tuple(given.get("late_words", ()))
    if any(type(word) is not int or not 0 <= word < WORDS for word in words):
        raise ValueError(f"scenario: late_words = {list(words)!r:.40}: words are 0 to {WORDS - 1}")
    return Incident(**{**_whole(given, "what", "late_words"), "what": what, "late_words": words})


def _incident_spec(incident: Incident) -> IncidentSpec:
    """Return an incident as a rack file has it."""
    return IncidentSpec(
        at_ms=Decimal(incident.at_ns).scaleb(-6),
        what=incident.what,
        slot=incident.slot or None,
        for_ms=Decimal(incident.for_ns).scaleb(-6) if incident.for_ns else None,
        late_words=incident.late_words,
    )


def shifted(machine: MachineSpec, steps: int) -> MachineSpec:
    """Return a machine with all of its switches and stations elsewhere."""

    def moved(position: int | None) -> int | None:
        return None if position is None else position + steps

    switches = tuple(
        replace(each, first=moved(each.first), last=moved(each.last)) for each in machine.switches
    )
    stations = tuple(replace(each, position=each.position + steps) for each in machine.stations)
    return replace(machine, switches=switches, stations=stations)


def entries_of(press: Press, machine: MachineSpec) -> tuple[TimelineEntry, TimelineEntry]:
    """Return the timeline entries of a press; afterwards the input is as it would have been."""
    end_ns = press.at_ns + press.for_ns
    if machine.fed_inputs & press.input.value:
        level: bool | None = None
    else:
        before = [each for each in machine.timeline if each.input is press.input and each.at_ns <= end_ns]
        level = max(before, key=lambda each: each.at_ns).energised if before else False
    return (
        TimelineEntry(press.at_ns, press.input, press.energised),
        TimelineEntry(end_ns, press.input, level),
    )
