"""The rack in the first message to a page: slots, words, bits, inputs, machines, faults to inject."""

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
"""Titles of a 3601's inputs."""

NAMES = {
    "amci3601": "AMCI 3601",
    "pcl601-adapter": "PCL601 adapter",
    "pmc006-adapter": "PMC006 adapter",
    "amci-drive": "networked drive",
    **{name: f"AMCI {model.title}" for name, model in MODELS.items()},
}
"""Titles of modules. The title of a card is its catalog number."""

SECTIONS = {
    "command": "chapter 5, Command Words",
    "status": "chapter 6, Status Bits",
}
"""The section of the manual that describes the bits of a group."""


def slots_of(spec: RackSpec) -> list[Json]:
    """Return the slots of a rack for `hello`."""
    return [slot_of(slot) for slot in spec.slot]


def slot_of(slot: SlotSpec) -> Json:
    """Return a slot for `hello`: its words, bits, values, inputs, lamps and machine."""
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
            {"name": name, "title": name, "word": bit_place.word, "bit": bit_place.bit}
            for name, bit_place in words.groups.get("output", {}).items()
        ],
        "machine": machine_of(slot.machine) if slot.has(Trait.MACHINE) and not slot.is_live else None,
    }


def _title(slot: SlotSpec) -> str:
    firmware = f", firmware {slot.firmware}" if slot.has(Trait.FIRMWARE) else ""
    return f"{NAMES.get(slot.module, slot.module)}{firmware}"


def bits_of(slot: int, words: ModuleWords) -> list[Json]:
    """Return the named bits of a module for `hello`, each with its address and section of the manual."""
    rows = []
    stepper = words if is_stepper(words) else None
    for group, names in words.groups.items():
        for name, bit_place in names.items():
            rows.append(
                {
                    "name": name,
                    "address": f"Local:{slot}:{bit_place.image}.Data[{bit_place.word}].{bit_place.bit}",
                    "meaning": f"slot{slot}.{group}.{name}",
                    "section": SECTIONS.get(group, "") if stepper and name not in stepper.further else "",
                    "word": bit_place.word,
                    "bit": bit_place.bit,
                    "output": bit_place.image == "O",
                    "error": bit_place.image == "I" and name in words.errors,
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
    """Return the inputs of a simulated module for `hello`.

    People operate inputs of kind "button"; the machine operates cams, stations and switches.
    """
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
                "word": bit_place.word,
                "bit": bit_place.bit,
            }
            for name, bit_place in wired.items()
        ]
    if not slot.has(Trait.MACHINE):
        return []
    switched = {input_name(switch.input) for switch in slot.machine.switches}
    stationed = {input_name(station.input) for station in slot.machine.stations}
    kinds = dict.fromkeys(stationed, "station") | dict.fromkeys(switched, "switch")
    return [
        {
            "name": name,
            "title": f"{TITLES[name]} ({terminal})" if terminal else TITLES[name],
            "kind": kinds.get(name, "button"),
            "rest": False,
        }
        for name, terminal in slot.record.machine_inputs(slot.options).items()
    ]


def machine_of(machine: MachineSpec) -> Json:
    """Return the rail of a machine for a page: the items along it, and its ends."""
    positions = [0]
    for switch in machine.switches:
        positions += [position for position in (switch.first, switch.last) if position is not None]
    positions += [station.position for station in machine.stations]
    positions += [jam.at for jam in machine.jams]
    low, high = min(positions), max(positions)
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
    FaultKind.POWER_CYCLE: "Module power cycle",
    FaultKind.LINK_LOST: "Module link lost",
    FaultKind.REMOVED: "Module removed",
    FaultKind.FATAL_ERROR: "Module failure",
    FaultKind.ASIC_LOST: "Backplane interface failure",
    FaultKind.TORN_UPDATE: "Torn output update",
    FaultKind.LINE_DOWN: "Line to controller open",
    FaultKind.REPLIES_LOST: "Controller replies lost",
    FaultKind.REPLIES_DAMAGED: "Controller replies damaged",
    FaultKind.CONTROLLER_POWER_CYCLE: "Controller power cycle",
}


def incidents_of(spec: RackSpec) -> list[Json]:
    """Return the faults that a page can inject, each with its slots."""
    rows = []
    for kind, title in _TITLES.items():
        slots = [slot.number for slot in spec.slot if not slot.is_live and _applies(kind, slot)]
        if slots:
            rows.append({"name": kind.value, "title": title, "fields": _fields_of(kind, spec, slots)})
    return [*rows, *_conditions_of(spec)]


def _fields_of(kind: FaultKind, spec: RackSpec, slots: Sequence[int]) -> list[Json]:
    """Return the fields of an injected fault that a page can set."""
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
    """Yield one row for the module conditions that a page can set, if any module has conditions.

    The named states of the first such module are the choices.
    """
    slots = [slot for slot in spec.slot if not slot.is_live and slot.record.conditions]
    if not slots:
        return
    conditions, numbers = slots[0].record.states(), [slot.number for slot in slots]
    choices = [f"{name}={state}" for name, states in conditions.items() for state in states]
    slot_field = {
        "name": "slot",
        "title": "Slot",
        "kind": "choice",
        "default": numbers[0],
        "choices": numbers,
    }
    state_field = {"name": "state", "title": "State", "kind": "text", "choices": choices}
    fields = [slot_field, state_field]
    yield {"name": FaultKind.CONDITION.value, "title": "Drive condition", "fields": fields}


def _applies(kind: FaultKind, slot: SlotSpec) -> bool:
    if kind in TROUBLES:
        return slot.has(Trait.STOPS_ANSWERING)
    return kind not in ON_THE_LINE or slot.has(Trait.LINE)
