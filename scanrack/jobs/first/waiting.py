"""Finds the conditions a program waits for, where the power flow in a rung ends after the last scan.

    XIC(Auto) ==== EQU(Step,20) ==== XIC(PartThere) ---- OTE(Clamp)     it waits for XIC(PartThere)

Rungs with a true condition before the false one come first, in scan order, because they are closer to
passing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from scanrack.ladder.debug import Debugger
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.operands import Calculation, Group, Place
from scanrack.ladder.model.spec import InstructionKind
from scanrack.ladder.state.lowered import LoweredLine, LoweredRoutine, LoweredStep, steps_of
from scanrack.ladder.state.memory import Value

SHOWN = 3
"""Maximum number of conditions that are shown, and of lines in each explanation."""

HEADS = frozenset({"IF", "ELSIF", "WHILE"})
"""Instructions of structured text with a condition."""


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition that stops the power flow."""

    routine: str
    rung: int
    unit: str  # "rung" or "line"
    condition: str  # the instruction as written
    tag: str
    value: object
    why: str  # since when it has its value, and the cause

    def as_json(self) -> dict[str, object]:
        """Return the condition for `--json`."""
        return {name: getattr(self, name) for name in self.__slots__}

    def lines(self) -> Iterator[str]:
        """Yield the condition as lines of text."""
        yield f"{self.routine}, {self.unit} {self.rung}: {self.condition}"
        yield from (f"    {line}" for line in self.why.splitlines()[:SHOWN])


def conditions(debugger: Debugger) -> list[Condition]:
    """Return the first conditions that are false after the last scan, each of a different tag."""
    by_tag: dict[str, Condition] = {}
    for blocked in sorted(_blocked(debugger), key=lambda blocked: not blocked.is_reached):
        condition = _condition(debugger, blocked)
        if condition is not None:
            by_tag.setdefault(condition.tag, condition)
        if len(by_tag) == SHOWN:
            break
    return list(by_tag.values())


class _BlockedRung(NamedTuple):
    """A scanned line with a false condition."""

    is_reached: bool  # whether a condition before it is true; always for structured text
    routine: LoweredRoutine
    line: LoweredLine
    step: LoweredStep  # the first false condition


def _blocked(debugger: Debugger) -> Iterator[_BlockedRung]:
    """Yield the scanned lines with a false condition, in scan order."""
    for routine in debugger.engine.lowered.routines.values():
        if routine.frame or routine.name == "Axes3601":
            continue
        try:
            truths = debugger.truth(routine.name)
        except LadderError:
            continue
        find_false = _false_in_rung if routine.body is None else _false_head
        for line in routine.lines:
            power = truths[line.number] if line.number < len(truths) else None
            steps = steps_of(line.nodes, copies=False)
            index = find_false(steps, power) if power else None
            if power and index is not None:
                is_reached = routine.body is not None or any(power[:index])
                yield _BlockedRung(is_reached, routine, line, steps[index])


def _false_head(steps: Sequence[LoweredStep], power: Sequence[bool]) -> int | None:
    """Return the index of the false condition in a line of structured text, or None."""
    return len(steps) - 1 if steps and not power[-1] and steps[-1].name in HEADS else None


def _false_in_rung(steps: Sequence[LoweredStep], power: Sequence[bool]) -> int | None:
    """Return the index of the first false condition in a rung, or None."""
    if len(power) != len(steps):
        return None
    return next((index for index, step in enumerate(steps) if not power[index] and _is_condition(step)), None)


def _is_condition(step: LoweredStep) -> bool:
    return (step.spec.decides or step.spec.kind is InstructionKind.INPUT) and bool(step.operands)


def _condition(debugger: Debugger, blocked: _BlockedRung) -> Condition | None:
    """Describe a false condition by its first false tag, or by its first tag if none is false.

    Return None if it has no tag, or if its tag can't be explained.
    """
    _, routine, line, step = blocked
    tags = [tag for operand in step.operands for tag in _tags(operand)]
    if not tags:
        return None
    try:
        values = {tag_name: debugger.tags[tag_name] for tag_name in tags}
        tag = next((name for name, value in values.items() if value is False), tags[0])
        value, why = values[tag], _why(debugger, tag, values[tag])
    except (LadderError, ValueError):
        return None
    step_text = f"{step.name}({','.join(map(_text, step.operands))})"
    if routine.body is not None:
        step_text = line.text.strip() or step_text
    return Condition(
        routine.name, line.number, routine.unit, condition=step_text, tag=tag, value=value, why=why
    )


def _why(debugger: Debugger, tag: str, value: Value) -> str:
    """Explain a tag's value. Do not search past scans if no rung writes the tag."""
    if ":" in tag or any(mention.writes for mention in debugger.cross_reference.of(tag)):
        return str(debugger.why(tag))
    return f"{tag} is {int(value) if isinstance(value, bool) else value}: no rung writes it."


def _tags(operand: object) -> Iterator[str]:
    """Yield the tags in an operand, as written."""
    if isinstance(operand, (Place, Group)):
        yield operand.text
    elif isinstance(operand, Calculation):
        for inner in operand.operands:
            yield from _tags(inner)


def _text(operand: object) -> str:
    """Return an operand as written."""
    if isinstance(operand, Calculation):
        return f"{operand.name}({','.join(map(_text, operand.operands))})"
    return str(getattr(operand, "text", getattr(operand, "value", operand)))
