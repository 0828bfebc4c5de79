"""Process control function blocks as Python code: a call with the values of all members.

__1 = fetched(7, (Loop_EnableIn, Loop_PV, ...))       the block's function gets the values of all members
Loop_PV = __1[1]                                      and returns the new ones, in the same order
"""

from __future__ import annotations

from ..model.operands import Group, Resolved, can_fault
from ..model.types import Structure
from .files import MemberText
from .rungs import RungWriter


def write_block(rungs: RungWriter, group: Group, *arrays: Resolved) -> None:
    """Write a call to a block; if an array has a computed subscript, the interpreter runs the block."""
    kind = group.type
    assert isinstance(kind, Structure)
    if any(map(can_fault, (group, *arrays))):
        rungs.interpret()
        return
    block, frame = MemberText(rungs, group), rungs.values.stores() if arrays else ""
    names = names_of(kind)
    arguments = f"({', '.join(block[name] for name in names)})"
    call = ", ".join([str(rungs.values.site), arguments, *([f"frame={frame}"] if frame else [])])
    outputs = rungs.values.keep(f"fetched({call})")
    block.set(**{name: f"{outputs}[{index}]" for index, name in enumerate(names)})


def names_of(kind: Structure) -> tuple[str, ...]:
    """Return the names of all members of a block's structure, including hidden members."""
    return (*(member.name for member in kind.members), *(f"~{member.name}" for member in kind.hidden))
