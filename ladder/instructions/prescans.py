"""Prescans that several families share."""

from __future__ import annotations

from collections.abc import Callable

from ..interpreter import Interpreter
from ..interpreter.files import Members
from ..model.operands import Group, Resolved


def prescan_sets(position: int, **members: bool | int) -> Callable[..., None]:
    """Return a prescan that sets members of the structure at a position among the operands.

    A prescan sets an edge bit so that a rung that is true in the first scan is not an edge.
    """

    def prescan(machine: Interpreter, *operands: Resolved) -> None:
        group = operands[position]
        assert isinstance(group, Group)
        Members(machine, group).set(**members)

    return prescan
