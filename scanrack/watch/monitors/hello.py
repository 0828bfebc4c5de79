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
    return [slot_of(slot) for slot in spec.slot]


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
            {"name": name, "title": name, "word": place.word, "bit": place.bit}
            for name, place in words.groups.get("output", {}).items()
        ],
        "machine": machine_of(slot.machine) if slot.has(Trait.MACHINE) and not slot.is_live else None,
    }


def _title(slot: SlotSpec) -> str:
    firmware = f", firmware {slot.firmware}" if slot.has(Trait.FIRMWARE) else ""
    return f"{NAMES.get(slot.module, slot.module)}{firmware}"


def bits_of(slot: int, words: ModuleWords) -> list[Json]:
    """Return the named bits of a module."""
    rows = []
    stepper = words if is_stepper(words) else None
    for group, names in words.groups.items():
        for name, place in names.items():
            rows.append(
                {
                    "name": name,
                    "address": f"Local:{slot}:{place.image}.Data[{place.word}].{place.bit}",
                    "meaning": f"slot{slot}.{group}.{name}",
                    "section": SECTIONS.get(group, "") if stepper and name not in stepper.further else "",
                    "word": place.word,
                    "bit": place.bit,
                    "output": place.image == "O",
                    "error": place.image == "I" and name in words.errors,
                }
            )
    return rows


def addresses_of(spec: RackSpec) -> list[Json]:
    """Return the words of all slots, and their named bits, as tags for `hello`."""
    rows = []
    for slot in spec.slot:
        for bit in bits_of(slot.number, slot.words):
            rows.append({"name": bit["address"], "type": "BOOL", "description": bit["meaning"]})
        for image, word_kind in (("I", "input"), ("O", "output")):
            rows += [
                {
                    "name": f"Local:{slot.number}:{image}.Data[{word}]",
                    "type": "INT",
                    "description": f"slot {slot.number}, {word_kind} word {word}",
                }
                for word in range(len(slot.words.named(image)))
            ]
    return rows


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
                "word": place.word,
                "bit": place.bit,
            }
            for name, place in wired.items()
        ]
    if not slot.has(Trait.MACHINE):
        return []
    switched = {input_name(switch.input) for switch in slot.machine.switches}
    stationed = {input_name(station.input) for station in slot.machine.stations}
    kinds = dict.fromkeys(stationed, "station") | dict.fromkeys(switched, "switch")
    return [
        {"name": name, "title": _titled(name, own_title), "kind": kinds.get(name, "button"), "rest": False}
        for name, own_title in slot.record.machine_inputs(slot.options).items()
    ]


def _titled(name: str, own: str) -> str:
    return f"{TITLES[name]} ({own})" if own else TITLES[name]


def machine_of(machine: MachineSpec) -> Json:
    """Return the rail of a machine: the items along it, and its ends."""
    places = [
        place for switch in machine.switches for place in (switch.first, switch.last) if place is not None
    ]
    places += [station.position for station in machine.stations] + [jam.at for jam in machine.jams] + [0]
    low, high = min(places), max(places)
    margin = max((high - low) // 20, 200)
    return {
        "min": low - margin,
        "max": high + margin,
        "switches": [
            {
                "input": input_name(switch.input),
                "first": switch.first,
                "last": switch.last,
                "normally_closed": switch.normally_closed,
            }
            for switch in machine.switches
        ],
        "stations": [
            {"position": station.position, "input": input_name(station.input)} for station in machine.stations
        ],
        "jams": [{"at": jam.at, "direction": jam.direction} for jam in machine.jams],
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
    rows = []
    for kind, title in _TITLES.items():
        slots = [slot.number for slot in spec.slot if not slot.is_live and _can(kind, slot)]
        if slots:
            rows.append({"name": kind.value, "title": title, "fields": _fields_of(kind, spec, slots)})
    return [*rows, *_conditions_of(spec)]


def _fields_of(kind: FaultKind, spec: RackSpec, slots: Sequence[int]) -> list[Json]:
    """Return the fields of an incident that a page can set."""
    fields: list[Json] = [
        {"name": "slot", "title": "Slot", "kind": "choice", "default": slots[0], "choices": slots}
    ]
    if kind in LASTING or kind is FaultKind.TORN_UPDATE:
        fields.append({"name": "for_ms", "title": "For", "kind": "number", "default": 100, "unit": "ms"})
    if kind is FaultKind.TORN_UPDATE:
        words = list(range(max(len(slot.words.outputs) for slot in spec.slot if slot.number in slots)))
        late = {"name": "late_words", "title": "Late words", "kind": "words", "default": [1, 2]}
        fields.append(late | {"choices": words})
    return fields


def _conditions_of(spec: RackSpec) -> Iterator[Json]:
    """Yield the conditions around modules that can be set: named states as choices, others as text."""
    slots = [
        slot_spec.number for slot_spec in spec.slot if not slot_spec.is_live and slot_spec.record.conditions
    ]
    if not slots:
        return
    conditions = next(slot_spec.record.states() for slot_spec in spec.slot if slot_spec.number == slots[0])
    choices = [f"{name}={state}" for name, states in conditions.items() for state in states]
    slot = {"name": "slot", "title": "Slot", "kind": "choice", "default": slots[0], "choices": slots}
    state = {"name": "state", "title": "State", "kind": "text", "choices": choices}
    yield {"name": FaultKind.CONDITION.value, "title": "Condition of a drive", "fields": [slot, state]}


def _can(kind: FaultKind, slot: SlotSpec) -> bool:
    if kind in TROUBLES:
        return slot.has(Trait.STOPS_ANSWERING)
    return kind not in ON_THE_LINE or slot.has(Trait.LINE)
