"""Terms on numbers: what a relation computes for given values of its variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .meaning import BOOL, meaning
from .terms import T, reach


class Evaluator:
    """Computes the same terms again and again.

    Args:
        roots: the terms.

    Attributes:
        variables: those that decide them.
    """

    def __init__(self, roots: Sequence[T]) -> None:
        order = reach(roots)
        slots = {t.id: number for number, t in enumerate(order)}
        self._found: list[Any] = [t.val for t in order]
        self.variables = [t for t in order if t.op == "var"]
        self._variables = [
            (slot, t.val, False if t.kind == BOOL else 0) for slot, t in enumerate(order) if t.op == "var"
        ]
        self._steps: list[tuple[int, Callable[..., Any], list[int]]] = [
            (slot, meaning(t.op, t.kind, t.val), [slots[a.id] for a in t.args])
            for slot, t in enumerate(order)
            if t.op not in ("const", "var")
        ]
        self._roots = [slots[t.id] for t in roots]

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """Compute the roots; `values` has those of variables by name, 0 for what it lacks."""
        found = self._found
        for slot, name, default in self._variables:
            found[slot] = values.get(name, default)
        for slot, function, operands in self._steps:
            found[slot] = function(*[found[each] for each in operands])
        return [found[slot] for slot in self._roots]


def evaluate(roots: Sequence[T], values: Mapping[str, Any]) -> list[Any]:
    """Compute terms once; `values` has those of variables by name, 0 for what it lacks."""
    return Evaluator(roots)(values)
