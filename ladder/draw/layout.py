"""Layout of a rung: wires, contacts, coils, boxes and names.

The x axis points right from the left power rail, and the y axis points down. Parts are measured, then placed.

    Start       Run                      Run
  ──┤ ├──┬───────┤/├──┬───────────────────( )──
         └─ ...       ┘
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ..instructions import BY_NAME
from ..model.spec import InstructionKind
from ..model.tree import Branch, Element, Instruction, Rung, Series, instructions_of
from .marks import Box, Corner, Picture, Symbol, Wire
from .power import Numbering, power
from .ruler import GAP, JOIN, SYMBOLS, LineLayout, Ruler, SeriesLayout, is_symbol

NO_CAPTIONS: Mapping[str, Sequence[str]] = MappingProxyType({})
"""No captions, for programs without add-on instructions."""


def lay_out(
    rung: Rung,
    width: int,
    truth: Sequence[bool] | None = None,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
) -> Picture:
    """Place a rung with `width` columns between the rails, or more if names or nesting require it.

    Args:
        truth: see `power`.
    """
    picture = place(rung, width, Ruler(captions))
    picture.power = None if truth is None else power(rung, truth)
    return picture


def place(rung: Rung, width: int, ruler: Ruler) -> Picture:
    """Place a rung without power, using a ruler's sizes."""
    return _Placer(rung.series, width, ruler).picture


class _Placer:
    """Places the elements of a rung from left to right; `last` is the preceding element."""

    def __init__(self, series: Series, width: int, ruler: Ruler) -> None:
        self.picture = Picture()
        self._ruler = ruler
        self._numbering = Numbering(series)
        self.picture.elements = self._numbering.rail + 1
        block = self._ruler.block(series, width)
        self.picture.width = max(width, block.width)
        last = self._numbering.rail
        for number, line in enumerate(block.lines):
            ends = number == len(block.lines) - 1
            last = self._line(line, block.room, last, first=number == 0, ends=ends)
        self.picture.gaps.append((self.picture.width, self.picture.right[-1]))

    def _line(self, line: LineLayout, room: int | None, last: int, *, first: bool, ends: bool) -> int:
        """Place a line of the rung in the next row; return its last element.

        The trailing outputs of the rung's last line are at the right rail.
        """
        picture = self.picture
        y = picture.rows + line.size.above
        picture.rows += line.size.above + 1 + line.size.below
        if first:
            picture.left.append(y)
        else:
            picture.continued.append((0, y))
        inputs = _leading_inputs(line.series) if ends else len(line.series)
        x, last = self._elements(line.series[:inputs], 0 if first else 1, y, last, room)
        outputs = line.series[inputs:]
        start = picture.width - sum(self._ruler.size(element, room).width for element in outputs)
        self._wire(x, y, start - 1, last)
        gap_index = len(self.picture.gaps)
        _, last = self._elements(outputs, start, y, last, room)
        if outputs:
            self.picture.gaps[gap_index] = x, y  # an element inserted here becomes the last input
        if ends:
            picture.right.append(y)
        else:
            picture.continued.append((picture.width - 1, y))
        return last

    def _elements(self, elements: Series, x: int, y: int, last: int, room: int | None) -> tuple[int, int]:
        """Place elements in a line; return the next free column and the last element."""
        for element in elements:
            self.picture.gaps.append((x, y))
            last = self._element(element, x, y, last, room)
            x += self._ruler.size(element, room).width
        return x, last

    def _wire(self, x: int, y: int, to_x: int, last: int) -> None:
        """Add a horizontal wire if it is at least one column wide; it shows the power after `last`."""
        if to_x >= x:
            self.picture.marks.append(Wire(x, y, to_x, y, last))

    def _element(self, element: Element, x: int, y: int, last: int, room: int | None) -> int:
        """Place an element with its wires, beginning at a column; return its number."""
        if isinstance(element, Branch):
            return self._branch(element, x, y, last, room)
        number = self._numbering.instruction()
        width = self._ruler.size(element, room).width
        if is_symbol(element):
            self._symbol(element, x, y, width, last, number)
            return number
        self._wire(x, y, x + GAP - 1, last)
        self.picture.marks.append(
            Box(
                x=x + GAP,
                y=y,
                width=width - 2 * GAP,
                title=element.name,
                lines=self._ruler.lines(element, room),
                element=number,
                states=self._ruler.states(element),
            )
        )
        self._wire(x + width - GAP, y, x + width - 1, number)
        return number

    def _symbol(self, element: Instruction, x: int, y: int, width: int, last: int, number: int) -> None:
        """Place a contact or a coil, and its name above, in the middle of its columns."""
        sign, name = SYMBOLS[element.name], str(element.operands[0])
        column = x + (width - len(sign)) // 2
        self._wire(x, y, column - 1, last)
        self._wire(column + len(sign), y, x + width - 1, number)
        label_x = x + (width - len(name)) // 2
        value = self._ruler.value(element)
        self.picture.marks.append(
            Symbol(column, y, sign, name, label_x, element=number, feeder=last, value=value)
        )

    def _branch(self, branch: Branch, x: int, y: int, last: int, room: int | None) -> int:
        """Place a branch: its legs lead from the left vertical wire to the right one."""
        number = self._numbering.branch()
        width = self._ruler.size(branch, room).width
        entries: list[int] = []
        exits: list[int] = []
        row = y
        for leg in self._ruler.legs(branch, room):
            row += leg.size.above if entries else 0
            entries.append(row)
            exits.append(row + leg.rows[-1])
            self._leg(leg, x + JOIN, row, width - 2 * JOIN, last)
            row += leg.size.below + 1
        marks = self.picture.marks
        right = x + width - 1
        marks += [Wire(x, y, x, entries[-1], last), Wire(right, y, right, exits[-1], number)]
        marks += [Corner(x, entry, True, last) for entry in entries[1:]]
        marks += [Corner(right, exit_row, False, number) for exit_row in exits if exit_row != y]
        self._wire(x, y, x, last)
        if y in exits:
            self._wire(right, y, right, number)
        else:  # the first leg continues below, so no wire arrives here from the left
            marks.append(Corner(right, y, True, number))
        return number

    def _leg(self, leg: SeriesLayout, x: int, y: int, width: int, last: int) -> None:
        """Place the lines of a leg that is `width` columns wide."""
        below = len(leg.lines) - 1
        for number, (line, row) in enumerate(zip(leg.lines, leg.rows, strict=True)):
            if number > 0:
                self.picture.continued.append((x, y + row))
            mark_before, mark_after = number > 0, number < below  # each takes one column
            column, last = self._elements(line.series, x + mark_before, y + row, last, leg.room)
            end = x + width - 1 - mark_after
            self._wire(column, y + row, end, last)
            if mark_after:
                self.picture.continued.append((end + 1, y + row))
            else:
                self.picture.gaps.append((column, y + row))


def _leading_inputs(series: Series) -> int:
    """Return the number of elements before the trailing outputs."""
    count = len(series)
    while count and all(map(_is_output, instructions_of((series[count - 1],)))):
        count -= 1
    return count


def _is_output(instruction: Instruction) -> bool:
    """Return whether an instruction is not an input; an unknown instruction counts as an output."""
    spec = BY_NAME.get(instruction.name)
    return spec is None or spec.kind is not InstructionKind.INPUT
