"""A scenario: the events and conditions of one run, in addition to the events in the rack file.

A scenario is data. The same scenario always produces the same run. It can be written to a file and read back,
and shrinking can remove any part.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from decimal import Decimal
from itertools import chain
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    StrictBool,
    StrictInt,
    StrictStr,
    TypeAdapter,
    ValidationError,
)
from scanrack.io_images.amci3601.firmware import Firmware
from scanrack.runtime.config.rackspec import InjectedFaultSpec, RackSpec, SlotSpec
from scanrack.runtime.live.actions import Action, Force, Mode, Unforce, Write, action_of, message_of
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault
from scanrack.runtime.machine import MachineSpec, MasterTurn, Slip, TimelineEntry
from scanrack.runtime.machine.spec import InputName
from scanrack.runtime.modules.cards.card_options import InputPress

Time = Annotated[StrictInt, Field(ge=0)]
NO_MORE_KEYS = ConfigDict(extra="forbid")


def _parse_versions(value: object) -> object:
    """Return pairs of slot and firmware version from a JSON object."""
    if not isinstance(value, Mapping):
        return value
    return tuple((int(slot), str(Firmware.parse(str(version)))) for slot, version in value.items())


def _versions_object(versions: tuple[tuple[int, str], ...]) -> dict[str, str]:
    return {str(slot): version for slot, version in versions}


Versions = Annotated[
    tuple[tuple[int, str], ...], BeforeValidator(_parse_versions), PlainSerializer(_versions_object)
]


@dataclass(frozen=True, slots=True)
class Part:
    """An event or a condition of a slot."""

    __pydantic_config__ = NO_MORE_KEYS

    slot: StrictInt


@dataclass(frozen=True, slots=True)
class Press(Part):
    """An input has a fixed level for a time. If it has a switch, the switch fails."""

    input: InputName
    energized: StrictBool
    at_ns: Time
    for_ns: Time


@dataclass(frozen=True, slots=True)
class ContactPress(Part):
    """A card contact, such as a button or selector switch, is operated for a time."""

    input: StrictStr
    at_ns: Time
    for_ns: Annotated[Time, Field(gt=0)]


@dataclass(frozen=True, slots=True)
class Signal(Part):
    """An analog input of a card has a different value for a time."""

    input: StrictStr
    value: float  # V or mA for a channel with a range, else the raw number
    at_ns: Time
    for_ns: Annotated[Time, Field(gt=0)]


@dataclass(frozen=True, slots=True)
class Turn(Part):
    """A master encoder turns. Overlapping turns follow one another."""

    counts: StrictInt  # quadrature counts (x4); negative = counts down
    at_ns: Time
    for_ns: Annotated[Time, Field(gt=0)]


@dataclass(frozen=True, slots=True)
class SwitchOffset(Part):
    """A displacement of all of a machine's switches from their positions in the drawing."""

    steps: StrictInt


@dataclass(frozen=True, slots=True)
class LostSteps(Part):
    """Steps that a motor loses."""

    at: StrictInt  # shaft position, steps
    steps: StrictInt


@dataclass(frozen=True, slots=True)
class TornUpdate:
    """An exchange in the middle of a scan. From a rung on, the program reads new inputs.

    It has no effect if no exchange is due before the next scan, or if the routine does not reach the rung.
    """

    __pydantic_config__ = NO_MORE_KEYS

    routine: StrictStr
    rung: Time  # number of the rung or line of structured text
    at_ns: Time
    for_ns: ClassVar[int] = 0


@dataclass(frozen=True, slots=True)
class OperatorAction:
    """An operator's order before a scan: a write, a force or its release, or a turn of the key."""

    at_ns: int
    order: Action


OPERATOR = {"write": Write, "force": Force, "unforce": Unforce, "mode": Mode}
"""The orders in a scenario, by name."""


def _parse_orders(value: object) -> object:
    """Return orders from JSON objects: `{"at_ns": 0, "do": "write", "tag": "Start", "value": true}`."""
    rows = list(value) if isinstance(value, list | tuple) else [value]
    return tuple(row if isinstance(row, OperatorAction) else _parse_order(row) for row in rows)


def _parse_order(row: object) -> OperatorAction:
    if not isinstance(row, Mapping) or type(row.get("at_ns")) is not int or row["at_ns"] < 0:
        raise ValueError("an order must be an object with at_ns, a whole number from 0, and do")
    message = {key: value for key, value in row.items() if key != "at_ns"}
    return OperatorAction(row["at_ns"], action_of(message, OPERATOR))


def _order_rows(orders: tuple[OperatorAction, ...]) -> list[dict[str, Any]]:
    return [{"at_ns": order.at_ns, **message_of(order.order)} for order in orders]


Orders = Annotated[tuple[OperatorAction, ...], PlainValidator(_parse_orders), PlainSerializer(_order_rows)]


@dataclass(frozen=True, slots=True)
class Scenario:
    """The events and conditions of one run."""

    __pydantic_config__ = NO_MORE_KEYS

    firmware: Versions = ()  # firmware versions that differ from the rack file, by slot number
    presses: tuple[Press, ...] = ()
    incidents: tuple[InjectedFault, ...] = ()
    shifts: tuple[SwitchOffset, ...] = ()  # displaced switches
    lost: tuple[LostSteps, ...] = ()  # lost steps
    pushes: tuple[ContactPress, ...] = ()  # operated card contacts
    signals: tuple[Signal, ...] = ()  # analog values of cards
    turns: tuple[Turn, ...] = ()  # movements of master encoders
    orders: Orders = ()  # an operator's orders
    tears: tuple[TornUpdate, ...] = ()  # input changes in the middle of a scan

    def laid_over(self, spec: RackSpec) -> RackSpec:
        """Return a rack with this scenario applied."""
        slots = tuple(map(self.laid_over_slot, spec.slot))
        incidents = tuple(_incident_spec(incident) for incident in self.incidents)
        return spec.model_copy(update={"slot": slots, "incident": (*spec.incident, *incidents)})

    def laid_over_slot(self, slot: SlotSpec) -> SlotSpec:
        """Return a slot with its parts of this scenario; the same slot if it has no parts."""
        changes: dict[str, Any] = {}
        if (firmware := dict(self.firmware).get(slot.number, slot.firmware)) != slot.firmware:
            changes["firmware"] = firmware
        if (machine := self._machine(slot)) is not slot.machine:
            changes["machine"] = machine
        rows: Any = slot.options.get("timeline", ())
        new_rows = [push_row(push) for push in of_slot(self.pushes, slot)]
        new_rows += signal_rows(of_slot(self.signals, slot), rows)
        if new_rows:
            changes["options"] = {**slot.options, "timeline": one_at_a_time([*rows, *new_rows])}
        return slot.model_copy(update=changes) if changes else slot

    def _machine(self, slot: SlotSpec) -> MachineSpec:
        """Return the machine of a slot with this scenario's offsets, lost steps, presses and turns."""
        machine = slot.machine
        for shift in of_slot(self.shifts, slot):
            machine = shifted(machine, shift.steps)
        slips = tuple(Slip(slip.at, slip.steps) for slip in of_slot(self.lost, slot))
        entries = tuple(
            entry for press in of_slot(self.presses, slot) for entry in entries_of(press, machine)
        )
        if slips or entries:
            machine = replace(machine, slips=(*machine.slips, *slips), timeline=(*machine.timeline, *entries))
        if turns := of_slot(self.turns, slot):
            machine = replace(machine, turns=in_succession(machine.turns, turns))
        return machine

    def to_json(self) -> dict[str, Any]:
        """Return the scenario as JSON types; the inverse of `from_json`."""
        scenario_object: dict[str, Any] = _SCENARIO.dump_python(self, mode="json")
        return scenario_object

    @classmethod
    def from_json(cls, value: object) -> Scenario:
        """Return the scenario from the JSON types that `to_json` returned.

        Raises:
            ValueError: the scenario is invalid; the message names the key.
        """
        try:
            return _SCENARIO.validate_python(value)
        except ValidationError as error:
            raise ValueError(f"scenario: {first_mistake(error)}") from None

    def check(self, spec: RackSpec) -> None:
        """Check that this scenario fits a rack.

        Raises:
            ValueError: the scenario has a slot or input that the rack lacks.
        """
        slots = [slot.number for slot in spec.slot]
        for number in self._slots():
            if number not in slots:
                slots_text = ", ".join(map(str, slots))
                raise ValueError(f"scenario: no slot {number}; the rack has {slots_text}")
        for slot in spec.slot:
            buttons, signals = slot.record.buttons(slot.options), slot.record.signals(slot.options)
            _check_inputs(of_slot(self.pushes, slot), "button", buttons)
            _check_inputs(of_slot(self.signals, slot), "analog input", signals)

    def _slots(self) -> Iterator[int]:
        """Yield the slot numbers of the scenario's parts."""
        yield from dict(self.firmware)
        for parts in (self.presses, self.pushes, self.signals, self.shifts, self.lost, self.turns):
            yield from (part.slot for part in parts)
        yield from (fault.slot for fault in self.incidents if fault.what is not FaultKind.PROGRAM_MODE)

    def is_possible(self, spec: RackSpec) -> bool:
        """Return whether the firmware of every module is new enough for the rack's program."""
        needed = {slot.number: Firmware.parse(slot.needs_firmware) for slot in spec.slot}
        return all(
            Firmware.parse(version) >= needed[slot] for slot, version in self.firmware if slot in needed
        )

    @property
    def size(self) -> int:
        """Number of parts in the scenario."""
        return sum(len(getattr(self, field.name)) for field in fields(self))


_SCENARIO = TypeAdapter(Scenario)

SomePart = TypeVar("SomePart", bound=Part)


def of_slot(parts: Iterable[SomePart], slot: SlotSpec) -> list[SomePart]:
    """Return the parts for a slot."""
    return [part for part in parts if part.slot == slot.number]


def _check_inputs(parts: Iterable[ContactPress | Signal], kind: str, names: Collection[str]) -> None:
    """Raise ValueError for a part with an input that its card lacks."""
    for part in parts:
        if part.input not in names:
            names_text = ", ".join(names) or "none"
            raise ValueError(f"scenario: slot {part.slot} has no {kind} {part.input!r}, only {names_text}")


def first_mistake(error: ValidationError) -> str:
    """Return the key, value and problem of the first mistake."""
    first = error.errors(include_url=False)[0]
    kind, path = first["type"], first["loc"]
    key, names = ".".join(map(str, path)), ", ".join(field.name for field in fields(Scenario))
    if not path:
        return f"{first['input']!r:.40}: must be an object with {names}"
    if kind == "unexpected_keyword_argument" and len(path) == 1:
        return f"unknown key {key}; choose from {names}"
    if kind == "missing":
        return f"key {key} is missing"
    return f"{key} = {first['input']!r:.40}: {first.get('ctx', {}).get('error', first['msg'])}"


def in_succession(machine_turns: Iterable[MasterTurn], turns: Iterable[Turn]) -> tuple[MasterTurn, ...]:
    """Return movements of a master encoder in time order, each delayed until the previous one has ended.

    >>> in_succession([MasterTurn(5, 3, 10)], [Turn(1, 40, 7, 20)])
    (MasterTurn(at_ns=5, counts=3, for_ns=10), MasterTurn(at_ns=15, counts=40, for_ns=20))
    """
    all_turns = [*machine_turns, *(MasterTurn(turn.at_ns, turn.counts, turn.for_ns) for turn in turns)]
    delayed: list[MasterTurn] = []
    for turn in sorted(all_turns, key=lambda turn: turn.at_ns):
        free_ns = delayed[-1].end_ns if delayed else 0
        delayed.append(replace(turn, at_ns=max(turn.at_ns, free_ns)))
    return tuple(delayed)


def push_row(push: ContactPress) -> dict[str, Any]:
    """Return a contact press as a row of a card's timeline."""
    return {"at_ms": push.at_ns / 1e6, "input": push.input, "for_ms": push.for_ns / 1e6}


def one_at_a_time(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return rows of a card's timeline without overlapping operations of an input, as the card requires.

    Overlapping presses are combined. If two rows have the same time, the later row is used.
    """
    rows_by_input: dict[str, list[Mapping[str, Any]]] = {}
    for row in sorted(rows, key=lambda row: InputPress(**row).begin_ns):
        input_rows = rows_by_input.setdefault(row["input"], [])
        input_rows += _combined(input_rows.pop(), row) if input_rows else [row]
    return list(chain.from_iterable(rows_by_input.values()))


def _combined(row: Mapping[str, Any], next_row: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the rows that replace two successive rows of the same input."""
    press, next_press = InputPress(**row), InputPress(**next_row)
    if press.value is not None:
        return [next_row] if press.begin_ns == next_press.begin_ns else [row, next_row]
    if press.end_ns is None:
        return [row]
    if next_press.begin_ns >= press.end_ns:
        return [row, next_row]
    combined = {"at_ms": press.begin_ns / 1e6, "input": row["input"]}
    if next_press.end_ns is not None:
        combined["for_ms"] = (max(next_press.end_ns, press.end_ns) - press.begin_ns) / 1e6
    return [combined]


def signal_rows(
    signals: Sequence[Signal], rows: Sequence[Mapping[str, Any]]
) -> list[dict[str, str | int | float]]:
    """Return signals as rows of a card's timeline. Afterward, the input returns to its value in `rows`."""
    new_rows: list[dict[str, str | int | float]] = []
    for signal in signals:
        end_ns = signal.at_ns + signal.for_ns
        value_by_time = {
            InputPress(**row).begin_ns: row["value"] for row in reversed(rows) if row["input"] == signal.input
        }
        last_ns = max((at_ns for at_ns in value_by_time if at_ns <= end_ns), default=None)
        end_value = 0 if last_ns is None else value_by_time[last_ns]
        new_rows.append({"at_ms": signal.at_ns / 1e6, "input": signal.input, "value": signal.value})
        new_rows.append({"at_ms": end_ns / 1e6, "input": signal.input, "value": end_value})
    return new_rows


def _incident_spec(incident: InjectedFault) -> InjectedFaultSpec:
    """Return an injected fault in the form used in a rack file."""
    return InjectedFaultSpec(
        at_ms=Decimal(incident.at_ns).scaleb(-6),
        what=incident.what,
        slot=incident.slot or None,
        for_ms=Decimal(incident.for_ns).scaleb(-6) if incident.for_ns else None,
        late_words=incident.late_words,
        state=incident.state,
    )


def shifted(machine: MachineSpec, steps: int) -> MachineSpec:
    """Return a machine with all switches and stations displaced."""

    def displaced(position: int | None) -> int | None:
        return None if position is None else position + steps

    switches = tuple(
        replace(switch, first=displaced(switch.first), last=displaced(switch.last))
        for switch in machine.switches
    )
    stations = tuple(replace(station, position=station.position + steps) for station in machine.stations)
    return replace(machine, switches=switches, stations=stations)


def entries_of(press: Press, machine: MachineSpec) -> tuple[TimelineEntry, TimelineEntry]:
    """Return the timeline entries of a press: its level, and the return to the level without the press."""
    end_ns = press.at_ns + press.for_ns
    end_level: bool | None = False
    if machine.fed_inputs & press.input.value:
        end_level = None  # the switch or station determines the level again
    else:
        earlier_entries = [
            entry for entry in machine.timeline if entry.input is press.input and entry.at_ns <= end_ns
        ]
        if earlier_entries:
            end_level = max(earlier_entries, key=lambda entry: entry.at_ns).energized
    return (
        TimelineEntry(press.at_ns, press.input, press.energized),
        TimelineEntry(end_ns, press.input, end_level),
    )
