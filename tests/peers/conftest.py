"""Notes which clients of others a test has tried."""

from __future__ import annotations

from collections.abc import Generator

import pytest
from peers import note


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if call.when == "call" and report.passed:
        note(item)
    return report
