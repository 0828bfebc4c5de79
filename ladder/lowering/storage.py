"""Select the tags to store as bytes: structures that are used as a whole often enough.

Copying bytes costs little per value, but each access to a single value costs more than with a variable. A
tag and the InOuts that it is passed to have the same storage, because an add-on instruction is compiled once.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

from ..model.operands import Calculation, Constant, Group, Place, Resolved, first_leaf
from ..model.spec import Use
from ..model.stretches import fits_bytes
from ..model.tags import OWN, FrameLayout, Layout, Tag, tag_in
from ..model.types import Structure, count_of, fields_of
from ..state.lowered import AddOnCall, Call, LoweredProgram, LoweredStep
from ..state.regions import copied_singly
from .rungs import pass_bits_on

_WHOLE_USES = frozenset(
    (
        *(Use.SOURCE, Use.DESTINATION, Use.ITEM, Use.ITEM_TARGET, Use.ARRAY, Use.TABLE, Use.TEXT),
        *(Use.TEXT_TARGET, Use.TEXT_OR_NUMBER, Use.TEXT_OR_NUMBER_TARGET, Use.TARGET, Use.PARAMETERS),
    )
)
"""Uses of a structure as a whole; uses of a timer, for example, count as uses of its members."""

_COPY = (Use.SOURCE, Use.DESTINATION)

_VALUE_NS, _COPIED_NS, _CONVERTED_NS, _FIELD_NS = 20, 12, 20, 200
"""Costs in ns. The first is the extra cost of bytes per access to a single value. The others are the costs of
a copied value without bytes: copied singly, in an array of another type, and in a region.
"""

_MEMBERS = 4  # single values in a use of a timer and the like

_Root = tuple[str, str]
"""A unit of storage: an add-on instruction and `Leaf.root`, or "" and a tag; all in capitals."""


def choose_bytes(lowered: LoweredProgram) -> None:
    """Lay out tags and InOuts as bytes where this is faster."""
    uses = _Uses()
    for step in lowered.all_steps:
        uses.count_step(step)
    layout = lowered.layout
    layout.make_bytes([unused.name.upper() for unused in layout.unused if _is_large(unused)])
    if uses.gain:
        chosen: dict[str, list[str]] = defaultdict(list)
        for owner, name in uses.roots_in_bytes(lowered):
            chosen[owner].append(name)
        for owner, names in chosen.items():
            _layout(lowered, owner).make_bytes(names)
        _pass_bits(lowered, uses.calls)
    for path in uses.wholes:
        if tag_in(path).upper() not in layout.boxed:
            layout.request_below(path)
    for tag in filter(_is_large, layout.partly_used):
        layout.fold_rest(tag.name.upper())


def _is_large(tag: Tag) -> bool:
    """Return whether a tag is a structure that bytes can store, so it needs only one variable."""
    return isinstance(tag.type, Structure) and fits_bytes(tag.type)


def _pass_bits(lowered: LoweredProgram, calls: Iterable[AddOnCall]) -> None:
    """Note the InOuts that receive a bit of a byte, because their argument is a BOOL stored in bytes."""
    for call in calls:
        for name, operand in call.handed.items():
            leaf = first_leaf(operand)
            spot = _layout(lowered, leaf.frame).spot(leaf)
            if spot is not None and spot.unit == 1 and leaf.type is operand.type:
                lowered.frames[call.name].bits.add(name)
    pass_bits_on(lowered)


class _Uses:
    """The uses of all roots, and groups of roots that share the same kind of storage."""

    def __init__(self) -> None:
        self.gain: dict[_Root, int] = defaultdict(int)  # ns per scan that bytes gain by whole uses
        self.loss: dict[_Root, int] = defaultdict(int)  # ns per scan that bytes lose by single uses
        self.unfit: set[_Root] = set()
        self.calls: list[AddOnCall] = []
        self.wholes: dict[str, None] = {}  # paths of structures of tags that instructions use as a whole
        self._parents: dict[_Root, _Root] = {}

    def count_step(self, step: LoweredStep) -> None:
        """Count the uses of an instruction."""
        if step.operands and isinstance(step.operands[0], AddOnCall):
            self._count_call(step.operands[0])
            return
        for use, operand in zip(step.uses, step.operands, strict=False):
            self._count_operand(operand, step, whole=use in _WHOLE_USES)

    def _count_operand(self, operand: Any, step: LoweredStep, *, whole: bool) -> None:
        """Count the uses of an operand and its subscripts; `whole` means that it is used as a whole."""
        if isinstance(operand, (Calculation, Call)):
            inner_operands = (
                operand.operands if isinstance(operand, Calculation) else operand.inputs + operand.returns
            )
            for inner in inner_operands:
                self._count_operand(inner, step, whole=True)
        elif isinstance(operand, Place):
            self._count_array(operand, step)
            self._count_subscripts(
                operand.indices if operand.bit is None else (*operand.indices, operand.bit), step
            )
        elif isinstance(operand, Group):
            if isinstance(operand.type, Structure):
                self._count_structure(operand, step, whole=whole)
            else:
                self._count_array(operand, step)
            self._count_subscripts(operand.indices, step)

    def _count_structure(self, operand: Group, step: LoweredStep, *, whole: bool) -> None:
        """Count a use of a structure: a gain by bytes if it is used as a whole, otherwise a loss."""
        root = _root_of(operand)
        if not whole:
            self.loss[root] += _MEMBERS * _VALUE_NS
        elif copied_singly(step.operands):
            self.gain[root] += _COPIED_NS * len(fields_of(operand.type))
        else:
            self.gain[root] += _FIELD_NS * len(fields_of(operand.type)) * _elements_copied(operand, step)
        if not root[0]:
            self.wholes[operand.path] = None

    def _count_array(self, operand: Place | Group, step: LoweredStep) -> None:
        """Count the use of a number, or of an array in a copy from or to another type."""
        root = _root_of(operand)
        copied = step.operands[: len(_COPY)] if step.uses[: len(_COPY)] == _COPY else ()
        if any(operand is copied_operand for copied_operand in copied) and copied[0].type != copied[1].type:
            self.gain[root] += _CONVERTED_NS * _elements_copied(operand, step)
        else:
            self.loss[root] += _VALUE_NS

    def _count_subscripts(self, indices: Iterable[Resolved], step: LoweredStep) -> None:
        for index in indices:
            if not isinstance(index, Constant):
                self._count_operand(index, step, whole=False)

    def _count_call(self, call: AddOnCall) -> None:
        """Count the uses of a call; an argument has the same kind of storage as its InOut."""
        self.calls.append(call)
        self._join(_root_of(call.instance), (call.name, OWN))
        for place in (call.enable_in, call.enable_in, call.enable_out):
            self.loss[_root_of(place)] += _VALUE_NS
        for name, operand in call.handed.items():
            if isinstance(operand.type, Structure):
                self._join(_root_of(operand), (call.name, name))
            elif operand.type.is_bool and isinstance(operand, Group):
                self.unfit.add(_root_of(operand))  # an array of BOOL is passed as a list

    def _join(self, a: _Root, b: _Root) -> None:
        first, second = self._representative(a), self._representative(b)
        if first != second:
            self._parents[first] = second

    def _representative(self, root: _Root) -> _Root:
        """Return the root that represents a group, and shorten the path to it."""
        while root in self._parents:
            parent = self._parents[root]
            self._parents[root] = self._parents.get(parent, parent)
            root = parent
        return root

    def roots_in_bytes(self, lowered: LoweredProgram) -> Iterator[_Root]:
        """Yield the roots to store as bytes: groups that gain more than they lose, if all of them fit."""
        roots = dict.fromkeys((*self.gain, *self.loss, *self._parents, *self._parents.values()))
        gains: dict[_Root, int] = defaultdict(int)
        for root in roots:
            gains[self._representative(root)] += self.gain[root] - self.loss[root]
        unfit = {
            self._representative(name)
            for name in roots
            if name in self.unfit or not _can_be_bytes(lowered, name)
        }
        for root in roots:
            top = self._representative(root)
            if gains[top] > 0 and top not in unfit:
                yield root


def _layout(lowered: LoweredProgram, owner: str) -> Layout:
    return lowered.frames[owner].layout if owner else lowered.layout


def _can_be_bytes(lowered: LoweredProgram, root: _Root) -> bool:
    """Return whether bytes can store a structure, or an array in a program."""
    owner, name = root
    layout = _layout(lowered, owner)
    if isinstance(layout, FrameLayout) and name == OWN:
        return fits_bytes(layout.own)
    tag = layout.declarations.get(name)
    if not isinstance(tag, Tag) or not fits_bytes(tag.type):
        return False  # numbers are passed as a list or a view, with the same code
    return isinstance(tag.type, Structure) or (not owner and bool(tag.dims))


def _root_of(operand: Place | Group) -> _Root:
    leaf = first_leaf(operand)
    return (leaf.frame, leaf.root) if leaf.frame else ("", tag_in(leaf.path).upper())


def _elements_copied(operand: Place | Group, step: LoweredStep) -> int:
    """Return the number of elements that are copied; an estimate if the length is computed."""
    most = count_of(operand.dims or operand.array)
    length = step.operands[-1]
    if isinstance(length, Constant) and isinstance(length.value, int):
        return max(1, min(length.value, most))
    return most if Use.DESTINATION in step.uses else 1
