"""Rules about programs with steps: the state of the axis when a command starts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from ..facts import Step, StepAction, StepUse, Violation
from ..groups import grouped, reached
from ..subject import Subject
from .motion import ENDING, MOTIONS


class _Machine:
    """The steps of a program that concern one axis.

    Attributes:
        motions: the motions of the axis that start in known steps.
    """

    def __init__(self, actions: Sequence[StepAction], axis: str) -> None:
        self._changes = [change for change in actions if change.goes is not None and change.steps is not None]
        self._axis_actions = [action for action in actions if action.axis == axis]
        self.motions = [
            action for action in self._axis_actions if action.kind in MOTIONS and action.steps is not None
        ]

    def changes_after(self, motion: StepAction, step: Step) -> list[StepAction]:
        """Return the changes from one step to another.

        If the motion starts in this step, changes that have the same condition as the motion take precedence.
        """
        changes = [
            change for change in self._changes if change.steps == frozenset((step,)) and change.goes != step
        ]
        with_motion = [change for change in changes if change.when == motion.when]
        return with_motion if with_motion and step in (motion.steps or ()) else changes

    def clears(self, step: Step, bits: int) -> bool:
        """Whether anything may clear bits of the command word in a step."""
        return any(action.clears & bits for action in self._axis_actions if action.happens_in(step))

    def clears_before(self, step: Step, bits: int) -> bool:
        """Whether anything may clear bits of the command word in a step before its motion starts."""
        actions = (action for action in self._axis_actions if action.happens_in(step))
        return any(action.clears & bits for action in actions if not action.moves)

    def motions_with_steps(self) -> Iterator[tuple[StepAction, Step]]:
        """Yield the motions, each with the steps in which it may start."""
        return ((motion, step) for motion in self.motions for step in motion.steps or ())

    def motions_after(
        self, start: Step, onward: Callable[[State], Iterator[State]]
    ) -> Iterator[tuple[bool, StepAction]]:
        """Yield the motions of the steps that can follow a step, each with the flag of the path to it."""
        for step, flag in reached([(start, False)], onward):
            for motion in self.motions:
                if motion.steps == frozenset((step,)):
                    yield flag, motion


def unfinished(subject: Subject) -> Iterator[Violation]:
    """Find motions of a step that start while the motion of an earlier step may still be under way."""
    for machine in _machines(subject):
        for first, start in machine.motions_with_steps():
            later = _next_unfinished(machine, first, start) if first.kind in ENDING else None
            if later is not None:
                text = (
                    f"{later.text} of step {_step_of(later)} begins while {first.text} of line "
                    f"{first.place.line}, step {_text(start)}, may still be in motion: "
                    "no step between them waits for its end"
                )
                yield Violation(later.place, text)


State = tuple[Step, bool]
"""A step, and a flag for the path to it: whether the command bit was cleared, or the motion has ended."""


def _next_unfinished(machine: _Machine, first: StepAction, start: Step) -> StepAction | None:
    """Return the first later motion that may start before this motion ends; None if there is none."""

    def onward(state: State) -> Iterator[State]:
        """Yield the states after a step, without changes that wait for an end of motion."""
        step, is_cleared = state
        is_cleared = is_cleared or machine.clears(step, first.sets)
        for change in machine.changes_after(first, step):
            if change.goes is not None and not change.ends:
                yield change.goes, is_cleared

    for is_cleared, later in machine.motions_after(start, onward):
        if (is_cleared or not later.sets & first.sets) and not later.ends:
            return later
    return None


FINAL = re.compile(r"done|end|finish|complete|ready|full|stop|idle|off|run", re.IGNORECASE)
"""Finds, in the names of steps, words for steps where a program may stay."""


def without_way_out(subject: Subject) -> Iterator[Violation]:
    """Find steps that are entered but never left.

    A start-up may end in a step that continues to work, and a list of steps may end. In rungs, a step counts
    as the end of a job if each step before it may also lead elsewhere.
    """
    use_of_step = subject.facts.step_use
    if use_of_step is None:
        return
    changes = (action for action in subject.facts.actions if action.goes is not None)
    for machine, machine_changes in grouped(changes, lambda change: change.machine).items():
        graph = _Graph(machine_changes)
        for step in graph.dead_ends():
            use = use_of_step(machine, step)
            if use is not None and graph.is_stuck(step, use, subject.facts.first_steps(machine)):
                tag = subject.facts.variables.get(machine)
                name = machine if tag is None else tag.name
                text = f"{name} goes to step {_text(step)} here, but nothing leaves this step"
                yield Violation(graph.entering(step)[0].place, text)


class _Graph:
    """The steps of a machine and the transitions between them."""

    def __init__(self, changes: Sequence[StepAction]) -> None:
        self._changes = changes
        entered = dict.fromkeys(change.goes for change in changes if change.goes is not None)
        self._next_steps = {step: self._next_of(step) for step in entered}
        # `reached` contains the start only if a change leads back to it
        self._has_cycle = any(
            step in reached([step], lambda start: self._next_steps.get(start, ())) for step in entered
        )
        self._never_entered = {step for change in changes for step in change.steps or ()} - entered.keys()

    def _next_of(self, step: Step) -> set[Step]:
        """Return the steps that can follow a step."""
        targets = (change.goes for change in self._changes if change.goes != step and change.happens_in(step))
        return {target for target in targets if target is not None}

    def entering(self, step: Step) -> list[StepAction]:
        """Return the changes to a step."""
        return [change for change in self._changes if change.goes == step]

    def dead_ends(self) -> Iterator[Step]:
        """Yield the steps that are never left, except steps whose names mark a final step."""
        for step, next_steps in self._next_steps.items():
            is_final = isinstance(step, str) and FINAL.search(step)
            if not next_steps and not is_final:
                yield step

    def is_stuck(self, step: Step, use: StepUse, first_steps: frozenset[Step]) -> bool:
        """Whether the program gets stuck in a dead end, rather than finishing there.

        Args:
            first_steps: steps in which the machine may start.
        """
        if use.works and not self._has_cycle:
            return False  # a start-up has ended, and the program works in this step
        if not use.chosen and self._has_alternatives(step):
            return False  # a job has ended
        has_unreached_step = bool(self._never_entered - first_steps)
        return use.tested or self._has_cycle or has_unreached_step

    def _has_alternatives(self, step: Step) -> bool:
        """Whether each step that leads to this step may also lead elsewhere."""
        for change in self.entering(step):
            if change.steps is None:  # it happens in all steps
                return False
            for origin in change.steps:
                if len(self._next_of(origin)) <= 1:
                    return False
        return True


def not_zeroed(subject: Subject) -> Iterator[Violation]:
    """Find commands that the module ignores because their bit is still set from the previous command."""
    for machine in _machines(subject):
        for first, start in machine.motions_with_steps():
            later = _next_ignored(machine, first, start) if first.sets else None
            if later is not None:
                text = (
                    f"{later.text} of step {_step_of(later)} has no effect: its bit is still set from line "
                    f"{first.place.line}, step {_text(start)}, and no step between them clears it"
                )
                yield Violation(later.place, text)


def _next_ignored(machine: _Machine, first: StepAction, start: Step) -> StepAction | None:
    """Return the first later motion whose bit has stayed set although the previous motion has ended."""

    def onward(state: State) -> Iterator[State]:
        """Yield the states after a step, unless this step or the next one clears the bits of the motion."""
        step, has_ended = state
        if machine.clears(step, first.sets):
            return
        for change in machine.changes_after(first, step):
            if change.goes is not None and not machine.clears_before(change.goes, first.sets):
                yield change.goes, has_ended or change.ends

    for has_ended, later in machine.motions_after(start, onward):
        if has_ended and later.sets & first.sets:
            return later
    return None


def _machines(subject: Subject) -> Iterator[_Machine]:
    """Yield the machines of the program, once for each axis that they command."""
    for actions in grouped(subject.facts.actions, lambda action: action.machine).values():
        for axis in dict.fromkeys(action.axis for action in actions if action.kind in MOTIONS):
            yield _Machine(actions, axis)


def _step_of(action: StepAction) -> str:
    """Return a step of an action as text; "" for an action in all steps."""
    return _text(next(iter(action.steps or ()), ""))


def _text(step: Step) -> str:
    return step if isinstance(step, str) else f"{step:g}"
