"""The pytest plugin: fixtures with racks on the bench, and the recordings of failed tests.

    def test_feeder(rack):
        feeder = rack("feeder.toml")          # beside the test's file
        feeder.run_until("Out.Done", within="3 s")

    pytest --scanrack-keep failed|all|never --scanrack-artifacts FOLDER --rung-coverage --scanrack-debug

A failed test leaves a recording of each of its benches. Its report explains the values of the tags in the
failure, and shows the command that opens the recording at the last scan. The plugin imports nothing else from
scanrack before a test uses a fixture.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from traceback import walk_tb
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from scanrack.jobs.bench import Bench
    from scanrack.testing.artifacts import TestArtifacts

OpenRack = Callable[[str | Path], "Bench"]
"""Type of the fixture `rack`: opens a rack file, whose path is relative to the folder of the test's file."""

_Report = Generator[None, pytest.TestReport, pytest.TestReport]

ARTIFACTS = pytest.StashKey["TestArtifacts"]()

RUNNING = pytest.StashKey[bool]()
"""Key for whether the function of a test is running; a report during this time is from a subtest."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    # pytest rewrites the assertions in a package that has a plugin; in scanrack this takes needless seconds
    for finder in sys.meta_path:
        getattr(finder, "_must_rewrite", set()).discard(__package__)
    group = parser.getgroup("scanrack")
    group.addoption(
        "--scanrack-keep",
        choices=["failed", "all", "never"],
        default="failed",
        help="Tests that leave recordings of their racks: failed (default), all, never.",
    )
    group.addoption(
        "--scanrack-artifacts",
        metavar="FOLDER",
        help="Folder of the recordings, with a folder for each test (default: scanrack-artifacts).",
    )
    group.addoption(
        "--rung-coverage",
        action="store_true",
        help="Write rung-coverage.html: the coverage of rungs, structured text and Python on the bench.",
    )
    group.addoption(
        "--scanrack-debug",
        action="store_true",
        help="Debug the racks of the tests in an editor: prints a port and a key, and waits for a client.",
    )
    parser.addini("scanrack_rack", "The rack of the fixture `bench`, relative to this folder.", default="")


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker, and start the debugger and the coverage that the options request."""
    config.addinivalue_line("markers", "rack(path): the rack file of the fixture `bench`")
    config.pluginmanager.register(_HiddenFrames(), "scanrack-frames")
    if config.getoption("--scanrack-debug"):
        from scanrack.dap.plugin_name import DEBUGGER
        from scanrack.dap.port_of_tests import PortOfTests

        config.pluginmanager.register(PortOfTests(config), DEBUGGER)
    if config.getoption("--rung-coverage"):
        from scanrack.testing.rung_coverage import KEY, CoverageReport

        config.pluginmanager.register(CoverageReport(config), KEY)


# --- fixtures


@pytest.fixture
def rack(request: pytest.FixtureRequest) -> Iterator[OpenRack]:
    """Open rack files on benches, recorded if recordings may be kept; close them after the test."""
    artifacts = _artifacts_of(request.node)
    yield lambda path: artifacts.open(request.path.parent / path)
    artifacts.close()


@pytest.fixture
def bench(request: pytest.FixtureRequest, rack: OpenRack) -> Bench:
    """The bench of the rack that `@pytest.mark.rack("feeder.toml")` or the key `scanrack_rack` names."""
    marker = request.node.get_closest_marker("rack")
    if marker is not None and marker.args:
        return rack(marker.args[0])
    path = request.config.getini("scanrack_rack")
    if not path:
        __tracebackhide__ = False
        pytest.fail(
            'bench: no rack; put @pytest.mark.rack("rack.toml") above the test, or scanrack_rack '
            "into pytest's configuration",
            pytrace=False,
        )
    return rack((request.config.inipath or request.config.rootpath / "ini").parent / path)


@pytest.fixture
def artifacts(request: pytest.FixtureRequest) -> Path:
    """The folder of the test; its files are kept like the recordings."""
    return _artifacts_of(request.node).folder.path


def _artifacts_of(item: pytest.Item) -> TestArtifacts:
    """Return the artifacts of a test; the first call creates them."""
    if ARTIFACTS not in item.stash:
        from scanrack.testing.artifacts import TestArtifacts

        item.stash[ARTIFACTS] = TestArtifacts(item, _base_of(item.config))
    return item.stash[ARTIFACTS]


def _base_of(config: pytest.Config) -> Path:
    """Return the folder of all tests."""
    folder = config.getoption("--scanrack-artifacts")
    return config.rootpath / "scanrack-artifacts" if folder is None else config.invocation_params.dir / folder


# --- test routines


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Collect the test routines of `test_*.rung` and `test_*.st`."""
    if file_path.suffix not in (".rung", ".st") or not file_path.name.startswith("test_"):
        return None
    from scanrack.testing.routines import RoutineFile

    collector: pytest.Collector = RoutineFile.from_parent(parent, path=file_path, artifacts_of=_artifacts_of)
    return collector


# --- reports


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Record that the function of the test is running."""
    item.stash[RUNNING] = True
    try:
        return (yield)
    finally:
        item.stash[RUNNING] = False


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> _Report:
    """Add scanrack's section to the report of a failed test; a rerun of the test starts over."""
    report = yield
    if ARTIFACTS in item.stash:
        item.stash[ARTIFACTS].reported(report, call, of_subtest=item.stash.get(RUNNING, False))
        if report.when == "teardown":
            del item.stash[ARTIFACTS]
    return report


class _HiddenFrames:
    """Hides the lines of scanrack in tracebacks; pytest shows them with --full-trace."""

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, call: pytest.CallInfo[None]) -> _Report:
        if call.excinfo is not None and __package__ in sys.modules:
            _hide(call.excinfo.value)
        return (yield)


def _hide(error: BaseException | None) -> None:
    """Hide the lines of scanrack's modules in the tracebacks of an error and its causes."""
    visited: list[BaseException] = []
    while error is not None and error not in visited:
        visited.append(error)
        for frame, _ in walk_tb(error.__traceback__):
            if str(frame.f_globals.get("__name__")).startswith(f"{__package__}."):
                frame.f_globals.setdefault("__tracebackhide__", True)  # the name that pytest looks for
        error = error.__cause__ or error.__context__


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Remove the folder of artifacts if it is empty; under pytest-xdist, after all workers have ended."""
    base = _base_of(session.config)
    if base.is_dir() and not hasattr(session.config, "workerinput"):
        from scanrack.testing.folder import remove_base

        remove_base(base)
