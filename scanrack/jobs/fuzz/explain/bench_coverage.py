"""Measures the coverage of tests: the rungs and branches of the programs that the tests open on a bench."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from operator import or_
from typing import Any

from scanrack.ladder import LadderLogic
from scanrack.ladder.compiler.observed import lines_of
from scanrack.ladder.debug import Debugger
from scanrack.runtime.loop.listeners import QuietListener, ScanListener
from scanrack.runtime.loop.scan import ScanLogic

from ...bench.opening import BenchObserver
from ...load.loading import LoadedRack, load_job
from ...record.logic_wrapper import unwrapped
from ..aim.branches import NAME, branches_noted
from ..aim.python_state import namespace_of
from .coverage import CoveredLine, PowerTally, covered_lines

Bits = list[bool]
"""For each instruction of a line, whether it was ever on (or ever off)."""


@dataclass(slots=True)
class _Program:
    """A program of a bench.

    Attributes:
        rack: the first rack file that opened it.
        branch_arrays: branch bytes of a Python program, one array per load.
    """

    rack: str
    tally: PowerTally = field(default_factory=PowerTally)
    branch_arrays: list[bytearray] = field(default_factory=list)

    def branches(self) -> bytearray:
        """Return a byte for each branch; nonzero if the branch was taken on any bench."""
        taken = self.tally.branches
        for branches in self.branch_arrays:
            taken = bytearray(map(or_, taken, branches)) if taken else bytearray(branches)
        return taken


class BenchCoverage(BenchObserver):
    """Gathers the coverage of the programs on all benches. `row` and `merge` pass it between processes."""

    def __init__(self) -> None:
        self._programs: dict[str, _Program] = {}

    def loading(self) -> AbstractContextManager[object]:
        """Return a context in which loaded Python programs record their branches."""
        return branches_noted()

    def listeners(self, job: LoadedRack, logic: ScanLogic) -> Iterable[ScanListener]:
        """Return a listener for the rungs of a program. Store the branch bytes of a Python program."""
        tested_job = job.tested or job
        program = self._program(str(tested_job.program.resolve()), str(tested_job.rack_file.resolve()))
        if isinstance(logic, Debugger):
            assert isinstance(tested_job.logic, LadderLogic)
            program.tally.lowered = tested_job.logic.build()
            return (_RungListener(logic, program.tally),)
        branches = namespace_of(unwrapped(logic)).get(NAME)
        if branches is not None and not any(branches is known for known in program.branch_arrays):
            program.branch_arrays.append(branches)
        return ()

    def _program(self, program: str, rack: str) -> _Program:
        return self._programs.setdefault(program, _Program(rack))

    def row(self) -> dict[str, Any]:
        """Return the coverage as plain data, for another process."""
        return {
            name: {
                "rack": program.rack,
                "on": {str(line): _text(bits) for line, bits in program.tally.on.items()},
                "off": {str(line): _text(bits) for line, bits in program.tally.off.items()},
                "branches": program.branches().hex(),
            }
            for name, program in self._programs.items()
        }

    def merge(self, row: Mapping[str, Any]) -> None:
        """Add the coverage from another process."""
        for name, program_row in row.items():
            program = self._program(name, program_row["rack"])
            program.branch_arrays.append(bytearray.fromhex(program_row["branches"]))
            _merge_bits(program.tally.on, program_row["on"])
            _merge_bits(program.tally.off, program_row["off"])

    def programs(self) -> Iterator[tuple[str, list[CoveredLine]]]:
        """Yield the file and the lines of each program, sorted by file."""
        for name, program in sorted(self._programs.items()):
            job = load_job(program.rack)
            if isinstance(job.logic, LadderLogic):
                program.tally.lowered = job.logic.compile().lowered
            program.tally.branches = program.branches()
            yield name, covered_lines(program.tally, job)


class _RungListener(QuietListener):
    """Adds each scan's power in the rungs to a tally, except in rungs of edits and test routines."""

    def __init__(self, debugger: Debugger, tally: PowerTally) -> None:
        self._debugger, self._tally, self._engine = debugger, tally, debugger.engine
        assert tally.lowered is not None
        self._numbers = {key: number for number, key in enumerate(lines_of(tally.lowered))}
        debugger.note_power()

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Add the power in the rungs of a scan."""
        if self._debugger.engine is self._engine:
            for key, truth in self._engine.truths.items():
                if key in self._numbers:
                    self._tally.add(self._numbers[key], truth)
        self._debugger.note_power()


def _text(bits: Bits) -> str:
    return "".join("01"[bit] for bit in bits)


def _merge_bits(bits_by_line: dict[int, Bits], texts: Mapping[str, str]) -> None:
    """Merge bits into the known bits of each line; each text is in the form of `_text`."""
    for line, text in texts.items():
        bits = [digit == "1" for digit in text]
        known_bits = bits_by_line.get(int(line), bits)
        bits_by_line[int(line)] = list(map(or_, known_bits, bits))
