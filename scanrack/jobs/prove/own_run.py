"""Runs the rack as its file describes it, without a scenario. The reached states need no proof.

Random scans rarely home an axis; the rack does so within thousands of scans.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace

import numpy as np
from scanrack.ladder import LadderLogic
from scanrack.ladder.prove.algebra.batch import Array, BatchEvaluator, dtype_of
from scanrack.ladder.prove.algebra.terms import T, variables_by_root
from scanrack.ladder.prove.system import CLOCK, DT, FIRST_SCAN, name_of
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.memory import Value
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.listeners import QuietListener

from ..run.running import JobRun, RunOptions
from .subject import ProofSubject

SCANS = 10_000
"""Maximum number of scans. The run ends earlier once every condition has been true in some scan."""

BLOCK = 500
"""Number of scans for which conditions are evaluated at once."""

FIRST_SCAN_NAME = name_of(FIRST_SCAN)


def seen_in_own_run(subject: ProofSubject, truths: Sequence[T]) -> set[T]:
    """Run a rack as its file describes it; return the conditions (`truths`) that are true in some scan.

    The result is empty without a rack.
    """
    job = subject.job
    if not job.spec.slot or not truths or not isinstance(job.logic, LadderLogic):
        return set()
    logic = job.logic.copied()
    notes = _ValueNotes(subject, logic.engine, truths)
    with ExitStack() as ports, suppress(CpuFault, ValueError):  # a fault ends the run
        run = JobRun(replace(job, logic=logic), ports, RunOptions(warn=lambda _text: None))
        notes.stop = run.cpu.stop
        run.cpu.add_listener(notes)
        run.run(SCANS)
    notes.compute()
    return notes.seen


@dataclass(frozen=True, slots=True)
class _Variable:
    """A variable of the prover, and a function that reads its value from the program's memory."""

    v: T
    read: Callable[[], Value]
    is_state: bool

    def column(self, values: Sequence[Value], times: Array, tick_ns: int) -> Array:
        """Return the variable's value in each scan of a block except the first.

        An input has the value noted after the scan itself. A state has the value that the previous scan left.

        Args:
            values: the values noted after each scan.
            times: the times of the scans, ns.
        """
        column = np.array(values[:-1] if self.is_state else values[1:], dtype=dtype_of(self.v))
        if self.v.val.endswith(f"{CLOCK}[0]"):
            column = np.clip((times[:-1] - column) // tick_ns, 0, self.v.hi)
        return column


class _ValueNotes(QuietListener):
    """Notes the values that conditions depend on, and evaluates the conditions for many scans at once.

    Attributes:
        unseen: the conditions on memory that have not been true in any scan so far.
        seen: the conditions that were true in some scan.
        stop: called when no condition is unseen.
    """

    def __init__(self, subject: ProofSubject, engine: Engine, truths: Sequence[T]) -> None:
        """Find the conditions that depend only on memory, and begin to note the values of their variables."""
        self._engine, self._problem = engine, subject.problem
        self._variables = variables_by_root(truths)
        in_memory = self._in_memory(term for terms in self._variables.values() for term in terms)
        readable = {variable.v for variable in in_memory}
        self.unseen = [
            truth
            for truth in truths
            if all(term in readable or _is_known(term) for term in self._variables[truth])
        ]
        self.seen: set[T] = set()
        self.stop: Callable[[], object] = lambda: None
        self._watch(in_memory)
        self._times: list[int] = []

    def _in_memory(self, terms: Iterable[T]) -> list[_Variable]:
        """Return the variables that are in memory, without duplicates or variables that are not modeled."""
        problem, variables = self._problem, []
        layout, memory = self._engine.lowered.layout, self._engine.memory
        for term in dict.fromkeys(terms):
            key = problem.key_of.get(term.val, FIRST_SCAN)
            leaf = None if key == FIRST_SCAN or term.val in problem.unmodeled else layout.find(key[0])
            if leaf is not None:
                is_state = problem.role(term.val) == "state"
                variables.append(_Variable(term, memory.reader(leaf, key[1]), is_state))
        return variables

    def _watch(self, variables: Iterable[_Variable]) -> None:
        """Start to note the values that the unseen conditions depend on."""
        deciding = {term for truth in self.unseen for term in self._variables[truth]}
        self._watched = [variable for variable in variables if variable.v in deciding]
        self._readers = [variable.read for variable in self._watched]
        self._rows: list[list[Value]] = []  # values after each scan

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Note the values after a scan."""
        self._rows.append([read() for read in self._readers])
        self._times.append(now_ns)
        if len(self._rows) > BLOCK:
            self.compute()
            if not self.unseen:
                self.stop()

    def compute(self) -> None:
        """Evaluate the unseen conditions for the noted scans; the last of these scans begins a new block."""
        count = len(self._rows) - 1
        if count < 1 or not self.unseen:
            return
        truths = BatchEvaluator(self.unseen, count)(self._values(count))
        self.seen |= {truth for truth, values in zip(self.unseen, truths, strict=True) if values.any()}
        self.unseen = [truth for truth in self.unseen if truth not in self.seen]
        last_values = dict(zip(self._watched, self._rows[-1], strict=True))
        self._watch(self._watched)
        self._rows, self._times = [[last_values[variable] for variable in self._watched]], self._times[-1:]

    def _values(self, count: int) -> dict[str, Array]:
        """Return the values of the variables in each scan of the block except the first, by name."""
        times, tick_ns = np.array(self._times, dtype=np.int64), self._problem.tick_ns
        columns = {DT: np.diff(times) // tick_ns, FIRST_SCAN_NAME: np.zeros(count, np.bool_)}
        for variable, values in zip(self._watched, zip(*self._rows, strict=True), strict=True):
            columns[variable.v.val] = variable.column(values, times, tick_ns)
        return columns


def _is_known(v: T) -> bool:
    """Return whether the value of a variable is known without the program's memory."""
    return v.val in (DT, FIRST_SCAN_NAME)
