"""Layout of a chart's drawing in columns from the left and rows from the top.

A step is below all transitions that lead down to it. Further legs of a branch go to the right. Elements after
a convergence are in the column of its first leg. A link back up to the beginning of a loop is a jump.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from scanrack.io_images.dataclass import dataclass

from .chart import Chart

Cell = tuple[int, int]
"""Column and row."""


@dataclass(frozen=True, slots=True)
class ChartLayout:
    """The cells of a chart."""

    steps: Mapping[str, Cell]  # by name in capitals
    transitions: tuple[Cell, ...]  # in the chart's order
    jumps: frozenset[tuple[int, str]]  # links drawn as arrows: transition and target in capitals

    @property
    def columns(self) -> int:
        """Number of columns."""
        return 1 + max((cell[0] for cell in (*self.steps.values(), *self.transitions)), default=0)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return 1 + max((cell[1] for cell in (*self.steps.values(), *self.transitions)), default=0)


def layout_of(chart: Chart) -> ChartLayout:
    """Return the cells of a chart's elements."""
    return _Placing(chart).layout()


class _Visit(NamedTuple):
    """A step or transition to place, or the end of all paths from a step."""

    kind: str  # step, transition, path end
    step: str  # in capitals; for a transition, its source
    transition: int  # number of the transition, or of the one that leads to the step; -1 for a start
    column: int | None  # None for the next free column


def _with_first_in(column: int, visits: list[_Visit]) -> list[_Visit]:
    """Return the visits, with a column assigned to the first one."""
    return [visit._replace(column=column) for visit in visits[:1]] + visits[1:]


class _Placing:
    """Follows the paths of a chart."""

    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        self._leaving = chart.leaving
        self._step_columns: dict[str, int] = {}  # by name in capitals
        self._transition_columns: dict[int, int] = {}  # by number
        self._jumps: set[tuple[int, str]] = set()
        self._free_column = 0

    def layout(self) -> ChartLayout:
        """Place the elements reachable from the initial step, then the others; return all cells."""
        initial = self._chart.initial
        starts = ([initial] if initial else []) + list(self._chart.steps)
        for step in starts:
            if step.name.upper() not in self._step_columns:
                self._assign_columns(step.name.upper())
        step_rows, transition_rows = self._rows()
        step_cells = {name: (column, step_rows[name]) for name, column in self._step_columns.items()}
        transition_cells = tuple(
            (self._transition_columns.get(number, 0), row) for number, row in transition_rows.items()
        )
        return ChartLayout(step_cells, transition_cells, frozenset(self._jumps))

    def _assign_columns(self, start: str) -> None:
        """Assign columns along all paths from a step; the first leg keeps the column, others go right."""
        steps_above: set[str] = set()  # of the current path: a transition to one of them is a jump
        todo = [_Visit("step", start, -1, self._free_column)]
        while todo:
            visit = todo.pop()
            if visit.kind == "path end":
                steps_above.discard(visit.step)
            elif visit.kind == "transition":
                todo += reversed(self._targets(visit))
            elif visit.step not in self._step_columns:
                self._step_columns[visit.step] = column = self._column(visit)
                steps_above.add(visit.step)
                todo.append(visit._replace(kind="path end"))
                leaving = [
                    number for number in self._leaving[visit.step] if number not in self._transition_columns
                ]
                visits = [_Visit("transition", visit.step, number, None) for number in leaving]
                todo += reversed(_with_first_in(column, visits))
            elif visit.step in steps_above:
                self._jumps.add((visit.transition, visit.step))

    def _targets(self, visit: _Visit) -> list[_Visit]:
        """Assign a transition its column; return the visits to its targets."""
        if visit.transition in self._transition_columns:
            return []
        self._transition_columns[visit.transition] = column = self._column(visit)
        targets = self._chart.transitions[visit.transition].targets
        visits = [_Visit("step", name.upper(), visit.transition, None) for name in targets]
        return _with_first_in(column, visits)

    def _column(self, visit: _Visit) -> int:
        """Return a visit's column and mark it as used."""
        column = self._free_column if visit.column is None else visit.column
        self._free_column = max(self._free_column, column + 1)
        return column

    def _rows(self) -> tuple[dict[str, int], dict[int, int]]:
        """Return the rows of steps and transitions, each below everything that leads to it, except jumps."""
        steps = dict.fromkeys(self._step_columns, 0)
        transitions = dict.fromkeys(range(len(self._chart.transitions)), 0)
        for _ in range(len(steps) + 1):
            changed = False
            for number, transition in enumerate(self._chart.transitions):
                row = 1 + max((steps[name.upper()] for name in transition.sources), default=0)
                changed |= row != transitions[number]
                transitions[number] = row
                for name in map(str.upper, transition.targets):
                    if (number, name) not in self._jumps and steps[name] < row + 1:
                        steps[name], changed = row + 1, True
            if not changed:
                break
        return steps, transitions
