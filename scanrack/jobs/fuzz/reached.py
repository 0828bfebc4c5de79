"""The coverage of a campaign: instructions that passed power, branches that were taken."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from operator import or_
from pathlib import Path

from scanrack.ladder import LadderLogic
from scanrack.ladder.compiler.observed import Reading, lines_of
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram, LoweredRoutine, steps_of

from ..check.rungs.view import own_routines
from ..load.loading import LoadedRack
from .aim.branches import branch_lines
from .aim.corpus import Feature
from .aim.probe import noting

LARGE = 1 << 30
"""Stands for a number of instructions of which only the size is recorded, see `aim.probe.SMALL`."""


@dataclass(frozen=True, slots=True)
class Gap:
    """An instruction or branch that no run has reached.

    Attributes:
        text: the instruction or line, with its place.
        number: index of an instruction in `LoweredProgram.sites`; None for a branch of a Python program.
    """

    text: str
    number: int | None = None


@dataclass(frozen=True, slots=True)
class ProgramReach:
    """Instructions that passed power in some run, or branches that were taken.

    Attributes:
        what: name of the counted things.
        total: their number.
        gaps: the instructions or branches that were not reached, in program order.
    """

    what: str
    total: int
    gaps: tuple[Gap, ...]


def reached(job: LoadedRack, seen: Collection[Feature]) -> ProgramReach:
    """Return the coverage of the user's own part of the program.

    Args:
        seen: the changes in all runs, see `aim.corpus.Corpus`.
    """
    if isinstance(job.logic, LadderLogic):
        return _of_rungs(job.logic, seen)
    return _of_python(job.program, seen)


def _of_rungs(logic: LadderLogic, seen: Collection[Feature]) -> ProgramReach:
    lowered = logic.compile().lowered
    passed = dict(_instructions(logic, lowered, *_noted(seen)))
    sites = lowered.sites
    gaps = (
        Gap(f"{sites[number].instruction} in {sites[number].routine}, {sites[number].place}", number)
        for number, true in passed.items()
        if not true
    )
    return ProgramReach("instructions of the program had power", len(passed), tuple(gaps))


def _of_python(program: Path, seen: Collection[Feature]) -> ProgramReach:
    lines = branch_lines(program.read_bytes(), program.name)
    taken_lines = bytearray(len(lines))
    for group, kind in seen:
        if group == "path" and isinstance(kind, bytes) and len(kind) == len(lines):
            taken_lines = bytearray(map(or_, taken_lines, kind))
    gaps = [Gap(f"{program.name}:{line}") for line, was in zip(lines, taken_lines, strict=True) if not was]
    return ProgramReach("branches of the program were taken", len(lines), tuple(gaps))


def _noted(seen: Collection[Feature]) -> tuple[dict[int, int], dict[int, set[int]]]:
    """Return the largest count at each place of the notes, and the truths of lines that record truths."""
    counts: dict[int, int] = {}
    truths: dict[int, set[int]] = {}
    for group, kind in seen:
        match group, kind:
            case "path", (_, int() as place, tuple() as true):
                truths.setdefault(place, set()).update(index for index, is_true in enumerate(true) if is_true)
            case "path", (_, int() as place, int() as count):
                counts[place] = max(counts.get(place, -1), count)
            case "size", (0, int() as place, *_):
                counts[place] = LARGE
    return counts, truths


def _instructions(
    logic: LadderLogic, lowered: LoweredProgram, counts: Mapping[int, int], truths: Mapping[int, set[int]]
) -> Iterator[tuple[int, bool]]:
    """Yield each instruction of the program's own lines, and whether it passed power."""
    readings = noting(lowered).readings
    for place, _routine, line in own_lines(logic, lowered):
        for index, step in enumerate(steps_of(line.nodes)):
            yield step.site, index in truths.get(place, ()) or _passed_power(readings[place], index, counts)


def own_lines(
    logic: LadderLogic, lowered: LoweredProgram
) -> Iterator[tuple[int, LoweredRoutine, LoweredLine]]:
    """Yield each line of the user's own routines, with its index in `lines_of` and its routine."""
    index_of = {key: index for index, key in enumerate(lines_of(lowered))}
    for routine in own_routines(logic, lowered):
        for line in routine.lines:
            yield index_of[routine.name.upper(), line.number], routine, line


def _passed_power(reading: Reading, at: int, counts: Mapping[int, int]) -> bool:
    if at >= len(reading):
        return True  # nothing is recorded here, so no gap is reported
    place, above, further = reading[at]
    return counts.get(place, -1) > above and all(counts.get(other, -1) > least for other, least in further)
