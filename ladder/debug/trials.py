"""Tries different inputs on a copy of a ladder program, for `remedies`.

The copy starts in the program's state after a scan. Inputs are terminals of input images, and tags that no
rung writes. All inputs except the changed ones keep the values that they had in that scan.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from itertools import islice
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..model.arithmetic import wrap
from ..model.operands import Calculation, Constant, Group, Place
from ..state.memory import Value
from ..state.snapshots import restore, snapshot
from .cells import Cell, cell_of
from .crossref import CrossReference, Mention, overlap
from .remedies import MOST_CANDIDATES, Candidate, InputChange, Remedies, Search, bit, number
from .replay import Replayer, image_bytes, repeat
from .stretch import ScanInputs
from .watching import WatchedEngine

Name = Callable[[int, int, int | None], str | None]
"""Returns the name of the terminal at a slot, word and bit (None for the whole word), or None."""


@dataclass(slots=True)
class Trials:
    """Runs scans on a copy of a program.

    Args:
        live: the program, between two scans.
        past: repeats the program's scans in separate memory.
        name: names the terminals of input images.
        scans: maximum length of a try, in scans.
    """

    live: WatchedEngine
    past: Replayer
    cross_reference: CrossReference
    name: Name
    scans: int = 10
    _values: Mapping[str, Any] = field(default_factory=dict)
    _images: Sequence[bytes] = ()
    _period_ns: int = 10_000_000

    def remedies_for(self, tag: str, cell: Cell, requested: Value) -> Remedies:
        """Return the smallest sets of inputs that set a tag, stored in `cell`, to a value.

        Other values that modules report are tried only if no set of terminals and tags works.
        """
        self._begin()
        search = Search(tag, requested, lambda changes: self._try(changes, cell, requested))
        unreported: list[Candidate] = []
        reported: list[Candidate] = []
        for candidate in islice(self.candidates(tag, requested), MOST_CANDIDATES):
            (reported if candidate.place.endswith(REPORTED) else unreported).append(candidate)
        remedies = search.among(unreported)
        return remedies if remedies.found or not reported else search.among([*unreported, *reported])

    def _begin(self) -> None:
        """Save the program's state, inputs and scan period; every try begins with them."""
        memory, last = self.live.memory, self.live.scans - 1
        self._values = snapshot(memory)
        self._images = [bytes(memory.cells[leaf.ident].cell_contents) for leaf in self.past.images]
        previous = self.past.inputs(last - 1) if last else None
        if previous is not None:
            self._period_ns = self.live.now_ns - previous.now_ns

    def _try(self, changes: Sequence[InputChange], cell: Cell, requested: Value) -> int | None:
        """Run scans with changed inputs; return the number of scans until a cell had a value, or None."""
        engine = self.past.engine
        engine.hold({})
        restore(engine.memory, self._values)
        engine.watching = False
        engine.note(())
        engine.hold(self.live.memory.forces)
        self.past.at = None
        images = self.past.images
        contents = [bytearray(image) for image in self._images]
        for change in changes:
            if change.cell.leaf.is_image:
                data = contents[[leaf.ident for leaf in images].index(change.cell.leaf.ident)]
                offset = 2 * change.cell.index
                word = int.from_bytes(data[offset : offset + 2], "little")
                data[offset : offset + 2] = _merged(word, change).to_bytes(2, "little")
            else:
                self._set(change)
        memory_images, changed_images = image_bytes(engine.memory), list(map(bytes, contents))
        for scan in range(1, self.scans + 1):
            now_ns = self.live.now_ns + scan * self._period_ns
            repeat(engine, memory_images, ScanInputs(now_ns, first=False, images=changed_images))
            if cell.read(engine.memory) == requested:
                return scan
        return None

    def _set(self, change: InputChange) -> None:
        """Set a tag, or a bit of a tag, in the copy."""
        memory, cell = self.past.engine.memory, change.cell
        if cell.mask is None:
            memory.write(cell.leaf, cell.index, change.value)
        else:
            bits = cell.leaf.type.wraps
            word = _merged(int(memory.read(cell.leaf, cell.index)), change)
            memory.write(cell.leaf, cell.index, wrap(word, bits))

    # --- candidates

    def candidates(self, tag: str, requested: Value) -> Iterator[Candidate]:
        """Yield the inputs that a tag depends on according to the program's code, nearest first."""
        compared = [] if isinstance(requested, bool) else [requested]
        operands_read: dict[str, Place | Group] = {}
        reads = self._reads()
        pending: list[Place | Group] = [
            mention.where for mention in self.cross_reference.of(tag) if mention.writes
        ]
        while pending:
            for line in self._lines_writing(pending.pop(0)):
                compared += self._constants(*line)
                for operand in reads[line]:
                    if operand.text not in operands_read:
                        operands_read[operand.text] = operand
                        pending.append(operand)
        for operand in operands_read.values():
            yield from self._candidate(operand, compared)

    def _reads(self) -> Mapping[_Line, list[Place | Group]]:
        """Return the operands that each rung or line reads, by routine and number."""
        by_line = defaultdict[_Line, list[Place | Group]](list)
        for mention in self.cross_reference.mentions:
            if mention.reads:
                by_line[_line_of(mention)].append(mention.where)
        return by_line

    def _lines_writing(self, operand: Place | Group) -> list[_Line]:
        """Return the rungs and lines that may write an operand."""
        writers = [mention for mention in self.cross_reference.mentions if mention.writes]
        lines = {_line_of(writer) for writer in writers if overlap(operand, writer.where, stretch=True)}
        return sorted(lines, key=str)

    def _constants(self, routine: str, rung: int | None) -> Iterator[float]:
        """Yield the numbers in a rung or line."""
        logic = self.live.lowered.routines.get(routine.upper())
        for line in logic.lines if logic is not None else ():
            if line.number == rung:
                yield from (value for step in line.steps for value in _numbers(step.operands))

    def _candidate(self, operand: Place | Group, compared: Sequence[float]) -> Iterator[Candidate]:
        """Yield an operand as a candidate if it is an input."""
        if not isinstance(operand, Place) or operand.can_fault:
            return
        cell, kind, place = cell_of(operand), operand.leaf.type, self._input_place(operand)
        current = cell.read(self.live.memory)
        if place is not None and isinstance(current, bool):
            yield bit(cell, operand.text, place, current)
        elif place is not None:
            limits = (-FARTHEST, FARTHEST) if isinstance(current, float) else (kind.lowest, kind.highest)
            yield number(cell, operand.text, place, current, limits, compared)

    def _input_place(self, operand: Place) -> str | None:
        """Return an input's place in the rack; "" for a tag that no rung writes, None for other operands."""
        leaf = operand.leaf
        if leaf.is_image and not leaf.output:
            bit_number = int(operand.bit.value) if isinstance(operand.bit, Constant) else None
            place = self.name(leaf.slot or 0, operand.fixed_index or 0, bit_number)
            return f"slot {leaf.slot}{REPORTED}" if place is None else place
        is_tag = leaf.slot is None and not leaf.path.startswith(("S:", "~"))
        return "" if is_tag and not self._lines_writing(operand) else None


_Line = tuple[str, int | None]
"""Routine and number of a rung or line."""


def _line_of(mention: Mention) -> _Line:
    return mention.site.routine, mention.site.rung


REPORTED = ", as the module reports it"
"""Suffix of the place of an input that is not a terminal."""

FARTHEST = 1e6
"""Largest REAL that is tried."""


def _numbers(operands: Iterable[Any]) -> Iterator[float]:
    """Yield the constants in operands, including constants in calculations."""
    for operand in operands:
        if isinstance(operand, Constant):
            yield operand.value
        elif isinstance(operand, Calculation):
            yield from _numbers(operand.operands)


def _merged(word: int, change: InputChange) -> int:
    """Return a word with a changed input, as a nonnegative number."""
    mask: int | None = change.cell.mask
    if mask is None:
        return int(change.value) & 0xFFFF
    return word | mask if change.value else word & ~mask


def terminal(slot: int, word: int, bit: int | None) -> str:
    """Return the place of an input bit or word as text."""
    return f"slot {slot} input word {word}" if bit is None else f"slot {slot} input {16 * word + bit}"
