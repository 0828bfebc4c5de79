"""The steps of a ladder program: a number says the step, and comparisons with it say what happens in it.

EQU(State,20)MOV(2,axis.O.Data[0]);                       a command in step 20
EQU(State,20)XIC(axis.status.MOVING_CW)MOV(30,State);     from 20 to 30
EQU(State,30)TON(Pause,400,0);  XIC(Pause.DN)MOV(40,State);     from 30 to 40: the timer runs in 30
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.ladder.model.operands import Constant, Place
from scanrack.ladder.state.lowered import ADD_ON, Call, LoweredStep

from ..facts import Command, FileLine, Step, StepAction, StepUse
from ..logic import (
    TRUE,
    UNKNOWN,
    AllOf,
    Bit,
    Compare,
    Condition,
    FixedTruth,
    base_of,
    leaves,
    needed,
    negated,
    plain,
    steps_in,
)
from ..module_kinds import KINDS, MODE_CONFIG
from .conditions import EDGE, key_of
from .number_ranges import Values, target_of, written_value
from .output_writes import Write
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

MOVING = StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW
OFF_AT_END = MOVING | StatusMsw.POSITION_INVALID
"""Status bits that are off when a motion has ended; of the others none says so while it is off."""

UNDER_WAY = ("BUSY", "ACTIVE", "TT", "EN")
"""Members of blocks and timers that are on until they are done."""

DEPTH = 3
"""Tags behind a tag whose conditions are looked at."""


class Steps:
    """The steps of a program.

    Args:
        points: of the user's routines, with their lines.
        places: operands by their keys.
        steppers: slots with 3601s.
    """

    def __init__(
        self, points: Placed, values: Values, places: Mapping[str, Place], steppers: Collection[int]
    ) -> None:
        self._points, self._values, self._places, self._steppers = points, values, places, steppers
        self._found: dict[tuple[Condition, str], frozenset[float] | None] = {}

    def actions(self, writes: Iterable[Write], commands: Iterable[Command]) -> Iterator[StepAction]:
        """Yield what the program does in its steps.

        Args:
            writes: to output words.
            commands: of blocks.
        """
        if not self._machines:
            return
        for point, place in self._points:
            target = target_of(point.step)
            machine = self._machine(target)
            value = written_value(point.step)
            if machine and isinstance(value, Constant):
                yield from self._in_steps(point, place, only=machine, goes=float(value.value))
        points = {point.step.site: point for point, _ in self._points}
        for write in writes:
            if write.site in points and write.word == 0:
                yield from self._written(points[write.site], write)
        for each in commands:
            for point, place in self._starting(each):
                yield from self._in_steps(point, place, axis=each.axis, kind=each.kind, text=each.text)

    def _written(self, point: Point, write: Write) -> Iterator[StepAction]:
        bits = 0 if write.sets & MODE_CONFIG else write.sets
        kind = next((kind for bit, kind in KINDS.items() if bits & bit), "")
        given = {"axis": f"slot {write.slot}", "kind": kind, "text": f"the command {kind}"}
        if not write.known:
            yield from self._in_steps(point, write.place, axis=given["axis"], clears=write.clears)
        else:
            clears = write.clears | (0xFFFF if write.sets & MODE_CONFIG else 0)
            yield from self._in_steps(point, write.place, **given, sets=bits, clears=clears)

    def _in_steps(
        self,
        point: Point,
        place: FileLine,
        *,
        only: str = "",
        goes: Step | None = None,
        axis: str = "",
        kind: str = "",
        text: str = "",
        sets: int = 0,
        clears: int = 0,
    ) -> Iterator[StepAction]:
        """Yield an action of each machine."""
        condition = self._implied(self._called(point))
        ends, moves = self._ends(condition, DEPTH), self._needs_motion(condition)
        for machine, steps in self._machines.items():
            if only in ("", machine):
                there = self._there(condition, machine, steps)
                yield StepAction(
                    *(machine, there, place, goes, ends, moves, axis, kind, text, sets, clears),
                    when=self.acts_when(point),
                )

    def _there(self, condition: Condition, machine: str, steps: frozenset[float]) -> frozenset[float] | None:
        """Return the steps in which a condition can hold, once per condition; None for all."""
        key = condition, machine
        if key not in self._found:
            self._found[key] = steps_in(condition, machine, steps)
        return self._found[key]

    def acts_when(self, point: Point) -> Condition:
        """Return the condition under which an instruction sets a bit or writes a word, calls included."""
        called = self._called(point)
        return called if point.value == TRUE else AllOf((called, point.value))

    def where(self, point: Point) -> dict[str, tuple[frozenset[Step] | None, bool]]:
        """Return the steps in which an instruction may act, and whether it does in each scan of them."""
        found: dict[str, tuple[frozenset[Step] | None, bool]] = {}
        when = self.acts_when(point)
        condition = self._implied(when)
        for machine, steps in self._machines.items():
            there = self._there(condition, machine, steps)
            parts = [each for each in leaves(when) if each != TRUE]
            sure = all(isinstance(each, Compare) and base_of(each.name) == machine for each in parts)
            found[machine] = (None if there is None else frozenset(there), sure)
        return found

    def use(self, machine: str, step: Step) -> StepUse:
        """Return what the program does in a step."""
        tested = works = chosen = False
        for point, _ in self._points:
            own = AllOf((point.condition, point.own))
            if not any(isinstance(each, Compare) and base_of(each.name) == machine for each in leaves(own)):
                continue
            if self._there(own, machine, self._machines[machine]) == frozenset({step}):
                tested, chosen = True, chosen or not point.is_rung
                others = (
                    each
                    for each in leaves(own)
                    if each != TRUE and not (isinstance(each, Compare) and base_of(each.name) == machine)
                )
                works = works or next(others, None) is not None or point.value != TRUE
        return StepUse(tested, works, chosen)

    # --- machines

    @cached_property
    def _machines(self) -> dict[str, frozenset[float]]:
        """The numbers that say a step, with all their steps."""
        found: dict[str, set[float]] = {}
        for point, _ in self._points:
            goes = self._machine(target_of(point.step))
            for each in leaves(AllOf((point.own, point.condition)) if goes else point.own):
                if isinstance(each, Compare) and each.relation in ("=", "<=", ">="):
                    machine = self._machine(self._places.get(base_of(each.name)))
                    if machine:
                        found.setdefault(machine, set()).add(each.number)
        for point, _ in self._points:
            value = written_value(point.step)
            machine = self._machine(target_of(point.step))
            if machine in found and isinstance(value, Constant):
                found[machine].add(float(value.value))
        return {machine: frozenset(steps) for machine, steps in found.items()}

    def _machine(self, place: Place | None) -> str:
        """Return the key of a number that only gets constants; "" of another one."""
        if place is None or place.bit is not None or not place.type.is_integer:
            return ""
        if place.fixed_index is None:
            return ""
        if place.leaf.slot is not None or place.leaf.frame:
            return ""
        written = self._values.written(place)
        return key_of(place) if len(written) > 1 and all(each.is_constant for each in written) else ""

    # --- conditions

    @cached_property
    def _calls(self) -> dict[str, list[Point]]:
        """The calls of each routine."""
        found: dict[str, list[Point]] = {}
        for point, _ in self._points:
            for each in point.step.operands:
                if isinstance(each, Call):
                    found.setdefault(each.routine, []).append(point)
        return found

    @cached_property
    def _writers(self) -> dict[str, list[Point]]:
        """The instructions that write each bit, or run each timer, by key."""
        found: dict[str, list[Point]] = {}
        for point, _ in self._points:
            for key in _written_keys(point.step):
                found.setdefault(key, []).append(point)
        return found

    def _called(self, point: Point) -> Condition:
        """Return the condition of a point, with that of the one call of its routine."""
        calls = self._calls.get(point.routine.name.upper(), [])
        is_sole = len(calls) == 1 and calls[0].routine is not point.routine
        return AllOf((calls[0].condition, point.condition)) if is_sole else point.condition

    def _implied(self, condition: Condition, depth: int = DEPTH) -> Condition:
        """Return a condition with those of the timers and the coils that it needs."""
        found = [condition]
        for bit in needed(condition) if depth else ():
            base = base_of(bit.name)
            timer = base.removesuffix(".DN").removesuffix(".TT")
            writers = self._writers.get(timer if timer != base else base, [])
            if bit.on and len(writers) == 1 and writers[0].step.name in ("TON", "OTE", ":="):
                found.append(self._implied(_power(writers[0]), depth - 1))
        return AllOf(tuple(found)) if len(found) > 1 else condition

    def starts(self, command: Command) -> str:
        """Return the condition of the bit that starts a block; "" if not of bits and steps alone."""
        coils = self._writers.get(command.execute, [])
        if len(coils) != 1 or coils[0].step.name != "OTE":
            return ""
        condition = coils[0].condition
        parts = condition.parts if isinstance(condition, AllOf) else (condition,)
        is_plain = all(isinstance(each, Bit | Compare) for each in parts)
        return " and ".join(sorted(map(repr, parts))) if is_plain else ""

    def executed(self, command: Command) -> tuple[Condition, Condition]:
        """Return the condition of a block's Execute, UNKNOWN if it is not known, and what it implies."""
        if command.execute in ("", "1"):
            return (TRUE if command.execute else UNKNOWN), TRUE
        coils = self._writers.get(command.execute, [])
        own = Bit(command.execute)
        if len(coils) == 1 and coils[0].step.name in ("OTE", ":="):
            power = _power(coils[0])
            return plain(power), plain(AllOf((own, self._implied(power))))
        return (own if not coils else UNKNOWN), own

    def first(self, machine: str) -> frozenset[Step]:
        """Return the steps in which a machine may begin: of its initial values, and of the first scan."""
        place = self._places.get(machine)
        found = None if place is None else self._values.initial(place)
        steps = self._machines.get(machine, frozenset())
        initial = frozenset(each for each in steps if found is not None and found.least <= each <= found.most)
        return frozenset(self._begun.get(machine, ())) or initial

    @cached_property
    def _begun(self) -> dict[str, set[float]]:
        """The steps to which machines go in the first scan."""
        found: dict[str, set[float]] = {}
        for point, _ in self._points:
            if any(each.on and each.name.startswith("S:FS") for each in needed(point.condition)):
                value = written_value(point.step)
                machine = self._machine(target_of(point.step))
                if machine and isinstance(value, Constant):
                    found.setdefault(machine, set()).add(float(value.value))
        return found

    def _starting(self, command: Command) -> Iterator[tuple[Point, FileLine]]:
        """Yield the copies to Execute of a block."""
        execute = f"{command.text.rpartition(' ')[2].upper()}.EXECUTE"
        for point in self._writers.get(execute, ()):
            if point.argument:
                yield replace(point, condition=point.value), command.place

    def _ends(self, condition: Condition, depth: int) -> bool:
        return any(self._says_end(each, depth) for each in leaves(condition))

    def _says_end(self, part: Condition, depth: int) -> bool:
        """Whether a part of a condition may say that a motion has ended, or that time has passed."""
        if isinstance(part, FixedTruth):
            return False
        if isinstance(part, Compare):
            return base_of(part.name) not in self._machines
        if not isinstance(part, Bit):
            return True
        base = base_of(part.name)
        place = self._places.get(base)
        if place is None or base.startswith("S:FS"):
            return not base.startswith((EDGE, "S:FS"))
        if place.leaf.slot is not None:
            return self._status_ends(place, on=part.on)
        member = base.rpartition(".")[2]
        if "." in place.leaf.path:
            return part.on != (member in UNDER_WAY)
        powers = [
            _power(each) if each.step.name != "OTU" else negated(_power(each))
            for each in self._writers.get(base, [])
        ]
        return depth > 0 and any(self._ends(each if part.on else negated(each), depth - 1) for each in powers)

    def _status_ends(self, place: Place, *, on: bool) -> bool:
        """Whether a bit of an image says the end of a motion."""
        if place.leaf.slot not in self._steppers or place.leaf.output:
            return False
        bit = _status(place)
        return bit is None or (not bit & MOVING if on else bool(bit & OFF_AT_END))

    def _needs_motion(self, condition: Condition) -> bool:
        """Whether a condition needs that an axis moves."""
        places = (
            self._places.get(base_of(each.name))
            for each in leaves(condition)
            if isinstance(each, Bit) and each.on
        )
        return any(
            (_status(each) or 0) & MOVING
            for each in places
            if each is not None and each.leaf.slot in self._steppers and not each.leaf.output
        )


def _status(place: Place) -> int | None:
    """Return the status bit of word 0 that an operand is, None for another one."""
    is_bit = place.fixed_index == 0 and isinstance(place.bit, Constant)
    return 1 << int(place.bit.value) if is_bit and isinstance(place.bit, Constant) else None


def _power(point: Point) -> Condition:
    return point.condition if point.value == TRUE else AllOf((point.condition, point.value))


def _written_keys(step: LoweredStep) -> Iterator[str]:
    """Yield the key of the bit that an instruction writes, or of the timer that it runs."""
    first = step.operands[0] if step.operands and step.name != ADD_ON else None
    if isinstance(first, Place) and first.type.is_bool and step.name in ("OTE", "OTL", "OTU", ":="):
        yield key_of(first)
    elif step.name in ("TON", "RTO", "TOF") and first is not None:
        yield first.text.upper()
