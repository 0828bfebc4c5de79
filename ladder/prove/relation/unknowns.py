"""What the relation leaves open, as uninterpreted functions of all that may decide it.

What an instruction without a model leaves is not known, but equal instructions that find the same leave the
same. So each unknown value has an origin: a function, named by the instruction, and its arguments.

| unknown | function | arguments |
|---|---|---|
| what an instruction leaves, its power, its fault | its row, operands, world | all that it may read |
| the result of a step of a computation, such as SIN | the step, the kind of its result | its operands |
| what nothing else decides | none: it is like no other | |

An instruction may read all elements of the tags that it names, with hidden members, the system's tags, where
its add-on instruction was called, and its power, if it acts without. The world is what programs have beside
tags.

Two programs may share a value only where the same function has equal arguments. What can't be compared has no
function: nothing is shared by default.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import NamedTuple

from ...model.tags import OVERRIDE, STATUS_FLAGS, Leaf
from ...model.types import HIDDEN
from ...state.lowered import AddOnCall, Call, LoweredProgram, LoweredStep
from ..algebra.terms import T
from .shapes import shape_of

NO_ARGUMENTS: Mapping[Hashable, T] = {}


class UnknownOrigin(NamedTuple):
    """Where an unknown value comes from.

    Attributes:
        function: its name; None if it is like no other.
        arguments: by their names.
        strict: whether more than the values of the arguments may decide it, such as the sign of NaN: then
            only the same terms of the same values are equal arguments.
    """

    function: Hashable | None
    arguments: Mapping[Hashable, T] = NO_ARGUMENTS
    strict: bool = False

    def of(self, what: Hashable) -> UnknownOrigin:
        """Return the origin of one of its values."""
        return self if self.function is None else self._replace(function=(self.function, what))


ONLY = UnknownOrigin(None)
"""Of an unknown value that is like no other."""


def named(step: LoweredStep, leaves: tuple[Leaf, ...], world: Hashable) -> Hashable | None:
    """Return the name of an instruction's function; None of one that calls.

    Args:
        leaves: all that it names, with their types.
        world: what else decides what instructions do, see `shapes.world_of`.
    """
    if any(isinstance(each, (Call, AddOnCall)) for each in step.operands):
        return None  # what it calls decides, too
    shapes = tuple(map(shape_of, step.operands))
    return step.spec, shapes, tuple((each.path.upper(), each.type, each.dims) for each in leaves), world


_NOT_READ = frozenset((*(name for name in STATUS_FLAGS if name != "S:FS"), OVERRIDE.upper()))
"""Status that rungs have as operands if they read it."""


def system_leaves(lowered: LoweredProgram, status: str) -> list[Leaf]:
    """Return the leaves of the system, which instructions may read without naming them.

    Args:
        status: the status file of an SLC.
    """
    leaves = lowered.layout.leaves
    return [
        leaf
        for path, leaf in leaves.items()
        if (path.startswith((HIDDEN, "S:")) or path == status) and path not in _NOT_READ
    ]
