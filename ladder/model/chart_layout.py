"""Layout of a chart's picture: columns from the left, rows from the top.

A step is below all transitions that lead down to it. Further legs of a branch go to the right. What follows a
convergence is in its first leg's column. A link back up to the beginning of a loop is a jump.
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
    """A step or transition to place; `by` is the transition, and `column` None is the next free column."""

    kind: str
    name: str
    by: int
    column: int | None


class _Placing:
    """Follows the paths of a chart."""

    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        self._leaving = chart.leaving
        self._columns: dict[str, int] = {}
        self._of_transitions: dict[int, int] = {}
        self._jumps: set[tuple[int, str]] = set()
        self._free = 0  # the next free column

    def layout(self) -> ChartLayout:
        """Place the elements of all paths, then the steps that no path reaches."""
        initial = self._chart.initial
        starts = ([initial] if initial else []) + list(self._chart.steps)
        for step in starts:
            if step.name.upper() not in self._columns:
                self._down(step.name.upper(), self._free)
        rows, of_transitions = self._rows()
        steps = {name: (column, rows[name]) for name, column in self._columns.items()}
        cells = tuple(
            (self._of_transitions.get(number, 0), of_transitions[number])
            for number in range(len(self._chart.transitions))
        )
        return ChartLayout(steps, cells, frozenset(self._jumps))

    def _down(self, start: str, column: int) -> None:
        """Assign columns down all paths from a step: the first leg stays in the column, others go right."""
        open_steps: set[str] = set()
        todo: list[_Visit] = [_Visit("step", start, -1, column)]
        while todo:
            visit = todo.pop()
            if visit.kind == "left":
                open_steps.discard(visit.name)
            elif visit.kind == "transition":
                todo += reversed(self._targets(visit))
            elif visit.name in self._columns:
                if visit.name in open_steps:
                    self._jumps.add((visit.by, visit.name))
            else:
                self._columns[visit.name] = own_column = self._column(visit)
                open_steps.add(visit.name)
                todo.append(visit._replace(kind="left"))
                leaving = [
                    transition
                    for transition in self._leaving[visit.name]
                    if transition not in self._of_transitions
                ]
                todo += reversed(
                    [
                        _Visit("transition", visit.name, transition, own_column if place == 0 else None)
                        for place, transition in enumerate(leaving)
                    ]
                )

    def _targets(self, visit: _Visit) -> list[_Visit]:
        """Assign a transition its column; return the steps after it."""
        if visit.by in self._of_transitions:
            return []
        self._of_transitions[visit.by] = column = self._column(visit)
        targets = self._chart.transitions[visit.by].targets
        return [
            _Visit("step", name.upper(), visit.by, column if place == 0 else None)
            for place, name in enumerate(targets)
        ]

    def _column(self, visit: _Visit) -> int:
        if visit.column is None:
            self._free += 1
            return self._free - 1
        self._free = max(self._free, visit.column + 1)
        return visit.column

    def _rows(self) -> tuple[dict[str, int], dict[int, int]]:
        """Return rows: each element below everything that leads to it, except jumps."""
        steps = dict.fromkeys(self._columns, 0)
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
