"""Members with `at`: aliases of another member, an element or a bit of the same structure."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass

from ..model.expressions import parse_address
from ..model.stretches import byte_parts
from ..model.tree import BitStep, MemberStep, Number, Operand, Step, SubscriptStep
from ..model.types import BOOL, DataType, Elementary, Member, Structure, count_of


@dataclass(frozen=True, slots=True)
class AliasTarget:
    """The part of a structure that is the target of a member with `at`."""

    path: str
    type: DataType
    dims: tuple[int, ...]
    index: int  # flat index in the path
    bit: int | None  # a bit of the part, None for the whole


def alias_target(path: str, kind: Structure, member: Member, index: int) -> AliasTarget:
    """Return the target of a member with `at` in structure number `index` of a path."""
    part_type: DataType = kind
    dims: tuple[int, ...] = ()
    bit = None
    steps = _steps_of(member)
    for _ in range(_DEEPEST):
        if not steps:
            return AliasTarget(path, part_type, dims, index, bit)
        step, *steps = steps
        problem_place = f"{member.name} of {kind.name} is at {member.at}"
        if isinstance(step, MemberStep):
            step_member = (
                part_type.member(step.name) if isinstance(part_type, Structure) and not dims else None
            )
            if step_member is None:
                raise ValueError(f"{problem_place}: no {step.name}")
            if step_member.at:
                steps = [*_steps_of(step_member), *steps]
                continue
            path, part_type, dims = f"{path}.{step_member.name}", step_member.type, step_member.dims
        elif isinstance(step, SubscriptStep):
            index, dims = _element_at(index, dims, step, problem_place), ()
        elif isinstance(step, BitStep):
            bit = _number_of(step.index, problem_place)
            if not isinstance(part_type, Elementary) or dims or bit >= part_type.bits:
                raise ValueError(f"{problem_place}: no bit {bit}")
    raise ValueError(f"{member.name} of {kind.name} is an alias of an alias more than {_DEEPEST} deep")


def alias_place(kind: Structure, member: Member) -> tuple[DataType, tuple[int, ...], int]:
    """Return the type, dimensions and first bit of an alias member's target in the structure."""
    target = alias_target("", kind, member, 0)
    part = byte_parts(kind)[target.path[1:].upper()]
    first_bit, index = part.offset, target.index * count_of(target.dims)
    for length, stride in zip(reversed(part.dims), reversed(part.strides), strict=True):
        index, number = divmod(index, length)
        first_bit += number * stride
    return (target.type, target.dims, first_bit) if target.bit is None else (BOOL, (), first_bit + target.bit)


_DEEPEST = 64  # maximum steps in a member's `at`


def _steps_of(member: Member) -> list[Step]:
    """Return the steps from the structure to the part in a member's `at`."""
    address = parse_address(member.at)
    return [MemberStep(address.name), *address.steps]


def _element_at(index: int, dims: tuple[int, ...], step: SubscriptStep, problem_place: str) -> int:
    """Return the flat index of an element of array number `index`; raise a ValueError out of range."""
    if len(step.indices) != len(dims):
        raise ValueError(f"{problem_place}: {len(step.indices)} subscripts for {len(dims)} dimensions")
    for subscript, length in zip(step.indices, dims, strict=True):
        number = _number_of(subscript, problem_place)
        if number >= length:
            raise ValueError(f"{problem_place}: no element {number}; must be below {length}")
        index = index * length + number
    return index


def _number_of(operand: Operand, problem_place: str) -> int:
    """Return the integer in a subscript; raise a ValueError for another operand."""
    if not isinstance(operand, Number) or not isinstance(operand.value, int):
        raise ValueError(f"{problem_place}: {operand} is not an integer")
    return operand.value
