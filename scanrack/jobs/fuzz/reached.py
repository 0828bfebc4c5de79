"""The coverage of a campaign: instructions that passed power, or branches that were taken."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from operator import or_
from pathlib import Path
from typing import NamedTuple

from scanrack.ladder import LadderLogic
from scanrack.ladder.compiler.observed import Reading, lines_of
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram, LoweredRoutine, steps_of

from ..check.rungs.view import own_routines
from ..load.loading import LoadedRack
from .aim.branches import branch_lines
from .aim.corpus import Feature
from .aim.probe import noting

LARGE = 1 << 30
"""Count for a number of instructions that is recorded only by size, see `aim.probe.SMALL`."""


@dataclass(frozen=True, slots=True)
class Gap:
    """An instruction or branch that no run has reached.

    Attributes:
        text: the instruction or line, with its place.
        number: index of the instruction in `LoweredProgram.sites`; None for a branch of a Python program.
    """

    text: str
    number: int | None = None


@dataclass(frozen=True, slots=True)
class ProgramReach:
    """Instructions that passed power in some run, or branches that were taken.

    Attributes:
        unit: phrase for the counted instructions or branches.
        total: number of instructions or branches.
        gaps: the instructions or branches that no run has reached, in program order.
    """

    unit: str
    total: int
    gaps: tuple[Gap, ...]


def reached(job: LoadedRack, seen: Collection[Feature]) -> ProgramReach:
    """Return the coverage of the user's own part of the program.

    Args:
        seen: the changes in all runs, see `aim.corpus.Corpus`.
    """
    if isinstance(job.logic, LadderLogic):
        return _ladder_reach(job.logic, seen)
    return _python_reach(job.program, seen)


def _ladder_reach(logic: LadderLogic, seen: Collection[Feature]) -> ProgramReach:
    """Return the coverage of the user's instructions in a ladder program."""
    lowered = logic.compile().lowered
    passed_by_site = dict(_instructions(logic, lowered, _notes_in(seen)))
    gaps: list[Gap] = []
    for number, has_passed in passed_by_site.items():
        if not has_passed:
            site = lowered.sites[number]
            gaps.append(Gap(f"{site.instruction} in {site.routine}, {site.place}", number))
    return ProgramReach("instructions of the program had power", len(passed_by_site), tuple(gaps))


def _python_reach(program: Path, seen: Collection[Feature]) -> ProgramReach:
    """Return the coverage of the branches of a Python program."""
    lines = branch_lines(program.read_bytes(), program.name)
    taken = bytearray(len(lines))
    for group, kind in seen:
        if group == "path" and isinstance(kind, bytes) and len(kind) == len(lines):
            taken = bytearray(map(or_, taken, kind))
    gaps = [
        Gap(f"{program.name}:{line}") for line, is_taken in zip(lines, taken, strict=True) if not is_taken
    ]
    return ProgramReach("branches of the program were taken", len(lines), tuple(gaps))


class _Notes(NamedTuple):
    """The probe's notes from all runs.

    Attributes:
        counts: largest number of instructions that passed power, by index of the note.
        powered: indices of the instructions that passed power, by index of a line with a note for each
            instruction.
    """

    counts: dict[int, int]
    powered: dict[int, set[int]]


def _notes_in(seen: Collection[Feature]) -> _Notes:
    """Return the notes about power in rungs from the changes in all runs."""
    notes = _Notes({}, {})
    for group, kind in seen:
        match group, kind:
            case "path", (_, int() as note, tuple() as truth):
                powered = {index for index, is_true in enumerate(truth) if is_true}
                notes.powered.setdefault(note, set()).update(powered)
            case "path", (_, int() as note, int() as count):
                notes.counts[note] = max(notes.counts.get(note, -1), count)
            case "size", (0, int() as note, *_):  # reader 0 reads the power in rungs
                notes.counts[note] = LARGE
    return notes


def _instructions(logic: LadderLogic, lowered: LoweredProgram, notes: _Notes) -> Iterator[tuple[int, bool]]:
    """Yield each instruction's site in the user's own lines, and whether the instruction passed power."""
    readings = noting(lowered).readings
    for number, _routine, line in own_lines(logic, lowered):
        powered = notes.powered.get(number, ())
        for index, step in enumerate(steps_of(line.nodes)):
            yield step.site, index in powered or _passed_power(readings[number], index, notes.counts)


def own_lines(
    logic: LadderLogic, lowered: LoweredProgram
) -> Iterator[tuple[int, LoweredRoutine, LoweredLine]]:
    """Yield each line of the user's own routines, with its index in `lines_of` and its routine."""
    index_of = {key: index for index, key in enumerate(lines_of(lowered))}
    for routine in own_routines(logic, lowered):
        for line in routine.lines:
            yield index_of[routine.name.upper(), line.number], routine, line


def _passed_power(reading: Reading, index: int, counts: Mapping[int, int]) -> bool:
    """Return whether an instruction of a line passed power: all its counts must be above their limits."""
    if index >= len(reading):
        return True  # nothing is recorded for this instruction, so no gap is reported
    first_note, first_limit, further = reading[index]
    limits = ((first_note, first_limit), *further)
    return all(counts.get(note, -1) > limit for note, limit in limits)
