"""Sequential function charts of a document: elements and links become steps and transitions.

    Step, Stop -- DirectedLink --> Transition -- DirectedLink --> Step
    a diverging Branch is entered at its ID and left at the IDs of its legs, a converging one the other way

Legs of a selection are ordered from left to right, by X of their targets; or as in the document, if
the branch has its own priority.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from scanrack.io_images.site import Site
from scanrack.ladder.files.chartreader import condition_of, expression_of
from scanrack.ladder.model.chart import PRESETS, Action, Chart, ChartStep, Qualifier, Transition
from scanrack.ladder.model.chart_checks import MOST_ELEMENTS
from scanrack.ladder.model.chart_layout import layout_of
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_address
from scanrack.ladder.model.spec import Spec
from scanrack.ladder.model.tree import Address, Block, Instruction, Operand, Origin, number
from scanrack.ladder.st import parse_statements

from .xml.records import ElementRecord, lines_of

NAMES: Mapping[Qualifier, str] = {
    Qualifier.N: "NonStored",
    Qualifier.R: "Reset",
    Qualifier.S: "Stored",
    Qualifier.L: "TimeLimited",
    Qualifier.D: "TimeDelayed",
    Qualifier.P: "Pulse",
    Qualifier.P1: "PulseRisingEdge",
    Qualifier.P0: "PulseFallingEdge",
    Qualifier.SL: "StoredTimeLimited",
    Qualifier.SD: "StoredTimeDelayed",
    Qualifier.DS: "TimeDelayedStored",
}
"""Names of qualifiers in a document."""

QUALIFIERS: Mapping[str, Qualifier] = {
    **{name.upper(): qualifier for qualifier, name in NAMES.items()},
    **{qualifier.value: qualifier for qualifier in Qualifier},
    "SET": Qualifier.S,
    "DELAYEDSTORED": Qualifier.DS,
}
"""Qualifiers by letter and by name in capitals, without `And`, including names that other programs write."""

_NODES = ("Step", "Stop", "Transition", "Branch", "Leg")


class ChartRefusedError(LadderError):
    """The chart can't be read; the error's site has the line."""


class _Graph:
    """The elements of a chart by ID, with the predecessors and successors of each."""

    def __init__(self, content: ElementRecord, file: str) -> None:
        self._file = file
        self.elements: dict[int, ElementRecord] = {}
        self._branches: dict[int, int] = {}  # of legs
        self.after: dict[int, list[int]] = {}
        self.before: dict[int, list[int]] = {}
        for child in content.children:
            if child.tag in ("Step", "Stop", "Transition", "Branch"):
                self._add(child)
            for inner in child.children:
                if inner.tag in ("Leg", "Action"):
                    key = self._add(inner)
                    if inner.tag == "Leg":
                        self._branches[key] = self.id_of(child)
        for child in content.children:
            if child.tag == "DirectedLink":
                self._link(self.end_of(child, "FromID"), self.end_of(child, "ToID"))
        for leg, branch in self._branches.items():
            self._link(*((branch, leg) if self._diverges(branch) else (leg, branch)))

    def refused(self, element: ElementRecord | None, text: str) -> ChartRefusedError:
        """Return the error for an element."""
        line = element.line if element is not None else 0
        return ChartRefusedError(f"{_named(element)}{text}", Site(file=self._file, line=line))

    def _add(self, element: ElementRecord) -> int:
        key = self.id_of(element)
        if key in self.elements:
            raise self.refused(element, f"has the ID {key} of another element")
        if len(self.elements) >= MOST_ELEMENTS:
            raise self.refused(None, f"it has more than {MOST_ELEMENTS:,} elements")
        self.elements[key] = element
        return key

    def id_of(self, element: ElementRecord, name: str = "ID") -> int:
        """Return an ID."""
        text = element.attributes.get(name, "")
        if not re.fullmatch(r"\d{1,9}", text, re.ASCII):
            raise self.refused(element, f"has {name} {text!r}, a number is needed")
        return int(text)

    def end_of(self, link: ElementRecord, name: str) -> int:
        """Return the ID at an end of a link."""
        end = self.id_of(link, name)
        if end not in self.elements or self.elements[end].tag not in _NODES:
            raise self.refused(link, f"has {name} {end}, which does not exist")
        return end

    def _link(self, a: int, b: int) -> None:
        self.after.setdefault(a, []).append(b)
        self.before.setdefault(b, []).append(a)

    def _diverges(self, branch: int) -> bool:
        """Whether a branch diverges: by its own attribute, else by whether links leave its legs."""
        flow = self.elements[branch].attributes.get("BranchFlow", "")
        if flow in ("Diverge", "Converge"):
            return flow == "Diverge"
        legs = [leg for leg, owner in self._branches.items() if owner == branch]
        return any(self.after.get(leg) for leg in legs)

    def reached(self, start: int, way: dict[int, list[int]]) -> list[int]:
        """Return the steps, stops and transitions next to an element, through branches, by priority."""
        ends: list[int] = []
        visited: set[int] = set()
        todo = list(reversed(self._ordered(start, way)))
        while todo:
            key = todo.pop()
            if self.elements[key].tag not in ("Branch", "Leg"):
                if key not in ends:
                    ends.append(key)
            elif key not in visited:
                visited.add(key)
                todo += reversed(self._ordered(key, way))
        return ends

    def _ordered(self, key: int, way: dict[int, list[int]]) -> list[int]:
        """Return the neighbors of an element; legs from left to right, unless they have priorities."""
        ordered = list(dict.fromkeys(way.get(key, ())))
        element = self.elements[key]
        if element.tag == "Branch" and element.attributes.get("Priority", "Default") != "Default":
            return ordered
        return sorted(ordered, key=lambda each: self._x(each, way))

    def _x(self, key: int, way: dict[int, list[int]]) -> int:
        for _ in range(len(self.elements)):
            text = self.elements[key].attributes.get("X", "")
            if text.lstrip("-").isdecimal() and text.isascii():
                return int(text[:12])
            onward = way.get(key)
            if not onward:
                return 0
            key = onward[0]
        return 0

    def joins(self, start: int, way: dict[int, list[int]], kind: str) -> bool:
        """Whether an element leads to a branch of a kind, directly or through other branches."""
        visited: set[int] = set()
        todo = list(way.get(start, ()))
        while todo:
            key = todo.pop()
            element = self.elements[key]
            if key in visited or element.tag not in ("Branch", "Leg"):
                continue
            visited.add(key)
            if element.tag == "Branch" and element.attributes.get("BranchType") == kind:
                return True
            todo += way.get(key, ())
        return False


def _named(element: ElementRecord | None) -> str:
    if element is None:
        return ""
    name = element.attributes.get("Operand") or element.attributes.get("ID", "")
    return f"{element.tag.lower() if element.tag != 'DirectedLink' else 'link'} {name} ".replace("  ", " ")


class ChartBuilder:
    """Builds one chart."""

    def __init__(self, content: ElementRecord, file: str, specs: Mapping[str, Spec]) -> None:
        self._content, self._file, self._specs = content, file, specs
        self._graph = _Graph(content, file)

    def chart(self) -> Chart:
        """Return the chart.

        Raises:
            ChartRefusedError: an element or a link is invalid.
            RungTextError: the text of an element is invalid.
        """
        steps = {key: self._step(key, element) for key, element in self._of("Step", "Stop")}
        ends = {key: self._ends(key, element) for key, element in self._of("Transition")}
        leaving = {key: self._leaving(key, element) for key, element in self._of("Step", "Stop")}
        names = {key: step.name for key, step in steps.items()}
        order = dict.fromkeys(chain(*leaving.values(), ends))
        transitions = {key: self._transition(key, *ends[key], names) for key in order}
        notes = tuple(box.text for box in self._content.children if box.tag == "TextBox" and box.text)
        return in_order(Chart(tuple(steps.values()), tuple(transitions.values()), *self._arguments(), notes))

    def _arguments(self) -> tuple[tuple[Address, ...], tuple[Address, ...]]:
        """Return the inputs and returns of the subroutine."""
        attributes = next((child.attributes for child in self._content.children if child.tag == "SbrRet"), {})
        inputs, returns = (
            tuple(map(parse_address, _listed(attributes.get(name, "")))) for name in ("In", "Ret")
        )
        return inputs, returns

    def _of(self, *tags: str) -> Iterator[tuple[int, ElementRecord]]:
        return ((key, element) for key, element in self._graph.elements.items() if element.tag in tags)

    # --- elements

    def _name(self, element: ElementRecord) -> str:
        name = element.attributes.get("Operand", "")
        if not name:
            raise self._graph.refused(element, "has no Operand, the name of its tag")
        return name

    def _step(self, key: int, element: ElementRecord) -> ChartStep:
        actions = tuple(self._action(child) for child in element.children if child.tag == "Action")
        presets = tuple(
            (name, value)
            for name in PRESETS
            if (value := self._preset(element, "Preset" if name == "PRE" else name)) is not None
        )
        initial = element.attributes.get("InitialStep", "").lower() == "true"
        origin = Origin(self._file, element.line)
        return ChartStep(
            self._name(element), actions, initial, element.tag == "Stop", presets, number=key, origin=origin
        )

    def _preset(self, element: ElementRecord, name: str) -> Operand | None:
        """Return the expression of a preset; None if the tag's value is the preset."""
        if element.attributes.get(f"{name}UsesExpr", "").lower() != "true":
            return None
        texts, lines = _text_in(element.child(name))
        return expression_of(texts, lines, self._file, self._specs) if "".join(texts).strip() else None

    def _action(self, element: ElementRecord) -> Action:
        word = element.attributes.get("Qualifier", "NonStored")
        qualifier = QUALIFIERS.get(word.upper().replace("AND", ""))
        if qualifier is None:
            qualifiers = ", ".join(choice.value for choice in Qualifier)
            raise self._graph.refused(element, f"has the qualifier {word!r}; choose from {qualifiers}")
        boolean = element.attributes.get("IsBoolean", "").lower() == "true"
        body = None if boolean or qualifier is Qualifier.R else self._body(element)
        return Action(
            self._name(element),
            qualifier,
            body,
            self._preset(element, "Preset"),
            element.attributes.get("IndicatorTag", ""),
            self._graph.id_of(element),
            Origin(self._file, element.line),
        )

    def _body(self, element: ElementRecord) -> Block:
        body = element.child("Body")
        call = None if body is None else body.child("JSR")
        texts, lines = _called(call) if call is not None else _text_in(body)
        return parse_statements("\n".join(texts), file=self._file, lines=lines, specs=self._specs)

    def _transition(
        self, key: int, sources: Sequence[int], targets: Sequence[int], names: Mapping[int, str]
    ) -> Transition:
        element = self._graph.elements[key]
        return Transition(
            self._name(element),
            tuple(names[source] for source in sources),
            tuple(names[target] for target in targets),
            self._condition(element),
            number=key,
            origin=Origin(self._file, element.line),
        )

    def _condition(self, element: ElementRecord) -> Operand | Instruction:
        condition = element.child("Condition")
        call = element.child("JSR") or (condition.child("JSR") if condition is not None else None)
        texts, lines = _called(call) if call is not None else _text_in(condition)
        if not "".join(texts).strip():
            raise self._graph.refused(element, "has no condition")
        return condition_of(texts, lines, self._file, self._specs)

    # --- links

    def _ends(self, key: int, element: ElementRecord) -> tuple[list[int], list[int]]:
        """Return the steps before and after a transition."""
        graph = self._graph
        ends = []
        for way, side, flow in ((graph.before, "before", "converge"), (graph.after, "after", "diverge")):
            near = graph.reached(key, way)
            for neighbor in near:
                if graph.elements[neighbor].tag == "Transition":
                    other_name = _named(graph.elements[neighbor]).strip()
                    raise graph.refused(element, f"and {other_name} have no step between them")
            if not near:
                raise graph.refused(element, f"has no step {side} it")
            if len(near) > 1 and not graph.joins(key, way, "Simultaneous"):
                raise graph.refused(
                    element, f"is linked to {len(near)} steps that no simultaneous branch {flow}s"
                )
            ends.append(near)
        return ends[0], ends[1]

    def _leaving(self, key: int, element: ElementRecord) -> list[int]:
        """Return the transitions that leave a step, in order of priority."""
        near = self._graph.reached(key, self._graph.after)
        for neighbor in near:
            other_element = self._graph.elements[neighbor]
            if other_element.tag != "Transition":
                raise self._graph.refused(
                    element, f"and {_named(other_element).strip()} have no transition between them"
                )
        return near


def in_order(chart: Chart) -> Chart:
    """Return a chart with its steps in order of execution: top to bottom, branches left to right."""
    cells = layout_of(chart).steps
    steps = sorted(chart.steps, key=lambda each: (cells[each.name.upper()][1], cells[each.name.upper()][0]))
    after = {step.name: [*chart.transitions_after(step.name)] for step in steps}
    transitions = [follower for step in steps for follower in after[step.name]]
    return replace(
        chart, steps=tuple(steps), transitions=tuple(dict.fromkeys([*transitions, *chart.transitions]))
    )


def _text_in(element: ElementRecord | None) -> tuple[list[str], list[int]]:
    """Return the lines of an element's structured text, and their numbers."""
    content = None if element is None else element.child("STContent")
    lines = [child for child in content.children if child.tag == "Line"] if content is not None else []
    return lines_of((line.text, line.line) for line in lines)


def _called(call: ElementRecord) -> tuple[list[str], list[int]]:
    """Return a call of a routine as structured text."""
    get = call.attributes.get
    inputs, returns = _listed(get("In", "")), _listed(get("Ret", ""))
    operands = [get("Routine") or get("RoutineName", ""), str(number(len(inputs))), *inputs, *returns]
    return [f"JSR({','.join(operands)});"], [call.line]


def _listed(text: str) -> list[str]:
    return [word for word in re.split(r"[\s,]+", text) if word]
