"""The commands that the axes of a program with sequences send, and the lines that await them.

An axis writes its module's words after the sequences have run, so no line of the program writes them.
It writes them for its present command, so they belong to the sequence's line that awaits that command.
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
    """Return the writers of the words of a program's modules, each with its command."""
    if isinstance(logic, Steps):
        return [Sender(logic.slot, "", Line(str(program), logic.line, "a step"))]
    if not isinstance(logic, Logic):
        return []
    return [_sender(logic, part) for part in parts_of(logic) if isinstance(part, Axis3601)]


def _sender(logic: Logic, axis: Axis3601) -> Sender:
    command = axis.commanded
    if command is None:
        return Sender(axis.slot, f"{axis.name}, before its first command", NOWHERE)
    if not command.busy:
        became = command.outcome.value
        return Sender(axis.slot, f"{axis.name}, after {command!r}: {became}", NOWHERE)
    waiting = [sequence for sequence in sequences_of(logic) if repr(command) in sequence.waits_for]
    line = NOWHERE
    if waiting:
        first = waiting[0]
        line = Line(first.file or "", first.line or 0, first.name)
    return Sender(axis.slot, f"{axis.name} for {command!r}", line)
