"""The parts that members with `at` name: another member, an element or a bit of the same structure."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass

from ..model.expressions import parse_address
from ..model.stretches import byte_parts
from ..model.tree import BitStep, MemberStep, Number, Operand, Step, SubscriptStep
from ..model.types import BOOL, DataType, Elementary, Member, Structure, count_of


@dataclass(frozen=True, slots=True)
class AliasTarget:
    """The part of a structure that a member with `at` names."""

    path: str
    type: DataType
    dims: tuple[int, ...]
    index: int  # flat index in the path
    bit: int | None  # a bit of the part, None for the whole


def meant_by(path: str, kind: Structure, member: Member, index: int) -> AliasTarget:
    """Return the part that a member with `at` names in structure number `index` of a path."""
    kind_here: DataType = kind
    dims: tuple[int, ...] = ()
    bit = None
    steps = _steps_of(member)
    for _ in range(_DEEPEST):
        if not steps:
            return AliasTarget(path, kind_here, dims, index, bit)
        step, *steps = steps
        where = f"{member.name} of {kind.name} is at {member.at}"
        if isinstance(step, MemberStep):
            named = kind_here.member(step.name) if isinstance(kind_here, Structure) and not dims else None
            if named is None:
                raise ValueError(f"{where}: no {step.name}")
            if named.at:
                steps = [*_steps_of(named), *steps]
                continue
            path, kind_here, dims = f"{path}.{named.name}", named.type, named.dims
        elif isinstance(step, SubscriptStep):
            index, dims = _element_at(index, dims, step, where), ()
        elif isinstance(step, BitStep):
            bit = _number_of(step.index, where)
            if not isinstance(kind_here, Elementary) or dims or bit >= kind_here.bits:
                raise ValueError(f"{where}: no bit {bit}")
    raise ValueError(f"{member.name} of {kind.name} leads to more than {_DEEPEST} others")


def place_of(kind: Structure, member: Member) -> tuple[DataType, tuple[int, ...], int]:
    """Return type, dimensions and first bit of what a member with `at` names in its structure's bytes."""
    there = meant_by("", kind, member, 0)
    part = byte_parts(kind)[there.path[1:].upper()]
    at, index = part.offset, there.index * count_of(there.dims)
    for length, stride in zip(reversed(part.dims), reversed(part.strides), strict=True):
        index, number = divmod(index, length)
        at += number * stride
    return (there.type, there.dims, at) if there.bit is None else (BOOL, (), at + there.bit)


_DEEPEST = 64  # maximum steps in a member's `at`


def _steps_of(member: Member) -> list[Step]:
    address = parse_address(member.at)
    return [MemberStep(address.name), *address.steps]


def _element_at(index: int, dims: tuple[int, ...], step: SubscriptStep, where: str) -> int:
    if len(step.indices) != len(dims):
        raise ValueError(f"{where}: {len(step.indices)} subscripts are given, it has {len(dims)} dimensions")
    for subscript, length in zip(step.indices, dims, strict=True):
        number = _number_of(subscript, where)
        if number >= length:
            raise ValueError(f"{where}: no element {number}, it has {length}")
        index = index * length + number
    return index


def _number_of(operand: Operand, where: str) -> int:
    if not isinstance(operand, Number) or not isinstance(operand.value, int):
        raise ValueError(f"{where}: {operand} is no number")
    return operand.value
