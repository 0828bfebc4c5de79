"""The commands that the axes of a program with sequences send, and the lines that await them.

An axis writes its module's words after the sequences have run, so no line of the program writes them.
A change in these words is attributed to the line of the sequence that awaits the axis's current command.
"""

from __future__ import annotations

from pathlib import Path

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.files.steps import Steps
from scanrack.ladder.python.axis3601 import Axis3601
from scanrack.ladder.python.sequences import Logic, parts_of, sequences_of

from .lines import NOWHERE, Line


@dataclass(frozen=True, slots=True)
class Sender:
    """An axis, or a step in a list of steps, that writes the words of a slot."""

    slot: int
    text: str  # the axis and its command in words; empty for a step
    line: Line  # the line that awaits the command, or `NOWHERE`


def senders(logic: object, program: Path) -> list[Sender]:
    """Return the axes, or the step in a list of steps, that write the words of a program's modules."""
    if isinstance(logic, Steps):
        return [Sender(logic.slot, "", Line(str(program), logic.line, "a step"))]
    if not isinstance(logic, Logic):
        return []
    return [_sender(logic, part) for part in parts_of(logic) if isinstance(part, Axis3601)]


def _sender(logic: Logic, axis: Axis3601) -> Sender:
    """Return an axis as the sender of its words, with its latest command and the line that awaits it."""
    command = axis.commanded
    if command is None:
        return Sender(axis.slot, f"{axis.name}, before its first command", NOWHERE)
    if not command.busy:
        return Sender(axis.slot, f"{axis.name}, after {command!r}: {command.outcome.value}", NOWHERE)
    waiting = (sequence for sequence in sequences_of(logic) if repr(command) in sequence.waits_for)
    sequence = next(waiting, None)
    line = NOWHERE if sequence is None else Line(sequence.file or "", sequence.line or 0, sequence.name)
    return Sender(axis.slot, f"{axis.name} for {command!r}", line)
