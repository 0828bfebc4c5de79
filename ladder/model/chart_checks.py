"""Check a chart's names, its reachability, and the pairing of divergences and convergences.

Each step has a list of the branches around it, as pairs of a divergence and some of its legs. A convergence
joins legs of one divergence. A step after a convergence of all legs is outside the divergence. So two
tokens never meet in one step, and no jump enters or leaves a branch.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from .chart import Chart, ChartStep, Qualifier, Transition

MOST_ELEMENTS = 2_000
"""Maximum number of steps, actions and transitions in a chart."""

Legs = tuple[tuple[int, frozenset[int]], ...]
"""The simultaneous branches around a step, outermost first; each is a divergence's number and its legs."""


class ChartProblem(NamedTuple):
    """An error in a chart."""

    number: int  # of the element
    element: str
    text: str
    remedy: str


def problems_of(chart: Chart) -> Iterator[ChartProblem]:
    """Yield the problems in a chart; if names have problems, branches are not checked."""
    problems = [*_name_problems(chart)]
    yield from problems
    if not problems:
        yield from _Net(chart).problems()


def unreached(chart: Chart) -> Iterator[ChartProblem]:
    """Yield the steps to which no path leads; SFR can still reach them."""
    net = _Net(chart)
    list(net.problems())  # fills `legs`
    for step in chart.steps:
        if step.name.upper() not in net.legs:
            text = f"no path leads to step {step.name}"
            yield ChartProblem(
                step.number, f"step {step.name}", text, "add a transition to it, or take it out"
            )


def _name_problems(chart: Chart) -> Iterator[ChartProblem]:
    """Yield problems with a chart's size, initial step, tags and links."""
    size = len(chart.elements)
    if size > MOST_ELEMENTS:
        text = f"it has {size:,} elements; must be at most {MOST_ELEMENTS:,}"
        yield ChartProblem(0, "chart", text, "divide it into charts that call each other")
        return
    initial = [step for step in chart.steps if step.initial]
    if len(initial) != 1:
        names = ", ".join(step.name for step in initial) or "none"
        text = f"it must have one initial step; it has {names}"
        yield ChartProblem(0, "chart", text, "mark the first step")
    yield from _duplicate_problems(chart)
    steps_by_name = chart.steps_by_name
    for transition in chart.transitions:
        yield from _end_problems(steps_by_name, transition)


def _duplicate_problems(chart: Chart) -> Iterator[ChartProblem]:
    """Yield steps with the same tag, and actions of one step with the same tag."""
    seen: set[str] = set()
    for step in chart.steps:
        if step.name.upper() in seen:
            text = f"two steps are called {step.name}"
            yield ChartProblem(step.number, f"step {step.name}", text, "give each its own tag")
        seen.add(step.name.upper())
        starting = [action for action in step.actions if action.qualifier is not Qualifier.R]
        names = [action.name.upper() for action in starting]
        for action in starting:
            if names.count(action.name.upper()) > 1:
                text = f"step {step.name} has the action {action.name} twice"
                yield ChartProblem(action.number, f"action {action.name}", text, "give each its own tag")


def _end_problems(steps_by_name: Mapping[str, ChartStep], transition: Transition) -> Iterator[ChartProblem]:
    """Yield problems with the steps before and after a transition."""
    for name in (*transition.sources, *transition.targets):
        if name.upper() not in steps_by_name:
            steps = ", ".join(step.name for step in steps_by_name.values())
            yield _transition_problem(transition, f"no step {name}", f"steps are {steps}")
    for name in transition.sources:
        if name.upper() in steps_by_name and steps_by_name[name.upper()].stop:
            yield _transition_problem(
                transition, f"it leaves the stop {name}", "end the path there, or use a step"
            )
    if not (transition.sources and transition.targets):
        yield _transition_problem(
            transition, "it must have a step before it and one after it", "link it to both"
        )


def _transition_problem(transition: Transition, text: str, remedy: str) -> ChartProblem:
    return ChartProblem(transition.number, f"transition {transition.name}", text, remedy)


class _Net:
    """Follows all paths of a chart from its initial step."""

    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        self.legs: dict[str, Legs] = {}  # of the steps reached, by name in capitals
        self._sizes: dict[int, int] = {}  # legs of each divergence
        self._leaving = chart.leaving

    def problems(self) -> Iterator[ChartProblem]:
        """Yield the transitions at which branches are not correctly paired."""
        initial = self._chart.initial
        if initial is None:
            return
        self.legs[initial.name.upper()] = ()
        open_steps, fired = [initial.name.upper()], set[int]()
        while open_steps:
            for number in self._leaving[open_steps.pop()]:
                transition = self._chart.transitions[number]
                if number not in fired and all(name.upper() in self.legs for name in transition.sources):
                    fired.add(number)
                    yield from self._fire(number, transition, open_steps)

    def _fire(self, number: int, transition: Transition, open_steps: list[str]) -> Iterator[ChartProblem]:
        """Follow a transition to its targets, and add new ones to `open_steps`; yield unpaired branches."""
        joined = self._join([self.legs[name.upper()] for name in transition.sources])
        if joined is None:
            text = (
                f"it converges from {', '.join(transition.sources)}, which are not branches of one divergence"
            )
            yield _transition_problem(transition, text, "begin the branches with one simultaneous divergence")
            return
        self._sizes[number] = len(transition.targets)
        for leg, name in enumerate(transition.targets):
            target_legs = joined if len(transition.targets) == 1 else (*joined, (number, frozenset((leg,))))
            earlier_legs = self.legs.setdefault(name.upper(), target_legs)
            if earlier_legs is target_legs:
                open_steps.append(name.upper())
            elif earlier_legs != target_legs:
                text = f"it jumps to {name}, which is in another simultaneous branch, or in none"
                yield _transition_problem(
                    transition,
                    text,
                    "enter simultaneous branches by their divergence, leave by their convergence",
                )

    def _join(self, sources: list[Legs]) -> Legs | None:
        """Return the branches around a step after a convergence; None if its sources do not match."""
        if len(sources) == 1:
            return sources[0]
        if not all(sources):  # one is in no branch
            return None
        (*outer, (number, _)) = sources[0]
        joined_legs: set[int] = set()
        for *source_outer, (source_number, legs) in sources:
            if (source_outer, source_number) != (outer, number) or joined_legs & legs:
                return None
            joined_legs |= legs
        is_complete = len(joined_legs) == self._sizes[number]
        return tuple(outer) if is_complete else (*outer, (number, frozenset(joined_legs)))
