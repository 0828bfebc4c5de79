"""Sizes of a rung's parts: columns, and rows above and below the wire.

Contacts and coils have their name above the wire. Every other instruction is a box with its name in the top
edge and one operand per line; the wire meets the first line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.dataclass import dataclass

from ..instructions import SPECS
from ..lowering.runnable import LadderLogic
from ..model.spec import Spec
from ..model.tree import Branch, Element, Instruction, Series
from .marks import BoxLine

SYMBOLS = {spec.name: spec.symbol for spec in SPECS if spec.symbol}
"""Symbols of contacts and coils, which have one operand above."""

_OF_MEMBERS = {"PRE": "Preset", "ACC": "Accum", "LEN": "Length", "POS": "Position"}


def _captions(spec: Spec) -> tuple[str, ...]:
    """Return the captions of an instruction's operands, or the names of shown members if it has none."""
    shown = {index: _OF_MEMBERS.get(member, member) for index, (_, member) in spec.members.items()}
    return spec.captions or tuple(shown.get(index, "") for index in range(max(shown, default=-1) + 1))


CAPTIONS = {spec.name: _captions(spec) for spec in SPECS}
"""Captions of the operands in a box, by instruction."""

GAP = 1
"""Columns of wire on either side of an instruction."""

JOIN = 1
"""Columns for a branch's vertical wire on either side."""

MARKS = 2
"""Columns for the marks where a series is broken into lines."""

NARROWEST = 12
"""Minimum columns of a branch leg, at any depth."""

SHORTEST = 8
"""Minimum characters of an operand's line."""

_PIECE = re.compile(r"[^-+*/,.()\[\] =<>]+|.")  # unbreakable piece of an operand: a word or a sign


@dataclass(frozen=True, slots=True)
class Size:
    """Size of a part: columns, and rows above and below its wire."""

    width: int
    above: int
    below: int


@dataclass(frozen=True, slots=True)
class LineLayout:
    """The elements of one line, and their size."""

    series: Series
    size: Size


@dataclass(frozen=True, slots=True)
class SeriesLayout:
    """A series in one or several lines; `room` is the number of columns available per element."""

    lines: tuple[LineLayout, ...]
    room: int | None

    @property
    def width(self) -> int:
        """The number of columns, including marks."""
        last = len(self.lines) - 1
        return max(line.size.width + (index > 0) + (index < last) for index, line in enumerate(self.lines))

    @property
    def rows(self) -> list[int]:
        """The rows of the lines' wires, counted from the first wire."""
        rows = [0]
        for line, next_line in zip(self.lines, self.lines[1:], strict=False):
            rows.append(rows[-1] + line.size.below + 1 + next_line.size.above)
        return rows

    @property
    def size(self) -> Size:
        """The total size, above and below the first wire."""
        return Size(self.width, self.lines[0].size.above, self.rows[-1] + self.lines[-1].size.below)


def captions_of(program: LadderLogic) -> dict[str, tuple[str, ...]]:
    """Return operand captions by instruction, for the program's dialect and its add-on instructions."""
    builtin = {name: _captions(definition) for name, definition in program.builtin.items()}
    add_ons = program.add_ons.values()
    return builtin | {
        add_on.name: ("Instance", *(parameter.name for parameter in add_on.required)) for add_on in add_ons
    }


class Ruler:
    """Measures elements.

    Parts wider than `room` columns are broken: a series into lines, a branch within its legs, and the
    operands of a box into pieces.
    """

    def __init__(self, captions: Mapping[str, Sequence[str]]) -> None:
        self._captions = {**CAPTIONS, **captions}
        self._sizes: dict[tuple[int, int | None], Size] = {}
        self._measured: list[Element] = []

    def size(self, element: Element, room: int | None = None) -> Size:
        """Return the size of an element."""
        key = id(element), room
        if key not in self._sizes:
            self._measured.append(element)  # keeps the element alive, so that its id stays unique
            self._sizes[key] = self._size(element, room)
        return self._sizes[key]

    def _size(self, element: Element, room: int | None) -> Size:
        """Measure an element: a branch by its legs, a symbol by its name, a box by its lines."""
        if isinstance(element, Branch):
            legs = [leg.size for leg in self.legs(element, room)]
            width = max(leg.width for leg in legs) + 2 * JOIN
            below = legs[0].below + sum(leg.above + 1 + leg.below for leg in legs[1:])
            return Size(max(width, 2 * JOIN + 1), legs[0].above, below)
        if is_symbol(element):
            widest = max(len(str(element.operands[0])), len(SYMBOLS[element.name]))
            return Size(widest + 2 * GAP, 1, 0)
        lines = self.lines(element, room)
        caption = caption_width(lines)
        inner = max([len(element.name), *(caption + len(line.operand) for line in lines)])
        return Size(inner + 4 + 2 * GAP, 1, max(len(lines), 1))

    def legs(self, branch: Branch, room: int | None) -> list[SeriesLayout]:
        """Return the legs of a branch, broken to fit."""
        inner = None if room is None else max(room - 2 * JOIN, NARROWEST)
        return [self.block(leg, inner) for leg in branch.legs]

    def block(self, series: Series, room: int | None) -> SeriesLayout:
        """Break a series into lines if it is wider than the room."""
        single_line = self._line(series, None)
        if room is None or single_line.size.width <= room:
            return SeriesLayout((single_line,), None)
        inner = room - MARKS
        return SeriesLayout(
            tuple(self._line(elements, inner) for elements in self._broken(series, inner)), inner
        )

    def _line(self, series: Series, room: int | None) -> LineLayout:
        """Return a series as one line, which is as wide as all its elements and as high as the highest."""
        sizes = [self.size(element, room) for element in series]
        size = Size(
            sum(size.width for size in sizes),
            max((size.above for size in sizes), default=0),
            max((size.below for size in sizes), default=0),
        )
        return LineLayout(series, size)

    def _broken(self, series: Series, room: int) -> Iterator[Series]:
        """Split a series into lines; an element wider than the room gets a separate line."""
        line: list[Element] = []
        used = 0
        for element in series:
            width = self.size(element).width
            if line and used + width > room:
                yield tuple(line)
                line, used = [], 0
            line.append(element)
            used += width
        yield tuple(line)

    def lines(self, instruction: Instruction, room: int | None = None) -> tuple[BoxLine, ...]:
        """Return the lines of a box; a long operand is split into several lines."""
        captions = self._captions.get(instruction.name, ())
        missing = len(instruction.operands) - len(captions)
        all_captions = [*captions[: len(instruction.operands)], *[""] * missing]
        fixed_width = 4 + 2 * GAP + caption_width([BoxLine(caption, "") for caption in all_captions])
        longest = None if room is None else max(room - fixed_width, SHORTEST)
        entries = (
            self.entry(instruction, index, caption, longest) for index, caption in enumerate(all_captions)
        )
        return tuple(line for entry in entries for line in entry)

    def entry(
        self, instruction: Instruction, number: int, caption: str, longest: int | None
    ) -> list[BoxLine]:
        """Return the lines of one operand, at most `longest` characters each."""
        operand = str(instruction.operands[number])
        texts = [operand] if longest is None else pieces(operand, longest)
        return [BoxLine(caption if index == 0 else "", text) for index, text in enumerate(texts)]

    def states(self, instruction: Instruction) -> Sequence[tuple[str, str]]:
        """Return the conditions and texts of a block's state beside its title, see `block_states`."""
        return ()

    def value(self, instruction: Instruction) -> str | None:
        """Return the tag shown beside a contact or coil; None if there is none."""
        return None


def pieces(text: str, longest: int) -> list[str]:
    """Break a text into pieces, between words where possible.

    >>> pieces("Total*1000+Offset", 8)
    ['Total*', '1000+', 'Offset']
    """
    lines = [""]
    for word in _PIECE.findall(text):
        if len(lines[-1]) + len(word) > longest and lines[-1]:
            lines.append("")
        while len(word) > longest:
            lines[-1], word = word[:longest], word[longest:]
            lines.append("")
        lines[-1] += word
    return lines


def caption_width(lines: Sequence[BoxLine]) -> int:
    """Return the columns of a box's captions, including the space after them."""
    widest = max((len(line.caption) for line in lines), default=0)
    return widest + 1 if widest else 0


def is_symbol(instruction: Instruction) -> bool:
    """Return whether an instruction is drawn as a contact or a coil."""
    return instruction.name in SYMBOLS and len(instruction.operands) == 1
