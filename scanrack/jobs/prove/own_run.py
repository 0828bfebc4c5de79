"""Runs the rack on its own, as its file describes it. What it reaches is possible without asking a solver.

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
"""Maximum number of scans; the run ends as soon as every truth has been seen."""

BLOCK = 500
"""Number of scans for which truths are computed at once."""

FIRST_SCAN_NAME = name_of(FIRST_SCAN)


def seen_in_own_run(subject: ProofSubject, truths: Sequence[T]) -> set[T]:
    """Run a rack on its own, and return the truths that hold in some scan; none without a rack."""
    job = subject.job
    if not job.spec.slot or not truths or not isinstance(job.logic, LadderLogic):
        return set()
    logic = job.logic.copied()
    notes = _ValueNotes(subject, logic.engine, truths)
    with ExitStack() as ports, suppress(CpuFault, ValueError):  # after a fault there are no more scans
        run = JobRun(replace(job, logic=logic), ports, RunOptions(warn=lambda _text: None))
        notes.stop = run.cpu.stop
        run.cpu.add_listener(notes)
        run.run(SCANS)
    notes.compute()
    return notes.found


@dataclass(frozen=True, slots=True)
class _Variable:
    """Where the value of a variable is in the program's memory."""

    v: T
    read: Callable[[], Value]
    is_state: bool

    def column(self, values: Sequence[Value], times: Array, tick_ns: int) -> Array:
        """Return the values before each scan of a block except the first, from the values after each scan.

        A state keeps the value that the previous scan left; an input has its value in the scan itself.
        """
        column = np.array(values[:-1] if self.is_state else values[1:], dtype=dtype_of(self.v))
        if self.v.val.endswith(f"{CLOCK}[0]"):
            column = np.clip((times[:-1] - column) // tick_ns, 0, self.v.hi)
        return column


class _ValueNotes(QuietListener):
    """Notes the values that decide truths, and computes the truths of many scans at once."""

    def __init__(self, subject: ProofSubject, engine: Engine, truths: Sequence[T]) -> None:
        self._engine, self._problem = engine, subject.problem
        self._variables = variables_by_root(truths)
        places = self._places_of(variable for variables in self._variables.values() for variable in variables)
        known = {place.v for place in places}
        self.left = [
            truth
            for truth in truths
            if all(variable in known or _is_known(variable) for variable in self._variables[truth])
        ]
        self.found: set[T] = set()
        self.stop: Callable[[], object] = lambda: None
        self._watch(places)
        self._times: list[int] = []

    def _places_of(self, variables: Iterable[T]) -> list[_Variable]:
        """Return the places of variables in memory; leave out variables that are not modeled."""
        problem, places = self._problem, []
        layout, memory = self._engine.lowered.layout, self._engine.memory
        for variable in dict.fromkeys(variables):
            key = problem.key_of.get(variable.val, FIRST_SCAN)
            leaf = None if key == FIRST_SCAN or variable.val in problem.unmodeled else layout.find(key[0])
            if leaf is not None:
                places.append(
                    _Variable(variable, memory.reader(leaf, key[1]), problem.role(variable.val) == "state")
                )
        return places

    def _watch(self, places: Iterable[_Variable]) -> None:
        """From now on, note the values that decide the remaining truths."""
        deciding = {variable for truth in self.left for variable in self._variables[truth]}
        self._places = [place for place in places if place.v in deciding]
        self._readers = [place.read for place in self._places]
        self._rows: list[list[Value]] = []

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Note the values after a scan."""
        self._rows.append([read() for read in self._readers])
        self._times.append(now_ns)
        if len(self._rows) > BLOCK:
            self.compute()
            if not self.left:
                self.stop()

    def compute(self) -> None:
        """Compute the remaining truths for the noted scans; the last of these scans begins a new block."""
        count = len(self._rows) - 1
        if count < 1 or not self.left:
            return
        truths = BatchEvaluator(self.left, count)(self._values(count))
        self.found |= {truth for truth, values in zip(self.left, truths, strict=True) if values.any()}
        self.left = [truth for truth in self.left if truth not in self.found]
        last = dict(zip(self._places, self._rows[-1], strict=True))
        self._watch(self._places)
        self._rows, self._times = [[last[place] for place in self._places]], self._times[-1:]

    def _values(self, count: int) -> dict[str, Array]:
        """Return the values of variables before each scan of the block."""
        times, tick_ns = np.array(self._times, dtype=np.int64), self._problem.tick_ns
        columns = zip(self._places, zip(*self._rows, strict=True), strict=True)
        columns_by_name = {place.v.val: place.column(values, times, tick_ns) for place, values in columns}
        return {DT: np.diff(times) // tick_ns, FIRST_SCAN_NAME: np.zeros(count, np.bool_), **columns_by_name}


def _is_known(v: T) -> bool:
    """Whether the value of a variable is known without the program's memory."""
    return v.val in (DT, FIRST_SCAN_NAME)
