"""Profiles of the property tests, the option that selects them, and the order of the tests."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import pytest
from amounts import EXAMPLES, FEW_EXAMPLES
from budget import Budget
from extras import skip_without_extras
from forked import fork_helpers
from hypothesis import HealthCheck, Phase, is_hypothesis_test, settings
from hypothesis.internal import charmap
from hypothesis.internal.conjecture import junkdrawer, providers
from needs import CANNOT_BE_IMPORTED, skip_without_needs
from pairs import left_out
from processes import Processes
from rewriting import RewritingProcess
from typer import testing

TESTS = Path(__file__).parent
BROWSER = TESTS / "browser"
MANUAL = TESTS / "manual"
collect_ignore = [file for file, can in CANNOT_BE_IMPORTED.items() if not can]

FIRST = (BROWSER, MANUAL, TESTS / "properties" / "test_against_oracle.py")
"""Run before all others: a browser, which waits most of the time, and beside it the tests that find most of
the mistakes in a controller's rules."""

SECOND_BROWSER = "test_watch_h"
"""The first of its files."""

settings.register_profile(
    "ci",
    derandomize=True,
    deadline=None,
    max_examples=EXAMPLES,
    phases=[Phase.explicit, Phase.generate, Phase.shrink],  # few examples: variety is worth more than aim
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("few", settings.get_profile("ci"), max_examples=FEW_EXAMPLES)
settings.register_profile(
    "long",
    deadline=None,
    max_examples=3_000,
    print_blob=True,  # the examples are new each time: a failure has to tell how to see it again
    suppress_health_check=[HealthCheck.too_slow],
)

YOUNG_OBJECTS = 100_000
"""Allocations between two searches for garbage: few tests make as many, and each file ends with a search."""

RULE_LINES = pytest.StashKey[list[str]]()
"""What processes have reported of the rules of the manual."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--long", action="store_true", help="run the property tests for long, with fresh random examples"
    )
    parser.addoption("--processes", type=int, help="number of processes that run the tests")


def pytest_configure(config: pytest.Config) -> None:
    settings.load_profile("long" if config.getoption("--long") else "few" if _is_quick_run(config) else "ci")
    fork_helpers()
    gc.disable()
    junkdrawer._gc_initialized = True  # Hypothesis times the collector for deadlines, which no test has
    testing._get_command = cache(testing._get_command)  # each run of a CliRunner builds the commands again
    if not config.getoption("--long"):
        _draw_no_constants_of_modules()
    if _is_quick_run(config):
        config.pluginmanager.register(Budget())
    lines = config.stash.setdefault(RULE_LINES, [])
    count = config.getoption("--processes") or _number_of_processes(config)
    if count > 1 and hasattr(os, "fork"):
        config.pluginmanager.register(RewritingProcess(config, sorted(TESTS.rglob("test_*.py"))))
    config.pluginmanager.register(Processes(count, _together, partial(_rule_lines, config), lines.extend))


def _draw_no_constants_of_modules() -> None:
    """Let a test's examples depend on nothing but the test.

    Hypothesis also draws the constants that it finds in whatever modules are loaded: a test would see other
    examples by itself than in the whole suite, in spite of `derandomize`.
    """
    providers._get_local_constants = providers.Constants


@pytest.fixture(autouse=True, scope="session")
def _heeded_signals() -> Iterator[None]:
    """Let tests send signals to themselves and their processes, though a shell's background ignores them."""
    before = {signal.SIGINT: signal.signal(signal.SIGINT, signal.default_int_handler)}
    for name in ("SIGHUP", "SIGQUIT"):
        if (number := getattr(signal, name, None)) is not None:  # Windows has none of them
            before[number] = signal.signal(number, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def _number_of_processes(config: pytest.Config) -> int:
    """Return one more than there are cores for the whole suite, and one for tests that are named.

    One more, since tests with a browser or in real time mostly wait.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return cores + 1 if _is_whole_suite(config) else 1


def _is_whole_suite(config: pytest.Config) -> bool:
    """Whether no file and no folder of tests is named."""
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS


def _is_quick_run(config: pytest.Config) -> bool:
    """Whether it is README's command: the whole suite, and nothing says which of its tests."""
    asked = config.option.markexpr or config.option.keyword or config.getoption("--long")
    return _is_whole_suite(config) and not asked


@cache
def _is_within(path: Path, folder: Path) -> bool:
    """Return `path.is_relative_to(folder)`; twenty thousand tests are in some hundred files."""
    return path.is_relative_to(folder)


def _together(item: pytest.Item) -> object:
    """Return what tests of one process have in common: their file, or one of two browsers.

    One browser would take longer than all other tests; each further one starts for seconds.
    """
    if item.config.getoption("--long"):
        return item.nodeid
    return item.path.name < SECOND_BROWSER if _is_within(item.path, BROWSER) else item.path


def pytest_collection_finish(session: pytest.Session) -> None:
    """Search what tests make for garbage, and not again and again what collecting has made."""
    if _is_whole_suite(session.config):  # once, before the processes are forked
        charmap.categories()
    gc.freeze()
    gc.set_threshold(YOUNG_OBJECTS)
    gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Search for garbage when a file ends: what an object warns of at its end belongs to that file."""
    if nextitem is None or nextitem.path != item.path:
        gc.collect()
        gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if _is_within(item.path, BROWSER):
            item.add_marker(pytest.mark.slow)
        if is_hypothesis_test(getattr(item, "obj", None)):
            item.add_marker(pytest.mark.sampled)
    for item in left_out(item for item in items if _is_within(item.path, MANUAL)):
        item.add_marker(pytest.mark.product)
    if _is_quick_run(config):
        config.option.markexpr = "not slow and not product"
    items.sort(key=_turn)
    if not config.getoption("--long"):
        for item in items:
            if item.get_closest_marker("long"):
                item.add_marker(pytest.mark.skip(reason="takes long: with --long"))
    skip_without_extras(items)
    skip_without_needs(items)


def _turn(item: pytest.Item) -> int:
    """Return the place in `FIRST` of what a test belongs to; the others keep their order behind it."""
    return next((turn for turn, path in enumerate(FIRST) if _is_within(item.path, path)), len(FIRST))


def _rule_lines(config: pytest.Config) -> list[str]:
    """Return the report on the rules that the scripts of the lockstep have made fire in this process."""
    coverage = getattr(config, "rule_coverage", None)
    return [] if coverage is None else list(coverage.lines())


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, exitstatus: int, config: pytest.Config
) -> None:
    """Print which rules of the manual the scripts of the lockstep have made fire."""
    lines = _rule_lines(config) or config.stash[RULE_LINES]
    if lines:
        terminalreporter.section("rules of the manual in the lockstep")
        for line in lines:
            terminalreporter.line(line)
