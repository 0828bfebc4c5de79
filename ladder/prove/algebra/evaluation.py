"""Computation of terms from the values of their variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .meaning import BOOL, meaning
from .terms import T, reach


class Evaluator:
    """Computes the same terms for different values of their variables.

    Each subterm has a slot; operands come first, so a single pass over the slots computes all terms.

    Args:
        roots: the terms to compute.
    """

    def __init__(self, roots: Sequence[T]) -> None:
        """Order the subterms; store the values of constants, and the steps that compute the others."""
        order = reach(roots)
        slots = {node.id: number for number, node in enumerate(order)}
        self._results: list[Any] = [None] * len(order)
        self._variables: list[tuple[int, str, int]] = []  # slot, name, default
        self._steps: list[tuple[int, Callable[..., Any], list[int]]] = []  # slot, function, operands' slots
        for slot, term in enumerate(order):
            if term.op == "var":
                self._variables.append((slot, term.val, False if term.kind == BOOL else 0))
            elif term.op == "const":
                self._results[slot] = self._constant(term)
            else:
                self._steps.append(
                    (slot, self._function(term), [slots[argument.id] for argument in term.args])
                )
        self._roots = [slots[root.id] for root in roots]

    def _constant(self, t: T) -> Any:
        return t.val

    def _function(self, t: T) -> Callable[..., Any]:
        return meaning(t.op, t.kind, t.val)

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """Return the values of the roots; `values` has the variables by name, a missing variable is 0."""
        results = self._results
        for slot, name, default in self._variables:
            results[slot] = values.get(name, default)
        for slot, function, operands in self._steps:
            results[slot] = function(*[results[operand] for operand in operands])
        return [results[slot] for slot in self._roots]


def evaluate(roots: Sequence[T], values: Mapping[str, Any]) -> list[Any]:
    """Return the values of terms; `values` has the variables by name, a missing variable is 0."""
    return Evaluator(roots)(values)
