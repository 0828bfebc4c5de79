"""What it would take: the smallest sets of inputs that give a tag a value, found by running scans with them.

The program is copied as it is after a scan, the inputs are held as they are then, and some are changed: bits
of input images, and bits that no rung writes. Sets of one input are tried first, then of two and three.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import combinations, islice
from typing import Any

from ..model.errors import LadderFault
from ..model.operands import Constant, Group, Place
from ..state.memory import Value
from .cells import Cell, cell_of
from .crossref import CrossReference, Mention, overlap
from .replay import Replayer, restore, snapshot
from .watched import shown
from .watching import WatchedEngine

MOST_INPUTS = 3
"""Most inputs of a set."""

MOST_TRIES = 3_000
"""Most sets that are tried."""

MOST_CANDIDATES = 64
"""Most inputs that are tried, the ones nearest to the tag."""

Name = Callable[[int, int, int], str | None]
"""Names the terminal at slot, word and bit of an input image; None for a bit that is none."""


@dataclass(frozen=True, slots=True)
class InputChange:
    """An input and its other value."""

    cell: Cell
    name: str
    place: str  # in the rack, such as `slot 2 input 3`; "" for a tag
    value: bool

    def __str__(self) -> str:
        at = f" ({self.place})" if self.place else ""
        return f"{self.name}{at} goes {'on' if self.value else 'off'}"


@dataclass(frozen=True, slots=True)
class Remedy:
    """A set of inputs that gives the value; none if it comes by itself."""

    changes: tuple[InputChange, ...]
    scans: int  # until then


@dataclass(frozen=True, slots=True)
class Remedies:
    """The answer to a question.

    Attributes:
        tried: number of sets that were tried.
        left: whether sets of up to `MOST_INPUTS` were left out.
    """

    tag: str
    wanted: Value
    found: tuple[Remedy, ...]
    candidates: tuple[str, ...]
    tried: int
    left: bool

    def __str__(self) -> str:
        if self.found:
            is_bit = isinstance(self.wanted, bool)
            what = ("goes off", "comes on")[int(self.wanted)] if is_bit else f"becomes {self.wanted}"
            return "\n".join(f"{self.tag} {what} {_condition(each)}" for each in self.found)
        if not self.candidates:
            return f"{self.tag} depends on no input"
        some = f"none of the first {self.tried} sets" if self.left else f"no set of up to {MOST_INPUTS}"
        of = f"of the inputs it depends on gives it {shown(self.wanted)}"
        return f"{self.tag}: {some} {of}: {', '.join(self.candidates)}"

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        sets = [
            {
                "scans": each.scans,
                "inputs": [
                    {"name": one.name, "place": one.place, "value": one.value} for one in each.changes
                ],
            }
            for each in self.found
        ]
        return {"wanted": self.wanted, "sets": sets, "tried": self.tried, "complete": not self.left}


@dataclass(slots=True)
class Trials:
    """Runs scans on a copy of a program.

    Args:
        live: the program, between two scans.
        past: runs its scans again, on a memory of its own.
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

    def of(self, tag: str, cell: Cell, wanted: Value) -> Remedies:
        """Return the smallest sets of inputs after which a tag has a value; `cell` is the tag's."""
        self._begin()
        candidates = list(islice(self.candidates(tag), MOST_CANDIDATES))
        found: list[Remedy] = []
        tried = 0
        for size in range(MOST_INPUTS + 1):
            for each in combinations(candidates, size):
                if any(set(known.changes) <= set(each) for known in found):
                    continue
                if tried == MOST_TRIES:
                    return self._told(tag, wanted, found, candidates, tried, left=True)
                tried += 1
                after = self._try(each, cell, wanted)
                if after is not None:
                    found.append(Remedy(each, after))
        return self._told(tag, wanted, found, candidates, tried, left=False)

    def _told(
        self,
        tag: str,
        wanted: Value,
        found: list[Remedy],
        candidates: Sequence[InputChange],
        tried: int,
        *,
        left: bool,
    ) -> Remedies:
        return Remedies(tag, wanted, tuple(found), tuple(each.name for each in candidates), tried, left)

    def _begin(self) -> None:
        memory, last = self.live.memory, self.live.scans - 1
        self._values = snapshot(memory)
        self._images = [bytes(memory.cells[leaf.ident].cell_contents) for leaf in self.past.images]
        before = self.past.inputs(last - 1) if last else None
        if before is not None:
            self._period_ns = self.live.now_ns - before.now_ns

    def _try(self, changes: Sequence[InputChange], cell: Cell, wanted: Value) -> int | None:
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
                at, mask = 2 * each.cell.index, each.cell.mask or 0
                word = int.from_bytes(data[at : at + 2], "little")
                data[at : at + 2] = (word | mask if each.value else word & ~mask).to_bytes(2, "little")
            else:
                self._set(each)
        for scan in range(1, self.scans + 1):
            for leaf, data in zip(images, contents, strict=True):
                engine.memory.cells[leaf.ident].cell_contents.cast("B")[:] = data
            with suppress(LadderFault):
                engine.do(self.live.now_ns + scan * self._period_ns, first=False)
            if _read(engine.memory, cell) == wanted:
                return scan
        return None

    def _set(self, change: InputChange) -> None:
        memory, cell = self.past.engine.memory, change.cell
        if cell.mask is None:
            memory.write(cell.leaf, cell.index, change.value)
            return
        word = int(memory.read(cell.leaf, cell.index))
        memory.write(cell.leaf, cell.index, word | cell.mask if change.value else word & ~cell.mask)

    # --- inputs that may matter

    def candidates(self, tag: str) -> Iterator[InputChange]:
        """Yield the inputs that a tag depends on by the text of the program, the nearest first."""
        mentions = self.cross_reference.mentions
        by_line: dict[tuple[str, int | None], list[Mention]] = {}
        for each in mentions:
            by_line.setdefault((each.site.routine, each.site.rung), []).append(each)
        written = [each for each in mentions if each.writes]
        wanted: list[Place | Group] = [each.where for each in self.cross_reference.of(tag) if each.writes]
        seen: set[str] = set()
        while wanted:
            where = wanted.pop(0)
            lines = {
                (each.site.routine, each.site.rung)
                for each in written
                if overlap(where, each.where, stretch=True)
            }
            for key in sorted(lines, key=str):
                for each in by_line[key]:
                    if each.reads and each.where.text not in seen:
                        seen.add(each.where.text)
                        wanted.append(each.where)
                        yield from self._change(each.where, written)

    def _change(self, where: Place | Group, written: Sequence[Mention]) -> Iterator[InputChange]:
        if not isinstance(where, Place) or where.can_fault or not where.type.is_bool:
            return
        cell, leaf = cell_of(where), where.leaf
        value = not _read(self.live.memory, cell)
        if leaf.is_image and not leaf.output:
            bit = int(where.bit.value) if isinstance(where.bit, Constant) else 0
            named = self.name(leaf.slot or 0, cell.index, bit)
            if named is not None:
                yield InputChange(cell, where.text, named, value)
        elif leaf.slot is None and not leaf.path.startswith(("S:", "~")):
            writers = (each for each in written if overlap(where, each.where, stretch=True))
            if next(writers, None) is None:
                yield InputChange(cell, where.text, "", value)


def terminal(slot: int, word: int, bit: int) -> str:
    """Return the place of an input bit as text."""
    return f"slot {slot} input {16 * word + bit}"


def _read(memory: Any, cell: Cell) -> Value:
    value: Value = memory.read(cell.leaf, cell.index)
    return value if cell.mask is None else bool(int(value) & cell.mask)


def _condition(remedy: Remedy) -> str:
    after = "" if remedy.scans == 1 else f", after {remedy.scans} scans"
    if not remedy.changes:
        return f"by itself{after}"
    return f"if {' and '.join(map(str, remedy.changes))}{after}"
