"""Where everything of a rung lies: wires, contacts, coils, boxes, names.

x runs to the right from the left power rail, y downwards. A part is measured first, then placed.

    Start       Run                      Run
  ──┤ ├──┬───────┤/├──┬───────────────────( )──
         └─ ...       ┘
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ..instructions import BY_NAME
from ..spec import Kind
from ..tree import Branch, Element, Instruction, Rung, Series, instructions_of
from .marks import Box, Corner, Picture, Symbol, Wire
from .ruler import GAP, JOIN, SYMBOLS, Block, Line, Ruler, is_symbol

NO_CAPTIONS: Mapping[str, Sequence[str]] = MappingProxyType({})
"""Captions where no add-on instruction is known."""


def lay_out(
    rung: Rung,
    width: int,
    truth: Sequence[bool] | None = None,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
) -> Picture:
    """Place a rung.

    Args:
        rung: the rung.
        width: columns between the rails that it keeps to, unless a name or many branches in one another
            take more.
        truth: whether there is power behind each instruction, in the order in which they execute.
        captions: what the operands of add-on instructions are called, see `captions_of`.

    Raises:
        ValueError: `truth` is not as long as the rung has instructions.
    """
    return _Placer(rung.series, width, truth, Ruler(captions)).picture


class _Placer:
    """Places the elements of one rung, from left to right."""

    def __init__(self, series: Series, width: int, truth: Sequence[bool] | None, ruler: Ruler) -> None:
        self.picture = Picture()
        self._ruler = ruler
        count = sum(1 for _ in instructions_of(series))
        if truth is not None and len(truth) != count:
            raise ValueError(f"the rung has {count} instructions, {len(truth)} truths are given")
        self._truth = iter(truth) if truth is not None else None
        block = self._ruler.block(series, width)
        self.picture.width = max(width, block.width)
        live: bool | None = None if truth is None else True
        for number, line in enumerate(block.lines):
            last = number == len(block.lines) - 1
            live = self._line(line, block.room, live, first=number == 0, last=last)

    def _line(
        self, line: Line, room: int | None, live: bool | None, *, first: bool, last: bool
    ) -> bool | None:
        """Place what stands in one line; outputs that end the rung stand at the right rail."""
        picture = self.picture
        y = picture.rows + line.size.above
        picture.rows += line.size.above + 1 + line.size.below
        if first:
            picture.left.append(y)
        else:
            picture.continued.append((0, y))
        inputs = _leading_inputs(line.series) if last else len(line.series)
        x, live = self._elements(line.series[:inputs], 0 if first else 1, y, live, room)
        outputs = line.series[inputs:]
        start = picture.width - sum(self._ruler.size(element, room).width for element in outputs)
        self._wire(x, y, start - 1, live)
        _, live = self._elements(outputs, start, y, live, room)
        if last:
            picture.right.append(y)
        else:
            picture.continued.append((picture.width - 1, y))
        return live

    def _elements(
        self, elements: Series, x: int, y: int, live: bool | None, room: int | None
    ) -> tuple[int, bool | None]:
        """Place elements behind each other; return the column and the power behind them."""
        for element in elements:
            live = self._element(element, x, y, live, room)
            x += self._ruler.size(element, room).width
        return x, live

    def _wire(self, x: int, y: int, to_x: int, live: bool | None) -> None:
        if to_x >= x:
            self.picture.marks.append(Wire(x, y, to_x, y, live))

    def _element(self, element: Element, x: int, y: int, live: bool | None, room: int | None) -> bool | None:
        if isinstance(element, Branch):
            return self._branch(element, x, y, live, room)
        behind = None if self._truth is None else next(self._truth)
        width = self._ruler.size(element, room).width
        if is_symbol(element):
            self._symbol(element, x, y, width, live, behind)
            return behind
        self._wire(x, y, x + GAP - 1, live)
        self.picture.marks.append(
            Box(x + GAP, y, width - 2 * GAP, element.name, self._ruler.lines(element, room), behind)
        )
        self._wire(x + width - GAP, y, x + width - 1, behind)
        return behind

    def _symbol(
        self, element: Instruction, x: int, y: int, width: int, live: bool | None, behind: bool | None
    ) -> None:
        sign, name = SYMBOLS[element.name], str(element.operands[0])
        at = x + (width - len(sign)) // 2
        self._wire(x, y, at - 1, live)
        self._wire(at + len(sign), y, x + width - 1, behind)
        self.picture.marks.append(Symbol(at, y, sign, name, x + (width - len(name)) // 2, live, behind))

    def _branch(self, branch: Branch, x: int, y: int, live: bool | None, room: int | None) -> bool | None:
        """Place a branch: a leg leaves the left wire at its first line, its last one meets the right wire."""
        width = self._ruler.size(branch, room).width
        behind: list[bool | None] = []
        entries: list[int] = []
        exits: list[int] = []
        row = y
        for leg in self._ruler.legs(branch, room):
            row += leg.size.above if entries else 0
            entries.append(row)
            exits.append(row + leg.rows[-1])
            behind.append(self._leg(leg, x + JOIN, row, width - 2 * JOIN, live))
            row += leg.size.below + 1
        out = None if None in behind else any(behind)
        marks = self.picture.marks
        right = x + width - 1
        marks += [Wire(x, y, x, entries[-1], live), Wire(right, y, right, exits[-1], out)]
        marks += [Corner(x, each, True, live) for each in entries[1:]]
        marks += [Corner(right, each, False, out) for each in exits if each != y]
        self._wire(x, y, x, live)
        if y in exits:
            self._wire(right, y, right, out)
        else:  # the first leg goes on below: nothing arrives here from the left
            marks.append(Corner(right, y, True, out))
        return out

    def _leg(self, leg: Block, x: int, y: int, width: int, live: bool | None) -> bool | None:
        """Place the lines of a leg in so many columns; return the power behind it."""
        last = len(leg.lines) - 1
        for number, (line, row) in enumerate(zip(leg.lines, leg.rows, strict=True)):
            if number > 0:
                self.picture.continued.append((x, y + row))
            at, live = self._elements(line.series, x + (number > 0), y + row, live, leg.room)
            end = x + width - 1 - (number < last)
            self._wire(at, y + row, end, live)
            if number < last:
                self.picture.continued.append((end + 1, y + row))
        return live


def _leading_inputs(series: Series) -> int:
    """Number of elements up to where only outputs follow."""
    count = len(series)
    while count and all(map(_is_output, instructions_of((series[count - 1],)))):
        count -= 1
    return count


def _is_output(instruction: Instruction) -> bool:
    spec = BY_NAME.get(instruction.name)
    return spec is None or spec.kind is not Kind.INPUT
