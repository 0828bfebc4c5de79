"""Lists the transitions that a step of a chart waits for, with the values that they read."""

from __future__ import annotations

from collections.abc import Iterator

from ..model.operands import Constant, Group, Place
from ..run.view import Tags
from ..state.lowered import ChartNode, ChartTransition, LoweredChart, LoweredProgram
from .cells import places_in
from .watched import shown


def waits_of(lowered: LoweredProgram, tags: Tags, where: Place | Group) -> Iterator[str]:
    """Yield the conditions that would end an active step, or start an inactive step, as lines."""
    for chart in lowered.charts.values():
        for node in chart.nodes:
            if _is_of(where, node):
                yield from _waits_of_step(chart, node, tags)


def _is_of(where: Place | Group, node: ChartNode) -> bool:
    """Return whether a tag is a step or its X bit."""
    if isinstance(where, Group):
        return where.path.upper() == node.tag.path.upper() and not where.dims
    x = node.bits["X"]
    return where.leaf is x.leaf and where.bit == x.bit


def _waits_of_step(chart: LoweredChart, node: ChartNode, tags: Tags) -> Iterator[str]:
    """Yield a heading, then the transitions that end the step if it is active, or else begin it."""
    active = bool(tags[node.bits["X"].text])
    if active and not node.stop:
        yield f"  step {node.name} is active; what ends it:"
    elif not active:
        yield f"  step {node.name} is not active; what begins it:"
    for transition in chart.transitions:
        if node in (transition.sources if active else transition.targets):
            yield f"    {_transition_text(transition, tags)}"


def _transition_text(transition: ChartTransition, tags: Tags) -> str:
    """Return a transition's source steps and condition as text, with the values that it reads."""
    sources = [
        f"{node.name} {'is' if tags[node.bits['X'].text] else 'is not'} active" for node in transition.sources
    ]
    places = [
        place
        for place in dict.fromkeys(places_in(transition.condition))
        if all(isinstance(index, Constant) for index in place.indices)  # computed ones are left out
    ]
    values = [f"{place.text} = {shown(tags[place.text])}" for place in places]
    read = f" [{', '.join(values)}]" if values else ""
    return f"transition {transition.name}, {' and '.join(sources)}: {transition.text}{read}"
