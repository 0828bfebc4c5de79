"""Prescans that several families share."""

from __future__ import annotations

from collections.abc import Callable

from ..interpreter import Interpreter
from ..interpreter.files import Members
from ..model.operands import Group, Resolved


def prescan_sets(operand: int, **members: bool | int) -> Callable[..., None]:
    """Return a prescan that sets members of the structure at this place among the operands.

    An edge bit that it sets keeps a rung that is true in the first scan from being an edge.
    """

    def prescan(machine: Interpreter, *operands: Resolved) -> None:
        group = operands[operand]
        assert isinstance(group, Group)
        Members(machine, group).set(**members)

    return prescan
