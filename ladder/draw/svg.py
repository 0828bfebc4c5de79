"""Routines as SVG: the same layout as in box characters, with cells of 8 by 20 units.

Wires and symbols with power have the class `live`. The title of a rung is its text, which a browser shows
when the pointer is over the rung. Colors follow the reader's light or dark scheme.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..model.routine import Routine
from .characters import WIDTH, comment_lines, lines_of, ran
from .chart import live_chart
from .diagram import live_diagram
from .layout import NO_CAPTIONS, lay_out
from .marks import Picture
from .markup import CELL, LivePicture, Pen, plain
from .shapes import Letters, Line, shapes_of

ROW = 20
"""SVG units per row."""

SPACE = 0.4
"""Rows between rungs."""

MARGIN = 7
"""Columns on either side of the rails; the left margin has the rung numbers."""

STYLE = """\
text { font: 13px "DejaVu Sans Mono", Menlo, Consolas, monospace; fill: #1b1f24; white-space: pre }
.heading { font-weight: bold }
.comment, .number { fill: #57606a }
.caption { fill: #57606a }
.paper { fill: #ffffff }
.wire, .sign { stroke: #57606a; stroke-width: 1.4; fill: none }
.rail { stroke: #1b1f24; stroke-width: 2.5 }
.middle { text-anchor: middle }
.bar { stroke-width: 3 }
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
    """Return an SVG document of routines, each given with the numbers of the rungs or lines to draw."""
    page = _Page(width, captions)
    for routine, rungs in routines:
        page.routine(routine, rungs, (truths or {}).get(routine.name))
    return page.document()


_PAPER = Pen(ROW)


class _Page:
    """A page to which routines are added one below another."""

    def __init__(self, columns: int, captions: Mapping[str, Sequence[str]]) -> None:
        self._columns = columns
        self._captions = captions
        self._svg: list[str] = []
        self._row = 0.0  # of the next text or rung
        self._width = 0  # columns used so far

    def routine(
        self, routine: Routine, rungs: Sequence[int], truths: Sequence[Sequence[bool] | None] | None
    ) -> None:
        """Add a routine: its chart, or else its diagram if it has one, and its statements or rungs."""
        self._row += 1
        self._text(0, self._row, f"Routine {routine.name}", "heading")
        self._row += 1
        if routine.chart is not None:
            self._picture(live_chart(routine.chart, routine.name))
            return
        if routine.drawing is not None:
            self._picture(live_diagram(routine.drawing.sheets, routine.name))
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

    def _picture(self, drawn: LivePicture) -> None:
        """Add a chart or a diagram in its own size."""
        self._svg.append(f'<g transform="translate(0 {round(self._row * ROW)})">{drawn.svg}</g>')
        self._width = max(self._width, drawn.width // CELL + 1)
        self._row += drawn.height / ROW + 1

    def _statements(
        self, routine: Routine, line_numbers: Sequence[int], truths: Sequence[Sequence[bool] | None] | None
    ) -> None:
        """Add lines of structured text with their numbers; lines that ran are live."""
        for number, text in lines_of(routine, line_numbers):
            number_text = str(number or "")
            self._text(MARGIN - 2 - len(number_text), self._row, number_text, "number")
            kind = "line" if number else "comment"
            self._text(MARGIN, self._row, text, "live" if ran(truths, number) else kind)
            self._width = max(self._width, MARGIN + len(text) + 2)
            self._row += 1

    def _rung(self, picture: Picture, number: int, text: str) -> None:
        """Add a rung with its number and rails; marks with power are live."""
        top, right = self._row, MARGIN + picture.width
        self._width = max(self._width, right + 2)
        self._svg.append(f"<g><title>{plain(text)}</title>")
        first = (picture.left or [0])[0]
        self._text(MARGIN - 2 - len(str(number)), top + first, str(number), "number")
        pen = Pen(ROW, MARGIN, top)
        for mark in picture.marks:
            for shape in shapes_of(mark):
                live = shape.element is not None and picture.live(shape.element)
                self._svg.append(pen.draw(shape.form, f"{shape.kind} live" if live else shape.kind))
        for x, y in picture.continued:
            self._text(MARGIN + x, top + y, "»", "comment")
        for x in (MARGIN, right):
            rail = Line(x - 0.5, top - 0.5, x - 0.5, top + picture.rows - 0.5 + SPACE)
            self._svg.append(_PAPER.line(rail, "rail"))
        self._svg.append("</g>")
        self._row += picture.rows + SPACE

    def _text(self, x: float, y: float, text: str, kind: str) -> None:
        self._svg.append(_PAPER.letters(Letters(x, y, text), kind))

    def document(self) -> str:
        """Return the whole document, as large as its content."""
        width, height = (self._width + 1) * CELL, round((self._row + 1) * ROW)
        size = f'width="{width}" height="{height}"'
        head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" {size}>'
        paper = f'<rect class="paper" {size}/>'
        elements = filter(None, self._svg)
        return "\n".join([head, f"<style>\n{STYLE}\n</style>", paper, *elements, "</svg>", ""])
