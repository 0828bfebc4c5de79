"""Where everything of a rung lies: wires, contacts, coils, boxes, names.

x runs to the right from the left power rail, y downwards. A part is measured first, then placed.

    Start       Run                      Run
  ──┤ ├──┬───────┤/├──┬───────────────────( )──
         └─ ...       ┘
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ..instructions import BY_NAME, Kind
from ..tree import Branch, Element, Instruction, Rung, Series, instructions_of
from .marks import Box, Corner, Picture, Symbol, Wire
from .ruler import GAP, JOIN, SYMBOLS, Ruler, is_symbol

NO_CAPTIONS: Mapping[str, Sequence[str]] = MappingProxyType({})
"""Captions where no add-on instruction is known."""

MARKS = 2
"""Columns of a line that the marks take which show that a wire goes on, one on either side."""


def lay_out(
    rung: Rung,
    width: int,
    truth: Sequence[bool] | None = None,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
) -> Picture:
    """Place a rung.

    Args:
        rung: the rung.
        width: columns between the rails that it should keep to; a branch that is wider gets its columns.
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
        whole = self._ruler.series(series).width <= width
        chunks = [series] if whole else list(self._ruler.chunks(series, width - MARKS))
        widest = max(self._ruler.series(chunk).width for chunk in chunks)
        self.picture.width = max(width, widest + (0 if len(chunks) == 1 else MARKS))
        live: bool | None = None if truth is None else True
        for number, chunk in enumerate(chunks):
            live = self._line(chunk, live, first=number == 0, last=number == len(chunks) - 1)

    def _line(self, chunk: Series, live: bool | None, *, first: bool, last: bool) -> bool | None:
        """Place what stands in one line; outputs that end the rung stand at the right rail."""
        picture = self.picture
        size = self._ruler.series(chunk)
        y = picture.rows + size.above
        picture.rows += size.above + 1 + size.below
        if first:
            picture.left.append(y)
        else:
            picture.continued.append((0, y))
        inputs = _leading_inputs(chunk) if last else len(chunk)
        x = 0 if first else 1
        for element in chunk[:inputs]:
            live = self._element(element, x, y, live)
            x += self._ruler.size(element).width
        rest = sum(self._ruler.size(element).width for element in chunk[inputs:])
        self._wire(x, y, picture.width - rest - 1, live)
        x = picture.width - rest
        for element in chunk[inputs:]:
            live = self._element(element, x, y, live)
            x += self._ruler.size(element).width
        if last:
            picture.right.append(y)
        else:
            picture.continued.append((picture.width - 1, y))
        return live

    def _wire(self, x: int, y: int, to_x: int, live: bool | None) -> None:
        if to_x >= x:
            self.picture.marks.append(Wire(x, y, to_x, y, live))

    def _element(self, element: Element, x: int, y: int, live: bool | None) -> bool | None:
        if isinstance(element, Branch):
            return self._branch(element, x, y, live)
        behind = None if self._truth is None else next(self._truth)
        width = self._ruler.size(element).width
        if is_symbol(element):
            self._symbol(element, x, y, width, live, behind)
            return behind
        self._wire(x, y, x + GAP - 1, live)
        self.picture.marks.append(
            Box(x + GAP, y, width - 2 * GAP, element.name, self._ruler.lines(element), behind)
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

    def _branch(self, branch: Branch, x: int, y: int, live: bool | None) -> bool | None:
        width = self._ruler.size(branch).width
        rows = self._ruler.leg_rows(branch, y)
        behind: list[bool | None] = []
        for leg, row in zip(branch.legs, rows, strict=True):
            at, power = x + JOIN, live
            for element in leg:
                power = self._element(element, at, row, power)
                at += self._ruler.size(element).width
            self._wire(at, row, x + width - JOIN - 1, power)
            behind.append(power)
        out = None if None in behind else any(behind)
        for at, opens, power in ((x, True, live), (x + width - 1, False, out)):
            self.picture.marks.append(Wire(at, y, at, rows[-1], power))
            self.picture.marks += [Corner(at, row, opens, power) for row in rows[1:]]
        self._wire(x, y, x, live)
        self._wire(x + width - 1, y, x + width - 1, out)
        return out


def _leading_inputs(series: Series) -> int:
    """Number of elements up to where only outputs follow."""
    count = len(series)
    while count and all(map(_is_output, instructions_of((series[count - 1],)))):
        count -= 1
    return count


def _is_output(instruction: Instruction) -> bool:
    spec = BY_NAME.get(instruction.name)
    return spec is None or spec.kind is not Kind.INPUT
