"""Jumps, calls, calls in loops and add-on instructions in a scan on terms."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from ...model.operands import Group, Place, Resolved
from ...model.tags import OWN
from ...state.lowered import BROKEN, AddOnCall, Call, LoweredRoutine, Node
from ..algebra.meaning import INT
from ..algebra.numbers import lt
from ..algebra.terms import FALSE, TRUE, T, and_, const, ite, not_, or_
from .steps import Answer, TermSteps
from .symbols import UnmodeledError, term_of

MOST_PASSES = 64
"""Maximum number of passes of a loop whose number of passes is unknown."""

MOST_PASSES_OF_A_SCAN = 192
"""Maximum total number of passes of such loops in a scan."""

MOST_KNOWN_PASSES = 2048
"""Maximum number of passes of any loop."""

MOST_CALLS = 12
"""Maximum nesting depth of calls."""

_OF_ROUTINE = ("active", "site", "inputs", "_pending", "_labels", "_number", "_answers", "_depth")
"""Attributes that a call saves and restores."""


class TermCalls(TermSteps):
    """Runs routines."""

    def call_routine(self, name: str, inputs: Sequence[Any]) -> list[Answer]:
        """Run a routine; return its results, each with the condition under which it returns them."""
        routine = self.lowered.routines.get(name)
        if routine is None:
            raise UnmodeledError("a routine in Python")
        if self._depth >= MOST_CALLS:
            raise UnmodeledError(f"calls more than {MOST_CALLS} deep")
        saved = {attribute: getattr(self, attribute) for attribute in _OF_ROUTINE}
        self._pending, self._labels, self._answers = {}, routine.labels, []
        self._depth += 1
        try:
            self._lines(routine, inputs)
            return self._answers
        finally:
            for saved_name, value in saved.items():
                setattr(self, saved_name, value)
            self.active = self._going_on(self.active)

    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Any]) -> None:
        """Run the statements or rungs of a routine. At a label, add the paths that have jumped to it."""
        if routine.body is not None:
            self._body(routine.body, inputs)
            return
        labels: dict[int, list[str]] = {}
        for label, number in routine.labels.items():
            labels.setdefault(number, []).append(label)
        for number, line in enumerate(routine.lines):
            for label in labels.get(number, ()):  # jumps only go forward
                self.active = or_(self.active, self._pending.get(label, FALSE))
            self._number = number
            self._line(line, inputs)

    def jump_to(self, power: T, label: str) -> T:
        """Jump forward to a label where power is true."""
        if self._labels[label] <= self._number:
            raise UnmodeledError("a jump backwards")
        before = self._pending.get(label, FALSE)
        self.log.put(self._pending, label, or_(before, and_(self.active, power)))
        return self._leave(power)

    def return_from(self, power: T, values: tuple[Any, ...]) -> T:
        """Return from the routine with results where power is true."""
        self.log.add(self._answers, (and_(self.active, power), values))
        return self._leave(power)

    def end_scan(self, power: T) -> T:
        """End the scan where power is true."""
        self._ended = or_(self._ended, and_(self.active, power))
        return self._leave(power)

    def exit_loop(self, power: T) -> T:
        """Leave the innermost loop where power is true."""
        self._exits = or_(self._exits, and_(self.active, power))
        return self._leave(power)

    def _leave(self, power: T) -> T:
        """Continue only where power is false; return FALSE, the power after the instruction."""
        self.active = and_(self.active, not_(power))
        return FALSE

    def take_values(self, places: Sequence[Place | Group], values: Sequence[Any]) -> None:
        """Set tags to arguments or results; extra tags or values are ignored."""
        for place, value in zip(places, values, strict=False):
            self.on_paths(partial(self.take, [place], [value]))

    def enter_with(self, power: T, places: Sequence[Place | Group]) -> T:
        """Set the routine's parameters to its arguments where power is true."""
        with self.when(power):
            self.take_values(places, self.inputs)
        return power

    def values_of(self, operands: Sequence[Resolved]) -> tuple[Any, ...]:
        """Return the values that are passed to or from a routine."""
        return tuple(map(self.value, operands))

    def call_with(self, power: T, call: Call) -> T:
        """Call a routine where power is true, and store its results."""
        with self.when(power):
            if self.active is not FALSE:
                results = self.call_routine(call.routine, self.values_of(call.inputs))
                for condition, values in results:
                    with self.when(condition):
                        self.take_values(call.returns, values)
        return power

    def loop_call(self, power: T, call: Call, index: Place, *bounds: Resolved) -> T:
        """Call a routine repeatedly while an index runs from one bound to the other."""
        initial, terminal, step = bounds
        with self.when(power):
            self._set_index(index, lambda: self.integer(initial))
            undecided = 0  # tests that end the loop on some paths
            for _ in range(MOST_KNOWN_PASSES):
                entry = self.active
                self.active = and_(entry, not_(self._is_over(index, terminal, step)))
                if self.active is not entry:
                    undecided += 1
                if self.active is FALSE or self._count_pass(undecided):
                    break
                for condition, values in self.call_routine(call.routine, ()):
                    if values is BROKEN:
                        self.active = and_(self.active, not_(condition))
                self._set_index(index, lambda: self.integer(index) + self.integer(step))
            self._cut_pass(self.site)
        return power

    def _count_pass(self, undecided: int) -> bool:
        """Count a pass if the end of its loop is unknown; return whether the limit is exceeded.

        Args:
            undecided: number of tests so far that end the loop only on some paths.
        """
        if undecided:
            self._passes += 1
        return undecided > MOST_PASSES or self._passes > MOST_PASSES_OF_A_SCAN

    def _is_over(self, index: Place, terminal: Resolved, step: Resolved) -> T:
        """Return the condition under which an index is past its last value, in the direction of the step."""
        count, last, increment = (term_of(self.integer(operand), INT) for operand in (index, terminal, step))
        return ite(lt(increment, const(0)), lt(count, last), lt(last, count))

    def _set_index(self, index: Place, value: Callable[[], Any]) -> None:
        self.on_paths(lambda: self.put(index, self.converted(index.type, value())))

    def call_add_on(self, power: T, call: AddOnCall) -> T:
        """Copy the inputs, run the routine for the rung's state (if it exists), and copy the outputs."""
        site, after = self.site, FALSE
        self._copies(call.inputs)
        self._put_power(call, power)
        for routine, condition in ((call.logic, power), (call.otherwise, not_(power))):
            if routine is None or condition is FALSE:
                continue
            with self.when(condition):
                self._run_add_on(call, routine)
                self.site = site
                self._copies(call.outputs)
                done = self.on_paths(lambda: self.get(call.enable_out))
            after = or_(after, and_(condition, done))
        return after

    def call_add_on_off(self, power: T, call: AddOnCall) -> T:
        """Run a call as if the rung were false, where power is true."""
        with self.when(power):
            return and_(power, self.call_add_on(FALSE, call))

    def _put_power(self, call: AddOnCall, power: T) -> None:
        """Set EnableIn and EnableOut of an add-on instruction to the power."""

        def put() -> None:
            self.put(call.enable_in, self.symbol(power))
            self.put(call.enable_out, self.symbol(power))

        self.on_paths(put)

    def _run_add_on(self, call: AddOnCall, routine: str) -> None:
        """Run a routine with the instance and arguments of a call."""
        with self._within(call):
            self.call_routine(routine, ())

    @contextmanager
    def _within(self, call: AddOnCall) -> Iterator[None]:
        """Run the body of the `with` with the instance and arguments of a call."""
        frames: list[dict[str, Any]] = []

        def add_frame() -> None:
            frame = {name: self.handed(operand) for name, operand in call.handed.items()}
            frames.append({**frame, OWN: self.handed(call.instance)})

        self.on_paths(add_frame)
        if len(frames) != 1:
            raise UnmodeledError("arguments that depend on the path")
        outer, self.frame = self.frame, frames[0]
        yield
        self.frame = outer

    def _copies(self, copies: tuple[tuple[Node, ...], ...]) -> None:
        """Run series of copies between arguments and parameters; keep the current instruction."""
        site, inputs = self.site, self.inputs
        for series in copies:
            self._series(series, TRUE)
        self.site, self.inputs = site, inputs

    def _cut_pass(self, site: int) -> None:
        """If a loop continues after its last modeled pass, note that the relation does not follow it."""
        if self.active is not FALSE:
            self.log.add(self.cut, (self.lowered.sites[site], "loop", f"more than {MOST_PASSES} passes"))
            self.deep = or_(self.deep, self.active)
