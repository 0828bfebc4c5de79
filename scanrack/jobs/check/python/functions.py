"""Facts of a Python program that is a function of the scan."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence, Set
from pathlib import Path
from typing import Any

from scanrack.io_images.amci3601 import Configuration, FindHome, Move
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.runtime.config.rackspec import RackSpec

from ..facts import Facts, FileLine, SentCommand, Violation
from .attributes import note_names
from .counting import note_counting
from .flow import Flow
from .hand_writes import HandWrites
from .images import Images
from .loops import fixed_loops
from .reader import Reader
from .reals import note_reals
from .scans import Scans
from .steps import PythonSteps
from .times import note_short_times
from .walk import Walk


def python_facts(path: Path, names: Mapping[str, Any], terminals: Set[str], spec: RackSpec) -> Facts:
    """Return the facts of a Python program.

    Args:
        names: global names of its module, with their values.
    """
    tree = ast.parse(read_input_text(path, TextKind.PYTHON))
    facts = Facts(not_seen=["values that the program computes", "words written without a command's class"])
    reader = Reader(str(path), tree, names, facts)
    _note_commands(reader)
    facts.remarks["command-held"] += reader.commands_never_cleared()
    note_short_times(reader, spec.scan_ns)
    for line, text in fixed_loops(tree):
        facts.remark("never-waits", FileLine(str(path), line), text)
    facts.uses_bit = reader.uses_bit(terminals)
    Flow(reader).note()
    Scans(reader, spec).note()
    note_reals(reader)
    note_counting(reader)
    note_names(reader)
    images = Images(reader, spec)
    images.note()
    steppers = [slot.number for slot in spec.slot if is_stepper(slot.words)]
    walk = Walk(reader)
    steps = PythonSteps(walk, images, steppers)
    writes = HandWrites(walk, steps, steppers)
    facts.writes = list(writes.writes())
    facts.actions = [*steps.changes, *writes.actions]
    facts.step_use, facts.first_steps = steps.use, steps.first
    facts.outputs = writes.outputs
    facts.remarks["lossy-conversion"] += writes.remarks
    if terminals and facts.uses_bit is None:
        facts.not_seen.append("which terminals of the cards the program uses: it names none of them")
    return facts


def _note_commands(reader: Reader) -> None:
    """Note the commands that a text constructs, and commands with arguments that the module refuses."""
    facts = reader.facts
    moves: list[tuple[FileLine, str, int]] = []  # the line, class and speed of each
    starting_speeds: list[int] = []
    for kind, call in reader.calls():
        place = reader.place(call)
        if kind == "FindHome":
            facts.searches.append(SentCommand(place, None))
        try:
            command = reader.make(kind, call)
        except ValueError as error:
            facts.remark("out-of-range", place, f"{kind}: {error}")
            continue
        if isinstance(command, Configuration):
            facts.configurations.append(SentCommand(place, None, tuple(command.to_image().words.tolist())))
            starting_speeds.append(command.starting_speed)
        elif isinstance(command, Move | FindHome) and "speed" in reader.known(kind, call):
            moves.append((place, kind, command.speed))
    facts.remarks["out-of-range"] += _too_slow(moves, starting_speeds)


def _too_slow(
    moves: Sequence[tuple[FileLine, str, int]], starting_speeds: Sequence[int]
) -> Iterator[Violation]:
    """Yield the moves and home searches that are slower than the starting speed in every configuration."""
    least = min(starting_speeds, default=0)
    for place, kind, speed in moves:
        if speed < least:
            yield Violation(place, f"{kind}: speed {speed} is below the starting speed, {least}")
