"""Marks as lines, curves, frames and letters. Cells are 1 by 1, centered at whole numbers; y points down."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from scanrack.io_images.dataclass import dataclass

from .marks import Box, Corner, Mark, Picture, Symbol, Wire
from .ruler import caption_width

HEADING = 0.92
"""Rows from a box's heading to its first line; at a full row, the frame would touch the heading."""

NEXT_TO = 0.4
"""Columns between a sign and its value."""


@dataclass(frozen=True, slots=True)
class Line:
    """A straight line from one point to another."""

    x: float
    y: float
    to_x: float
    to_y: float


@dataclass(frozen=True, slots=True)
class Curve:
    """Half of a coil: an upright arc at a point that bends to one side."""

    x: float
    y: float
    bend: float


@dataclass(frozen=True, slots=True)
class BoxFrame:
    """The frame of a box: its upper left corner and its size."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Letters:
    """A text that starts in a given cell."""

    x: float
    y: float
    text: str


@dataclass(frozen=True, slots=True)
class Value:
    """The place of a tag's value: next to a symbol, below its wire, or at the right edge of a box."""

    x: float  # column of its beginning or end
    y: float
    name: str
    beside: bool  # whether it is small, beside a symbol
    ends: bool  # whether it ends at `x`
    states: Sequence[tuple[str, str]] = ()  # texts that replace the value, see `BoxLine`


Form = Line | Curve | BoxFrame | Letters | Value


@dataclass(frozen=True, slots=True)
class Shape:
    """A form, its style class, and the element whose power it shows, or None."""

    form: Form
    kind: str
    element: int | None = None


def bottom_of(picture: Picture) -> float:
    """Return the lowest row of a picture."""
    return max((_bottom(shape) for mark in picture.marks for shape in shapes_of(mark)), default=0.0)


def _bottom(shape: Shape) -> float:
    """Return the lowest row that a shape covers."""
    form = shape.form
    if isinstance(form, Line):
        return max(form.y, form.to_y)
    if isinstance(form, BoxFrame):
        return form.y + form.height - 0.5
    return form.y + (0.4 if isinstance(form, Curve | Value) else 0)


def shapes_of(mark: Mark) -> Iterator[Shape]:
    """Yield the shapes of a mark."""
    yield from _SHAPES[type(mark)](mark)


def _wire(wire: Wire) -> Iterator[Shape]:
    """Yield a wire; a horizontal wire reaches the outer edges of its end cells."""
    reach = 0.5 if wire.y == wire.to_y else 0
    yield Shape(Line(wire.x - reach, wire.y, wire.to_x + reach, wire.to_y), "wire", wire.element)


def _corner(corner: Corner) -> Iterator[Shape]:
    """Yield the half of a cell's wire that leads to a leg."""
    to_x = corner.x + (0.5 if corner.opens else -0.5)
    yield Shape(Line(corner.x, corner.y, to_x, corner.y), "wire", corner.element)


def _symbol(symbol: Symbol) -> Iterator[Shape]:
    """Yield the name, wire and sides of a contact or coil, then the sign inside and the value if any."""
    x, y, width, element = symbol.x - 0.5, symbol.y, len(symbol.sign), symbol.element
    left, right = x + 0.75, x + width - 0.75
    yield Shape(Letters(symbol.label_x, y - 1, symbol.name), "name")
    yield Shape(Line(x, y, left, y), "wire", symbol.feeder)
    yield Shape(Line(right, y, x + width, y), "sign", element)
    if symbol.sign.startswith("("):
        yield Shape(Curve(left, y, -0.7), "sign", element)
        yield Shape(Curve(right, y, 0.7), "sign", element)
    else:
        yield from (Shape(Line(edge, y - 0.4, edge, y + 0.4), "sign", element) for edge in (left, right))
    inner = symbol.sign[1:-1].strip()
    if inner == "/":
        yield Shape(Line(right, y - 0.4, left, y + 0.4), "sign", element)
    elif inner:
        yield Shape(Letters(x + (width - len(inner)) / 2 + 0.5, y, inner), "mark", element)
    if symbol.value is not None:
        yield Shape(_value_of(symbol, left, right), "value")


def _value_of(symbol: Symbol, left: float, right: float) -> Value:
    """Place a value on free wire: after a contact, before a coil."""
    if symbol.sign.startswith("("):
        return Value(left - 2 * NEXT_TO, symbol.y, symbol.value or "", beside=True, ends=True)
    return Value(right + NEXT_TO, symbol.y, symbol.value or "", beside=True, ends=False)


def _box(box: Box) -> Iterator[Shape]:
    """Yield the frame, heading and lines of a box; a line ends with its state, value or operand."""
    rows, end = max(len(box.lines), 1), box.x + box.width - 2
    yield Shape(BoxFrame(box.x, box.y - 0.95, box.width, rows + 1.05), "box", box.element)
    title_x = box.x + (2 if box.states else (box.width - len(box.title)) / 2)
    yield Shape(Letters(title_x, box.y - HEADING, box.title), "heading")
    if box.states:
        yield Shape(
            Value(end - 0.5, box.y - HEADING, "", beside=False, ends=True, states=box.states),
            "value",
        )
    captions = caption_width(box.lines)
    for y, (caption, operand, value, states) in enumerate(box.lines, box.y):
        yield Shape(Letters(box.x + 2, y, caption), "caption")
        if states:
            yield Shape(Value(box.x + 1.5, y, "", beside=False, ends=False, states=states), "value")
        elif value is not None:
            yield Shape(Value(end - 0.5, y, value, beside=False, ends=True), "value")
        else:
            yield Shape(Letters(end - len(operand) if captions else box.x + 2, y, operand), "operand")


_SHAPES: Mapping[type, Callable[[Any], Iterator[Shape]]] = {
    Wire: _wire,
    Corner: _corner,
    Symbol: _symbol,
    Box: _box,
}
