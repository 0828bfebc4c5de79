"""Values that the relation does not determine, as uninterpreted functions of the values that may decide them.

The result of an instruction without a model is unknown, but equal instructions with equal inputs have equal
results. Therefore each unknown value has an origin: a function, named by the instruction, and its arguments.

| unknown | function | arguments |
|---|---|---|
| an instruction's results, power or fault | its row, operands, world | everything that it may read |
| the result of an operation, such as SIN | the operation, the kind of its result | its operands |
| any other unknown value | none: it is never shared | |

An instruction may read all elements of the tags that it names, including hidden members. It may also read the
system's tags, the arguments of its add-on instruction's call, and its power, if it acts without power.
For the world, see `shapes.world_of`.

Two programs share a value only if the same function has equal arguments. A value that can't be compared
has no function, so it is not shared.
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
    """The origin of an unknown value.

    Attributes:
        function: the name of the function; None if the value is never shared.
        arguments: the arguments by name.
        strict: whether a property beyond the values of the arguments may decide it, such as the sign of NaN.
            Then only identical terms of shared values count as equal arguments.
    """

    function: Hashable | None
    arguments: Mapping[Hashable, T] = NO_ARGUMENTS
    strict: bool = False

    def of(self, value_name: Hashable) -> UnknownOrigin:
        """Return the origin of one of an instruction's values, by the value's name."""
        return self if self.function is None else self._replace(function=(self.function, value_name))


ONLY = UnknownOrigin(None)
"""Origin of an unknown value that is never shared."""


def named(step: LoweredStep, leaves: tuple[Leaf, ...], world: Hashable) -> Hashable | None:
    """Return the name of an instruction's function; None for an instruction that calls a routine.

    Args:
        leaves: all leaves that the instruction names, with their types.
        world: other things that decide the effects of instructions, see `shapes.world_of`.
    """
    if any(isinstance(operand, (Call, AddOnCall)) for operand in step.operands):
        return None  # the called routine also decides the effects
    shapes = tuple(map(shape_of, step.operands))
    return step.spec, shapes, tuple((leaf.path.upper(), leaf.type, leaf.dims) for leaf in leaves), world


_NOT_READ = frozenset((*(name for name in STATUS_FLAGS if name != "S:FS"), OVERRIDE.upper()))
"""Status flags that an instruction reads only if they are its operands."""


def system_leaves(lowered: LoweredProgram, status: str) -> list[Leaf]:
    """Return the system's leaves, which instructions may read without naming them.

    Args:
        status: the status file of an SLC.
    """
    leaves = lowered.layout.leaves
    return [
        leaf
        for path, leaf in leaves.items()
        if (path.startswith((HIDDEN, "S:")) or path == status) and path not in _NOT_READ
    ]
