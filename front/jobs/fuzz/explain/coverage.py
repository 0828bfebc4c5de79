"""What a program went through in some runs: of each rung what was never on, never off, never reached."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ....ladder.compiler import ObservedScanner
from ....ladder.compiler.observed import lines_of, truth_of
from ....ladder.run.engine import Engine
from ....ladder.state.lowered import LoweredLine, LoweredProgram
from ....runtime.loop.rack import Rack
from ....runtime.loop.scan import ScanLogic
from ..aim.branches import branch_lines
from ..aim.edges import Edges
from ..aim.probe import Probe, noting
from ..run import TrialBench
from ..scenarios.scenario import Scenario

DeadPlace = tuple[str, int | str | None, str, str]
"""What is proved never to happen: routine, rung, instruction as text, state."""


@dataclass(frozen=True, slots=True)
class CoveredLine:
    """A rung, or a line of structured text or Python.

    Attributes:
        place: routine or file, with the number.
        never: what never happened, a sentence each; empty for a line without gaps.
    """

    place: str
    text: str
    never: tuple[str, ...] = ()


def coverage_of(
    bench: TrialBench, scenarios: Iterable[Scenario], program: Path, dead: Collection[DeadPlace] = ()
) -> list[CoveredLine]:
    """Run scenarios and return the lines of the program with their gaps, in its order.

    Args:
        program: its file, whose lines are shown of a Python program.
        dead: what is proved dead, and is no gap.
    """
    tally = _Tally()
    for scenario in scenarios:
        bench.run(scenario, without=bench.names, probe=_TallyProbe(tally))
    if tally.lowered is not None:
        return list(_ladder_lines(tally, tally.lowered, frozenset(dead)))
    return list(_python_lines(tally, program))


@dataclass(slots=True)
class _Tally:
    """What happened in the runs.

    Attributes:
        on, off: of each line of a ladder program, by instruction, whether it ever passed power, or none.
        branches: of a Python program, whether each was taken.
    """

    lowered: LoweredProgram | None = None
    scanner: ObservedScanner | None = None
    on: dict[int, list[bool]] = field(default_factory=dict)
    off: dict[int, list[bool]] = field(default_factory=dict)
    branches: bytearray = field(default_factory=bytearray)

    def add_notes(self, notes: list[Any]) -> None:
        """Add the power in the rungs of a scan."""
        assert self.scanner is not None
        for line, reading in enumerate(self.scanner.readings):
            truth = truth_of(notes, line, reading)
            if truth is not None:
                on = self.on.setdefault(line, [False] * len(truth))
                off = self.off.setdefault(line, [False] * len(truth))
                for place, each in enumerate(truth):
                    (on if each else off)[place] = True


class _TallyProbe(Probe):
    """Adds the scans of a run to a tally."""

    def __init__(self, tally: _Tally) -> None:
        super().__init__(Edges())
        self._tally = tally
        self._seen_notes: list[Any] = []

    def prepared(self, logic: ScanLogic) -> ScanLogic:
        """Note which program runs."""
        if type(logic) is Engine:
            self._tally.lowered, self._tally.scanner = logic.lowered, noting(logic.lowered)
        return super().prepared(logic)

    def watch(self, logic: ScanLogic, rack: Rack) -> None:
        """Take the branches of a Python program."""
        super().watch(logic, rack)
        if not self._tally.branches:
            self._tally.branches = bytearray(len(self._branches))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Add what differs from the scan before."""
        if self._notes and self._notes != self._seen_notes:
            self._seen_notes = self._notes.copy()
            self._tally.add_notes(self._notes)
        if self._branches:
            for place, taken in enumerate(self._branches):
                self._tally.branches[place] |= taken


def _ladder_lines(
    tally: _Tally, lowered: LoweredProgram, dead: frozenset[DeadPlace]
) -> Iterator[CoveredLine]:
    numbers = {key: number for number, key in enumerate(lines_of(lowered))}
    for routine in lowered.routines.values():
        for line in routine.lines:
            number = numbers[routine.name.upper(), line.number]
            place = f"{routine.name} {routine.unit} {line.number}"
            gaps = tuple(_gaps(tally, number, line, lowered, dead))
            yield CoveredLine(place, line.text, gaps)


def _gaps(
    tally: _Tally, number: int, line: LoweredLine, lowered: LoweredProgram, dead: frozenset[DeadPlace]
) -> Iterator[str]:
    sites = [lowered.sites[step.site] for step in line.steps]
    if number not in tally.on:
        if not any((s.routine, s.rung, s.instruction, "reached") in dead for s in sites):
            yield "never reached"
        return
    for site, on, off in zip(sites, tally.on[number], tally.off[number], strict=False):
        where = site.routine, site.rung, site.instruction
        if not on and (*where, "on") not in dead:
            yield f"{site.instruction}: never on"
        elif not off and (*where, "off") not in dead and site is not sites[-1]:
            yield f"{site.instruction}: never off"


def _python_lines(tally: _Tally, program: Path) -> Iterator[CoveredLine]:
    data = program.read_bytes()
    never = _branch_gaps(data, str(program), tally.branches)
    for number, text in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        yield CoveredLine(f"{program.name}:{number}", text, (never[number],) if number in never else ())


def _branch_gaps(data: bytes, file: str, branches: bytearray) -> dict[int, str]:
    """Return what never happened in the lines in which branches begin.

    The branch that an `if` without `else` takes else has the line of the `if`.
    """
    without_else = {
        node.lineno
        for node in ast.walk(ast.parse(data, file))
        if isinstance(node, ast.If) and not node.orelse
    }
    taken: dict[int, list[int]] = {}
    for line, each in zip(branch_lines(data, file), branches, strict=False):
        taken.setdefault(line, []).append(each)
    gaps = {}
    for line, ways in taken.items():
        other_way = line in without_else and (len(ways) == 1 or any(ways))
        if not any(ways) or (other_way and not all(ways)):
            gaps[line] = "never false" if other_way else "never reached"
    return gaps
