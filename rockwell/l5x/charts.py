"""Reads the sequential function charts of a document; elements and links become steps and transitions.

    Step, Stop -- DirectedLink --> Transition -- DirectedLink --> Step
    links enter a diverging Branch at its ID and leave it at the IDs of its legs; a converging one is reversed

Legs of a selection are ordered from left to right, by the X of their targets. If the branch has its own
priority, the legs keep the order of the document.
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
"""Qualifiers by letter and by name in capitals, without `And`, including names from other software."""

_NODES = ("Step", "Stop", "Transition", "Branch", "Leg")


def preset_tag(name: str) -> str:
    """Return the tag of the element with the expression of a preset, given the member that it sets."""
    return "Preset" if name == "PRE" else name


class ChartRefusedError(LadderError):
    """The chart can't be read; the error's site has the line."""


class _Graph:
    """The elements of a chart by ID, with the predecessors and successors of each."""

    def __init__(self, content: ElementRecord, file: str) -> None:
        """Read the elements, then their links; then link each leg with its branch, in its direction."""
        self._file = file
        self.elements: dict[int, ElementRecord] = {}
        self._branches: dict[int, int] = {}  # the branch of each leg
        self.successors: dict[int, list[int]] = {}  # IDs to which links of an ID lead
        self.predecessors: dict[int, list[int]] = {}
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
        # decided for all branches first, because a link of a leg would make its branch diverge
        diverging = {branch for branch in self._branches.values() if self._diverges(branch)}
        for leg, branch in self._branches.items():
            if branch in diverging:
                self._link(branch, leg)
            else:
                self._link(leg, branch)

    def refused(self, element: ElementRecord | None, text: str) -> ChartRefusedError:
        """Return the error for an element, or for the whole chart if it is None."""
        line = element.line if element is not None else 0
        return ChartRefusedError(f"{_label_of(element)}{text}", Site(file=self._file, line=line))

    def _add(self, element: ElementRecord) -> int:
        """Store an element by its ID, and return the ID; refuse a repeated ID, or too many elements."""
        key = self.id_of(element)
        if key in self.elements:
            raise self.refused(element, f"has the ID {key} of another element")
        if len(self.elements) >= MOST_ELEMENTS:
            raise self.refused(None, f"it has more than {MOST_ELEMENTS:,} elements")
        self.elements[key] = element
        return key

    def id_of(self, element: ElementRecord, name: str = "ID") -> int:
        """Return the ID in an attribute of an element."""
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

    def _link(self, source: int, target: int) -> None:
        """Record a link from one element to another."""
        self.successors.setdefault(source, []).append(target)
        self.predecessors.setdefault(target, []).append(source)

    def _diverges(self, branch: int) -> bool:
        """Return whether a branch diverges, by its attribute or else by whether links leave its legs."""
        flow = self.elements[branch].attributes.get("BranchFlow", "")
        if flow in ("Diverge", "Converge"):
            return flow == "Diverge"
        legs = [leg for leg, owner in self._branches.items() if owner == branch]
        return any(self.successors.get(leg) for leg in legs)

    def neighbors(self, start: int, links: dict[int, list[int]]) -> list[int]:
        """Return the steps, stops and transitions linked to an element, directly or by branches, by priority.

        Args:
            links: `successors` or `predecessors`.
        """
        ends: list[int] = []
        visited: set[int] = set()
        todo = list(reversed(self._ordered(start, links)))
        while todo:
            key = todo.pop()
            if self.elements[key].tag not in ("Branch", "Leg"):
                if key not in ends:
                    ends.append(key)
            elif key not in visited:
                visited.add(key)
                todo += reversed(self._ordered(key, links))
        return ends

    def _ordered(self, key: int, links: dict[int, list[int]]) -> list[int]:
        """Return the neighbors of an element; legs go from left to right unless they have priorities."""
        ordered = list(dict.fromkeys(links.get(key, ())))
        element = self.elements[key]
        if element.tag == "Branch" and element.attributes.get("Priority", "Default") != "Default":
            return ordered
        return sorted(ordered, key=lambda neighbor: self._x(neighbor, links))

    def _x(self, key: int, links: dict[int, list[int]]) -> int:
        """Return the X of an element, or of the first element after it that has an X; 0 if none has one."""
        for _ in range(len(self.elements)):
            text = self.elements[key].attributes.get("X", "")
            if text.lstrip("-").isdecimal() and text.isascii():
                return int(text[:12])
            onward = links.get(key)
            if not onward:
                return 0
            key = onward[0]
        return 0

    def reaches_branch(self, start: int, links: dict[int, list[int]], kind: str) -> bool:
        """Return whether links lead to a branch of a kind, directly or through other branches."""
        visited: set[int] = set()
        todo = list(links.get(start, ()))
        while todo:
            key = todo.pop()
            element = self.elements[key]
            if key in visited or element.tag not in ("Branch", "Leg"):
                continue
            visited.add(key)
            if element.tag == "Branch" and element.attributes.get("BranchType") == kind:
                return True
            todo += links.get(key, ())
        return False


def _label_of(element: ElementRecord | None) -> str:
    """Return the kind and name of an element, followed by a space; "" for the whole chart."""
    if element is None:
        return ""
    kind = "link" if element.tag == "DirectedLink" else element.tag.lower()
    name = element.attributes.get("Operand") or element.attributes.get("ID", "")
    return f"{kind} {name} ".replace("  ", " ")


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
        steps = {key: self._step(key, element) for key, element in self._elements("Step", "Stop")}
        ends = {key: self._ends(key, element) for key, element in self._elements("Transition")}
        leaving = [self._leaving(key, element) for key, element in self._elements("Step", "Stop")]
        names = {key: step.name for key, step in steps.items()}
        order = dict.fromkeys(chain(*leaving, ends))
        transitions = tuple(self._transition(key, *ends[key], names) for key in order)
        notes = tuple(box.text for box in self._content.children if box.tag == "TextBox" and box.text)
        return in_order(Chart(tuple(steps.values()), transitions, *self._arguments(), notes))

    def _arguments(self) -> tuple[tuple[Address, ...], tuple[Address, ...]]:
        """Return the inputs and the returns of the chart as a subroutine."""
        parameters = self._content.child("SbrRet")
        attributes = parameters.attributes if parameters is not None else {}
        inputs, returns = (
            tuple(map(parse_address, _words(attributes.get(name, "")))) for name in ("In", "Ret")
        )
        return inputs, returns

    def _elements(self, *tags: str) -> Iterator[tuple[int, ElementRecord]]:
        return ((key, element) for key, element in self._graph.elements.items() if element.tag in tags)

    # --- elements

    def _name(self, element: ElementRecord) -> str:
        """Return the name of an element's tag; refuse an element without one."""
        name = element.attributes.get("Operand", "")
        if not name:
            raise self._graph.refused(element, "has no Operand, the name of its tag")
        return name

    def _step(self, key: int, element: ElementRecord) -> ChartStep:
        """Return a step or stop with its actions and presets; `key` is its ID."""
        actions = tuple(self._action(child) for child in element.children if child.tag == "Action")
        presets: list[tuple[str, Operand]] = []
        for name in PRESETS:
            value = self._preset(element, preset_tag(name))
            if value is not None:
                presets.append((name, value))
        initial = element.attributes.get("InitialStep", "").lower() == "true"
        origin = Origin(self._file, element.line)
        return ChartStep(
            self._name(element),
            actions,
            initial=initial,
            stop=element.tag == "Stop",
            presets=tuple(presets),
            number=key,
            origin=origin,
        )

    def _preset(self, element: ElementRecord, name: str) -> Operand | None:
        """Return the expression of a preset; None if the tag's value is the preset."""
        if element.attributes.get(f"{name}UsesExpr", "").lower() != "true":
            return None
        texts, lines = _structured_text(element.child(name))
        return expression_of(texts, lines, self._file, self._specs) if "".join(texts).strip() else None

    def _action(self, element: ElementRecord) -> Action:
        """Return an action; a Boolean action and a reset have no body. Refuse an unknown qualifier."""
        word = element.attributes.get("Qualifier", "NonStored")
        qualifier = QUALIFIERS.get(word.upper().replace("AND", ""))
        if qualifier is None:
            qualifiers = ", ".join(choice.value for choice in Qualifier)
            raise self._graph.refused(element, f"has the qualifier {word!r}; choose from {qualifiers}")
        is_boolean = element.attributes.get("IsBoolean", "").lower() == "true"
        body = None if is_boolean or qualifier is Qualifier.R else self._body(element)
        return Action(
            self._name(element),
            qualifier,
            body,
            preset=self._preset(element, "Preset"),
            indicator=element.attributes.get("IndicatorTag", ""),
            number=self._graph.id_of(element),
            origin=Origin(self._file, element.line),
        )

    def _body(self, element: ElementRecord) -> Block:
        """Return the statements of an action, which may be the call of a routine."""
        body = element.child("Body")
        call = None if body is None else body.child("JSR")
        texts, lines = _call_text(call) if call is not None else _structured_text(body)
        return parse_statements("\n".join(texts), file=self._file, lines=lines, specs=self._specs)

    def _transition(
        self, key: int, sources: Sequence[int], targets: Sequence[int], names: Mapping[int, str]
    ) -> Transition:
        """Return a transition between the steps with these IDs; `names` are the names of all steps."""
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
        """Return a transition's condition: an expression, or the call of a routine."""
        condition = element.child("Condition")
        call = element.child("JSR") or (condition.child("JSR") if condition is not None else None)
        texts, lines = _call_text(call) if call is not None else _structured_text(condition)
        if not "".join(texts).strip():
            raise self._graph.refused(element, "has no condition")
        return condition_of(texts, lines, self._file, self._specs)

    # --- links

    def _ends(self, key: int, element: ElementRecord) -> tuple[list[int], list[int]]:
        """Return the steps before and after a transition."""
        graph = self._graph
        ends = []
        for links, side, flow in (
            (graph.predecessors, "before", "converge"),
            (graph.successors, "after", "diverge"),
        ):
            near = graph.neighbors(key, links)
            for neighbor in near:
                if graph.elements[neighbor].tag == "Transition":
                    other_name = _label_of(graph.elements[neighbor]).strip()
                    raise graph.refused(element, f"and {other_name} have no step between them")
            if not near:
                raise graph.refused(element, f"has no step {side} it")
            if len(near) > 1 and not graph.reaches_branch(key, links, "Simultaneous"):
                raise graph.refused(
                    element, f"is linked to {len(near)} steps that no simultaneous branch {flow}s"
                )
            ends.append(near)
        return ends[0], ends[1]

    def _leaving(self, key: int, element: ElementRecord) -> list[int]:
        """Return the transitions that leave a step, in order of priority."""
        near = self._graph.neighbors(key, self._graph.successors)
        for neighbor in near:
            other_element = self._graph.elements[neighbor]
            if other_element.tag != "Transition":
                raise self._graph.refused(
                    element, f"and {_label_of(other_element).strip()} have no transition between them"
                )
        return near


def in_order(chart: Chart) -> Chart:
    """Return a chart with its steps in order of execution: top to bottom, branches left to right."""
    cells = layout_of(chart).steps

    def row_and_column(step: ChartStep) -> tuple[int, int]:
        column, row = cells[step.name.upper()]
        return row, column

    steps = sorted(chart.steps, key=row_and_column)
    transitions = dict.fromkeys(
        transition for step in steps for transition in chart.transitions_after(step.name)
    )
    transitions |= dict.fromkeys(chart.transitions)
    return replace(chart, steps=tuple(steps), transitions=tuple(transitions))


def _structured_text(element: ElementRecord | None) -> tuple[list[str], list[int]]:
    """Return the lines of an element's structured text, and their numbers in the file."""
    content = None if element is None else element.child("STContent")
    lines = [child for child in content.children if child.tag == "Line"] if content is not None else []
    return lines_of((line.text, line.line) for line in lines)


def _call_text(call: ElementRecord) -> tuple[list[str], list[int]]:
    """Return a call of a routine as a line of structured text, and its number in the file."""
    get = call.attributes.get
    inputs, returns = _words(get("In", "")), _words(get("Ret", ""))
    operands = [get("Routine") or get("RoutineName", ""), str(number(len(inputs))), *inputs, *returns]
    return [f"JSR({','.join(operands)});"], [call.line]


def _words(text: str) -> list[str]:
    return [word for word in re.split(r"[\s,]+", text) if word]
