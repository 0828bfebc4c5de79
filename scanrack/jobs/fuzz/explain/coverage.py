"""Measures the coverage of a program by runs. Finds instructions that were never on, off or reached."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scanrack.io_images.amci3601.words import may_be_stepper
from scanrack.ladder import LadderLogic
from scanrack.ladder.compiler import ObservedScanner
from scanrack.ladder.compiler.observed import truth_of
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ...load.loading import LoadedRack
from ..aim.branches import branch_lines
from ..aim.edges import Edges
from ..aim.probe import Probe, noting
from ..reached import own_lines
from ..run import TrialBench
from ..scenarios.scenario import Scenario
from .unfired import WordHistory

DeadPlace = tuple[str, int | str | None, str, str]
"""The routine, rung, text and state of an instruction that is proved never to have this state."""


@dataclass(frozen=True, slots=True)
class CoveredLine:
    """A rung, or a line of structured text or Python.

    Attributes:
        place: routine or file, and number of the rung or line.
        never: a sentence for each gap; empty for a line without gaps.
    """

    place: str
    text: str
    never: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Coverage:
    """The coverage of several runs.

    Attributes:
        lines: lines of the program with their gaps, in program order.
        words: words of each 3601 in the runs, by slot.
    """

    lines: list[CoveredLine]
    words: Mapping[int, WordHistory]


def coverage_of(
    bench: TrialBench, scenarios: Iterable[Scenario], job: LoadedRack, dead: Collection[DeadPlace] = ()
) -> Coverage:
    """Run scenarios and return their coverage.

    Args:
        job: the rack with the program; the package's motion blocks are ignored.
        dead: states that are proved impossible. They do not count as gaps.
    """
    tally = PowerTally()
    for scenario in scenarios:
        bench.run(scenario, without=bench.names, probe=_TallyProbe(tally))
    return Coverage(covered_lines(tally, job, dead), tally.words)


def covered_lines(tally: PowerTally, job: LoadedRack, dead: Collection[DeadPlace] = ()) -> list[CoveredLine]:
    """Return the lines of a program with their gaps, in program order."""
    if tally.lowered is not None:
        return list(_ladder_lines(tally, tally.lowered, job, frozenset(dead)))
    return list(_python_lines(tally, job.program))


def places_in(bench: TrialBench, scenario: Scenario, job: LoadedRack) -> frozenset[str]:
    """Run a scenario; return the instructions that passed power, or the branches that were taken.

    The name of each is its routine or file and its text, without numbers.
    """
    tally = PowerTally()
    bench.run(scenario, without=bench.names, probe=_TallyProbe(tally))
    if (lowered := tally.lowered) is not None:
        assert isinstance(job.logic, LadderLogic)
        return frozenset(
            f"{routine.name}: {lowered.sites[step.site].instruction}"
            for number, routine, line in own_lines(job.logic, lowered)
            for step, was_on in zip(line.steps, tally.on.get(number, ()), strict=False)
            if was_on
        )
    data, program = job.program.read_bytes(), job.program
    text = data.decode("utf-8", "replace").splitlines()
    branches = zip(branch_lines(data, str(program)), tally.branches, strict=False)
    return frozenset(f"{program.name}: {text[line - 1].strip()}" for line, is_taken in branches if is_taken)


@dataclass(slots=True)
class PowerTally:
    """The coverage data of several runs.

    Attributes:
        on: whether each instruction was ever on, by line of a ladder program.
        off: whether each instruction was ever off, by line of a ladder program.
        branches: whether each branch of a Python program was taken.
        words: words of each 3601, by slot.
    """

    lowered: LoweredProgram | None = None
    scanner: ObservedScanner | None = None
    on: dict[int, list[bool]] = field(default_factory=dict)
    off: dict[int, list[bool]] = field(default_factory=dict)
    branches: bytearray = field(default_factory=bytearray)
    words: defaultdict[int, WordHistory] = field(default_factory=lambda: defaultdict(WordHistory))

    def add_notes(self, notes: list[Any]) -> None:
        """Add the power flow in the rungs of a scan."""
        assert self.scanner is not None
        for line, reading in enumerate(self.scanner.readings):
            truth = truth_of(notes, line, reading)
            if truth is not None:
                self.add(line, truth)

    def add(self, line: int, truth: Sequence[bool]) -> None:
        """Add the power flow after each instruction of a line, given the line's number in `lines_of`."""
        on = self.on.setdefault(line, [False] * len(truth))
        off = self.off.setdefault(line, [False] * len(truth))
        for index, has_power in enumerate(truth):
            (on if has_power else off)[index] = True


class _TallyProbe(Probe):
    """Adds the scans of a run to a tally."""

    def __init__(self, tally: PowerTally) -> None:
        super().__init__(Edges())
        self._tally = tally
        self._seen_memory = b""
        self._seen_notes: list[Any] = []

    def prepared(self, logic: ScanLogic) -> ScanLogic:
        """Store the program in the tally."""
        if type(logic) is Engine:
            self._tally.lowered, self._tally.scanner = logic.lowered, noting(logic.lowered)
        return super().prepared(logic)

    def watch(self, logic: ScanLogic, rack: Rack) -> None:
        """Watch a rack and the branches of a Python program."""
        super().watch(logic, rack)
        self._steppers = [slot for slot in rack.slots.values() if may_be_stepper(slot.words)]
        if not self._tally.branches:
            self._tally.branches = bytearray(len(self._branches))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Add the differences from the previous scan."""
        if self._memory != self._seen_memory:
            self._seen_memory = bytes(self._memory)
            for slot in self._steppers:
                self._tally.words[slot.number].note(slot)
        if self._notes and self._notes != self._seen_notes:
            self._seen_notes = self._notes.copy()
            self._tally.add_notes(self._notes)
        if self._branches:
            for index, is_taken in enumerate(self._branches):
                self._tally.branches[index] |= is_taken


def _ladder_lines(
    tally: PowerTally, lowered: LoweredProgram, job: LoadedRack, dead: frozenset[DeadPlace]
) -> Iterator[CoveredLine]:
    assert isinstance(job.logic, LadderLogic)
    for number, routine, line in own_lines(job.logic, lowered):
        place = f"{routine.name} {routine.unit} {line.number}"
        yield CoveredLine(place, line.text, tuple(_gaps(tally, number, line, lowered, dead)))


def _gaps(
    tally: PowerTally, number: int, line: LoweredLine, lowered: LoweredProgram, dead: frozenset[DeadPlace]
) -> Iterator[str]:
    """Yield a sentence for each gap of a line. A last instruction that was never off is not a gap."""
    sites = [lowered.sites[step.site] for step in line.steps]
    places = [(site.routine, site.rung, site.instruction) for site in sites]
    if number not in tally.on:
        if not any((*place, "reached") in dead for place in places):
            yield "never reached"
        return
    for site, place, on, off in zip(sites, places, tally.on[number], tally.off[number], strict=False):
        if not (on or (*place, "on") in dead):
            yield f"{site.instruction}: never on"
        elif not (off or (*place, "off") in dead or site is sites[-1]):
            yield f"{site.instruction}: never off"


def _python_lines(tally: PowerTally, program: Path) -> Iterator[CoveredLine]:
    data = program.read_bytes()
    gaps = _branch_gaps(data, str(program), tally.branches)
    for number, text in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        yield CoveredLine(f"{program.name}:{number}", text, (gaps[number],) if number in gaps else ())


def _branch_gaps(data: bytes, file: str, branches: bytearray) -> dict[int, str]:
    """Return a sentence for each line whose branches have a gap, by line number.

    A missing `else` belongs to the line of its `if`.
    """
    branches_by_line: dict[int, list[int]] = {}
    for line, branch in zip(branch_lines(data, file), branches, strict=False):
        branches_by_line.setdefault(line, []).append(branch)
    without_else = _ifs_without_else(data, file)
    gaps = {line: _branch_gap(taken, line in without_else) for line, taken in branches_by_line.items()}
    return {line: gap for line, gap in gaps.items() if gap}


def _branch_gap(taken: Sequence[int], is_without_else: bool) -> str:
    """Return a sentence about a gap in the branches of a line; an empty text if there is no gap."""
    if is_without_else and (len(taken) == 1 or any(taken)):
        return "" if all(taken) else "never false"
    return "" if any(taken) else "never reached"


def _ifs_without_else(data: bytes, file: str) -> set[int]:
    """Return the lines of a program's `if` statements without `else`."""
    nodes = ast.walk(ast.parse(data, file))
    return {node.lineno for node in nodes if isinstance(node, ast.If) and not node.orelse}
