"""SVG elements for shapes. A cell is 8 units wide; the caller chooses its height."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from scanrack.io_images.dataclass import dataclass

from ..model.tree import Address
from .shapes import BoxFrame, Curve, Form, Letters, Line

CELL = 8
"""SVG units per column."""

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 does not allow even if they are escaped [XML 1.0, 2.2]."""


TagName = Callable[[Address], str | None]
"""Returns the full tag name of a single-value address; None for other addresses."""


def cut(text: str, most: int) -> str:
    """Return a text cut to at most `most` characters; a text that was cut ends in `…`."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


def plain(text: str) -> str:
    """Escape a text for an element's content."""
    return _NO_XML.sub("\ufffd", text).replace("&", "&amp;").replace(">", "&gt;").replace("<", "&lt;")


def attribute(text: str) -> str:
    """Quote a text as an attribute's value."""
    quoted = plain(text).replace("\n", "&#10;").replace("\t", "&#9;").replace("\r", "&#13;")
    if '"' in quoted and "'" not in quoted:
        return f"'{quoted}'"
    return '"' + quoted.replace('"', "&quot;") + '"'


def units(value: float) -> str:
    """Format SVG units with at most two decimals."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


@dataclass(frozen=True, slots=True)
class LivePicture:
    """A chart or a diagram for a page: its SVG, the tags that it shows, and its size in pixels."""

    svg: str
    names: tuple[str, ...]
    width: int
    height: int


def live_picture(
    kind: str, label: str, svg: Iterable[str], names: Iterable[str], width: int, height: int
) -> LivePicture:
    """Return a picture of SVG elements.

    Args:
        kind: the style classes of the picture.
        label: the name of the picture for screen readers.
        svg: the elements.
        names: the tags that the picture shows.
    """
    size = f'viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="{kind}"'
    about = f'role="group" aria-label={attribute(label)}'
    document = f"{head} {about} {size}>{''.join(svg)}</svg>"
    return LivePicture(document, tuple(names), width, height)


@dataclass(frozen=True, slots=True)
class Pen:
    """Draws shapes at a position of the page."""

    row: int  # units per row
    left: float = 0  # columns to the left of column 0
    top: float = 0  # rows above row 0

    def x(self, x: float) -> str:
        """Return the x coordinate of a column's center, in SVG units."""
        return units((self.left + x + 0.5) * CELL)

    def y(self, y: float) -> str:
        """Return the y coordinate of a row's center, in SVG units."""
        return units((self.top + y + 0.5) * self.row)

    def line(self, line: Line, kind: str) -> str:
        """Return a line as an element."""
        start, end = (self.x(line.x), self.y(line.y)), (self.x(line.to_x), self.y(line.to_y))
        return f'<line class="{kind}" x1="{start[0]}" y1="{start[1]}" x2="{end[0]}" y2="{end[1]}"/>'

    def frame(self, frame: BoxFrame, kind: str) -> str:
        """Return a frame with rounded corners as an element."""
        position = f'x="{units((self.left + frame.x) * CELL)}" y="{units((self.top + frame.y) * self.row)}"'
        size = f'width="{units(frame.width * CELL)}" height="{units(frame.height * self.row)}"'
        return f'<rect class="{kind}" {position} {size} rx="3"/>'

    def letters(self, letters: Letters, kind: str) -> str:
        """Return text with one column per character; "" if it is empty."""
        if not letters.text:
            return ""
        x, y = units((self.left + letters.x) * CELL), units((self.top + letters.y + 0.5) * self.row + 4.5)
        length = len(letters.text) * CELL
        return f'<text class="{kind}" x="{x}" y="{y}" textLength="{length}">{plain(letters.text)}</text>'

    def stroke(self, form: Line | Curve) -> str:
        """Return a line or a curve as path data."""
        if isinstance(form, Line):
            return f"M{self.x(form.x)} {self.y(form.y)}L{self.x(form.to_x)} {self.y(form.to_y)}"
        return self._arc(form)

    def _arc(self, curve: Curve) -> str:
        """Return half of a coil as path data, 16.8 units high."""
        x, middle = self.x(curve.x), (self.top + curve.y + 0.5) * self.row
        through = f"{self.x(curve.x + curve.bend)} {units(middle)}"
        return f"M{x} {units(middle - 8.4)} Q{through} {x} {units(middle + 8.4)}"

    def draw(self, form: Form, kind: str) -> str:
        """Return a form as an element; "" for a value."""
        if isinstance(form, Line):
            return self.line(form, kind)
        if isinstance(form, Curve):
            return f'<path class="{kind}" d="{self._arc(form)}"/>'
        if isinstance(form, BoxFrame):
            return self.frame(form, kind)
        return self.letters(form, kind) if isinstance(form, Letters) else ""
