"""A scenario: the events and conditions of one run, in addition to those of the rack file.

A scenario is data. The same scenario gives the same run. It can be written to a file and read back, and
shrinking can leave out any part.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from decimal import Decimal
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


def _versions(given: object) -> object:
    """Return pairs of slot and firmware version from a JSON object."""
    if not isinstance(given, Mapping):
        return given
    return tuple((int(slot), str(Firmware.parse(str(version)))) for slot, version in given.items())


def _object(versions: tuple[tuple[int, str], ...]) -> dict[str, str]:
    return {str(slot): version for slot, version in versions}


Versions = Annotated[tuple[tuple[int, str], ...], BeforeValidator(_versions), PlainSerializer(_object)]


@dataclass(frozen=True, slots=True)
class Part:
    """An event or a condition of a slot."""

    __pydantic_config__ = NO_MORE_KEYS

    slot: StrictInt


@dataclass(frozen=True, slots=True)
class Press(Part):
    """An input is held at a level for a time; if it has a switch, this is a failure of the switch."""

    input: InputName
    energized: StrictBool
    at_ns: Time
    for_ns: Time


@dataclass(frozen=True, slots=True)
class ContactPress(Part):
    """A contact of a card, such as a button or selector switch, is operated for a time."""

    input: StrictStr
    at_ns: Time
    for_ns: Annotated[Time, Field(gt=0)]


@dataclass(frozen=True, slots=True)
class Signal(Part):
    """An analog input of a card has another value for a time."""

    input: StrictStr
    value: float  # V or mA for a channel with a range, else the raw number
    at_ns: Time
    for_ns: Annotated[Time, Field(gt=0)]


@dataclass(frozen=True, slots=True)
class Turn(Part):
    """A master encoder turns; overlapping turns follow one another."""

    counts: StrictInt  # quadrature counts (x4); negative = counting down
    at_ns: Time
    for_ns: Annotated[Time, Field(gt=0)]


@dataclass(frozen=True, slots=True)
class SwitchOffset(Part):
    """A displacement of all switches of a machine from the drawing."""

    steps: StrictInt


@dataclass(frozen=True, slots=True)
class LostSteps(Part):
    """Steps that a motor loses."""

    at: StrictInt  # shaft position, steps
    steps: StrictInt


@dataclass(frozen=True, slots=True)
class TornUpdate:
    """An exchange in the middle of a scan: from a given rung, the program sees the next inputs.

    Nothing happens if no exchange is due before the next scan, or if the routine does not reach the rung.
    """

    __pydantic_config__ = NO_MORE_KEYS

    routine: StrictStr
    rung: Time  # number of the rung, or of the line in structured text
    at_ns: Time
    for_ns: ClassVar[int] = 0


@dataclass(frozen=True, slots=True)
class OperatorAction:
    """An operator's order before a scan: write, force or release a tag, or turn the key."""

    at_ns: int
    order: Action


OPERATOR = {"write": Write, "force": Force, "unforce": Unforce, "mode": Mode}
"""The orders in a scenario, by name."""


def _orders(given: object) -> object:
    """Return orders from JSON objects: `{"at_ns": 0, "do": "write", "tag": "Start", "value": true}`."""
    rows = list(given) if isinstance(given, list | tuple) else [given]
    return tuple(row if isinstance(row, OperatorAction) else _order(row) for row in rows)


def _order(given: object) -> OperatorAction:
    if not isinstance(given, Mapping) or type(given.get("at_ns")) is not int or given["at_ns"] < 0:
        raise ValueError("an order is an object with at_ns, a whole number from 0, and do")
    return OperatorAction(
        given["at_ns"], action_of({key: value for key, value in given.items() if key != "at_ns"}, OPERATOR)
    )


def _order_rows(orders: tuple[OperatorAction, ...]) -> list[dict[str, Any]]:
    return [{"at_ns": order.at_ns, **message_of(order.order)} for order in orders]


Orders = Annotated[tuple[OperatorAction, ...], PlainValidator(_orders), PlainSerializer(_order_rows)]


@dataclass(frozen=True, slots=True)
class Scenario:
    """The events and conditions of one run."""

    __pydantic_config__ = NO_MORE_KEYS

    firmware: Versions = ()  # firmware versions that differ from the rack file, by slot number
    presses: tuple[Press, ...] = ()
    incidents: tuple[InjectedFault, ...] = ()
    shifts: tuple[SwitchOffset, ...] = ()  # displaced switches
    lost: tuple[LostSteps, ...] = ()  # lost steps
    pushes: tuple[ContactPress, ...] = ()  # people's actions on the contacts of cards
    signals: tuple[Signal, ...] = ()
    turns: tuple[Turn, ...] = ()  # movements of master encoders
    orders: Orders = ()  # an operator's orders, in the scenario of a proof
    tears: tuple[TornUpdate, ...] = ()  # scans within which the inputs change

    def laid_over(self, spec: RackSpec) -> RackSpec:
        """Return a rack with this scenario added."""
        slots = tuple(map(self.laid_over_slot, spec.slot))
        incidents = tuple(_incident_spec(incident) for incident in self.incidents)
        return spec.model_copy(update={"slot": slots, "incident": (*spec.incident, *incidents)})

    def laid_over_slot(self, slot: SlotSpec) -> SlotSpec:
        """Return a slot with the parts of this scenario that concern it; without any, the same slot."""
        changed_fields: dict[str, Any] = {}
        if (firmware := dict(self.firmware).get(slot.number, slot.firmware)) != slot.firmware:
            changed_fields["firmware"] = firmware
        if (machine := self._machine(slot)) is not slot.machine:
            changed_fields["machine"] = machine
        rows: Any = slot.options.get("timeline", ())
        entries = [push_entry(push) for push in of_slot(self.pushes, slot)]
        entries += signal_entries(of_slot(self.signals, slot), rows)
        if entries:
            changed_fields["options"] = {**slot.options, "timeline": one_at_a_time([*rows, *entries])}
        return slot.model_copy(update=changed_fields) if changed_fields else slot

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
    def from_json(cls, given: object) -> Scenario:
        """Return the scenario that `to_json` has converted.

        Raises:
            ValueError: the scenario is illegal; the message names the key.
        """
        try:
            return _SCENARIO.validate_python(given)
        except ValidationError as error:
            raise ValueError(f"scenario: {first_mistake(error)}") from None

    def check(self, spec: RackSpec) -> None:
        """Check that this scenario fits a rack.

        Raises:
            ValueError: it refers to a slot or input that the rack lacks.
        """
        have = [slot.number for slot in spec.slot]
        for number in self._slots():
            if number not in have:
                slots = ", ".join(map(str, have))
                raise ValueError(f"scenario: no slot {number}; the rack has {slots}")
        for slot in spec.slot:
            buttons, signals = slot.record.buttons(slot.options), slot.record.signals(slot.options)
            _check_inputs(of_slot(self.pushes, slot), "button", buttons)
            _check_inputs(of_slot(self.signals, slot), "analog input", signals)

    def _slots(self) -> Iterator[int]:
        """Yield the numbers of the slots that its parts concern."""
        yield from dict(self.firmware)
        for parts in (self.presses, self.pushes, self.signals, self.shifts, self.lost, self.turns):
            yield from (part.slot for part in parts)
        yield from (
            incident.slot for incident in self.incidents if incident.what is not FaultKind.PROGRAM_MODE
        )

    def is_possible(self, spec: RackSpec) -> bool:
        """Return whether every module's firmware is recent enough for the rack's program."""
        needed = {slot.number: Firmware.parse(slot.needs_firmware) for slot in spec.slot}
        return all(
            Firmware.parse(version) >= needed[slot] for slot, version in self.firmware if slot in needed
        )

    @property
    def size(self) -> int:
        """Number of its parts."""
        return sum(len(getattr(self, field.name)) for field in fields(self))


_SCENARIO = TypeAdapter(Scenario)

SomePart = TypeVar("SomePart", bound=Part)


def of_slot(parts: Iterable[SomePart], slot: SlotSpec) -> list[SomePart]:
    """Return the parts that concern a slot."""
    return [part for part in parts if part.slot == slot.number]


def _check_inputs(parts: Iterable[ContactPress | Signal], what: str, names: Collection[str]) -> None:
    """Raise ValueError for a part whose input is not among the names of its card."""
    for part in parts:
        if part.input not in names:
            names_text = ", ".join(names) or "none"
            raise ValueError(f"scenario: slot {part.slot} has no {what} {part.input!r}, only {names_text}")


def first_mistake(error: ValidationError) -> str:
    """Return a description of the first mistake: key, value, problem."""
    first = error.errors(include_url=False)[0]
    kind, path = first["type"], first["loc"]
    key, names = ".".join(map(str, path)), ", ".join(field.name for field in fields(Scenario))
    if not path:
        return f"an object with {names} is needed, not {first['input']!r:.40}"
    if kind == "unexpected_keyword_argument" and len(path) == 1:
        return f"unknown key {key}; choose from {names}"
    if kind == "missing":
        return f"key {key} is missing"
    return f"{key} = {first['input']!r:.40}: {first.get('ctx', {}).get('error', first['msg'])}"


def in_succession(own: Iterable[MasterTurn], turns: Iterable[Turn]) -> tuple[MasterTurn, ...]:
    """Return movements of a master encoder in time order, each delayed until the previous one has ended.

    >>> in_succession([MasterTurn(5, 3, 10)], [Turn(1, 40, 7, 20)])
    (MasterTurn(at_ns=5, counts=3, for_ns=10), MasterTurn(at_ns=15, counts=40, for_ns=20))
    """
    placed: list[MasterTurn] = []
    all_turns = [
        *own,
        *(MasterTurn(master_turn.at_ns, master_turn.counts, master_turn.for_ns) for master_turn in turns),
    ]
    for turn in sorted(all_turns, key=lambda turn: turn.at_ns):
        free_ns = placed[-1].end_ns if placed else 0
        placed.append(replace(turn, at_ns=max(turn.at_ns, free_ns)))
    return tuple(placed)


def push_entry(push: ContactPress) -> dict[str, Any]:
    """Return a push as a row of a card's timeline."""
    return {"at_ms": push.at_ns / 1e6, "input": push.input, "for_ms": push.for_ns / 1e6}


def one_at_a_time(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return rows of a card's timeline without overlapping operations of an input, as the card requires.

    Overlapping presses are combined. Of two values at the same instant, the later row is used.
    """
    rows_by_input: dict[str, list[Mapping[str, Any]]] = {}
    for row in sorted(rows, key=lambda row: InputPress(**row).begin_ns):
        before = rows_by_input.setdefault(row["input"], [])
        joined = _joined(before.pop(), row) if before else [row]
        before += joined
    return [row for kept_rows in rows_by_input.values() for row in kept_rows]


def _joined(last: Mapping[str, Any], row: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the rows that replace a row and a later row of the same input."""
    before, press = InputPress(**last), InputPress(**row)
    if before.value is not None:
        return [row] if before.begin_ns == press.begin_ns else [last, row]
    if before.end_ns is None:
        return [last]
    if press.begin_ns >= before.end_ns:
        return [last, row]
    if press.end_ns is None:
        return [{"at_ms": before.begin_ns / 1e6, "input": row["input"]}]
    for_ms = (max(press.end_ns, before.end_ns) - before.begin_ns) / 1e6
    return [{"at_ms": before.begin_ns / 1e6, "input": row["input"], "for_ms": for_ms}]


def signal_entries(
    signals: Sequence[Signal], rows: Sequence[Mapping[str, Any]]
) -> list[dict[str, str | int | float]]:
    """Return signals as rows of a card's timeline; after each, the input returns to its other value."""
    entries: list[dict[str, str | int | float]] = []
    for signal in signals:
        end_ms = (signal.at_ns + signal.for_ns) / 1e6
        own = [(InputPress(**row).begin_ns, row["value"]) for row in rows if row["input"] == signal.input]
        before = [(at_ns, value) for at_ns, value in own if at_ns <= signal.at_ns + signal.for_ns]
        base_value = max(before, key=lambda row: row[0])[1] if before else 0
        entries.append({"at_ms": signal.at_ns / 1e6, "input": signal.input, "value": signal.value})
        entries.append({"at_ms": end_ms, "input": signal.input, "value": base_value})
    return entries


def _incident_spec(incident: InjectedFault) -> InjectedFaultSpec:
    """Return an incident in the form of a rack file."""
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

    def moved(position: int | None) -> int | None:
        return None if position is None else position + steps

    switches = tuple(
        replace(switch, first=moved(switch.first), last=moved(switch.last)) for switch in machine.switches
    )
    stations = tuple(replace(station, position=station.position + steps) for station in machine.stations)
    return replace(machine, switches=switches, stations=stations)


def entries_of(press: Press, machine: MachineSpec) -> tuple[TimelineEntry, TimelineEntry]:
    """Return the timeline entries of a press: its level, and the return to the level without the press."""
    end_ns = press.at_ns + press.for_ns
    if machine.fed_inputs & press.input.value:
        level: bool | None = None
    else:
        before = [
            earlier
            for earlier in machine.timeline
            if earlier.input is press.input and earlier.at_ns <= end_ns
        ]
        level = max(before, key=lambda each: each.at_ns).energized if before else False
    return (
        TimelineEntry(press.at_ns, press.input, press.energized),
        TimelineEntry(end_ns, press.input, level),
    )
