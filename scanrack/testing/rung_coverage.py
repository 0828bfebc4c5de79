"""`pytest --rung-coverage`: how much the tests covered of the programs that they opened on the bench.

The page `rung-coverage.html` goes into the folder of pytest's configuration. Under pytest-xdist each process
collects coverage, and the first process combines it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scanrack.jobs.bench.opening import OBSERVER
from scanrack.jobs.fuzz.explain.bench_coverage import BenchCoverage
from scanrack.jobs.fuzz.explain.coverage_page import coverage_line, save_programs

PAGE = "rung-coverage.html"
KEY = "scanrack_rung_coverage"


class CoverageReport:
    """The plugin's part that pytest calls while the option is given."""

    def __init__(self, config: Any) -> None:
        self._config, self._gathered, self._before = config, BenchCoverage(), OBSERVER.get()
        OBSERVER.set(self._gathered)

    def pytest_unconfigure(self) -> None:
        """Stop collecting coverage."""
        OBSERVER.set(self._before)

    def pytest_sessionfinish(self, session: Any) -> None:
        """Send the coverage of a worker to the first process."""
        output = getattr(self._config, "workeroutput", None)
        if output is not None:
            output[KEY] = self._gathered.row()

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any, error: object) -> None:
        """Add the coverage that a worker has sent; a killed worker has sent nothing."""
        self._gathered.merge(getattr(node, "workeroutput", {}).get(KEY, {}))

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Write the page, and print a line with the coverage."""
        programs = list(self._gathered.programs())
        page = Path(self._config.rootpath) / PAGE
        terminalreporter.section("rung coverage")
        for name, lines in programs:
            terminalreporter.line(f"{Path(name).name}: {coverage_line(lines)}")
        if programs:
            save_programs(page, programs)
            terminalreporter.line(f"see {page}")
        else:
            terminalreporter.line("no test opened a rack on the bench")
