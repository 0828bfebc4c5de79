"""Computes terms for given values of their variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .meaning import BOOL, meaning
from .terms import T, reach


class Evaluator:
    """Computes the same terms for different values of their variables.

    Args:
        roots: the terms to compute.
    """

    def __init__(self, roots: Sequence[T]) -> None:
        order = reach(roots)
        slots = {t.id: number for number, t in enumerate(order)}
        self._found: list[Any] = [None] * len(order)
        self._variables: list[tuple[int, str, int]] = []
        self._steps: list[tuple[int, Callable[..., Any], list[int]]] = []
        for slot, t in enumerate(order):
            if t.op == "var":
                self._variables.append((slot, t.val, False if t.kind == BOOL else 0))
            elif t.op == "const":
                self._found[slot] = self._constant(t)
            else:
                self._steps.append((slot, self._function(t), [slots[a.id] for a in t.args]))
        self._roots = [slots[t.id] for t in roots]

    def _constant(self, t: T) -> Any:
        return t.val

    def _function(self, t: T) -> Callable[..., Any]:
        return meaning(t.op, t.kind, t.val)

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """Return the values of the roots; `values` has the variables by name, a missing variable is 0."""
        found = self._found
        for slot, name, default in self._variables:
            found[slot] = values.get(name, default)
        for slot, function, operands in self._steps:
            found[slot] = function(*[found[operand] for operand in operands])
        return [found[slot] for slot in self._roots]


def evaluate(roots: Sequence[T], values: Mapping[str, Any]) -> list[Any]:
    """Return the values of terms; `values` has the variables by name, a missing variable is 0."""
    return Evaluator(roots)(values)
