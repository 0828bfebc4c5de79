"""Power and tags of a ladder program as lists of changes, collected in a single pass over its scans.

A scan changes few of the program's variables, so only tags in changed variables are read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, compress
from operator import ne
from types import CellType
from typing import Any

from scanrack.ladder.debug.journal import EVERY
from scanrack.ladder.debug.replay import Truths
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.model.operands import Constant, Group, Place, can_fault, leaves_in
from scanrack.ladder.model.types import BOOL, Elementary, count_of
from scanrack.ladder.state.memory import Memory, column_in
from scanrack.ladder.state.tag_bytes import TagBytes

from ..history.catalog import PageRoutine, shown_value, value_of
from ..history.program_replica import ProgramReplica
from .changes import ChangeLists


def take_ladder(replica: ProgramReplica, walk: LadderWalk, scans: range) -> int:
    """Collect power and tags of a ladder program in scans; return the scan after the last known scan."""
    scan = scans.start
    for _ in replica.walk(scans.start, scans.stop - 1, noted=True):
        walk.note(scan)
        scan += 1
        if scan % EVERY == 0:
            replica.keep(scan)
    return scan


@dataclass(eq=False, slots=True)
class _Tag:
    """A tag with the scans and values of its changes."""

    read: Callable[[], Any]
    scans: list[int]
    values: list[Any]


@dataclass(slots=True)
class _Variable:
    """A variable of the program, with the tags in it."""

    cell: CellType
    element_tags: list[list[_Tag]]  # by element; empty if changes of elements are not distinguished
    other_tags: list[_Tag] = field(default_factory=list)  # any change may affect these
    previous: Any = ()  # the value at the last call of `changed`

    def changed(self) -> Iterable[_Tag]:
        """Return the tags that may have changed since the last call."""
        value, previous = self.cell.cell_contents, self.previous
        if value == previous:
            return ()
        if isinstance(value, TagBytes):
            value = value.saved()
        elif isinstance(value, memoryview):
            value = value.tolist()
        if value == previous:
            return ()
        self.previous = value[:] if isinstance(value, list) else value
        if not self.element_tags:
            return self.other_tags
        return chain(self.other_tags, *compress(self.element_tags, map(ne, value, previous)))


class LadderWalk:
    """Collects changes in successive scans, and reads only tags in changed variables.

    Args:
        lists: the changes are added to these lists.
        number: number of the program.
        shown: the routines whose power is collected.
        names: the tags whose values are collected; unknown names are ignored.
    """

    def __init__(
        self,
        lists: ChangeLists,
        number: int,
        engine: WatchedEngine,
        shown: Sequence[PageRoutine],
        names: Iterable[str],
    ) -> None:
        self._lists, self._number, self._engine, self._shown = lists, number, engine, shown
        self._names = [name for name in names if name in engine.tags]
        self._notes: Sequence[object] = ()  # of the engine, when power was last collected
        self._latest_power: dict[str, list[tuple[bool, ...] | None]] = {}  # by routine
        self._forces: object = None
        self._tags: list[_Tag] = []
        self._always: list[_Tag] = []  # tags that are read in every scan
        self._variables: dict[str, _Variable] = {}

    def note(self, scan: int) -> None:
        """Collect the changes in the latest scan, `scan`."""
        engine = self._engine
        if self._notes != engine.notes:
            self._notes = list(engine.notes)
            self._note_power(scan, engine.truths)
        if not self._tags:
            self._tags = [self._tag(name) for name in self._names]
        due: Iterable[_Tag] = chain(
            self._always, *[variable.changed() for variable in self._variables.values()]
        )
        if engine.memory.forces is not self._forces:
            self._forces, due = engine.memory.forces, self._tags
        for tag in dict.fromkeys(due):
            value = tag.read()
            if not tag.values or tag.values[-1] != value:
                tag.scans.append(scan)
                tag.values.append(value)

    def _note_power(self, scan: int, truths: Truths) -> None:
        """Collect the power of each shown routine in which the power of a rung or line has changed."""
        for ladder in self._shown:
            routine = ladder.name.upper()
            powers = [truths.get((routine, number)) for number in (*ladder.rungs, *ladder.lines)]
            if self._latest_power.get(routine) != powers:
                self._latest_power[routine] = powers
                for key, value in ladder.power(truths).items():
                    self._lists.note(f"power\n{self._number}\n{key}", scan, value)

    def _tag(self, name: str) -> _Tag:
        """Return a tag, and register it with its variables; if they are unknown, read it in every scan."""
        tags, memory = self._engine.tags, self._engine.memory
        place = tags.where(name)
        scans, values = self._lists.list_of(f"tags\n{self._number}\n{name}")
        tag = _Tag(_reader(place, memory) or (lambda: shown_value(value_of(tags, name))), scans, values)
        for ident, elements in _variables_of(place, memory):
            cell = memory.cells.get(ident)
            if cell is None:
                self._always.append(tag)
                continue
            count = len(cell.cell_contents) if _has_elements(cell) else 0
            variable = self._variables.setdefault(ident, _Variable(cell, [[] for _ in range(count)]))
            if not count:
                variable.other_tags.append(tag)
            for element in elements if count else ():
                variable.element_tags[element].append(tag)
        return tag


def _variables_of(place: Place | Group, memory: Memory) -> Iterator[tuple[str, Sequence[int]]]:
    """Yield the variables of a tag, each with the tag's elements in it; "" if a subscript is computed."""
    if can_fault(place):
        yield "", ()
        return
    fixed = [int(step.value) for step in place.indices if isinstance(step, Constant)]
    for leaf in leaves_in(place):
        dims, begin = leaf.dims, 0
        for index, length in zip(fixed, dims, strict=False):
            begin = begin * length + index
        count = count_of(dims[len(fixed) :])
        elements, spot = range(begin * count, (begin + 1) * count), memory.layout.spot(leaf)
        if leaf.ident in memory.cells:
            yield leaf.ident, elements
        else:
            yield (spot.ident, [*map(spot.at, elements)]) if spot else ("", ())


def _has_elements(cell: CellType) -> bool:
    """Return whether changes are tracked for each element of a variable."""
    return isinstance(cell.cell_contents, list | memoryview)


def _reader(place: Place | Group, memory: Memory) -> Callable[[], Any] | None:
    """Return a function that reads integers or bits directly from a list; None for any other tag."""
    (ident, elements), *other_variables = _variables_of(place, memory)
    cell = memory.cells.get(ident)
    if cell is None or not isinstance(cell.cell_contents, list) or other_variables:
        return None
    if not _has_plain_elements(place):
        return None
    if isinstance(place, Group):
        column = column_in(cell.cell_contents, elements.__getitem__, begin=0, step=1, count=len(elements))
        if column is None or len(place.dims) != 1:
            return None
        _, span = column
        return lambda: cell.cell_contents[span]
    array_index = elements[0]
    if place.type is BOOL:
        return lambda: bool(cell.cell_contents[array_index])
    return lambda: cell.cell_contents[array_index]


def _has_plain_elements(place: Place | Group) -> bool:
    """Return whether a tag consists of integers or BOOLs, and is not a bit of an integer."""
    kind, bit = place.type, place.bit if isinstance(place, Place) else None
    return bit is None and isinstance(kind, Elementary) and (kind is BOOL or kind.is_integer)
