"""A rung as SVG that is drawn once and then updated by a page; elements are numbered, see `power`.

    <g class="instruction" data-element="Main.3.0" data-tag="Start"> ... </g>
    <text class="value" data-name="Fill.ACC" ...></text>

An element's group has its symbol, its name and the wires after it. The page sets `data-power` of the groups
and fills in the values. Colors and fonts come from the page's style sheet.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.dataclass import dataclass
from typing_extensions import override

from ..instructions import BY_NAME
from ..model.spec import Spec
from ..model.tree import Address, Instruction, Operand, Rung, addresses_in, instructions_of
from .block_states import BESIDE, WIDE, BlockTexts, states_of
from .layout import NO_CAPTIONS, place
from .marks import BoxLine, Picture, Symbol
from .markup import CELL, Pen, TagName, attribute, plain, units
from .ruler import GAP, Ruler
from .shapes import BoxFrame, Curve, Letters, Line, Shape, Value, bottom_of, shapes_of

ROW = 22
"""Units per row, with room for a contact's value below the wire."""

VALUE = 12
"""Columns reserved for a value in a box."""

SHORT_LINE = len("TON 0.020 of 10.000 s")
"""Columns in a one-line box, which has its title and its state."""

HEAD, FOOT = 3, 10
"""Units above the first row and below the lowest mark."""

EDGE = 1
"""Columns outside each rail."""

SHORT = frozenset(("TON", "TOF", "RTO", "CTU", "CTD"))
"""Instructions drawn as a one-line box whose title shows their members."""


@dataclass(frozen=True, slots=True)
class LiveRung:
    """A rung for a page: its SVG, the number of elements, and the tags that it shows or uses.

    `gaps` are the points in the SVG where an element can be inserted, in the order of the rung's text: before
    each element of a series, and after the last element.
    """

    svg: str
    elements: int
    names: tuple[str, ...]
    gaps: tuple[tuple[float, float], ...] = ()


def live_rung(
    rung: Rung,
    ident: str,
    width: int,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
    name_of: TagName = str,
    *,
    specs: Mapping[str, Spec] = BY_NAME,
    operands: bool = False,
) -> LiveRung:
    """Draw a rung for a page.

    Args:
        ident: prefix of its element ids: `Main.3` for rung 3 of routine Main.
        name_of: returns the tag of an address.
        specs: instructions of the program's dialect.
        operands: whether blocks that show their state also show their operands.
    """
    instructions = tuple(instructions_of(rung.series))
    ruler = _ValueRuler(captions, name_of, specs, operands=operands)
    picture = place(rung, width, ruler)
    groups = [_Group() for _ in range(picture.elements)]
    for mark in picture.marks:
        if isinstance(mark, Symbol):
            groups[mark.element].add(_reach(mark))
        for shape in shapes_of(mark):
            groups[mark.element if shape.element is None else shape.element].add(shape)
    svg = [_rails(picture)]
    for number, group in enumerate(groups):
        attributes = f" data-element={attribute(f'{ident}.{number}')}"
        title = ""
        if number < len(instructions):
            attributes += f' class="instruction"{ruler.attributes(instructions[number])}'
            title = f"<title>{plain(str(instructions[number]))}</title>"
        svg.append(f"<g{attributes}>{title}{group.markup()}</g>")
    names = dict.fromkeys(name for instruction in instructions for name in ruler.names(instruction))
    gaps = tuple(((x + EDGE) * CELL, (y + 0.5) * ROW) for x, y in picture.gaps)
    return LiveRung(_document(picture, ident, str(rung), "".join(svg)), len(groups), tuple(names), gaps)


def _reach(symbol: Symbol) -> Shape:
    """Return the clickable area of a symbol, which extends to its neighbors. A box uses its frame."""
    sign_x, label_x = symbol.x - 0.5, symbol.label_x
    start = min(sign_x, label_x) - GAP
    end = max(sign_x + len(symbol.sign), label_x + len(symbol.name)) + GAP
    return Shape(BoxFrame(start, symbol.y - 1, end - start, 2), "hit")


def _document(picture: Picture, ident: str, text: str, content: str) -> str:
    width, high = units((picture.width + 2 * EDGE) * CELL), _height(picture)
    labels = f'data-rung={attribute(ident)} role="group" aria-label={attribute(text)}'
    size = f'viewBox="0 -{HEAD} {width} {high}" width="{width}" height="{high}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" class="rung" {labels} {size}>{content}</svg>'


def _height(picture: Picture) -> str:
    """Return the height of the marks with a margin, but without an empty row below a box."""
    return units(HEAD + (bottom_of(picture) + 0.5) * ROW + FOOT)


def _rails(picture: Picture) -> str:
    """Return both rails, and the marks where a line continues."""
    high = _height(picture)
    rails = [
        f'<path class="rail" d="M{units(x * CELL)} -{HEAD}v{high}"/>' for x in (EDGE, EDGE + picture.width)
    ]
    onward = [_PEN.letters(Letters(x, y, "»"), "onward") for x, y in picture.continued]
    return "".join(rails + onward)


class _ValueRuler(Ruler):
    """Measures elements with room for the values and states that a page fills in."""

    def __init__(
        self,
        captions: Mapping[str, Sequence[str]],
        name_of: TagName,
        specs: Mapping[str, Spec],
        *,
        operands: bool,
    ) -> None:
        super().__init__(captions)
        self._name_of, self._specs, self._operands = name_of, specs, operands

    def _block_texts(self, instruction: Instruction) -> BlockTexts | None:
        """Return the texts of an instruction's state; None if it does not show its state."""
        return states_of(instruction, self._captions.get(instruction.name, ()), self._name_of)

    @override
    def states(self, instruction: Instruction) -> Sequence[tuple[str, str]]:
        texts = self._block_texts(instruction) if instruction.name in BESIDE else None
        return () if texts is None else texts.line(0)

    @override
    def lines(self, instruction: Instruction, room: int | None = None) -> tuple[BoxLine, ...]:
        """Return the lines of a box; lines for a block's state may replace its operands."""
        texts = self._block_texts(instruction)
        if not self._operands:
            if instruction.name in SHORT and texts is not None:
                return (BoxLine("", str(instruction.operands[0]).ljust(SHORT_LINE)),)
            if instruction.name == "JSR" and str(instruction.operands[-1]) == "0":  # without parameters
                return super().lines(instruction, room)[:-1]
        if instruction.name in BESIDE or texts is None:
            return super().lines(instruction, room)
        shown_lines = [BoxLine("", " " * WIDE, states=texts.line(number)) for number in range(texts.lines)]
        if self._operands:
            return *shown_lines, *super().lines(instruction, room)
        return BoxLine("", str(instruction.operands[0])), *shown_lines

    @override
    def value(self, instruction: Instruction) -> str | None:
        return self._tag_of(instruction.operands[0])

    @override
    def entry(
        self, instruction: Instruction, number: int, caption: str, longest: int | None
    ) -> list[BoxLine]:
        """Return the lines of an operand; a value replaces a member's number, or appears below a tag."""
        members = self._members(instruction)
        if number in members:
            structure, member = members[number]
            name = self._tag_of(instruction.operands[structure], member)
            if name is not None:
                return [BoxLine(caption, " " * VALUE, name)]
        lines = super().entry(instruction, number, caption, longest)
        name = self._tag_of(instruction.operands[number])
        return lines if name is None else [*lines, BoxLine("", " " * VALUE, name)]

    def _members(self, instruction: Instruction) -> Mapping[int, tuple[int, str]]:
        spec = self._specs.get(instruction.name)
        return {} if spec is None else spec.members

    def _tag_of(self, operand: Operand, member: str = "") -> str | None:
        """Return the tag of an operand, or of its member; None if there is none."""
        if not isinstance(operand, Address):
            return None
        return self._name_of(operand.member(member) if member else operand)

    def names(self, instruction: Instruction) -> Iterator[str]:
        """Yield the tags that an instruction shows or uses."""
        for operand in instruction.operands:
            yield from filter(None, map(self._name_of, addresses_in(operand)))
        texts = self._block_texts(instruction)
        if texts is not None:
            yield from texts.names()
        for structure, member in self._members(instruction).values():
            tag = instruction.operands[structure]  # a cause may be the tag's DN, which has no line in the box
            yield from filter(None, (self._tag_of(tag, member), self._tag_of(tag, "DN")))

    def attributes(self, instruction: Instruction) -> str:
        """Return the attributes by which a page finds an instruction, its first tag, and all its tags."""
        names = tuple(dict.fromkeys(self.names(instruction)))
        first = next((operand for operand in instruction.operands if isinstance(operand, Address)), None)
        tag = "" if first is None else self._tag_of(first) or str(first)
        return (
            f' data-instruction="{instruction.name}" data-tag={attribute(tag)}'
            f" data-names={attribute(chr(10).join(names))}"
        )


class _Group:
    """The markup of one element: one path for wires, one for strokes, then everything else."""

    def __init__(self) -> None:
        self._strokes: dict[str, list[str]] = {}
        self._other_elements: list[str] = []

    def add(self, shape: Shape) -> None:
        """Add a shape; the strokes of one kind become one path."""
        form = shape.form
        if isinstance(form, Line | Curve):
            self._strokes.setdefault(shape.kind, []).append(_PEN.stroke(form))
        elif isinstance(form, Value):
            self._other_elements.append(_value(form))
        else:
            self._other_elements.append(_PEN.draw(form, shape.kind))

    def markup(self) -> str:
        paths = [f'<path class="{kind}" d="{"".join(stroke)}"/>' for kind, stroke in self._strokes.items()]
        return "".join(paths + self._other_elements)


def _value(value: Value) -> str:
    """Return the empty text element for a value: beside a symbol, in a box, or for a block's state."""
    kind, baseline = ("bit value", 11.0) if value.beside else ("value", 4.5)
    position = f'x="{_PEN.x(value.x)}" y="{units((value.y + 0.5) * ROW + baseline)}"'
    anchor = ' text-anchor="end"' if value.ends else ""
    if value.states:
        texts = attribute(json.dumps(value.states))
        return f'<text class="now" data-now={texts} {position}{anchor}></text>'
    return f'<text class="{kind}" data-name={attribute(value.name)} {position}{anchor}></text>'


_PEN = Pen(ROW, EDGE)
