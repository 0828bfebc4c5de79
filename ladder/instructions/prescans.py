"""Prescan functions that several instruction families share."""

from __future__ import annotations

from collections.abc import Callable

from ..interpreter import Interpreter
from ..interpreter.files import Members
from ..model.operands import Group, Resolved


def prescan_sets(position: int, **members: bool | int) -> Callable[..., None]:
    """Return a prescan function that sets members of the structure at an operand position.

    Prescan sets an edge bit, so a rung that is true in the first scan does not count as an edge.
    """

    def prescan(machine: Interpreter, *operands: Resolved) -> None:
        group = operands[position]
        assert isinstance(group, Group)
        Members(machine, group).set(**members)

    return prescan
