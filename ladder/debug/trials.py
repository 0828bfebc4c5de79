"""Tries other inputs on a copy of a ladder program, for `remedies`.

The program is copied as it is after a scan, the inputs are held as they are then, and some are changed: those
of input images, and tags that no rung writes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from itertools import islice
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..model.arithmetic import wrap
from ..model.errors import LadderFault
from ..model.operands import Calculation, Constant, Group, Place
from ..state.memory import Value
from ..state.snapshots import restore, snapshot
from .cells import Cell, cell_of
from .crossref import CrossReference, Mention, overlap
from .remedies import MOST_CANDIDATES, Candidate, InputChange, Remedies, Search, bit, number
from .replay import Replayer
from .watching import WatchedEngine

Name = Callable[[int, int, int | None], str | None]
"""Names the terminal at slot, word and bit of an input image, None for the word; None for what is none."""


@dataclass(slots=True)
class Trials:
    """Runs scans on a copy of a program.

    Args:
        live: the program, between two scans.
        past: runs its scans again, on its own memory.
        scans: most scans of a try.
        name: names the terminals of input images.
    """

    live: WatchedEngine
    past: Replayer
    cross_reference: CrossReference
    name: Name
    scans: int = 10
    _values: Mapping[str, Any] = field(default_factory=dict)
    _images: Sequence[bytes] = ()
    _period_ns: int = 10_000_000

    def of(self, tag: str, cell: Cell, requested: Value) -> Remedies:
        """Return the smallest sets of inputs after which a tag has a value; `cell` is the tag's.

        What modules report is tried if no terminal and no tag does it.
        """
        self._begin()
        search = Search(tag, requested, lambda changes: self._try(changes, cell, requested))
        own: list[Candidate] = []
        reported: list[Candidate] = []
        for each in islice(self.candidates(tag, requested), MOST_CANDIDATES):
            (reported if each.place.endswith(REPORTED) else own).append(each)
        found = search.among(own)
        return found if found.found or not reported else search.among([*own, *reported])

    def _begin(self) -> None:
        memory, last = self.live.memory, self.live.scans - 1
        self._values = snapshot(memory)
        self._images = [bytes(memory.cells[leaf.ident].cell_contents) for leaf in self.past.images]
        before = self.past.inputs(last - 1) if last else None
        if before is not None:
            self._period_ns = self.live.now_ns - before.now_ns

    def _try(self, changes: Sequence[InputChange], cell: Cell, requested: Value) -> int | None:
        """Return after how many scans a cell has a value; None if it has not."""
        engine = self.past.engine
        engine.hold({})
        restore(engine.memory, self._values)
        engine.watching = False
        engine.note(())
        engine.hold(self.live.memory.forces)
        self.past.at = None
        images = self.past.images
        contents = [bytearray(each) for each in self._images]
        for each in changes:
            if each.cell.leaf.is_image:
                data = contents[[leaf.ident for leaf in images].index(each.cell.leaf.ident)]
                at = 2 * each.cell.index
                word = int.from_bytes(data[at : at + 2], "little")
                data[at : at + 2] = _merged(word, each).to_bytes(2, "little")
            else:
                self._set(each)
        for scan in range(1, self.scans + 1):
            for leaf, data in zip(images, contents, strict=True):
                engine.memory.cells[leaf.ident].cell_contents.cast("B")[:] = data
            with suppress(LadderFault):
                engine.do(self.live.now_ns + scan * self._period_ns, first=False)
            if _read(engine.memory, cell) == requested:
                return scan
        return None

    def _set(self, change: InputChange) -> None:
        memory, cell = self.past.engine.memory, change.cell
        if cell.mask is None:
            memory.write(cell.leaf, cell.index, change.value)
        else:
            bits = cell.leaf.type.wraps
            word = _merged(int(memory.read(cell.leaf, cell.index)), change)
            memory.write(cell.leaf, cell.index, wrap(word, bits))

    # --- inputs that may matter

    def candidates(self, tag: str, requested: Value) -> Iterator[Candidate]:
        """Yield the inputs that a tag depends on by the text of the program, the nearest first."""
        mentions = self.cross_reference.mentions
        by_line: dict[tuple[str, int | None], list[Mention]] = {}
        for each in mentions:
            by_line.setdefault((each.site.routine, each.site.rung), []).append(each)
        written = [each for each in mentions if each.writes]
        ahead: list[Place | Group] = [each.where for each in self.cross_reference.of(tag) if each.writes]
        seen: dict[str, Place | Group] = {}
        compared = [] if isinstance(requested, bool) else [requested]
        while ahead:
            where = ahead.pop(0)
            lines = {
                (each.site.routine, each.site.rung)
                for each in written
                if overlap(where, each.where, stretch=True)
            }
            for key in sorted(lines, key=str):
                compared += self._constants(*key)
                for each in by_line[key]:
                    if each.reads and each.where.text not in seen:
                        seen[each.where.text] = each.where
                        ahead.append(each.where)
        for where in seen.values():
            yield from self._candidate(where, written, compared)

    def _constants(self, routine: str, rung: int | None) -> Iterator[float]:
        """Yield the numbers in a rung or line."""
        found = self.live.lowered.routines.get(routine.upper())
        for line in found.lines if found is not None else ():
            if line.number == rung:
                yield from (each for step in line.steps for each in _numbers(step.operands))

    def _candidate(
        self, where: Place | Group, written: Sequence[Mention], compared: Sequence[float]
    ) -> Iterator[Candidate]:
        if not isinstance(where, Place) or where.can_fault:
            return
        cell, leaf = cell_of(where), where.leaf
        now = _read(self.live.memory, cell)
        if leaf.is_image and not leaf.output:
            at = int(where.bit.value) if isinstance(where.bit, Constant) else None
            place = self.name(leaf.slot or 0, cell.index, at)
            place = f"slot {leaf.slot}{REPORTED}" if place is None else place
        elif leaf.slot is None and not leaf.path.startswith(("S:", "~")):
            place = ""
            if any(overlap(where, each.where, stretch=True) for each in written):
                return
        else:
            return
        if isinstance(now, bool):
            yield bit(cell, where.text, place, now)
        else:
            limits = (
                (-FARTHEST, FARTHEST) if isinstance(now, float) else (leaf.type.lowest, leaf.type.highest)
            )
            yield number(cell, where.text, place, now, limits, compared)


REPORTED = ", as the module reports it"
"""The end of the place of an input that is no terminal."""

FARTHEST = 1e6
"""Largest REAL that is tried."""


def _numbers(operands: Iterable[Any]) -> Iterator[float]:
    for each in operands:
        if isinstance(each, Constant):
            yield each.value
        elif isinstance(each, Calculation):
            yield from _numbers(each.operands)


def _merged(word: int, change: InputChange) -> int:
    """Return a word, not negative, with a changed input."""
    mask: int | None = change.cell.mask
    if mask is None:
        return int(change.value) & 0xFFFF
    return word | mask if change.value else word & ~mask


def terminal(slot: int, word: int, bit: int | None) -> str:
    """Return the place of an input bit as text, or of a word."""
    return f"slot {slot} input word {word}" if bit is None else f"slot {slot} input {16 * word + bit}"


def _read(memory: Any, cell: Cell) -> Value:
    value: Value = memory.read(cell.leaf, cell.index)
    return value if cell.mask is None else bool(int(value) & cell.mask)
