"""Checks of a chart: names, reachability, and that its simultaneous branches begin and end in pairs.

A step is inside each branch whose divergence comes before it and whose convergence comes after it. These are
a list of pairs: a divergence and its legs. A convergence joins legs of one divergence; joining all of them
leaves it. So two tokens never meet in one step, and no jump enters or leaves a branch.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from .chart import Chart, ChartStep, Qualifier, Transition

MOST_ELEMENTS = 2_000
"""Maximum steps, actions and transitions of a chart."""

Legs = tuple[tuple[int, frozenset[int]], ...]
"""The simultaneous branches around a step, outermost first: the divergence's number, and its legs."""


class ChartProblem(NamedTuple):
    """A part of a chart that is not allowed."""

    number: int  # of the element
    element: str
    text: str
    remedy: str


def problems_of(chart: Chart) -> Iterator[ChartProblem]:
    """Yield what is wrong with a chart; if its names are wrong, nothing else is checked."""
    problems = [*_names(chart)]
    yield from problems
    if not problems:
        yield from _Net(chart).problems()


def unreached(chart: Chart) -> Iterator[ChartProblem]:
    """Yield the steps that no path leads to; SFR may reach them."""
    net = _Net(chart)
    list(net.problems())
    for step in chart.steps:
        if step.name.upper() not in net.legs:
            text = f"no path leads to step {step.name}"
            yield ChartProblem(
                step.number, f"step {step.name}", text, "add a transition to it, or take it out"
            )


def _names(chart: Chart) -> Iterator[ChartProblem]:
    size = len(chart.elements)
    if size > MOST_ELEMENTS:
        text = f"it has {size:,} elements; {MOST_ELEMENTS:,} are allowed"
        yield ChartProblem(0, "chart", text, "divide it into charts that call each other")
        return
    initial = [step for step in chart.steps if step.initial]
    if len(initial) != 1:
        names = ", ".join(step.name for step in initial) or "none"
        text = f"it needs one initial step; there are: {names}"
        yield ChartProblem(0, "chart", text, "mark the first step")
    yield from _twice(chart)
    named = chart.named
    for transition in chart.transitions:
        yield from _ends(named, transition)


def _twice(chart: Chart) -> Iterator[ChartProblem]:
    """Yield steps with the same tag, and actions of one step with the same tag."""
    seen: set[str] = set()
    for step in chart.steps:
        if step.name.upper() in seen:
            text = f"there are two steps {step.name}"
            yield ChartProblem(step.number, f"step {step.name}", text, "give each its own tag")
        seen.add(step.name.upper())
        active = [named for named in step.actions if named.qualifier is not Qualifier.R]
        names = [named.name.upper() for named in active]
        for action in active:
            if names.count(action.name.upper()) > 1:
                text = f"step {step.name} has the action {action.name} twice"
                yield ChartProblem(action.number, f"action {action.name}", text, "give each its own tag")


def _ends(named: Mapping[str, ChartStep], each: Transition) -> Iterator[ChartProblem]:
    """Yield what is wrong with the steps before and after a transition."""
    for name in (*each.sources, *each.targets):
        if name.upper() not in named:
            steps = ", ".join(step.name for step in named.values())
            yield _of(each, f"no step {name}", f"steps are {steps}")
    for name in each.sources:
        if name.upper() in named and named[name.upper()].stop:
            yield _of(each, f"it leaves the stop {name}", "end the path there, or use a step")
    if not (each.sources and each.targets):
        yield _of(each, "it needs a step before it and one after it", "link it to both")


def _of(transition: Transition, text: str, remedy: str) -> ChartProblem:
    return ChartProblem(transition.number, f"transition {transition.name}", text, remedy)


class _Net:
    """Follows all paths of a chart from its initial step."""

    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        self.legs: dict[str, Legs] = {}  # of the steps reached, by name in capitals
        self._sizes: dict[int, int] = {}  # legs of each divergence
        self._leaving = chart.leaving

    def problems(self) -> Iterator[ChartProblem]:
        """Yield the transitions at which branches do not begin and end in pairs."""
        initial = self._chart.initial
        if initial is None:
            return
        self.legs[initial.name.upper()] = ()
        todo, done = [initial.name.upper()], set[int]()
        while todo:
            for number in self._leaving[todo.pop()]:
                transition = self._chart.transitions[number]
                if number not in done and all(name.upper() in self.legs for name in transition.sources):
                    done.add(number)
                    yield from self._fire(number, transition, todo)

    def _fire(self, number: int, each: Transition, todo: list[str]) -> Iterator[ChartProblem]:
        joined = self._join([self.legs[name.upper()] for name in each.sources])
        if joined is None:
            text = f"it converges from {', '.join(each.sources)}, which are not branches of one divergence"
            yield _of(each, text, "begin the branches with one simultaneous divergence")
            return
        self._sizes[number] = len(each.targets)
        for leg, name in enumerate(each.targets):
            inside = joined if len(each.targets) == 1 else (*joined, (number, frozenset((leg,))))
            known = self.legs.setdefault(name.upper(), inside)
            if known is inside:
                todo.append(name.upper())
            elif known != inside:
                text = f"it jumps to {name}, which is in another simultaneous branch, or in none"
                yield _of(
                    each, text, "enter simultaneous branches by their divergence, leave by their convergence"
                )

    def _join(self, sources: list[Legs]) -> Legs | None:
        """Return where a convergence leads, None if its sources do not belong together."""
        if len(sources) == 1:
            return sources[0]
        around = {(source[:-1], source[-1][0]) if source else None for source in sources}
        if len(around) != 1 or None in around:
            return None
        number = sources[0][-1][0]
        legs = [source[-1][1] for source in sources]
        together = frozenset[int]().union(*legs)
        if len(together) != sum(map(len, legs)):
            return None
        outer = sources[0][:-1]
        return outer if len(together) == self._sizes[number] else (*outer, (number, together))
