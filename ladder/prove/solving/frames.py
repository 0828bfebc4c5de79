"""Consecutive scans in a solver; each scan has its own solver terms for the variables."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..algebra.meaning import INT
from ..algebra.terms import TRUE, T
from ..system import System
from .solver import Solver
from .translation import declare, fit, literal, translate, width


class Frame:
    """One scan in a solver.

    Args:
        system: the system to model.
        solver: the solver that creates the terms.
        before: the previous scan; None for the first scan of a run, or for a scan from any state.
        first: whether it is the first scan after power-up, when states have their initial values.
    """

    def __init__(
        self, system: System, solver: Solver, before: Frame | None = None, *, first: bool = False
    ) -> None:
        self.system, self.solver, self.before, self.first = system, solver, before, first
        self.number: int = 0 if before is None else before.number + 1
        self.chosen: dict[str, tuple[T, Any]] = {}  # variables whose values the solver chooses
        self._memo: dict[int, Any] = {}
        if system.contract is not TRUE:
            solver.state(self.term(system.contract))

    def term(self, t: T) -> Any:
        """Return the solver's term for a term in this scan."""
        return translate(self.solver, t, self._lookup, self._memo)

    def _lookup(self, v: T) -> Any:
        """Return a constant, the state after the previous scan, or a variable for the solver to choose."""
        system, name = self.system, v.val
        if name in system.held or (self.first and (name in system.next or name in system.late)):
            return literal(self.solver, v, system.initial[name])
        if self.before is not None and name in system.next:
            next_term = system.next[name]
            earlier = self.before.term(next_term)
            return fit(self.solver, earlier, width(next_term), width(v)) if v.kind == INT else earlier
        choice = self.chosen.get(name)
        if choice is None:
            choice = self.chosen[name] = v, declare(self.solver, v, f"{name}@{self.number}")
        return choice[1]

    def __iter__(self) -> Iterator[Frame]:
        """Yield the scans up to this one, earliest first."""
        frames: list[Frame] = []
        frame: Frame | None = self
        while frame is not None:
            frames.append(frame)
            frame = frame.before
        return reversed(frames)

    def values(self) -> dict[str, Any]:
        """Return the values that the solver chose, by name; call it only after the answer sat."""
        return {
            name: self.solver.found(formula, variable) for name, (variable, formula) in self.chosen.items()
        }
