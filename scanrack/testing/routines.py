"""Test routines: each routine of a `test_*.rung` or `.st` file is a test, see `ladder.files.testfile`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from scanrack.jobs.bench import Bench
from scanrack.jobs.bench.opening import bench_of
from scanrack.jobs.load.tested import load_test
from scanrack.ladder.files.testfile import TestFile, read_test_file
from scanrack.ladder.model.errors import LadderError, LadderFault
from scanrack.ladder.state.lowered import LoweredProgram, steps_of
from scanrack.runtime.loop.faults import CpuFault

if TYPE_CHECKING:
    from .artifacts import TestArtifacts


class RoutineFile(pytest.File):
    """A file of test routines.

    Args:
        artifacts_of: returns the artifacts of a test.
    """

    def __init__(self, artifacts_of: Callable[[pytest.Item], TestArtifacts], **arguments: Any) -> None:
        super().__init__(**arguments)
        self._artifacts_of = artifacts_of

    def collect(self) -> Iterator[pytest.Item]:
        """Yield a test for each test routine."""
        try:
            file = read_test_file(self.path)
        except (LadderError, OSError) as error:
            raise self.CollectError(str(error)) from None
        for name in file.routines if file else ():
            yield RoutineTest.from_parent(self, name=name, file=file, artifacts_of=self._artifacts_of)


class RoutineTest(pytest.Item):
    """A test routine, which runs after its rack's program in each scan until its time is up.

    It passes if each of its ASSERTs was reached and no ASSERT in the program was false.
    """

    def __init__(
        self, file: TestFile, artifacts_of: Callable[[pytest.Item], TestArtifacts], **arguments: Any
    ) -> None:
        super().__init__(**arguments)
        self._file, self._artifacts_of = file, artifacts_of
        self._picture = ""

    def runtest(self) -> None:
        """Run the routine; an AssertionError or a controller fault fails the test."""
        job, name = load_test(self._file, self.name)
        bench = self._artifacts_of(self).add(self._file.rack.stem, lambda trace: bench_of(job, trace))
        try:
            bench.run_for(self._file.time)
        except CpuFault as fault:
            self._picture = _picture_of(bench, fault)
            raise
        engine = bench.program.engine
        sites = list(_asserts(engine.lowered, name))
        missing = [engine.lowered.sites[site].call for site in sites if site not in engine.fault_log.checked]
        if not sites:
            raise AssertionError("no ASSERT; add one")
        if missing:
            raise AssertionError("\n".join([f"not reached within {self._file.time}:", *missing]))

    def teardown(self) -> None:
        """Close the bench."""
        self._artifacts_of(self).close()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return the failure in terms of the program, without Python's traceback."""
        error = excinfo.value
        if isinstance(error, CpuFault):
            return f"{_fault_text(error)}\n{self._picture}".rstrip()
        has_message = isinstance(error, (ValueError, AssertionError))
        return str(error) if has_message else super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the file, the line from 0, and the heading of the report."""
        return self.path, self._file.routines[self.name] - 1, self.name


def _fault_text(error: CpuFault) -> str:
    """Return the text of a fault, with the program line and instruction that caused it."""
    fault = error.__cause__
    if not isinstance(fault, LadderFault):
        return str(error)
    return f"{Path(fault.site.file).name}:{fault.site.line}: {fault.site.call}: {fault.text}"


def _picture_of(bench: Bench, fault: CpuFault) -> str:
    """Return a drawing of the faulted rung with power and values; "" for a line of structured text."""
    if fault.fault.site.rung is None or fault.fault.site.unit != "rung":
        return ""
    return str(bench.program.picture(fault.fault.site.routine, [fault.fault.site.rung]))


def _asserts(lowered: LoweredProgram, name: str) -> Iterator[int]:
    """Yield the sites of the ASSERTs in a routine."""
    for line in lowered.routines[name.upper()].lines:
        for step in steps_of(line.nodes):
            if step.spec.name == "ASSERT":
                yield step.site
