"""Runs prescan on terms between two scans, after program mode or at a start with retained tags.

`state` still has the values after the scan. `before_next` returns the values at the beginning of the next
scan, after a prescan if there is one. As in the interpreter, prescan skips instructions with a subscript out
of range.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from ...model.operands import Place
from ...model.tags import Leaf
from ...state.lowered import AddOnCall, Call, LoweredStep, Node
from ..algebra.terms import FALSE, TRUE, T, const, ite
from .machine import ScanMachine
from .paths import Path
from .places import Key
from .stored import Lost
from .symbols import UnmodeledError

Begun = Callable[[Key, T], T]
"""Returns the value of a place when prescan begins, given the place and its value after the scan."""


def as_left(_key: Key, t: T) -> T:
    """Return the value that the scan left."""
    return t


class TurningMachine(ScanMachine):
    """A machine that may prescan after its scan, like a controller whose key is turned.

    Attributes:
        prescanned_places: the places that prescan may write.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.prescanned_places: dict[Key, bool] = {}
        self._turns = False
        self._begins: Begun = as_left
        self._reads: Begun = as_left
        self._skips = 0  # number of instructions that some path has skipped
        self._turned: dict[Key, T] = {}  # values in and after prescan; `_kept` during prescan
        self._turned_lost: dict[str, list[Lost]] = {}
        self._scanned: tuple[dict[Key, T], dict[Key, bool], dict[str, list[Lost]]] = {}, {}, {}

    def turn_key(self, condition: T, begins: Begun = as_left, reads: Begun = as_left) -> None:
        """Prescan after the scan where a condition is true.

        Args:
            begins: returns the value of a place before prescan; the place keeps it if prescan does not write
                it.
            reads: returns the value that prescan reads from a place, which may have been written from
                outside.
        """
        self._scanned, faults = (self._kept, self.written, self._lost), self.faults
        self._begins, self._reads, self._turns = begins, reads, True
        self._kept, self.written, self._lost = self._turned, self.prescanned_places, self._turned_lost
        self.faults = []
        minor, self.fault_log.minor = self.fault_log.minor, {}  # type: ignore[assignment]
        may_fault = dict(self.may_fault)
        self.active = condition
        try:
            self.prescan()
            self.active = condition
            self._begin_tasks()
        finally:
            (self._kept, self.written, self._lost), self.faults = self._scanned, faults
            self.fault_log.minor = minor
            self.may_fault = may_fault
            self.active, self._turns = TRUE, False

    def before_next(self, key: Key) -> T:
        """Return the value of a place at the beginning of the next scan."""
        if key not in self._turned:
            begun = self._begins(key, self.state[key])
            self._turned[key] = self._with_lost(key, begun, self._turned_lost)
        return self._turned[key]

    def _with_lost(self, key: Key, t: T, lost: dict[str, list[Lost]]) -> T:
        """Return a value; it is unknown under the conditions that made its whole leaf unknown."""
        for condition, site in lost.get(key[0], ()):
            t = ite(condition, self.unknown_of(self.leaves[key], key[1], site=site), t)
        return t

    def _begin_tasks(self) -> None:
        """Restart the tasks as the scheduler does."""
        schedule = self.lowered.schedule
        if schedule is None:
            return
        for program in schedule.programs:
            self.poke(program.started, 0, FALSE)
            for leaf in (program.fault_type, program.fault_code):
                self.poke(leaf, 0, const(0))
        for task in schedule.tasks:
            self.poke(task.pending, 0, FALSE)
            self.poke(task.overlaps, 0, const(0))

    # --- differences in prescan

    def _read_first(self, key: Key, leaf: Leaf) -> None:
        """Create the value of a place. In prescan, it is the value after the scan, with outside changes."""
        if not self._turns:
            super()._read_first(key, leaf)
            return
        turning = self._kept, self.written, self._lost
        self._kept, self.written, self._lost = self._scanned
        if key not in self._kept:
            super()._read_first(key, leaf)
        self._kept, self.written, self._lost = turning
        value = self.state[key]
        if key in self.leaves:
            value = self._with_lost(key, self._reads(key, self._begins(key, value)), self._lost)
        self.log.put(self._kept, key, value)

    def merge_paths(self, run: Callable[[], Any]) -> list[Path]:
        """Run a function on every path; in prescan, a bad subscript ends a path without a fault."""
        if not self._turns:
            return super().merge_paths(run)
        paths = self.paths.walk(run)
        if any(path.faulted for path in paths):
            self._skips += 1
        for merged in paths:
            merged.faulted = False
        self.write_paths(paths)
        return paths

    def stop(self, bad: T) -> None:
        """Stop the processor where a condition is true, but not in prescan."""
        if not self._turns:
            super().stop(bad)

    def _copies(self, copies: tuple[tuple[Node, ...], ...]) -> None:
        """Run series of copies; in prescan, refuse a parameter if a bad subscript skips its copy."""
        skips = self._skips
        super()._copies(copies)
        if self._turns and self._skips != skips and any(len(series) > 1 for series in copies):
            raise UnmodeledError("a parameter with a computed subscript, in prescan")

    def start_clock(self, since: Place) -> None:
        """Start a clock in a hidden place; do nothing in prescan."""
        self._refuse_clock()
        super().start_clock(since)

    def elapsed(self, since: Place, unit_ns: int) -> Any:
        """Return the whole units of time since the clock started; prescan reads no time."""
        self._refuse_clock()
        return super().elapsed(since, unit_ns)

    def _refuse_clock(self) -> None:
        """Refuse a clock in prescan."""
        if self._turns:
            raise UnmodeledError("a timer that runs in prescan")

    def _prescan_step(self, step: LoweredStep) -> None:
        """Run the prescan action of an instruction, if it has one; for an add-on call, prescan the add-on."""
        prescan = step.spec.prescan
        if prescan is None:
            return
        self.site = step.site
        call = next((operand for operand in step.operands if isinstance(operand, (Call, AddOnCall))), None)
        row: Callable[[], Any] = partial(prescan, self, *step.operands)
        if isinstance(call, AddOnCall):
            row = partial(self._prescan_add_on, call)
        elif call is None:
            row = partial(self.merge_paths, row)
        self._attempt(step, TRUE, row)

    def _prescan_add_on(self, call: AddOnCall) -> None:
        """Copy the inputs, prescan the logic, run the Prescan routine, and copy the outputs."""
        site = self.site
        self._copies(call.inputs)
        skips = self._skips
        self._put_power(call, FALSE)
        with self._within(call):
            if self._skips != skips:
                raise UnmodeledError("an instance with a computed subscript, in prescan")
            self.prescan(call.logic)
            if call.prescan is not None:
                self.call_routine(call.prescan, ())
        self.site = site
        self._copies(call.outputs)
