"""The steps of a ladder program. A number holds the step, and rungs compare it to act in certain steps.

EQU(State,20)MOV(2,axis.O.Data[0]);                       a command in step 20
EQU(State,20)XIC(axis.status.MOVING_CW)MOV(30,State);     from 20 to 30
EQU(State,30)TON(Pause,400,0);  XIC(Pause.DN)MOV(40,State);     from 30 to 40, since the timer runs in 30
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeGuard

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.ladder.model.operands import Constant, Place
from scanrack.ladder.state.lowered import LoweredStep

from ..facts import Command, Step, StepAction, StepUse
from ..groups import grouped
from ..logic import (
    TRUE,
    UNKNOWN,
    AllOf,
    Bit,
    Compare,
    Condition,
    FixedTruth,
    base_of,
    compares,
    is_only_of,
    leaves,
    needed,
    negated,
    plain,
    steps_in,
)
from ..module_kinds import MOVING, given_by, shows_end
from ..written import WordWrite
from .accesses import FIRST_SCAN, in_first_scan
from .calls import RoutineCalls
from .conditions import EDGE
from .number_ranges import written_value
from .operands import first_of, group_of, is_input, key_of
from .output_writes import Write
from .view import LadderView
from .walk import Point

UNDER_WAY = ("BUSY", "ACTIVE", "TT", "EN")
"""Members of blocks and timers that are on until the block or timer is done."""

DEPTH = 3
"""Maximum number of coils and timers whose conditions are followed one after another."""


class Steps:
    """The steps of a program."""

    def __init__(self, view: LadderView, calls: RoutineCalls) -> None:
        self._points, self._values, self._places = view.main, view.values, view.places
        self._steppers, self._calls = view.steppers, calls
        self._found: dict[tuple[Condition, str], frozenset[float] | None] = {}

    def actions(self, writes: Iterable[Write], commands: Iterable[Command]) -> Iterator[StepAction]:
        """Yield what the program does in its steps.

        Args:
            writes: writes to output words.
            commands: commands of motion blocks.
        """
        if not self._machines:
            return
        for point, machine, step in self._assigned():
            yield from self._in_steps(point, only=machine, goes=step)
        points = {point.step.site: point for point in self._points}
        for write in writes:
            if write.site in points and write.word == 0:
                yield from self._written(points[write.site], write)
        for command in commands:
            for point in self._starting(command):
                yield from self._in_steps(point, axis=command.axis, kind=command.kind, text=command.text)

    def _assigned(self) -> Iterator[tuple[Point, str, float]]:
        """Yield the writes of constants to numbers that get only constants."""
        for point in self._points:
            machine, value = self._machine(point.target), written_value(point.step)
            if machine and isinstance(value, Constant):
                yield point, machine, float(value.value)

    def _written(self, point: Point, write: Write) -> Iterator[StepAction]:
        words = given_by(write.sets, write.clears) if write.known else {"clears": write.clears}
        yield from self._in_steps(replace(point, place=write.place), axis=f"slot {write.slot}", **words)

    def _in_steps(self, point: Point, *, only: str = "", **given: Any) -> Iterator[StepAction]:
        """Yield an action for each machine.

        Args:
            only: the machine, if the action belongs to only one.
            given: fields of `StepAction` for what it does.
        """
        condition = self._implied(self._called(point))
        ends, moves = self._ends(condition, DEPTH), self._needs_motion(condition)
        when = self._acts_when(point)
        for machine, steps in self._machines.items():
            if only in ("", machine):
                possible_steps = self._there(condition, machine, steps)
                yield StepAction(
                    machine, possible_steps, point.place, ends=ends, moves=moves, when=when, **given
                )

    def _there(self, condition: Condition, machine: str, steps: frozenset[float]) -> frozenset[float] | None:
        """Return the steps in which a condition can hold, computed once per condition; None for all."""
        key = condition, machine
        if key not in self._found:
            self._found[key] = steps_in(condition, machine, steps)
        return self._found[key]

    def word_writes(self, writes: Iterable[Write]) -> Iterator[WordWrite]:
        """Yield the writes of the user's routines, each with its condition and steps."""
        points = {point.step.site: point for point in self._points if not point.argument}
        for write in writes:
            point = points.get(write.site)
            if point is not None:
                when, steps = self._acts_when(point), self._where(point)
                yield replace(write, when=when, steps=steps, text=point.text)

    def _acts_when(self, point: Point) -> Condition:
        """Return the condition under which an instruction sets a bit or writes a word, including calls."""
        call_condition = self._called(point)
        return call_condition if point.value == TRUE else AllOf((call_condition, point.value))

    def _where(self, point: Point) -> dict[str, tuple[frozenset[Step] | None, bool]]:
        """Return the steps in which an instruction may act, and whether it acts in every scan of them."""
        steps_by_machine: dict[str, tuple[frozenset[Step] | None, bool]] = {}
        when = self._acts_when(point)
        condition = self._implied(when)
        for machine, steps in self._machines.items():
            possible_steps = self._there(condition, machine, steps)
            steps_by_machine[machine] = (
                None if possible_steps is None else frozenset(possible_steps),
                is_only_of(when, machine),
            )
        return steps_by_machine

    def use(self, machine: str, step: Step) -> StepUse:
        """Return what the program does in a step."""
        tests = list(self._testing(machine, step))
        works = any(not is_only_of(own, machine) or point.value != TRUE for point, own in tests)
        return StepUse(bool(tests), works, chosen=any(not point.is_rung for point, _ in tests))

    def _testing(self, machine: str, step: Step) -> Iterator[tuple[Point, Condition]]:
        """Yield the instructions that act only in one step, each with what it tests and needs."""
        steps = self._machines[machine]
        for point in self._points:
            own = AllOf((point.condition, point.own))
            is_testing = any(compares(leaf, machine) for leaf in leaves(own))
            if is_testing and self._there(own, machine, steps) == frozenset({step}):
                yield point, own

    # --- machines

    @cached_property
    def _machines(self) -> dict[str, frozenset[float]]:
        """The numbers that hold a step, each with all its steps."""
        numbers: dict[str, set[float]] = {}
        for point in self._points:
            goes = self._machine(point.target)
            for leaf in leaves(AllOf((point.own, point.condition)) if goes else point.own):
                if isinstance(leaf, Compare) and leaf.relation in ("=", "<=", ">="):
                    machine = self._machine(self._places.get(base_of(leaf.name)))
                    if machine:
                        numbers.setdefault(machine, set()).add(leaf.number)
        for _, machine, step in self._assigned():
            if machine in numbers:
                numbers[machine].add(step)
        return {machine: frozenset(steps) for machine, steps in numbers.items()}

    def _machine(self, place: Place | None) -> str:
        """Return the key of a number that gets only constants; "" for any other."""
        if place is None or place.can_fault or place.bit is not None or not place.type.is_integer:
            return ""
        if place.leaf.slot is not None or place.leaf.frame:
            return ""
        values_written = self._values.written(place)
        return (
            key_of(place)
            if len(values_written) > 1 and all(write.is_constant for write in values_written)
            else ""
        )

    # --- conditions

    @cached_property
    def _writers(self) -> dict[str, list[Point]]:
        """The instructions that write each bit or run each timer, by key."""
        writers = grouped(self._points, lambda point: _written_key(point.step))
        writers.pop("", None)
        return writers

    def _called(self, point: Point) -> Condition:
        """Return the condition of a point, including that of the only call of its routine."""
        calls = self._calls.of(point.routine.name)
        is_sole = len(calls) == 1 and calls[0].routine is not point.routine
        return AllOf((calls[0].condition, point.condition)) if is_sole else point.condition

    def _implied(self, condition: Condition, depth: int = DEPTH) -> Condition:
        """Return a condition together with those of the timers and coils that it needs."""
        conditions = [condition]
        for bit in needed(condition) if depth else ():
            base = base_of(bit.name)
            timer = base.removesuffix(".DN").removesuffix(".TT")
            writers = self._writers.get(timer, []) if bit.on else []
            if len(writers) == 1 and writers[0].step.name in ("TON", "OTE", ":="):
                conditions.append(self._implied(writers[0].power, depth - 1))
        return AllOf(tuple(conditions)) if len(conditions) > 1 else condition

    def _starts(self, command: Command) -> str:
        """Return the condition of the bit that starts a block; "" if it is not only of bits and steps."""
        coils = self._writers.get(command.execute, [])
        if len(coils) != 1 or coils[0].step.name != "OTE":
            return ""
        condition = coils[0].condition
        parts = condition.parts if isinstance(condition, AllOf) else (condition,)
        is_plain = all(isinstance(part, Bit | Compare) for part in parts)
        return " and ".join(sorted(map(repr, parts))) if is_plain else ""

    def with_start(self, command: Command) -> Command:
        """Return the command of a block with the conditions that start it."""
        on, implies = self._executed(command.execute)
        return replace(command, starts=self._starts(command), on=on, implies=implies)

    def _executed(self, execute: str) -> tuple[Condition, Condition]:
        """Return the condition of a block's Execute, UNKNOWN if it is unknown, and what it implies."""
        if execute in ("", "1"):
            return (TRUE if execute else UNKNOWN), TRUE
        coils = self._writers.get(execute, [])
        own = Bit(execute)
        if len(coils) == 1 and coils[0].step.name in ("OTE", ":="):
            power = coils[0].power
            return plain(power), plain(AllOf((own, self._implied(power))))
        return (own if not coils else UNKNOWN), own

    def first(self, machine: str) -> frozenset[Step]:
        """Return the steps in which a machine may start: set in the first scan, otherwise initial values."""
        place = self._places.get(machine)
        initial_range = None if place is None else self._values.initial(place)
        steps = self._machines.get(machine, frozenset())
        initial = frozenset(
            step
            for step in steps
            if initial_range is not None and initial_range.least <= step <= initial_range.most
        )
        return frozenset(self._begun.get(machine, ())) or initial

    @cached_property
    def _begun(self) -> dict[str, set[float]]:
        """The steps to which machines go in the first scan."""
        steps: dict[str, set[float]] = {}
        for point, machine, step in self._assigned():
            if in_first_scan(needed(point.condition)):
                steps.setdefault(machine, set()).add(step)
        return steps

    def _starting(self, command: Command) -> Iterator[Point]:
        """Yield the points that copy a value to the Execute of a block, placed at its call."""
        execute = f"{command.text.rpartition(' ')[2].upper()}.EXECUTE"
        for point in self._writers.get(execute, ()):
            if point.argument:
                yield replace(point, condition=point.value, place=command.place)

    def _ends(self, condition: Condition, depth: int) -> bool:
        return any(self._says_end(leaf, depth) for leaf in leaves(condition))

    def _says_end(self, part: Condition, depth: int) -> bool:
        """Whether a part of a condition may show that a motion has ended or that time has passed."""
        match part:
            case FixedTruth():
                return False
            case Compare():
                return base_of(part.name) not in self._machines
            case Bit():
                return self._bit_ends(base_of(part.name), depth, on=part.on)
        return True

    def _bit_ends(self, base: str, depth: int, *, on: bool) -> bool:
        """Whether a bit may show that a motion has ended or that time has passed."""
        place = self._places.get(base)
        if place is None or base.startswith(FIRST_SCAN):
            return not base.startswith((EDGE, FIRST_SCAN))
        if place.leaf.slot is not None:
            return self._status_ends(place, on=on)
        if "." in place.leaf.path:
            return on != (base.rpartition(".")[2] in UNDER_WAY)
        for writer in self._writers.get(base, []) if depth else ():
            is_opposite = on == (writer.step.name == "OTU")
            if self._ends(negated(writer.power) if is_opposite else writer.power, depth - 1):
                return True
        return False

    def _status_ends(self, place: Place, *, on: bool) -> bool:
        """Whether a bit in an image shows that a motion has ended."""
        if not self._is_input(place):
            return False
        name = _status(place)
        return name is None or shows_end(name, on=on)

    def _needs_motion(self, condition: Condition) -> bool:
        """Whether a condition requires a moving axis."""
        on = (leaf for leaf in leaves(condition) if isinstance(leaf, Bit) and leaf.on)
        places = (self._places.get(base_of(bit.name)) for bit in on)
        return any(_status(place) in MOVING for place in places if self._is_input(place))

    def _is_input(self, place: Place | None) -> TypeGuard[Place]:
        """Whether an operand is an input of a 3601."""
        return is_input(place) and place.leaf.slot in self._steppers


def _status(place: Place) -> str | None:
    """Return the name of the status bit in word 0 that an operand is; None for other operands."""
    is_bit = place.fixed_index == 0 and isinstance(place.bit, Constant)
    return StatusMsw(1 << int(place.bit.value)).name if is_bit and isinstance(place.bit, Constant) else None


def _written_key(step: LoweredStep) -> str:
    """Return the key of the bit that an instruction writes or of the timer that it runs; "" if none."""
    timer = group_of(step, ("TON", "RTO", "TOF"))
    bit = first_of(step, ("OTE", "OTL", "OTU", ":="))
    if isinstance(bit, Place) and bit.type.is_bool:
        return key_of(bit)
    return "" if timer is None else timer.text.upper()
