"""A function block diagram as SVG that a page updates: sheets, blocks, references and wires.

    <g class="element block" data-at="Main.3" data-tag="Delay"> ... </g>
    <path class="wire" data-lit="Delay.DN" d="..."/>
    <text class="value" data-value-of="Delay.ACC"></text>

The page sets `data-value` of elements with `data-lit`, which are wires and references for bits, and fills in
the values. An element has nested groups, one for each of its lines of structured text. The editor's
coordinates are scaled up, because names are wider here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..model.drawing import DrawnElement, DrawnPin, DrawnSheet, DrawnWire
from .markup import CELL, LivePicture, attribute, cut, live_picture, plain

PinTag = Callable[[str], tuple[str, bool] | None]
"""Returns the full tag name of a single-value address and whether it is a bit; None for other addresses."""

STRETCH_X, STRETCH_Y = 2.0, 1.25
PIN, HEAD, PAD, LINE = 24, 46, 10, 18
"""Pixels: height of a pin's row, height of a block's header, padding around text, height of a line."""

LEAST, EDGE, TITLE = 128, 24, 34
"""Pixels: minimum width of a block, margin of a sheet, height of its title."""

MOST = 28
"""Maximum characters of a name."""

BOX = 24
"""Height of a reference, in pixels."""


def as_written(address: str) -> tuple[str, bool] | None:
    """Return an address as if it named a tag that is not a bit, for drawings without values."""
    return (address, False) if address and not address[0].isdigit() else None


def live_diagram(sheets: tuple[DrawnSheet, ...], ident: str, tag_of: PinTag = as_written) -> LivePicture:
    """Draw a diagram for a page.

    Args:
        sheets: the sheets, which are drawn one below another.
        ident: prefix of its element ids: `Main` for routine Main.
        tag_of: returns the tag of an address as text.
    """
    svg: list[str] = []
    names: dict[str, None] = {}
    width, top = LEAST, 0
    for sheet in sheets:
        drawn = _Sheet(sheet, ident, tag_of, top)
        svg += drawn.svg()
        names |= drawn.names
        width, top = max(width, drawn.right + EDGE), drawn.bottom + EDGE
    return live_picture("rung chart fbd", f"Diagram {ident}", svg, names, width, top)


def _text_width(text: str) -> int:
    return min(len(text), MOST) * CELL


class _Sheet:
    """Draws one sheet, below `top`; `right` and `bottom` are the ends of its elements."""

    def __init__(self, sheet: DrawnSheet, ident: str, tag_of: PinTag, top: int) -> None:
        self._sheet, self._ident, self._tag_of, self._top = sheet, ident, tag_of, top
        self.names: dict[str, None] = {}
        self._rows: dict[tuple[int, bool], dict[str, int]] = {}  # the pins on one side of an element, by name
        self._least_x = min((element.x for element in sheet.elements), default=0)
        self._least_y = min((element.y for element in sheet.elements), default=0)
        self._boxes = [self._box(element) for element in sheet.elements]
        self.right = max((x + width for x, _, width, _ in self._boxes), default=0)
        self.bottom = max((y + height for _, y, _, height in self._boxes), default=top + TITLE)

    def _box(self, element: DrawnElement) -> tuple[int, int, int, int]:
        """Return the left, top, width and height of an element."""
        x = EDGE + round((element.x - self._least_x) * STRETCH_X)
        y = self._top + TITLE + EDGE + round((element.y - self._least_y) * STRETCH_Y)
        longest = max(map(_text_width, element.lines), default=0) + 2 * PAD
        if element.kind == "text":
            return x, y, longest, LINE * max(len(element.lines), 1)
        if element.kind != "block":
            return x, y, max(longest, 48), BOX
        sides = [
            max((_text_width(pin.name) for pin in pins), default=0)
            for pins in (element.inputs, element.outputs)
        ]
        width = max(LEAST, longest, sum(sides) + 4 * PAD)
        return x, y, width, HEAD + PIN * max(len(element.inputs), len(element.outputs), 1)

    def svg(self) -> Iterator[str]:
        """Yield the SVG: the title, the wires, then the elements drawn over them."""
        title = f"Sheet {self._sheet.number}" + (f"  {self._sheet.comment}" if self._sheet.comment else "")
        yield self._text(EDGE, self._top + LINE, " ".join(title.split()), "heading")
        for number, wire in enumerate(self._sheet.wires):
            yield self._wire(wire, number)
        for number, element in enumerate(self._sheet.elements):
            yield self._element(element, number)

    # --- values

    def _tag(self, address: str) -> tuple[str, bool] | None:
        """Return the tag of an address and whether it is a bit; add it to `names`. None without a tag."""
        tag = self._tag_of(address) if address else None
        if tag is not None:
            self.names[tag[0]] = None
        return tag

    def _value(self, address: str, x: int, y: int, *, ends: bool) -> str:
        """Return an empty text element, which the page fills with a tag's value; "" without a tag."""
        tag = self._tag(address)
        if tag is None:
            return ""
        anchor = ' text-anchor="end"' if ends else ""
        return f'<text class="bit value" data-value-of={attribute(tag[0])} x="{x}" y="{y}"{anchor}></text>'

    def _lit(self, address: str) -> str:
        """Return the attribute that makes the page light an element when a bit is on."""
        tag = self._tag(address)
        return f" data-lit={attribute(tag[0])}" if tag is not None and tag[1] else ""

    # --- elements

    def _text(self, x: int, y: int, text: str, kind: str, *, ends: bool = False) -> str:
        anchor = ' text-anchor="end"' if ends else ""
        shown = text if kind == "heading" else cut(text, MOST)
        return f'<text class="{kind}" x="{x}" y="{y}"{anchor}>{plain(shown)}</text>'

    def _element(self, element: DrawnElement, number: int) -> str:
        """Return an element as a group, nested in a group for each of its other lines of text."""
        x, y, width, height = self._boxes[number]
        if element.kind == "text":
            lines = (self._text(x, y + LINE * n, line, "caption") for n, line in enumerate(element.lines, 1))
            return "".join(lines)
        inside = self._frame(element, x, y, width, height)
        tag_and_kind = self._tag(element.tag)
        tag = tag_and_kind[0] if tag_and_kind else element.tag
        lit = "" if element.kind == "block" else self._lit(element.tag)
        title = plain(" ".join(element.lines))
        line_ids = [f"{self._ident}.{line_id}" for line_id in element.places] or [f"{self._ident}.s{number}"]
        about = f"data-at={attribute(line_ids[0])} data-tag={attribute(tag)}{lit}"
        text = f'<g class="element {element.kind}" {about}><title>{title}</title>{inside}</g>'
        for line_id in line_ids[1:]:
            text = f"<g data-at={attribute(line_id)}>{text}</g>"
        return text

    def _frame(self, element: DrawnElement, x: int, y: int, width: int, height: int) -> str:
        """Return the inside of an element: a block with its pins, or a reference with its value."""
        bounds = f'x="{x}" y="{y}" width="{width}" height="{height}"'
        if element.kind != "block":
            round_ = BOX // 2 if element.kind == "connector" else 2
            name = self._text(x + PAD, y + 16, element.lines[0], "name")
            end = x + width if element.kind == "input" else x
            outside = end + 4 if element.kind == "input" else end - 4
            literal = element.kind == "connector" or not element.tag
            value = "" if literal else self._value(element.tag, outside, y + 8, ends=element.kind != "input")
            return f'<rect class="box" {bounds} rx="{round_}"/>{name}{value}'
        elements = [
            f'<rect class="box" {bounds} rx="3"/>',
            self._text(x + PAD, y + 18, element.lines[0], "heading"),
        ]
        if len(element.lines) > 1:
            elements.append(self._text(x + PAD, y + 36, element.lines[1], "name"))
        elements += [self._pin(pin, x, y, n, ends=False) for n, pin in enumerate(element.inputs)]
        elements += [self._pin(pin, x + width, y, n, ends=True) for n, pin in enumerate(element.outputs)]
        return "".join(elements)

    def _pin(self, pin: DrawnPin, x: int, y: int, row: int, *, ends: bool) -> str:
        """Return a pin's name inside the block and its value outside; `ends` is set on the right side."""
        middle = y + HEAD + PIN * row + PIN // 2
        name = self._text(x - 6 if ends else x + 6, middle + 4, pin.name, "caption", ends=ends)
        return name + self._value(pin.value, x + 4 if ends else x - 4, middle - 4, ends=not ends)

    # --- wires

    def _end(self, number: int, pin: str, *, output: bool) -> tuple[int, int]:
        """Return the coordinates of a pin."""
        element = self._sheet.elements[number]
        x, y, width, _ = self._boxes[number]
        if element.kind != "block":
            return (x + width if output else x), y + BOX // 2
        if (number, output) not in self._rows:
            pins = element.outputs if output else element.inputs
            self._rows[number, output] = {
                candidate.name.upper(): n for n, candidate in reversed([*enumerate(pins)])
            }
        row = self._rows[number, output].get(pin.upper(), 0)
        return (x + width if output else x), y + HEAD + PIN * row + PIN // 2

    def _wire(self, wire: DrawnWire, number: int) -> str:
        """Draw a wire to the right, or back to the left below its elements."""
        x, y = self._end(wire.source, wire.output, output=True)
        to_x, to_y = self._end(wire.target, wire.input, output=False)
        step = 14 + 5 * (number % 4)  # wires bend at different columns, so that they can be distinguished
        if to_x - x >= 2 * step:
            path = f"M{x} {y}H{to_x - step}V{to_y}H{to_x}"
        elif to_x - x > 8:
            path = f"M{x} {y}H{(x + to_x) // 2}V{to_y}H{to_x}"
        else:
            below = max(
                top + height for _, top, _, height in (self._boxes[n] for n in (wire.source, wire.target))
            )
            path = f"M{x} {y}H{x + step}V{below + step // 2}H{to_x - step}V{to_y}H{to_x}"
        kind = "wire feedback" if wire.feedback else "wire"
        return f'<path class="{kind}"{self._lit(wire.value)} d="{path}"/>'
