"""Profiles of the property tests, and the option that selects them."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, settings

settings.register_profile(
    "ci",
    derandomize=True,
    deadline=None,
    max_examples=60,
    phases=set(Phase) - {Phase.target},  # with so few examples, variety is worth more than aim
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "long", deadline=None, max_examples=3_000, suppress_health_check=[HealthCheck.too_slow]
)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--long", action="store_true", help="run the property tests for long, with fresh random examples"
    )


def pytest_configure(config: pytest.Config) -> None:
    settings.load_profile("long" if config.getoption("--long") else "ci")


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, exitstatus: int, config: pytest.Config
) -> None:
    """Tell which rules of the manual the scripts of the lockstep have made fire."""
    coverage = getattr(config, "rule_coverage", None)
    if coverage is not None:
        terminalreporter.section("rules of the manual in the lockstep")
        for line in coverage.lines():
            terminalreporter.line(line)
