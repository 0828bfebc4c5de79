"""The steps of a ladder program. A number contains the step, and rungs compare it to act in certain steps.

EQU(State,20)MOV(2,axis.O.Data[0]);                       a command in step 20
EQU(State,20)XIC(axis.status.MOVING_CW)MOV(30,State);     from 20 to 30
EQU(State,30)TON(Pause,400,0);  XIC(Pause.DN)MOV(40,State);     from 30 to 40: the timer runs in step 30
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
from ..module_kinds import MOVING, action_fields, shows_end
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
"""Maximum number of coils and timers to follow in a chain of conditions."""


class Steps:
    """The steps of a program."""

    def __init__(self, view: LadderView, calls: RoutineCalls) -> None:
        self._points, self._values, self._places = view.main, view.values, view.places
        self._steppers, self._calls = view.steppers, calls
        self._steps_of: dict[tuple[Condition, str], frozenset[float] | None] = {}  # see `_possible_steps`

    def actions(self, writes: Iterable[Write], commands: Iterable[Command]) -> Iterator[StepAction]:
        """Yield the actions of the program in its steps.

        Args:
            writes: writes to output words.
            commands: commands of motion blocks.
        """
        if not self._machines:
            return
        for point, machine, step in self._assigned():
            yield from self._actions_at(point, only=machine, goes=step)
        points = {point.step.site: point for point in self._points}
        for write in writes:
            if write.site in points and write.word == 0:
                words = action_fields(write.sets, write.clears) if write.known else {"clears": write.clears}
                point = replace(points[write.site], place=write.place)
                yield from self._actions_at(point, axis=f"slot {write.slot}", **words)
        for command in commands:
            for point in self._starting(command):
                yield from self._actions_at(point, axis=command.axis, kind=command.kind, text=command.text)

    def _assigned(self) -> Iterator[tuple[Point, str, float]]:
        """Yield the writes of constants to numbers that are assigned only constants."""
        for point in self._points:
            machine, value = self._machine(point.target), written_value(point.step)
            if machine and isinstance(value, Constant):
                yield point, machine, float(value.value)

    def _actions_at(self, point: Point, *, only: str = "", **fields: Any) -> Iterator[StepAction]:
        """Yield an action for each machine.

        Args:
            only: the machine, if the action belongs to a single machine.
            fields: the other fields of `StepAction`.
        """
        condition = self._implied(self._called(point))
        ends, moves = self._ends(condition, DEPTH), self._needs_motion(condition)
        when = self._acts_when(point)
        for machine in self._machines:
            if only in ("", machine):
                steps = self._possible_steps(condition, machine)
                yield StepAction(machine, steps, point.place, ends=ends, moves=moves, when=when, **fields)

    def _possible_steps(self, condition: Condition, machine: str) -> frozenset[float] | None:
        """Return the steps in which a condition can be true; None for all. Results are cached."""
        key = condition, machine
        if key not in self._steps_of:
            self._steps_of[key] = steps_in(condition, machine, self._machines[machine])
        return self._steps_of[key]

    def word_writes(self, writes: Iterable[Write]) -> Iterator[WordWrite]:
        """Yield the writes of the user's routines, each with its condition and steps."""
        points = {point.step.site: point for point in self._points if not point.argument}
        for write in writes:
            point = points.get(write.site)
            if point is not None:
                when, steps = self._acts_when(point), self._in_steps(point)
                yield replace(write, when=when, steps=steps, text=point.text)

    def _acts_when(self, point: Point) -> Condition:
        """Return the condition for an instruction to set a bit or write a word, including calls."""
        condition = self._called(point)
        return condition if point.value == TRUE else AllOf((condition, point.value))

    def _in_steps(self, point: Point) -> dict[str, tuple[frozenset[Step] | None, bool]]:
        """Return, by machine, the steps in which an instruction may act, and whether it acts in each scan.

        The steps are None if it may act in all of them.
        """
        steps_by_machine: dict[str, tuple[frozenset[Step] | None, bool]] = {}
        when = self._acts_when(point)
        condition = self._implied(when)
        for machine in self._machines:
            steps = self._possible_steps(condition, machine)
            in_steps = None if steps is None else frozenset[Step](steps)
            steps_by_machine[machine] = in_steps, is_only_of(when, machine)
        return steps_by_machine

    def use(self, machine: str, step: Step) -> StepUse:
        """Return how the program uses a step."""
        tests = list(self._testing(machine, step))
        works = any(not is_only_of(condition, machine) or point.value != TRUE for point, condition in tests)
        return StepUse(bool(tests), works, chosen=any(not point.is_rung for point, _ in tests))

    def _testing(self, machine: str, step: Step) -> Iterator[tuple[Point, Condition]]:
        """Yield the instructions that act only in one step, each with its condition."""
        for point in self._points:
            condition = AllOf((point.condition, point.own))
            is_testing = any(compares(leaf, machine) for leaf in leaves(condition))
            if is_testing and self._possible_steps(condition, machine) == frozenset({step}):
                yield point, condition

    # --- machines

    @cached_property
    def _machines(self) -> dict[str, frozenset[float]]:
        """The numbers that contain a step, each with all its steps."""
        numbers: dict[str, set[float]] = {}
        for point in self._points:
            is_change = self._machine(point.target)
            for leaf in leaves(AllOf((point.own, point.condition)) if is_change else point.own):
                if isinstance(leaf, Compare) and leaf.relation in ("=", "<=", ">="):
                    machine = self._machine(self._places.get(base_of(leaf.name)))
                    if machine:
                        numbers.setdefault(machine, set()).add(leaf.number)
        for _, machine, step in self._assigned():
            if machine in numbers:
                numbers[machine].add(step)
        return {machine: frozenset(steps) for machine, steps in numbers.items()}

    def _machine(self, place: Place | None) -> str:
        """Return the key of a number assigned only constants, at least two; "" for any other operand."""
        if place is None or place.can_fault or place.bit is not None or not place.type.is_integer:
            return ""
        if place.leaf.slot is not None or place.leaf.frame:
            return ""
        written = self._values.written(place)
        return key_of(place) if len(written) > 1 and all(value.is_constant for value in written) else ""

    # --- conditions

    @cached_property
    def _writers(self) -> dict[str, list[Point]]:
        """The instructions that write each bit or run each timer, by key."""
        writers = grouped(self._points, lambda point: _written_key(point.step))
        writers.pop("", None)
        return writers

    def _called(self, point: Point) -> Condition:
        """Return the condition of a point, together with the condition of the only call of its routine."""
        calls = self._calls.calls_to(point.routine.name)
        is_only_call = len(calls) == 1 and calls[0].routine is not point.routine
        return AllOf((calls[0].condition, point.condition)) if is_only_call else point.condition

    def _implied(self, condition: Condition, depth: int = DEPTH) -> Condition:
        """Return a condition combined with the conditions of the timers and coils that it needs."""
        conditions = [condition]
        for bit in needed(condition) if depth else ():
            base = base_of(bit.name)
            timer = base.removesuffix(".DN").removesuffix(".TT")
            writers = self._writers.get(timer, []) if bit.on else []
            if len(writers) == 1 and writers[0].step.name in ("TON", "OTE", ":="):
                conditions.append(self._implied(writers[0].power, depth - 1))
        return AllOf(tuple(conditions)) if len(conditions) > 1 else condition

    def _starts(self, command: Command) -> str:
        """Return the condition of the bit that starts a block as text.

        Return "" if it contains anything other than bits and comparisons.
        """
        coils = self._writers.get(command.execute, [])
        if len(coils) != 1 or coils[0].step.name != "OTE":
            return ""
        condition = coils[0].condition
        parts = condition.parts if isinstance(condition, AllOf) else (condition,)
        is_plain = all(isinstance(part, Bit | Compare) for part in parts)
        return " and ".join(sorted(map(repr, parts))) if is_plain else ""

    def with_start(self, command: Command) -> Command:
        """Return the command of a block with the conditions that start it."""
        on, implies = self._execute_conditions(command.execute)
        return replace(command, starts=self._starts(command), on=on, implies=implies)

    def _execute_conditions(self, execute: str) -> tuple[Condition, Condition]:
        """Return the condition of a block's Execute, or UNKNOWN, and the condition that it implies."""
        if execute in ("", "1"):
            return (TRUE if execute else UNKNOWN), TRUE
        coils = self._writers.get(execute, [])
        execute_bit = Bit(execute)
        if len(coils) == 1 and coils[0].step.name in ("OTE", ":="):
            power = coils[0].power
            return plain(power), plain(AllOf((execute_bit, self._implied(power))))
        return (execute_bit if not coils else UNKNOWN), execute_bit

    def first(self, machine: str) -> frozenset[Step]:
        """Return a machine's possible start steps: steps set in the first scan, or else initial values."""
        if machine in self._first_scan_steps:
            return frozenset(self._first_scan_steps[machine])
        place = self._places.get(machine)
        initial = None if place is None else self._values.initial(place)
        if initial is None:
            return frozenset()
        steps = self._machines.get(machine, ())
        return frozenset(step for step in steps if initial.least <= step <= initial.most)

    @cached_property
    def _first_scan_steps(self) -> dict[str, set[float]]:
        """The steps that machines go to in the first scan."""
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
        """Whether a condition may show that a motion has ended or that time has passed."""
        return any(self._leaf_ends(leaf, depth) for leaf in leaves(condition))

    def _leaf_ends(self, part: Condition, depth: int) -> bool:
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
        bits_on = (leaf for leaf in leaves(condition) if isinstance(leaf, Bit) and leaf.on)
        places = (self._places.get(base_of(bit.name)) for bit in bits_on)
        return any(_status(place) in MOVING for place in places if self._is_input(place))

    def _is_input(self, place: Place | None) -> TypeGuard[Place]:
        """Whether an operand is an input of a 3601."""
        return is_input(place) and place.leaf.slot in self._steppers


def _status(place: Place) -> str | None:
    """Return the name of a status bit in word 0; None for other operands."""
    if place.fixed_index != 0 or not isinstance(place.bit, Constant):
        return None
    return StatusMsw(1 << int(place.bit.value)).name


def _written_key(step: LoweredStep) -> str:
    """Return the key of the bit that an instruction writes or of the timer that it runs; "" if none."""
    timer = group_of(step, ("TON", "RTO", "TOF"))
    bit = first_of(step, ("OTE", "OTL", "OTU", ":="))
    if isinstance(bit, Place) and bit.type.is_bool:
        return key_of(bit)
    return "" if timer is None else timer.text.upper()
