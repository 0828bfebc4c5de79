"""Rules about programs with steps: in which state a command is reached."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from ..facts import Step, StepAction, StepUse, Violation
from ..groups import grouped, reached
from ..subject import Subject
from .motion import ENDING, MOTIONS


class _Machine:
    """The steps of a program, as far as they concern one axis."""

    def __init__(self, actions: Sequence[StepAction], axis: str) -> None:
        self._goes = [action for action in actions if action.goes is not None and action.steps is not None]
        self._own = [action for action in actions if action.axis == axis]
        self.motions = [action for action in self._own if action.kind in MOTIONS and action.steps is not None]

    def onward(self, step: Step) -> Iterator[StepAction]:
        """Yield the actions that leave a step."""
        return (action for action in self._goes if action.steps == frozenset((step,)) and action.goes != step)

    def onward_with(self, motion: StepAction, step: Step) -> Iterator[StepAction]:
        """Yield the actions that leave a step; if some have the same condition as its motion, only those."""
        every = list(self.onward(step))
        own = [action for action in every if action.when == motion.when]
        yield from own if own and step in (motion.steps or ()) else every

    def clears(self, step: Step, bits: int) -> bool:
        """Whether anything may clear bits of the command word in a step."""
        return any(action.clears & bits for action in self._own if action.happens_in(step))

    def clears_before(self, step: Step, bits: int) -> bool:
        """Whether anything may clear bits of the command word in a step before its motion starts."""
        return any(
            action.clears & bits for action in self._own if action.happens_in(step) and not action.moves
        )

    def motions_with_steps(self) -> Iterator[tuple[StepAction, Step]]:
        """Yield the motions, each with the steps in which it may start."""
        return ((motion, step) for motion in self.motions for step in motion.steps or ())

    def motions_after(
        self, start: Step, onward: Callable[[State], Iterator[State]]
    ) -> Iterator[tuple[bool, StepAction]]:
        """Yield the motions of the steps that can follow a step, each with the fact about the path to it."""
        for step, fact in reached([(start, False)], onward):
            for motion in self.motions:
                if motion.steps == frozenset((step,)):
                    yield fact, motion


def unfinished(subject: Subject) -> Iterator[Violation]:
    """Find motions of a step that start while the motion of an earlier step may be under way."""
    for machine in _machines(subject):
        for first, start in machine.motions_with_steps():
            later = _next_unfinished(machine, first, start) if first.kind in ENDING else None
            if later is not None:
                text = (
                    f"{later.text} of step {_name(later)} begins while {first.text} of line "
                    f"{first.place.line}, step {_text(start)}, may be under way: "
                    "nothing between waits for its end"
                )
                yield Violation(later.place, text)


State = tuple[Step, bool]
"""A step, and a fact about the path to it."""


def _next_unfinished(machine: _Machine, first: StepAction, start: Step) -> StepAction | None:
    """Return the first later motion that may start before this one ends, as nothing waits for its end."""

    def onward(state: State) -> Iterator[State]:
        step, is_cleared = state
        is_cleared = is_cleared or machine.clears(step, first.sets)
        for edge in machine.onward_with(first, step):
            if edge.goes is not None and not edge.ends:
                yield edge.goes, is_cleared

    for is_cleared, other in machine.motions_after(start, onward):
        if (is_cleared or not other.sets & first.sets) and not other.ends:
            return other
    return None


FINAL = re.compile(r"done|end|finish|complete|ready|full|stop|idle|off|run", re.IGNORECASE)
"""Finds, in the names of steps, words that say that the step is meant to stay."""


def without_way_out(subject: Subject) -> Iterator[Violation]:
    """Find steps that are entered but never left.

    A start-up may end in a step that continues to work, and a list of steps may end. In rungs, a step counts
    as the end of a job if each step that leads to it may also lead elsewhere.
    """
    use = subject.facts.step_use
    if use is None:
        return
    leading = (action for action in subject.facts.actions if action.goes is not None)
    for machine, goes in grouped(leading, lambda each: each.machine).items():
        graph = _Graph(goes)
        for step in graph.dead_ends():
            step_use = use(machine, step)
            if step_use is not None and graph.is_stuck(step, step_use, subject.facts.first_steps(machine)):
                tag = subject.facts.variables.get(machine)
                name = machine if tag is None else tag.name
                text = f"{name} goes to step {_text(step)} here, and nothing leaves this step"
                yield Violation(graph.entering(step)[0].place, text)


class _Graph:
    """The steps of a machine and the transitions between them."""

    def __init__(self, goes: Sequence[StepAction]) -> None:
        self._goes = goes
        entered = dict.fromkeys(action.goes for action in goes if action.goes is not None)
        self._ways = {step: self._ways_from(step) for step in entered}
        self._turns = any(step in reached([step], lambda one: self._ways.get(one, ())) for step in entered)
        self._never_entered = {step for action in goes for step in action.steps or ()} - entered.keys()

    def _ways_from(self, step: Step) -> set[Step]:
        """Return the steps that can follow a step."""
        next_steps = (action.goes for action in self._goes if action.goes != step and action.happens_in(step))
        return {target for target in next_steps if target is not None}

    def entering(self, step: Step) -> list[StepAction]:
        """Return the actions that go to a step."""
        return [action for action in self._goes if action.goes == step]

    def dead_ends(self) -> Iterator[Step]:
        """Yield the steps that nothing leaves, except those that are final by name."""
        for step, next_steps in self._ways.items():
            is_final = isinstance(step, str) and FINAL.search(step)
            if not next_steps and not is_final:
                yield step

    def is_stuck(self, step: Step, use: StepUse, first: frozenset[Step]) -> bool:
        """Whether the program gets stuck in a dead end, rather than finishing there.

        Args:
            first: steps in which the machine may start.
        """
        another_is_meant = bool(self._never_entered - first)
        is_left = use.tested or self._turns or another_is_meant
        works_on = use.works and not self._turns
        return is_left and not works_on and not (self._is_one_of_several_ways(step) and not use.chosen)

    def _is_one_of_several_ways(self, step: Step) -> bool:
        """Whether each step that leads to this one may also lead elsewhere."""
        for action in self.entering(step):
            if action.steps is None:  # it happens in all steps
                return False
            for origin in action.steps:
                if len(self._ways_from(origin)) <= 1:
                    return False
        return True


def not_zeroed(subject: Subject) -> Iterator[Violation]:
    """Find commands that the module does not notice because their bit is still set from the previous one."""
    for machine in _machines(subject):
        for first, start in machine.motions_with_steps():
            later = _next_unseen(machine, first, start) if first.sets else None
            if later is not None:
                text = (
                    f"{later.text} of step {_name(later)} is no new one: its bit is still set from line "
                    f"{first.place.line}, step {_text(start)}, and no step between clears it"
                )
                yield Violation(later.place, text)


def _next_unseen(machine: _Machine, first: StepAction, start: Step) -> StepAction | None:
    """Return the first later motion whose bit has stayed set although the previous motion has ended."""

    def onward(state: State) -> Iterator[State]:
        step, has_ended = state
        if machine.clears(step, first.sets):
            return
        for edge in machine.onward_with(first, step):
            if edge.goes is not None and not machine.clears_before(edge.goes, first.sets):
                yield edge.goes, has_ended or edge.ends

    for has_ended, other in machine.motions_after(start, onward):
        if has_ended and other.sets & first.sets:
            return other
    return None


def _machines(subject: Subject) -> Iterator[_Machine]:
    """Yield the steps of each axis that they command."""
    for actions in grouped(subject.facts.actions, lambda each: each.machine).values():
        for axis in dict.fromkeys(action.axis for action in actions if action.kind in MOTIONS):
            yield _Machine(actions, axis)


def _name(action: StepAction) -> str:
    return _text(next(iter(action.steps or ()), ""))


def _text(step: Step) -> str:
    return step if isinstance(step, str) else f"{step:g}"
