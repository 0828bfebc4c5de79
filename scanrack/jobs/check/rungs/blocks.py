"""Commands of the motion blocks in `USE axis3601`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved, first_leaf
from scanrack.ladder.model.tags import program_of
from scanrack.ladder.state.lowered import ADD_ON, AddOnCall, steps_of

from ..facts import Command, FileLine
from ..ranges import Range, exactly
from .number_options import OperandOptions
from .number_ranges import Values
from .operands import first_of, is_zero, key_of, path_of
from .walk import Point

OWNER = "AMCI3601"
"""The block that writes the module's words, called in the last rung of the scan."""

RATES = {"ACCELERATION": "acceleration", "DECELERATION": "deceleration"}
PROFILE = {"VELOCITY": "speed", **RATES}

SEGMENTS_MAX = 64
"""Maximum number of segments whose values are read."""

METHODS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "CONFIGURE3601": ("configure", {}),
    "MC_MOVEABSOLUTE": ("move_to", {"POSITION": "position", **PROFILE}),
    "MC_MOVERELATIVE": ("move_by", {"DISTANCE": "distance", **PROFILE}),
    "MC_MOVEVELOCITY": ("run", PROFILE),
    "MC_HOME": ("home", {"DIRECTION": "direction", **PROFILE}),
    "MC_HALT": ("halt", {}),
    "MC_STOP": ("stop", {}),
    "MC_RESET": ("reset", {}),
    "MC_SETPOSITION": ("set_position", {"POSITION": "position"}),
    "MC_GEARIN": ("gear", {"RATIONUMERATOR": "numerator", "RATIODENOMINATOR": "denominator", **RATES}),
    "MC_TOUCHPROBE": ("captured", {}),
    "MOVEREGISTRATION3601": ("register", {"DISTANCE": "register", **PROFILE}),
    "STOREMINIMUM3601": ("store_minimum", {"DISTANCE": "distance"}),
    "PROGRAMBLEND3601": (
        "program_blend",
        {"SEGMENTS": "segments", "FINALDECELERATION": "final_deceleration"},
    ),
    "RUNBLEND3601": ("run_blend", {"DIRECTION": "direction"}),
}
"""By block: the corresponding method of `Axis3601`, and its arguments by block parameter."""


class BlockCall(NamedTuple):
    """A call of a motion block."""

    point: Point
    call: AddOnCall
    order: int  # position in the scan

    @property
    def place(self) -> FileLine:
        """The line of the call."""
        return self.point.place

    @property
    def is_owner(self) -> bool:
        """Whether it is the block that owns the axis."""
        return self.call.name == OWNER

    @property
    def axis(self) -> str:
        """The tag of the block's axis, in capitals; "" if it has none."""
        axis = self.call.handed.get("AXIS")
        return "" if axis is None else axis.text.upper()


def block_calls(points: Iterable[Point]) -> Iterator[BlockCall]:
    """Yield the calls of motion blocks in the user's routines, in order."""
    for order, point in enumerate(points):
        call = first_of(point.step, (ADD_ON,))
        if isinstance(call, AddOnCall) and (call.name in METHODS or call.name == OWNER):
            yield BlockCall(point, call, order)


def slots_of(calls: Iterable[BlockCall]) -> dict[str, int]:
    """Return the slot of each axis, from the Outputs argument of Amci3601."""
    slots = {}
    for call in calls:
        outputs = call.call.handed.get("OUTPUTS") if call.is_owner else None
        slot = None if outputs is None else first_leaf(outputs).slot
        if slot is not None:
            slots[call.axis] = slot
    return slots


def commands_of(
    calls: Iterable[BlockCall], slots: Mapping[str, int], values: Values, owners: Mapping[str, str]
) -> Iterator[Command]:
    """Yield the commands of motion blocks.

    Args:
        slots: slots of axes, by the tag of the axis in capitals.
        owners: the task of each program, by its name in capitals.
    """
    for call in calls:
        if call.call.name not in METHODS:
            continue
        kind, parameters = METHODS[call.call.name]
        sources = dict(_sources(call.call, parameters))
        unit = call.point.routine.name
        yield Command(
            kind,
            call.axis,
            slots.get(call.axis),
            call.place,
            f"{call.call.name} {call.call.instance.text}",
            values={name: values.range_of(source) for name, source in sources.items()},
            choices={name: _choices(source, values) for name, source in sources.items()},
            order=call.order,
            unit=unit,
            owner=owners.get(program_of(unit).upper(), ""),
            execute=_execute(call.call),
            segments=_segments(call.call, sources.get("segments"), values),
        )


def _choices(source: Resolved, values: Values) -> tuple[Range, ...]:
    """Return the values of an argument; for a table, its elements."""
    options = OperandOptions(values).evaluate(source).options
    return tuple(map(exactly, options)) if len(options) > 1 else values.choices(source)


def _sources(call: AddOnCall, parameters: Mapping[str, str]) -> Iterator[tuple[str, Resolved]]:
    """Yield the arguments of a call, by their names in `Axis3601`."""
    for step in (step for nodes in call.inputs for step in steps_of(nodes)):
        target = step.operands[-1]
        if step.name == "MOV" and isinstance(target, Place):
            name = path_of(target).rpartition(".")[2]
            if name in parameters:
                yield parameters[name], step.operands[0]


def _execute(call: AddOnCall) -> str:
    """Return the name of the bit passed to Execute; "1" for a constant."""
    for copies in call.inputs:
        steps = steps_of(copies)
        target = first_of(steps[-1], ("OTE",)) if steps else None
        if isinstance(target, Place) and path_of(target).endswith(".EXECUTE"):
            source = steps[0].operands[0]
            if len(steps) != 2 or is_zero(source):
                return ""
            return "1" if isinstance(source, Constant) else _text(source)
    return ""


def _text(operand: Resolved) -> str:
    """Return the text of an expression; equal expressions have equal texts."""
    if isinstance(operand, Place):
        return key_of(operand)
    if isinstance(operand, Calculation):
        return f"{operand.name}({', '.join(map(_text, operand.operands))})"
    return str(operand.value) if isinstance(operand, Constant) else repr(operand)


def _segments(
    call: AddOnCall, number: Resolved | None, values: Values
) -> tuple[tuple[Range, Range, Range], ...] | None:
    """Return the length, speed and rate of a blend's segments, if known.

    Args:
        number: the number of segments; None if the block programs no blend.
    """
    if number is None:
        return None
    count = values.range_of(number)
    if not count.is_constant or not 0 < count.least <= SEGMENTS_MAX:
        return None
    arrays = [call.handed.get(name) for name in ("LENGTHS", "VELOCITIES", "RATES")]
    columns = [values.elements(array, int(count.least)) for array in arrays if array is not None]
    return tuple(zip(*columns, strict=True)) if len(columns) == len(arrays) and all(columns) else None
