"""Draws rungs in box characters; wires with power are heavy.

0 ║  Start             Stop       Run   ║
  ╟───┤ ├──┬────────────┤/├───────( )───╢
  ║   Run  │                            ║
  ║ ──┤ ├──┘                            ║
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ..model.routine import Routine
from ..model.statements import numbered_lines
from ..model.tree import NumberedLine, Rung
from .chart import chart_lines
from .layout import NO_CAPTIONS, lay_out
from .marks import Box, BoxLine, Corner, Symbol, Wire
from .ruler import caption_width

WIDTH = 96
"""Default columns between the rails."""

UP, DOWN, LEFT, RIGHT = 1, 2, 4, 8

LIGHT = {
    0: " ", LEFT: "─", RIGHT: "─", LEFT | RIGHT: "─", UP: "│", DOWN: "│", UP | DOWN: "│",
    DOWN | RIGHT: "┌", DOWN | LEFT: "┐", UP | RIGHT: "└", UP | LEFT: "┘",
    UP | DOWN | RIGHT: "├", UP | DOWN | LEFT: "┤", LEFT | RIGHT | DOWN: "┬", LEFT | RIGHT | UP: "┴",
    UP | DOWN | LEFT | RIGHT: "┼",
}  # fmt: skip
"""Characters of a cell, by the directions of its wires."""

HEAVY = dict(zip("─│┌┐└┘├┤┬┴┼", "━┃┏┓┗┛┣┫┳┻╋", strict=True))
"""The same characters for wires with power."""

HEAVY_SIGN = str.maketrans("┤├", "┨┠")
"""Replaces the characters of a contact if there is power after it."""


class _Canvas:
    """Character cells: the directions of the wires in each cell, and the text over them."""

    def __init__(self, width: int, rows: int) -> None:
        self._directions = [[0] * width for _ in range(rows)]
        self._live = [[False] * width for _ in range(rows)]
        self._written: list[dict[int, str]] = [{} for _ in range(rows)]
        self._width = width

    def wire(self, wire: Wire, live: bool) -> None:
        """Add a horizontal or vertical wire: each cell gets the directions in which the wire continues."""
        if wire.y == wire.to_y:
            for x in range(wire.x, wire.to_x + 1):
                self._add(x, wire.y, LEFT | RIGHT, live)
            return
        for y in range(wire.y, wire.to_y + 1):
            directions = (UP if y > wire.y else 0) | (DOWN if y < wire.to_y else 0)
            self._add(wire.x, y, directions, live)

    def _add(self, x: int, y: int, directions: int, live: bool) -> None:
        """Add directions of wires to a cell, which is live if any of its wires is live."""
        self._directions[y][x] |= directions
        self._live[y][x] |= live

    def corner(self, corner: Corner, live: bool) -> None:
        """Add a corner of a branch's leg: to the right if it opens the leg, otherwise to the left."""
        self._add(corner.x, corner.y, RIGHT if corner.opens else LEFT, live)

    def write(self, x: int, y: int, text: str) -> None:
        for number, sign in enumerate(text):
            self._written[y][x + number] = sign

    def lines(self) -> Iterator[str]:
        """Yield the rows as text: written text hides wires, and wires with power are heavy."""
        for directions, live, written in zip(self._directions, self._live, self._written, strict=True):
            signs = []
            for x in range(self._width):
                sign = LIGHT[directions[x]]
                signs.append(written.get(x, HEAVY.get(sign, sign) if live[x] else sign))
            yield "".join(signs)


def rung_text(
    rung: Rung,
    width: int = WIDTH,
    truth: Sequence[bool] | None = None,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
) -> list[str]:
    """Draw a rung, `width` columns between its rails; return lines of equal length."""
    picture = lay_out(rung, width, truth, captions)
    canvas = _Canvas(picture.width, picture.rows)
    for mark in picture.marks:
        live = picture.live(mark.element)
        if isinstance(mark, Wire):
            canvas.wire(mark, live)
        elif isinstance(mark, Corner):
            canvas.corner(mark, live)
        elif isinstance(mark, Symbol):
            canvas.write(mark.x, mark.y, mark.sign.translate(HEAVY_SIGN) if live else mark.sign)
            canvas.write(mark.label_x, mark.y - 1, mark.name)
        else:
            _box(canvas, mark, live)
    for x, y in picture.continued:
        canvas.write(x, y, "»")
    rows = enumerate(canvas.lines())
    return [
        f"{'╟' if y in picture.left else '║'}{line}{'╢' if y in picture.right else '║'}" for y, line in rows
    ]


def comment_lines(comment: str, width: int) -> list[str]:
    """Return the lines of a comment, wrapped between words."""
    return [wrapped for line in comment.splitlines() for wrapped in textwrap.wrap(line, width) or [""]]


def _box(canvas: _Canvas, box: Box, live: bool) -> None:
    """Draw a box with its title in the top edge; with power, its sides are heavy at the wire."""
    captions = caption_width(box.lines)
    inner = box.width - 2
    left_edge, right_edge = ("┨", "┠") if live else ("┤", "├")
    canvas.write(box.x, box.y - 1, f"┌{box.title.center(inner, '─')}┐")
    for number, (caption, operand, *_) in enumerate(box.lines or (BoxLine("", ""),)):
        text = f"{caption.ljust(captions)}{operand.rjust(inner - 2 - captions) if captions else operand}"
        edges = (left_edge, right_edge) if number == 0 else ("│", "│")
        canvas.write(box.x, box.y + number, f"{edges[0]} {text.ljust(inner - 2)} {edges[1]}")
    canvas.write(box.x, box.y + max(len(box.lines), 1), f"└{'─' * inner}┘")


def routine_text(
    routine: Routine,
    width: int = WIDTH,
    truths: Sequence[Sequence[bool] | None] | None = None,
    rungs: Iterable[int] | None = None,
    captions: Mapping[str, Sequence[str]] = NO_CAPTIONS,
) -> str:
    """Draw a routine: rungs with their numbers and comments, or lines of structured text.

    A heavy bar marks executed lines of structured text.

    Args:
        width: columns between the rails.
        truths: power after each instruction, per rung; None for a rung that was not scanned.
        rungs: numbers of the rungs to draw; None for all.
    """
    if routine.statements is not None or routine.chart is not None:
        return _statements_text(routine, truths, rungs)
    shown = range(len(routine.rungs)) if rungs is None else rungs
    margin = max(len(str(len(routine.rungs))), 2) + 1
    lines: list[str] = []
    for number in shown:
        rung = routine.rungs[number]
        lines += [f"{' ' * margin}{line}".rstrip() for line in comment_lines(rung.comment, width)]
        drawn = rung_text(rung, width, truths[number] if truths else None, captions)
        # the number stands before the row of the first wire
        first = next((row for row, line in enumerate(drawn) if line.startswith("╟")), 0)
        lines += [
            f"{str(number).rjust(margin - 1) if row == first else ' ' * (margin - 1)} {line}"
            for row, line in enumerate(drawn)
        ]
    return "\n".join(lines) + "\n"


def _statements_text(
    routine: Routine, truths: Sequence[Sequence[bool] | None] | None, shown: Iterable[int] | None
) -> str:
    """Draw structured text or a chart: numbered lines after a bar, which is heavy if the line ran."""
    lines = []
    for number, text in lines_of(routine, shown):
        bar = "┃" if ran(truths, number) else "│"
        lines.append(f"{str(number or '').rjust(4)} {bar} {text}".rstrip())
    return "\n".join(lines) + "\n"


def lines_of(routine: Routine, shown: Iterable[int] | None) -> Iterator[NumberedLine]:
    """Yield lines of structured text, or elements of a chart, with their numbers; None shows all."""
    if routine.chart is not None:
        yield from (line for line in chart_lines(routine.chart) if shown is None or line[0] in set(shown))
        return
    chosen = set(routine.numbers if shown is None else shown)
    shows_all = chosen.issuperset(routine.numbers)
    yield from (line for line in numbered_lines(routine.statements or ()) if shows_all or line[0] in chosen)


def ran(truths: Sequence[Sequence[bool] | None] | None, number: int) -> bool:
    """Return whether a line of structured text ran and, if it is a condition, was true."""
    truth = truths[number] if truths and number else None
    return truth is not None and len(truth) > 0 and truth[-1]
