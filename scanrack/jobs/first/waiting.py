"""Finds the conditions for which a program waits: where the power in a rung ends after the last scan.

    XIC(Auto) ==== EQU(Step,20) ==== XIC(PartThere) ---- OTE(Clamp)     it waits for XIC(PartThere)

A rung whose first conditions pass is closer to passing than a rung whose first condition is false. Such rungs
come first, in scan order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scanrack.ladder.debug import Debugger
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.operands import Calculation, Group, Place
from scanrack.ladder.model.spec import InstructionKind
from scanrack.ladder.state.lowered import LoweredLine, LoweredRoutine, LoweredStep, steps_of
from scanrack.ladder.state.memory import Value

SHOWN = 3
"""Largest number of conditions that are shown."""


HEADS = frozenset({"IF", "ELSIF", "WHILE"})
"""Instructions of structured text with a condition."""


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition that stops the power."""

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
    """Return the first conditions that are false after the last scan."""
    blocked = sorted(_blocked(debugger), key=lambda each: not each[0])
    conditions: list[Condition] = []
    for _, routine, line, step in blocked:
        condition = _condition(debugger, routine, line, step)
        if condition is not None and condition.tag not in [known.tag for known in conditions]:
            conditions.append(condition)
        if len(conditions) == SHOWN:
            break
    return conditions


def _blocked(debugger: Debugger) -> Iterator[tuple[bool, LoweredRoutine, LoweredLine, LoweredStep]]:
    """Yield scanned rungs with a false condition, and whether a condition before it passes."""
    for routine in debugger.engine.lowered.routines.values():
        if routine.frame or routine.name == "Axes3601":
            continue
        try:
            truths = debugger.truth(routine.name)
        except LadderError:
            continue
        find = _false_in_rung if routine.body is None else _false_head
        for line in routine.lines:
            power = truths[line.number] if line.number < len(truths) else None
            step = find(steps_of(line.nodes, copies=False), power) if power else None
            if step is not None:
                yield step[0], routine, line, step[1]


def _false_head(steps: Sequence[LoweredStep], power: Sequence[bool]) -> tuple[bool, LoweredStep] | None:
    """Return the false condition of structured text; it always counts as reached."""
    return (True, steps[-1]) if steps and not power[-1] and steps[-1].name in HEADS else None


def _false_in_rung(steps: Sequence[LoweredStep], power: Sequence[bool]) -> tuple[bool, LoweredStep] | None:
    """Return the first false condition of a rung, and whether a condition before it passes."""
    for place, step in enumerate(steps if len(power) == len(steps) else ()):
        if not power[place] and _is_condition(step):
            return any(power[:place]), step
    return None


def _is_condition(step: LoweredStep) -> bool:
    return (step.spec.decides or step.spec.kind is InstructionKind.INPUT) and bool(step.operands)


def _condition(
    debugger: Debugger, routine: LoweredRoutine, line: LoweredLine, step: LoweredStep
) -> Condition | None:
    tags = [operand_tag for operand in step.operands for operand_tag in _tags(operand)]
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
    return Condition(routine.name, line.number, routine.unit, step_text, tag, value, why)


def _why(debugger: Debugger, tag: str, value: Value) -> str:
    """Return why a tag has its value; do not search the past if nothing writes the tag."""
    if ":" in tag or any(mention.writes for mention in debugger.cross_reference.of(tag)):
        return str(debugger.why(tag))
    return f"{tag} is {int(value) if isinstance(value, bool) else value}: no rung writes it."


def _tags(operand: object) -> Iterator[str]:
    if isinstance(operand, (Place, Group)):
        yield operand.text
    elif isinstance(operand, Calculation):
        for part in operand.operands:
            yield from _tags(part)


def _text(operand: object) -> str:
    if isinstance(operand, Calculation):
        return f"{operand.name}({','.join(map(_text, operand.operands))})"
    return str(getattr(operand, "text", getattr(operand, "value", operand)))
