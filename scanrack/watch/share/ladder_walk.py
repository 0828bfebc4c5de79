"""Collects power and tags of a ladder program as lists of changes, in one walk over its scans.

A scan changes few of the program's variables, and only tags in the changed ones are read.
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


def take_ladder(replica: ProgramReplica, walk: LadderWalk, ends: range) -> int:
    """Collect power and tags of a ladder program; return the scan after the last known one."""
    scan = ends.start
    for _ in replica.walk(ends.start, ends.stop - 1, noted=True):
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
    """A variable of the program, with tags by element, and tags that any change may affect."""

    cell: CellType
    parts: list[list[_Tag]]  # tags by element; empty if changes of elements are not distinguished
    whole: list[_Tag] = field(default_factory=list)
    before: Any = ()

    def changed(self) -> Iterable[_Tag]:
        """Return the tags that may have changed since the last call."""
        now, before = self.cell.cell_contents, self.before
        if now == before:
            return ()
        if isinstance(now, TagBytes):
            now = now.saved()
        elif isinstance(now, memoryview):
            now = now.tolist()
        if now == before:
            return ()
        self.before = now[:] if isinstance(now, list) else now
        return chain(self.whole, *compress(self.parts, map(ne, now, before))) if self.parts else self.whole


class LadderWalk:
    """Records the changes by successive scans; it reads only tags whose variables have changed.

    Args:
        lists: receive the changes.
        number: number of the program.
        names: names of the tags; unknown tags get no list.
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
        self._notes: Sequence[object] = ()
        self._power_of: dict[str, list[tuple[bool, ...] | None]] = {}
        self._forces: object = None
        self._tags: list[_Tag] = []
        self._always: list[_Tag] = []
        self._variables: dict[str, _Variable] = {}

    def note(self, scan: int) -> None:
        """Record the changes by the latest scan, which has this number."""
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
        for variable in dict.fromkeys(due):
            value = variable.read()
            if not variable.values or variable.values[-1] != value:
                variable.scans.append(scan)
                variable.values.append(value)

    def _note_power(self, scan: int, truths: Truths) -> None:
        for ladder in self._shown:
            routine = ladder.name.upper()
            powers = [truths.get((routine, number)) for number in (*ladder.rungs, *ladder.lines)]
            if self._power_of.get(routine) != powers:
                self._power_of[routine] = powers
                for key, value in ladder.power(truths).items():
                    self._lists.note(f"power\n{self._number}\n{key}", scan, value)

    def _tag(self, name: str) -> _Tag:
        """Return a tag that is read when its variables change, or in every scan if they are unknown."""
        tags, memory = self._engine.tags, self._engine.memory
        place = tags.where(name)
        scans, values = self._lists.of(f"tags\n{self._number}\n{name}")
        tag = _Tag(_reader(place, memory) or (lambda: shown_value(value_of(tags, name))), scans, values)
        for ident, elements in _places(place, memory):
            cell = memory.cells.get(ident)
            if cell is None:
                self._always.append(tag)
                continue
            count = len(cell.cell_contents) if _has_elements(cell) else 0
            variable = self._variables.setdefault(ident, _Variable(cell, [[] for _ in range(count)]))
            for part in [variable.parts[element] for element in elements] if count else [variable.whole]:
                part.append(tag)
        return tag


def _places(where: Place | Group, memory: Memory) -> Iterator[tuple[str, Sequence[int]]]:
    """Yield the variables of a tag, each with the tag's elements in it; "" if a subscript is computed."""
    if can_fault(where):
        yield "", ()
        return
    fixed = [int(step.value) for step in where.indices if isinstance(step, Constant)]
    for leaf in leaves_in(where):
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
    """Return whether changes of a variable's elements are distinguished."""
    return isinstance(cell.cell_contents, list | memoryview)


def _reader(where: Place | Group, memory: Memory) -> Callable[[], Any] | None:
    """Return a function that reads integers or bits directly from a list; None for any other tag."""
    (ident, elements), *extra_places = _places(where, memory)
    cell, kind = memory.cells.get(ident), where.type
    if cell is None or not isinstance(cell.cell_contents, list) or extra_places or not _is_whole(where):
        return None
    if isinstance(where, Group):
        column = column_in(cell.cell_contents, elements.__getitem__, 0, 1, len(elements))
        return None if column is None or len(where.dims) != 1 else lambda: cell.cell_contents[column[1]]
    array_index = elements[0]
    if kind is BOOL:
        return lambda: bool(cell.cell_contents[array_index])
    return lambda: cell.cell_contents[array_index]


def _is_whole(where: Place | Group) -> bool:
    """Return whether a tag consists of integers or BOOLs, and is not a bit of an integer."""
    kind, bit = where.type, where.bit if isinstance(where, Place) else None
    return bit is None and isinstance(kind, Elementary) and (kind is BOOL or kind.is_integer)
