"""Describes the rack for the first message to a page: slots, words, bits, inputs, machines, incidents."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.drives.models import MODELS
from scanrack.io_images.module_words import ModuleWords
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.loop.incidents import LASTING, ON_THE_LINE, TROUBLES, FaultKind
from scanrack.runtime.machine.spec import MachineSpec, input_name
from scanrack.runtime.modules.record import Trait

from .picture import Json, described_values

TITLES = {
    "capture": "Capture",
    "external": "External",
    "home": "Home",
    "estop": "E-stop",
    "cw_limit": "CW limit",
    "ccw_limit": "CCW limit",
}
"""Titles of the inputs of a 3601."""

NAMES = {
    "amci3601": "AMCI 3601",
    "pcl601-adapter": "PCL601 adapter",
    "pmc006-adapter": "PMC006 adapter",
    "amci-drive": "networked drive",
    **{name: f"AMCI {model.title}" for name, model in MODELS.items()},
}
"""Titles of modules; a card's title is its catalog number."""

SECTIONS = {
    "command": "chapter 5, Command Words",
    "status": "chapter 6, Status Bits",
}
"""The manual's section about the bits of each group."""


def slots_of(spec: RackSpec) -> list[Json]:
    """Return the slots of a rack for `hello`."""
    return [slot_of(each) for each in spec.slot]


def slot_of(slot: SlotSpec) -> Json:
    """Return a slot for `hello`."""
    words = slot.words
    return {
        "number": slot.number,
        "catalog": slot.module,
        "title": _title(slot),
        "words": {"in": len(words.inputs), "out": len(words.outputs)},
        "bits": bits_of(slot.number, words),
        "values": described_values(words),
        "inputs": inputs_of(slot),
        "lamps": [
            {"name": name, "title": name, "word": at.word, "bit": at.bit}
            for name, at in words.groups.get("output", {}).items()
        ],
        "machine": machine_of(slot.machine) if slot.has(Trait.MACHINE) and not slot.is_live else None,
    }


def _title(slot: SlotSpec) -> str:
    firmware = f", firmware {slot.firmware}" if slot.has(Trait.FIRMWARE) else ""
    return f"{NAMES.get(slot.module, slot.module)}{firmware}"


def bits_of(slot: int, words: ModuleWords) -> list[Json]:
    """Return the named bits of a module."""
    found = []
    known = words if is_stepper(words) else None
    for group, names in words.groups.items():
        for name, at in names.items():
            found.append(
                {
                    "name": name,
                    "address": f"Local:{slot}:{at.image}.Data[{at.word}].{at.bit}",
                    "meaning": f"slot{slot}.{group}.{name}",
                    "section": SECTIONS.get(group, "") if known and name not in known.further else "",
                    "word": at.word,
                    "bit": at.bit,
                    "output": at.image == "O",
                    "error": at.image == "I" and name in words.errors,
                }
            )
    return found


def addresses_of(spec: RackSpec) -> list[Json]:
    """Return the words of all slots, and their named bits, as tags for `hello`."""
    found = []
    for slot in spec.slot:
        for each in bits_of(slot.number, slot.words):
            found.append({"name": each["address"], "type": "BOOL", "description": each["meaning"]})
        for image, what in (("I", "input"), ("O", "output")):
            found += [
                {
                    "name": f"Local:{slot.number}:{image}.Data[{word}]",
                    "type": "INT",
                    "description": f"slot {slot.number}, {what} word {word}",
                }
                for word in range(len(slot.words.named(image)))
            ]
    return found


def inputs_of(slot: SlotSpec) -> list[Json]:
    """Return the inputs of a module: those that a person presses, and those that a machine operates."""
    if slot.is_live:
        return []
    wired = slot.words.groups.get("input")
    if wired is not None:
        buttons = slot.record.buttons(slot.options)
        closed = slot.options.get("normally_closed", ())
        return [
            {
                "name": name,
                "title": name,
                "kind": "button" if name in buttons else "cam",
                "rest": isinstance(closed, list | tuple) and name in closed,
                "word": at.word,
                "bit": at.bit,
            }
            for name, at in wired.items()
        ]
    if not slot.has(Trait.MACHINE):
        return []
    switched = {input_name(each.input) for each in slot.machine.switches}
    stationed = {input_name(each.input) for each in slot.machine.stations}
    kinds = dict.fromkeys(stationed, "station") | dict.fromkeys(switched, "switch")
    return [
        {"name": name, "title": _titled(name, own), "kind": kinds.get(name, "button"), "rest": False}
        for name, own in slot.record.machine_inputs(slot.options).items()
    ]


def _titled(name: str, own: str) -> str:
    return f"{TITLES[name]} ({own})" if own else TITLES[name]


def machine_of(machine: MachineSpec) -> Json:
    """Return the rail of a machine: the items along it, and its ends."""
    places = [place for each in machine.switches for place in (each.first, each.last) if place is not None]
    places += [each.position for each in machine.stations] + [each.at for each in machine.jams] + [0]
    low, high = min(places), max(places)
    margin = max((high - low) // 20, 200)
    return {
        "min": low - margin,
        "max": high + margin,
        "switches": [
            {
                "input": input_name(each.input),
                "first": each.first,
                "last": each.last,
                "normally_closed": each.normally_closed,
            }
            for each in machine.switches
        ],
        "stations": [
            {"position": each.position, "input": input_name(each.input)} for each in machine.stations
        ],
        "jams": [{"at": each.at, "direction": each.direction} for each in machine.jams],
        "encoder": machine.encoder is not None,
    }


_TITLES = {
    FaultKind.POWER_CYCLE: "Power goes and comes back",
    FaultKind.LINK_LOST: "Link to the module lost",
    FaultKind.REMOVED: "Module taken out",
    FaultKind.FATAL_ERROR: "Module fails",
    FaultKind.ASIC_LOST: "Backplane interface fails",
    FaultKind.TORN_UPDATE: "Torn update of the outputs",
    FaultKind.LINE_DOWN: "Line to the controller open",
    FaultKind.REPLIES_LOST: "Replies of the controller lost",
    FaultKind.REPLIES_DAMAGED: "Replies of the controller damaged",
    FaultKind.CONTROLLER_POWER_CYCLE: "Controller's power goes and comes back",
}


def incidents_of(spec: RackSpec) -> list[Json]:
    """Return the incidents of a rack, each with the slots to which it can happen."""
    found = []
    for kind, title in _TITLES.items():
        slots = [each.number for each in spec.slot if not each.is_live and _can(kind, each)]
        if slots:
            found.append({"name": kind.value, "title": title, "fields": _fields_of(kind, spec, slots)})
    return [*found, *_conditions_of(spec)]


def _fields_of(kind: FaultKind, spec: RackSpec, slots: Sequence[int]) -> list[Json]:
    """Return the fields of an incident that a page can set."""
    fields: list[Json] = [
        {"name": "slot", "title": "Slot", "kind": "choice", "default": slots[0], "choices": slots}
    ]
    if kind in LASTING or kind is FaultKind.TORN_UPDATE:
        fields.append({"name": "for_ms", "title": "For", "kind": "number", "default": 100, "unit": "ms"})
    if kind is FaultKind.TORN_UPDATE:
        words = list(range(max(len(each.words.outputs) for each in spec.slot if each.number in slots)))
        late = {"name": "late_words", "title": "Late words", "kind": "words", "default": [1, 2]}
        fields.append(late | {"choices": words})
    return fields


def _conditions_of(spec: RackSpec) -> Iterator[Json]:
    """Yield the conditions around modules that can be set: named states as choices, others as text."""
    slots = [each.number for each in spec.slot if not each.is_live and each.record.conditions]
    if not slots:
        return
    known = next(each.record.states() for each in spec.slot if each.number == slots[0])
    choices = [f"{name}={state}" for name, states in known.items() for state in states]
    slot = {"name": "slot", "title": "Slot", "kind": "choice", "default": slots[0], "choices": slots}
    state = {"name": "state", "title": "State", "kind": "text", "choices": choices}
    yield {"name": FaultKind.CONDITION.value, "title": "Condition of a drive", "fields": [slot, state]}


def _can(kind: FaultKind, slot: SlotSpec) -> bool:
    if kind in TROUBLES:
        return slot.has(Trait.STOPS_ANSWERING)
    return kind not in ON_THE_LINE or slot.has(Trait.LINE)
