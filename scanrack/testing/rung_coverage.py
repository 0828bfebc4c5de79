"""`pytest --rung-coverage`: the coverage of the programs that tests opened on the bench.

The page `rung-coverage.html` is written to the folder that contains pytest's configuration. Under
pytest-xdist each process collects coverage, and the first process combines it.
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
    """The part of the plugin for the option `--rung-coverage`."""

    def __init__(self, config: Any) -> None:
        self._config, self._coverage, self._earlier_observer = config, BenchCoverage(), OBSERVER.get()
        OBSERVER.set(self._coverage)

    def pytest_unconfigure(self) -> None:
        """Stop collecting coverage."""
        OBSERVER.set(self._earlier_observer)

    def pytest_sessionfinish(self, session: Any) -> None:
        """Send the coverage of a worker to the first process."""
        output = getattr(self._config, "workeroutput", None)
        if output is not None:
            output[KEY] = self._coverage.row()

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any, error: object) -> None:
        """Add the coverage of a worker, if it sent any before it ended."""
        self._coverage.merge(getattr(node, "workeroutput", {}).get(KEY, {}))

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Write the page, and print a line with the coverage."""
        programs = list(self._coverage.programs())
        page = Path(self._config.rootpath) / PAGE
        terminalreporter.section("rung coverage")
        for name, lines in programs:
            terminalreporter.line(f"{Path(name).name}: {coverage_line(lines)}")
        if programs:
            save_programs(page, programs)
            terminalreporter.line(f"see {page}")
        else:
            terminalreporter.line("no test opened a rack on the bench")
