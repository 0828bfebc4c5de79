"""A routine of a program: rungs, statements, or a chart."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site

from .chart import Chart, body_name
from .drawing import Drawing
from .errors import LadderError
from .statements import Invocation, statements_in
from .tree import Block, Instruction, Rung, instructions_of


@dataclass(frozen=True, slots=True)
class Routine:
    """A routine of rungs, of statements if `statements` is not None, or a chart if `chart` is not None."""

    name: str
    rungs: tuple[Rung, ...]
    comment: str = ""
    statements: Block | None = None
    chart: Chart | None = None
    drawing: Drawing | None = field(default=None, compare=False)  # of a diagram, whose lines are statements

    @property
    def unit(self) -> str:
        """Kind of its numbers: rungs, lines, or elements of a chart."""
        return "element" if self.chart else "rung" if self.statements is None else "line"

    @property
    def block(self) -> Block:
        """The routine's statements, including those in a chart; empty for rungs."""
        return tuple(self.chart.statements()) if self.chart else self.statements or ()

    def instructions(self) -> Iterator[tuple[int, Instruction]]:
        """Yield the instructions of rungs and of statements, each with the number of its rung or line."""
        for number, rung in enumerate(self.rungs):
            yield from ((number, instruction) for instruction in instructions_of(rung.series))
        for statement in statements_in(self.block):
            if isinstance(statement, Invocation):
                yield statement.line, statement.instruction

    @property
    def numbers(self) -> Sequence[int]:
        """Numbers of the rungs (from 0), of lines with statements (from 1), or of a chart's elements."""
        if self.chart is not None:
            return sorted(self.chart.elements)
        if self.statements is None:
            return range(len(self.rungs))
        return sorted(
            {number for statement in self.statements for number, _ in statement.numbered() if number}
        )

    def numbered(self, number: int) -> str:
        """Return the rung or statements with this number, or raise a LadderError."""
        if number not in self.numbers:
            available = (
                ", ".join(map(str, self.numbers))
                if self.statements or self.chart
                else f"0 to {len(self.rungs) - 1}"
            )
            raise LadderError(f"routine {self.name} has no {self.unit} {number}; must be {available}")
        if self.chart is not None:
            return self.chart.elements[number]
        if self.statements is None:
            return str(self.rungs[number])
        lines = (line for statement in self.statements for line in statement.numbered())
        return " ".join(text.strip() for line_number, text in lines if line_number == number)

    @property
    def text(self) -> str:
        """The text of the rungs (without comments), the statements or the chart."""
        if self.chart is not None:
            return "\n".join(self.chart.lines())
        return "\n".join(map(str, self.rungs if self.statements is None else self.statements))


def element_of(routines: Iterable[Routine], site: Site) -> tuple[str, int | None]:
    """Return the routine and number of a site; for an action's body, the chart and the element."""
    for routine in routines:
        if routine.chart is not None and site.routine.upper().startswith(f"{routine.name.upper()}."):
            for step, action, _ in routine.chart.bodies():
                if body_name(routine.name, step, action).upper() == site.routine.upper():
                    return routine.name, action.number
    return site.routine, site.rung
