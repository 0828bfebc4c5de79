"""The rack's own run, as its file has it: what it does is possible, and no solver has to find a run to it.

Random scans rarely home an axis. The rack does, in thousands of scans.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace

import numpy as np
from scanrack.ladder import LadderLogic
from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.prove.algebra.batch import Array, BatchEvaluator, dtype_of
from scanrack.ladder.prove.algebra.terms import T
from scanrack.ladder.prove.system import CLOCK, DT, FIRST_SCAN
from scanrack.ladder.run.engine import Engine
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.listeners import QuietListener

from ..run.running import JobRun, RunOptions
from .subject import ProofSubject

SCANS = 10_000
"""Scans of the run, at most: it ends as soon as all has been seen."""

AT_ONCE = 500
"""Scans that are computed at once."""


class OwnRun:
    """Runs a rack on its own, and tells which truths of a problem some scan makes true.

    Args:
        subject: with a rack; a program alone has no own run.
    """

    def __init__(self, subject: ProofSubject) -> None:
        self._subject = subject

    def seen(self, truths: Sequence[T]) -> set[T]:
        """Return those that some scan makes true; none without a rack."""
        job = self._subject.job
        if not job.spec.slot or not truths or not isinstance(job.logic, LadderLogic):
            return set()
        logic = job.logic.copied()
        noted = _ValueNotes(self._subject, logic.engine, truths)
        with ExitStack() as ports, suppress(CpuFault, ValueError):  # it then has no more scans
            run = JobRun(replace(job, logic=logic), ports, RunOptions(warn=lambda _text: None))
            noted.stop = run.cpu.stop
            run.cpu.add_listener(noted)
            run.run(SCANS)
        noted.compute()
        return noted.found


class _ValueNotes(QuietListener):
    """Notes the values that decide truths, and computes them for many scans at once."""

    def __init__(self, subject: ProofSubject, engine: Engine, truths: Sequence[T]) -> None:
        problem = subject.problem
        self._engine, self._tick_ns = engine, problem.tick_ns
        unknown = problem.havocs.keys()
        known = {t: BatchEvaluator([t], AT_ONCE).variables for t in truths}
        self.left = [t for t, needs in known.items() if not any(v.val in unknown for v in needs)]
        self.found: set[T] = set()
        self.stop: Callable[[], object] = lambda: None
        needed = {v.val: v for t in self.left for v in known[t]}
        self._places: list[tuple[T, Leaf, int, bool]] = []
        for v in needed.values():
            key = problem.key_of.get(v.val, FIRST_SCAN)
            leaf = None if key == FIRST_SCAN else engine.lowered.layout.find(key[0])
            if leaf is not None:
                self._places.append((v, leaf, key[1], problem.role(v.val) == "state"))
        others = needed.keys() - {v.val for v, *_ in self._places} - {DT, "S:FS[0]"}
        self.left = [t for t in self.left if not any(v.val in others for v in known[t])]
        self._rows: list[list[object]] = []
        self._times: list[int] = []

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Note the values behind a scan."""
        read = self._engine.memory.read
        self._rows.append([read(leaf, index) for _, leaf, index, _ in self._places])
        self._times.append(now_ns)
        if len(self._rows) > AT_ONCE:
            self.compute()
            if not self.left:
                self.stop()

    def compute(self) -> None:
        """Compute the truths that are left for the scans that are noted."""
        count = len(self._rows) - 1
        if count < 1 or not self.left:
            return
        terms = BatchEvaluator(self.left, count)
        got = terms(self._values(count))
        self.found |= {t for t, truths in zip(self.left, got, strict=True) if truths.any()}
        self.left = [t for t in self.left if t not in self.found]
        self._rows, self._times = self._rows[-1:], self._times[-1:]

    def _values(self, count: int) -> dict[str, Array]:
        """Return the values before each scan: states as the one before left them, inputs as it has them."""
        times = np.array(self._times, dtype=np.int64)
        found: dict[str, Array] = {
            DT: (times[1:] - times[:-1]) // self._tick_ns,
            "S:FS[0]": np.zeros(count, np.bool_),
        }
        for column, (v, _, _, is_state) in enumerate(self._places):
            rows = self._rows[:-1] if is_state else self._rows[1:]
            values = np.array([row[column] for row in rows], dtype=dtype_of(v))
            if v.val.endswith(f"{CLOCK}[0]"):
                values = np.clip((times[:-1] - values) // self._tick_ns, 0, v.hi)
            found[v.val] = values
        return found
