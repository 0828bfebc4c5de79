"""Which tests of a quick run take more than their budget: processor time, which other programs change little.

A test may take 0.25 s on a quiet machine, else it is made smaller or carries `slow`, or `costly` with the
reason why it stays in the quick run. Machines differ, and a test may load what others use, too: a run names
the tests that take four times as much. They fail it only if SCANRACK_BUDGET is set, for
a machine that does nothing else.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from time import process_time

import pytest

BUDGET_S = 0.25
ALLOWED_S = 4 * BUDGET_S
KEY = "processor_s"
EXEMPT = ("slow", "long", "costly")


def processor_s() -> float:
    """Return the processor time of this process and of those that it has waited for."""
    times = os.times()
    return process_time() + times.children_user + times.children_system


class Budget:
    """A plugin of pytest; reports carry the times to the process that prints."""

    def __init__(self) -> None:
        self._above: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Note the time of a test without its fixtures, which others may use."""
        start = processor_s()
        try:
            return (yield)
        finally:
            if not any(item.get_closest_marker(name) for name in EXEMPT):
                item.user_properties.append((KEY, processor_s() - start))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep what is above."""
        took = dict(report.user_properties).get(KEY)
        if report.when == "call" and isinstance(took, float) and took > ALLOWED_S:
            self._above[report.nodeid] = took

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Fail the run if that is asked for."""
        if self._above and os.environ.get("SCANRACK_BUDGET") and not session.exitstatus:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Name the tests."""
        if self._above:
            terminalreporter.section(f"more than {ALLOWED_S:g} s of the processor; {BUDGET_S:g} s is allowed")
            for name, took in sorted(self._above.items(), key=lambda each: -each[1]):
                terminalreporter.line(f"{took:6.2f} s  {name}")
