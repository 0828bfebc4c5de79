"""Writes a sequential function chart as the content of a routine in an L5X, with the branches it needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Any

from scanrack.ladder.model.chart import PRESETS, Action, Chart, ChartStep, Transition
from scanrack.ladder.model.chart_layout import Cell, layout_of
from scanrack.ladder.model.statements import block_lines

from .charts import NAMES, preset_tag
from .xml.writing import cdata, element, flag, write_statements

_LEFT, _TOP, _WIDE, _HIGH = 240, 60, 320, 100  # pixels of the first cell and of a cell


def write_chart(parent: Any, chart: Chart) -> None:
    """Add the content of a chart to a routine's element."""
    _Writer(parent, chart).write()


class _Writer:
    """Adds the elements of a chart to a routine's element."""

    def __init__(self, parent: Any, chart: Chart) -> None:
        self._chart, self._layout = chart, layout_of(chart)
        self._content = element(
            parent, "SFCContent", SheetSize="Letter - 8.5 x 11 in", SheetOrientation="Landscape"
        )
        self._numbers = count()
        self._ids: dict[str, int] = {}  # of steps and stops, by name in capitals
        self._links: list[tuple[int, int]] = []  # IDs: from, to

    def write(self) -> None:
        """Write steps, transitions, branches, stops and links."""
        for step in self._chart.steps:
            if not step.stop:
                self._write_step(step)
        numbers = [
            self._write_transition(transition, self._layout.transitions[index])
            for index, transition in enumerate(self._chart.transitions)
        ]
        for step in self._chart.steps:
            if step.stop:
                stop = self._add("Stop", step.name, self._layout.steps[step.name.upper()])
                self._ids[step.name.upper()] = int(stop.get("ID"))
        for transition, number in zip(self._chart.transitions, numbers, strict=True):
            self._link_sides(transition, number)
        for step in self._chart.steps:
            self._link_selections(step, numbers)
        self._write_rest()

    def _write_rest(self) -> None:
        """Write the parameters of the chart, the links and the notes."""
        if self._chart.inputs or self._chart.returns:
            addresses = {"In": self._chart.inputs, "Ret": self._chart.returns}
            attributes = {name: " ".join(map(str, names)) for name, names in addresses.items()}
            element(self._content, "SbrRet", ID=self._id(), X="40", Y="60", **attributes)
        for source, target in self._links:
            element(self._content, "DirectedLink", FromID=str(source), ToID=str(target), Show="true")
        for note in self._chart.notes:
            box = element(self._content, "TextBox", ID=self._id(), X="20", Y="20")
            element(box, "Text").text = cdata(note)

    def _id(self) -> str:
        """Return the next free ID."""
        return str(next(self._numbers))

    def _add(self, tag: str, name: str, cell: Cell, **more: str) -> Any:
        """Add an element of the chart at a cell."""
        x, y = str(_LEFT + cell[0] * _WIDE), str(_TOP + cell[1] * _HIGH)
        return element(self._content, tag, ID=self._id(), X=x, Y=y, Operand=name, HideDesc="true", **more)

    def _write_step(self, step: ChartStep) -> None:
        """Add a step with the expressions of its presets, and with its actions."""
        presets = dict(step.presets)
        uses = {f"{preset_tag(name)}UsesExpr": flag(name in presets) for name in PRESETS}
        cell = self._layout.steps[step.name.upper()]
        step_element = self._add(
            "Step", step.name, cell, InitialStep=flag(step.initial), **uses, ShowActions="true"
        )
        self._ids[step.name.upper()] = int(step_element.get("ID"))
        for name, value in step.presets:
            write_statements(element(step_element, preset_tag(name)), [str(value)])
        for action in step.actions:
            self._write_action(step_element, action)

    def _write_action(self, parent: Any, action: Action) -> None:
        """Add an action to a step's element, with its preset, its indicator and its statements."""
        action_element = element(
            parent,
            "Action",
            ID=self._id(),
            Operand=action.name,
            Qualifier=NAMES[action.qualifier],
            IsBoolean=flag(action.is_boolean),
            PresetUsesExpr=flag(action.preset is not None),
        )
        if action.indicator:
            action_element.set("IndicatorTag", action.indicator)
        if action.preset is not None:
            write_statements(element(action_element, "Preset"), [str(action.preset)])
        if action.body is not None:
            write_statements(element(action_element, "Body"), block_lines(action.body))

    def _write_transition(self, transition: Transition, cell: Cell) -> int:
        """Add a transition; return its ID."""
        transition_element = self._add("Transition", transition.name, cell)
        write_statements(element(transition_element, "Condition"), [str(transition.condition)])
        return int(transition_element.get("ID"))

    # --- branches and links

    def _branch(self, kind: str, flow: str, row: int, leg_count: int, **more: str) -> tuple[int, list[int]]:
        """Add a branch; return its ID and the IDs of its legs."""
        number, y = self._id(), str(_TOP + row * _HIGH - _HIGH // 2)
        branch_element = element(
            self._content, "Branch", ID=number, Y=y, BranchType=kind, BranchFlow=flow, **more
        )
        legs = [element(branch_element, "Leg", ID=self._id()) for _ in range(leg_count)]
        return int(number), [int(leg.get("ID")) for leg in legs]

    def _link_sides(self, transition: Transition, number: int) -> None:
        """Link a transition to several steps through a simultaneous branch; see also `_link_selections`."""
        _, source_row = self._layout.steps[transition.sources[0].upper()]
        row = source_row + 1
        if len(transition.sources) > 1:
            branch, legs = self._branch("Simultaneous", "Converge", row, len(transition.sources))
            self._links += zip((self._ids[name.upper()] for name in transition.sources), legs, strict=True)
            self._links.append((branch, number))
        if len(transition.targets) > 1:
            branch, legs = self._branch("Simultaneous", "Diverge", row + 1, len(transition.targets))
            self._links.append((number, branch))
            self._links += zip(legs, (self._ids[name.upper()] for name in transition.targets), strict=True)

    def _link_selections(self, step: ChartStep, numbers: Sequence[int]) -> None:
        """Link a step to transitions with no other step on that side; use a selection branch for several."""
        key = step.name.upper()
        step_id, (_, row) = self._ids[key], self._layout.steps[key]
        leaving = list(self._numbers_of(key, numbers, "sources"))
        entering = list(self._numbers_of(key, numbers, "targets"))
        if len(leaving) == 1:
            self._links.append((step_id, leaving[0]))
        elif leaving:
            branch, legs = self._branch("Selection", "Diverge", row + 1, len(leaving), Priority="UserDefined")
            self._links += [(step_id, branch), *zip(legs, leaving, strict=True)]
        if len(entering) == 1:
            self._links.append((entering[0], step_id))
        elif entering:
            branch, legs = self._branch("Selection", "Converge", row, len(entering))
            self._links += [*zip(entering, legs, strict=True), (branch, step_id)]

    def _numbers_of(self, key: str, numbers: Sequence[int], side: str) -> Iterator[int]:
        """Yield the IDs of the transitions with only this step on a side, `sources` or `targets`."""
        for transition, number in zip(self._chart.transitions, numbers, strict=True):
            names = getattr(transition, side)
            if len(names) == 1 and names[0].upper() == key:
                yield number
