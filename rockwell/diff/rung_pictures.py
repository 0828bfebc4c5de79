"""Draws both versions of a rung as SVG, with the differences marked.

A rung that can't be read, or is too long to draw, has no picture; only its text is shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from scanrack.ladder.draw.layout import NO_CAPTIONS, place
from scanrack.ladder.draw.marks import Box, Mark, Picture, Symbol
from scanrack.ladder.draw.markup import CELL, Pen, plain, units
from scanrack.ladder.draw.ruler import GAP, Ruler
from scanrack.ladder.draw.shapes import BoxFrame, Letters, Line, bottom_of, shapes_of
from scanrack.ladder.instructions import BY_NAME
from scanrack.ladder.instructions.slc import SLC_SPECS
from scanrack.ladder.lowering.text import parse_rung
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.spec import InstructionKind, Spec, Use
from scanrack.ladder.model.tree import Rung, instructions_of

from ..slc.rungs import RungReader
from .alignment import aligned
from .outline import Step

WIDTH = 50
"""Columns between the rails."""

MOST_INSTRUCTIONS = 150
"""Maximum number of instructions in a rung that is drawn."""

ROW = 20
_EDGE = 1
_PEN = Pen(ROW, _EDGE)
_EDITED = re.compile(r"^[A-Za-z]+(?:, [^:]*)?: ")
"""The type of an online edit before a rung's text."""

_CALLED = re.compile(r"([A-Za-z_]\w*+)\s*+\(")


def rung_of(step: Step) -> Rung | None:
    """Return the tree of a rung; None if it can't be drawn."""
    text = _EDITED.sub("", step.text, count=1)
    if text.count("(") > MOST_INSTRUCTIONS or len(text) > 100 * MOST_INSTRUCTIONS:
        return None
    try:
        if text.startswith("SOR"):
            words = text.removesuffix("EOR").split()[1:]
            return Rung(RungReader(SLC_SPECS).read(words))
        return parse_rung(text, specs=_SpecsOf(text))
    except LadderError:
        return None


class _SpecsOf(Mapping[str, Spec]):
    """Instruction specs by name; an unknown name counts as an add-on with any operands."""

    def __init__(self, text: str) -> None:
        self._calls = {name.upper(): name for name in _CALLED.findall(text)}

    def __getitem__(self, name: str) -> Spec:
        """Return the spec of an instruction, or of an add-on that the text calls with any operands."""
        spec = BY_NAME.get(name)
        if spec is not None:
            return spec
        called = self._calls[name]
        return Spec(called, InstructionKind.OUTPUT, (Use.ANYTHING,), run=lambda *_operands: None)

    def __iter__(self) -> Iterator[str]:
        return iter(self._calls)

    def __len__(self) -> int:
        return len(self._calls)


def pictures(old: Step, new: Step) -> tuple[str, str] | None:
    """Return both versions of a rung as SVG, with differences in class `edit`; None if one can't be drawn."""
    old_rung, new_rung = rung_of(old), rung_of(new)
    if old_rung is None or new_rung is None:
        return None
    old_texts, new_texts = (list(map(str, instructions_of(rung.series))) for rung in (old_rung, new_rung))
    pairs = aligned(old_texts, new_texts)
    return (
        _svg(old_rung, set(range(len(old_texts))) - {i for i, _ in pairs}),
        _svg(new_rung, set(range(len(new_texts))) - {k for _, k in pairs}),
    )


def picture(step: Step) -> str:
    """Return a rung as SVG; "" if it can't be drawn."""
    rung = rung_of(step)
    return "" if rung is None else _svg(rung, set())


def _svg(rung: Rung, edited: set[int]) -> str:
    """Return a rung as SVG; `edited` are the indexes of its instructions that differ."""
    drawn = place(rung, WIDTH, Ruler(NO_CAPTIONS))
    bottom = bottom_of(drawn)
    width, height = (drawn.width + 2 * _EDGE) * CELL, units((bottom + 1) * ROW)
    shapes = (*_field_markup(drawn, edited), *_rail_markup(drawn, bottom), *_shape_markup(drawn, edited))
    size = f'viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="rung" role="img" {size}>'
        f"<title>{plain(str(rung))}</title>{''.join(shapes)}</svg>"
    )


def _shape_markup(drawn: Picture, edited: set[int]) -> Iterator[str]:
    """Yield the shapes of the marks; shapes that the other version lacks, except wires, get class `edit`."""
    for mark in drawn.marks:
        is_edited = _is_edited(mark, edited)
        for shape in shapes_of(mark):
            has_edit_class = is_edited and shape.kind != "wire"
            yield _PEN.draw(shape.form, f"{shape.kind} edit" if has_edit_class else shape.kind)
    yield from (_PEN.letters(Letters(x, y, "»"), "caption") for x, y in drawn.continued)


def _field_markup(drawn: Picture, edited: set[int]) -> Iterator[str]:
    """Yield a background for each instruction that the other version lacks."""
    for mark in drawn.marks:
        if _is_edited(mark, edited):
            yield _PEN.frame(_field_of(mark), "field")


def _is_edited(mark: Mark, edited: set[int]) -> bool:
    return isinstance(mark, Symbol | Box) and mark.element in edited


def _field_of(mark: Mark) -> BoxFrame:
    """Return the frame around a box, or around a symbol and its label."""
    if isinstance(mark, Box):
        return BoxFrame(mark.x - 0.5, mark.y - 1.1, mark.width + 1, max(len(mark.lines), 1) + 1.35)
    assert isinstance(mark, Symbol)
    left = min(mark.x, mark.label_x) - GAP / 2
    right = max(mark.x + len(mark.sign), mark.label_x + len(mark.name)) + GAP / 2
    return BoxFrame(left, mark.y - 1, right - left, 2)


def _rail_markup(drawn: Picture, bottom: float) -> Iterator[str]:
    for x in (0, drawn.width):
        yield _PEN.line(Line(x - 0.5, -0.5, x - 0.5, bottom + 0.5), "rail")
