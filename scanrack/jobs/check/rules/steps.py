"""Rules about programs that go from step to step: what a command finds when it is reached."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from ..facts import Step, StepAction
from ..subject import Subject, Violation
from .motion import ENDING, MOTIONS


class _Machine:
    """The steps of a program, as far as one axis is concerned."""

    def __init__(self, actions: Sequence[StepAction], axis: str) -> None:
        self._goes = [each for each in actions if each.goes is not None and each.steps is not None]
        self._own = [each for each in actions if each.axis == axis]
        self.motions = [each for each in self._own if each.kind in MOTIONS and each.steps is not None]

    def onward(self, step: Step) -> Iterator[StepAction]:
        """Yield what continues from a step."""
        return (each for each in self._goes if each.steps == frozenset((step,)) and each.goes != step)

    def onward_with(self, motion: StepAction, step: Step) -> Iterator[StepAction]:
        """Yield what leads on from a step of a motion: what has its condition, if anything has; else all."""
        every = list(self.onward(step))
        own = [each for each in every if each.when == motion.when]
        yield from own if own and step in (motion.steps or ()) else every

    def clears(self, step: Step, bits: int) -> bool:
        """Whether something may clear bits of the command word in a step."""
        return any(each.clears & bits for each in self._own if each.happens_in(step))

    def clears_before(self, step: Step, bits: int) -> bool:
        """Whether something may clear bits of the command word in a step before its motion."""
        return any(each.clears & bits for each in self._own if each.happens_in(step) and not each.moves)

    def motions_in(self, step: Step) -> Iterator[StepAction]:
        """Yield the motions of a step."""
        return (each for each in self.motions if each.steps == frozenset((step,)))


def unfinished(subject: Subject) -> Iterator[Violation]:
    """Find motions of a step that begin while that of an earlier step may be under way."""
    for machine in _machines(subject):
        for first in machine.motions:
            for start in first.steps or () if first.kind in ENDING else ():
                later = _next_unfinished(machine, first, start)
                if later is not None:
                    text = (
                        f"{later.text} of step {_name(later)} begins while {first.text} of line "
                        f"{first.place.line}, step {_text(start)}, may be under way: "
                        "nothing between waits for its end"
                    )
                    yield Violation(later.place, text)


def _next_unfinished(machine: _Machine, first: StepAction, start: Step) -> StepAction | None:
    """Return the first motion behind a step that no condition on the way delays until the one before ends."""
    seen: set[tuple[Step, bool]] = set()
    todo: list[tuple[Step, bool]] = [(start, machine.clears(start, first.sets))]
    while todo:
        step, is_cleared = todo.pop(0)
        for edge in machine.onward_with(first, step):
            if edge.ends or edge.goes is None or (edge.goes, is_cleared) in seen:
                continue
            seen.add((edge.goes, is_cleared))
            for other in machine.motions_in(edge.goes):
                is_new = is_cleared or not other.sets & first.sets
                if is_new and not other.ends:
                    return other
            todo.append((edge.goes, is_cleared or machine.clears(edge.goes, first.sets)))
    return None


FINAL = re.compile(r"done|end|finish|complete|ready|full|stop|idle|off|run", re.IGNORECASE)
"""In names of steps that are meant to stay."""


def without_way_out(subject: Subject) -> Iterator[Violation]:
    """Find steps that are entered and that nothing leaves.

    A start-up that ends in a step which goes on working is none, nor is the end of a list of steps. In rungs
    a step to which its steps go at choice is taken for the end of a job.
    """
    use = subject.facts.step_use
    machines: dict[str, list[StepAction]] = {}
    for each in subject.facts.actions if use is not None else ():
        if each.goes is not None:
            machines.setdefault(each.machine, []).append(each)
    for machine, goes in machines.items():
        ways = {step: _ways(step, goes) for step in {each.goes for each in goes if each.goes is not None}}
        turns = any(step in _reached(step, ways) for step in ways)
        left = {one for each in goes for one in each.steps or ()} - ways.keys()
        for step, onward in ways.items():
            if onward or (isinstance(step, str) and FINAL.search(step)) or use is None:
                continue
            entered = [each for each in goes if each.goes == step]
            found = use(machine, step)
            is_missed = bool(left - subject.facts.first_steps(machine))  # another step is meant
            if found is None:
                continue
            is_end = not found.chosen and all(
                each.steps is not None and all(len(_ways(one, goes)) > 1 for one in each.steps)
                for each in entered
            )
            if (found.tested or turns or is_missed) and (turns or not found.works) and not is_end:
                tag = subject.facts.variables.get(machine)
                name = machine if tag is None else tag.name
                text = f"{name} goes to step {_text(step)} here, and nothing leaves this step"
                yield Violation(entered[0].place, text)


def _ways(step: Step, goes: Sequence[StepAction]) -> set[Step]:
    """Return the steps that follow a step."""
    return {
        each.goes for each in goes if each.goes is not None and each.goes != step and each.happens_in(step)
    }


def _reached(step: Step, ways: Mapping[Step, set[Step]]) -> set[Step]:
    """Return the steps that can be reached from a step."""
    found: set[Step] = set()
    todo = [step]
    while todo:
        for each in ways.get(todo.pop(), ()):
            if each not in found:
                found.add(each)
                todo.append(each)
    return found


def not_zeroed(subject: Subject) -> Iterator[Violation]:
    """Find commands that the module does not see, since their bit is still set from the one before."""
    for machine in _machines(subject):
        for first in machine.motions:
            for start in first.steps or () if first.sets else ():
                later = _next_unseen(machine, first, start)
                if later is not None:
                    text = (
                        f"{later.text} of step {_name(later)} is no new one: its bit is still set from line "
                        f"{first.place.line}, step {_text(start)}, and no step between clears it"
                    )
                    yield Violation(later.place, text)


def _next_unseen(machine: _Machine, first: StepAction, start: Step) -> StepAction | None:
    """Return the first motion behind a step whose bit nothing clears before, though a motion has ended."""
    if machine.clears(start, first.sets):
        return None
    seen: set[tuple[Step, bool]] = set()
    todo: list[tuple[Step, bool]] = [(start, False)]
    while todo:
        step, has_ended = todo.pop(0)
        for edge in machine.onward_with(first, step):
            here = edge.goes
            ended = has_ended or edge.ends
            if here is None or (here, ended) in seen or machine.clears_before(here, first.sets):
                continue
            seen.add((here, ended))
            for other in machine.motions_in(here):
                if ended and other.sets & first.sets:
                    return other
            if not machine.clears(here, first.sets):
                todo.append((here, ended))
    return None


def _machines(subject: Subject) -> Iterator[_Machine]:
    """Yield the steps of each axis, if they command it at all."""
    found: dict[str, list[StepAction]] = {}
    for each in subject.facts.actions:
        found.setdefault(each.machine, []).append(each)
    for actions in found.values():
        for axis in dict.fromkeys(each.axis for each in actions if each.kind in MOTIONS):
            yield _Machine(actions, axis)


def _name(action: StepAction) -> str:
    return _text(next(iter(action.steps or ()), ""))


def _text(step: Step) -> str:
    return step if isinstance(step, str) else f"{step:g}"
