"""Routines as SVG: the same layout as with characters, a cell being 8 by 20 units.

Wires and signs with power have the class `live`; every sign and box carries the instruction as its title,
which a browser shows under the pointer. Colours follow the reader's light or dark scheme.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from xml.sax.saxutils import escape

from ..tree import Routine
from .characters import WIDTH, comment_lines, lines_of, ran
from .layout import NO_CAPTIONS, lay_out
from .marks import Box, Corner, Picture, Symbol, Wire
from .ruler import caption_width

CELL, ROW = 8, 20
"""Units of a column and of a row."""

SPACE = 0.4
"""Rows between rungs."""

MARGIN = 7
"""Columns on either side of the rails; the left one holds the rungs' numbers."""

STYLE = """\
text { font: 13px "DejaVu Sans Mono", Menlo, Consolas, monospace; fill: #1b1f24; white-space: pre }
.heading { font-weight: bold }
.comment, .number { fill: #57606a }
.caption { fill: #57606a }
.paper { fill: #ffffff }
.wire, .sign { stroke: #57606a; stroke-width: 1.4; fill: none }
.rail { stroke: #1b1f24; stroke-width: 2.5 }
.box { stroke: #57606a; stroke-width: 1.4; fill: #f6f8fa }
.live { stroke: #1a7f37; stroke-width: 3 }
text.live { stroke: none; fill: #1a7f37 }
@media (prefers-color-scheme: dark) {
  text { fill: #e6edf3 }
  .comment, .number, .caption { fill: #9198a1 }
  .paper { fill: #0d1117 }
  .wire, .sign, .box { stroke: #9198a1 }
  .box { fill: #151b23 }
  .rail { stroke: #e6edf3 }
  .live { stroke: #3fb950 }
  text.live { fill: #3fb950 }
}"""


def routines_svg(
    routines: Sequence[tuple[Routine, Sequence[int]]],
    width: int = WIDTH,
    truths: Mapping[str, Sequence[Sequence[bool] | None]] | None = None,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
) -> str:
    """Draw routines below each other.

    Args:
        routines: the routines, each with the numbers of the rungs or lines that are drawn.
        width: columns between the rails.
        truths: power behind each instruction, per rung, by the routine's name; none for routines left out.
        captions: what the operands of add-on instructions are called, see `captions_of`.

    Returns:
        The text of an SVG document.
    """
    page = _Page(width, captions)
    for routine, rungs in routines:
        page.routine(routine, rungs, (truths or {}).get(routine.name))
    return page.document()


class _Page:
    """Collects elements from top to bottom."""

    def __init__(self, columns: int, captions: Mapping[str, Sequence[str]]) -> None:
        self._columns = columns
        self._captions = captions
        self._parts: list[str] = []
        self._row = 0.0
        self._width = 0

    def routine(
        self, routine: Routine, rungs: Sequence[int], truths: Sequence[Sequence[bool] | None] | None
    ) -> None:
        self._row += 1
        self._text(0, self._row, f"Routine {routine.name}", "heading")
        self._row += 1
        if routine.statements is not None:
            self._statements(routine, rungs, truths)
            return
        for number in rungs:
            rung = routine.rungs[number]
            for line in comment_lines(rung.comment, self._columns):
                self._text(MARGIN, self._row, line, "comment")
                self._row += 1
            truth = truths[number] if truths else None
            self._rung(lay_out(rung, self._columns, truth, self._captions), number, str(rung))

    def _statements(
        self, routine: Routine, wanted: Sequence[int], truths: Sequence[Sequence[bool] | None] | None
    ) -> None:
        for number, text in lines_of(routine, wanted):
            live = ran(truths, number)
            self._text(MARGIN - 2 - len(str(number or "")), self._row, str(number or ""), "number")
            self._text(MARGIN, self._row, text, "live" if live else "line" if number else "comment")
            self._width = max(self._width, MARGIN + len(text) + 2)
            self._row += 1

    def _rung(self, picture: Picture, number: int, text: str) -> None:
        top, right = self._row, MARGIN + picture.width
        self._width = max(self._width, right + 2)
        self._parts.append(f"<g><title>{escape(text)}</title>")
        first = (picture.left or [0])[0]
        self._text(MARGIN - 2 - len(str(number)), top + first, str(number), "number")
        for mark in picture.marks:
            _DRAW[type(mark)](self, mark, top)
        for x, y in picture.continued:
            self._text(MARGIN + x, top + y, "»", "comment")
        for x in (MARGIN, right):
            self._line(x - 0.5, top - 0.5, x - 0.5, top + picture.rows - 0.5 + SPACE, "rail")
        self._parts.append("</g>")
        self._row += picture.rows + SPACE

    def wire(self, wire: Wire, top: float) -> None:
        x, to_x = MARGIN + wire.x, MARGIN + wire.to_x
        kind = _class("wire", wire.live)
        if wire.y == wire.to_y:
            self._line(x - 0.5, top + wire.y, to_x + 0.5, top + wire.y, kind)
        else:
            self._line(x, top + wire.y, x, top + wire.to_y, kind)

    def corner(self, corner: Corner, top: float) -> None:
        x = MARGIN + corner.x
        self._line(
            x,
            top + corner.y,
            x + (0.5 if corner.opens else -0.5),
            top + corner.y,
            _class("wire", corner.live),
        )

    def symbol(self, symbol: Symbol, top: float) -> None:
        x, y, wide = MARGIN + symbol.x - 0.5, top + symbol.y, len(symbol.sign)
        kind = _class("sign", symbol.live)
        self._text(MARGIN + symbol.label_x, y - 1, symbol.name, "name")
        left, right = x + 0.75, x + wide - 0.75
        self._line(x, y, left, y, _class("wire", symbol.fed))
        self._line(right, y, x + wide, y, kind)
        if symbol.sign.startswith("("):
            for edge, bend in ((left, -0.7), (right, 0.7)):
                self._path(edge, y, bend, kind)
        else:
            for edge in (left, right):
                self._line(edge, y - 0.4, edge, y + 0.4, kind)
        if symbol.sign[1:-1] == "/":
            self._line(right, y - 0.4, left, y + 0.4, kind)
        elif symbol.sign[1:-1].strip():
            text = symbol.sign[1:-1]
            self._text(x + (wide - len(text)) / 2 + 0.5, y, text, _class("mark", symbol.live))

    def box(self, box: Box, top: float) -> None:
        x, y = MARGIN + box.x, top + box.y
        rows = max(len(box.lines), 1)
        corner = f'x="{_units(x * CELL)}" y="{_units((y - 0.95) * ROW)}"'
        size = f'width="{_units(box.width * CELL)}" height="{_units((rows + 1.05) * ROW)}"'
        self._parts.append(f'<rect class="{_class("box", box.live)}" {corner} {size} rx="3"/>')
        self._text(x + (box.width - len(box.title)) / 2, y - 1, box.title, "heading")
        captions = caption_width(box.lines)
        for number, (caption, operand) in enumerate(box.lines):
            self._text(x + 2, y + number, caption, "caption")
            at = x + box.width - 2 - len(operand) if captions else x + 2
            self._text(at, y + number, operand, "operand")

    # --- elements

    def _line(self, x: float, y: float, to_x: float, to_y: float, kind: str) -> None:
        a, b = (x + 0.5) * CELL, (y + 0.5) * ROW
        c, d = (to_x + 0.5) * CELL, (to_y + 0.5) * ROW
        self._parts.append(
            f'<line class="{kind}" x1="{_units(a)}" y1="{_units(b)}" x2="{_units(c)}" y2="{_units(d)}"/>'
        )

    def _path(self, x: float, y: float, bend: float, kind: str) -> None:
        a, b, rise = (x + 0.5) * CELL, (y + 0.5) * ROW, 0.42 * ROW
        start, middle, end = (
            f"{_units(a)} {_units(b - rise)}",
            f"{_units(a + bend * CELL)} {_units(b)}",
            _units(b + rise),
        )
        self._parts.append(f'<path class="{kind}" d="M{start} Q{middle} {_units(a)} {end}"/>')

    def _text(self, x: float, y: float, text: str, kind: str) -> None:
        if text:
            at = f'x="{_units(x * CELL)}" y="{_units((y + 0.5) * ROW + 4.5)}" textLength="{len(text) * CELL}"'
            self._parts.append(f'<text class="{kind}" {at}>{escape(text)}</text>')

    def document(self) -> str:
        """Return the whole document."""
        width, height = (self._width + 1) * CELL, round((self._row + 1) * ROW)
        size = f'width="{width}" height="{height}"'
        head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" {size}>'
        paper = f'<rect class="paper" {size}/>'
        return "\n".join([head, f"<style>\n{STYLE}\n</style>", paper, *self._parts, "</svg>", ""])


def _class(kind: str, live: bool | None) -> str:
    return f"{kind} live" if live else kind


def _units(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")


_DRAW: Mapping[type, Callable[..., None]] = {
    Wire: _Page.wire,
    Corner: _Page.corner,
    Symbol: _Page.symbol,
    Box: _Page.box,
}
