"""The artifacts of a test: the recordings of its benches, and its report's lines about them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, NamedTuple

from scanrack.dap.plugin_name import DEBUGGER
from scanrack.io_images.times import seconds
from scanrack.jobs.bench import Bench, NotReachedError
from scanrack.jobs.bench.opening import open_bench
from scanrack.ladder.model.errors import LadderFault
from scanrack.runtime.loop.faults import CpuFault
from scanrack.traces.files.portable import relative

from .folder import ArtifactFolder, file_name
from .page import FailedTest, page_line

if TYPE_CHECKING:
    import pytest

SECTION = "scanrack"

MOST_WHYS = 2
"""Maximum tags that a report explains."""


class OpenedBench(NamedTuple):
    """A bench that a test has opened, and its recording, if any."""

    name: str  # of the rack file
    bench: Bench
    trace: Path | None
    since_s: float  # processor time when it was open


class TestArtifacts:
    """The artifacts of a test.

    Attributes:
        folder: the folder of the artifacts.

    Args:
        base: the folder of all tests.
    """

    __test__ = False  # for pytest: this class is not a test

    def __init__(self, item: pytest.Item, base: Path) -> None:
        self._test = item.nodeid
        self._config = item.config
        self._near = item.config.invocation_params.dir
        self._keep = item.config.getoption("--scanrack-keep")
        self.folder = ArtifactFolder(base, item.nodeid)
        self._opened: list[OpenedBench] = []
        self._failed: BaseException | None = None  # the first failure, of a subtest or else of the test
        self._ended = False  # by a failure, so that its recordings are complete

    def open(self, rack: Path) -> Bench:
        """Open a rack on a bench, recorded if the recording may be kept; see `open_bench`."""
        return self.add(rack.stem, partial(open_bench, rack))

    def add(self, name: str, opened: Callable[[Path | None], Bench]) -> Bench:
        """Open a bench with a name, recorded if the recording may be kept.

        Args:
            opened: opens the bench with its recording.
        """
        trace = None if self._keep == "never" else self._new_trace(name)
        bench = opened(trace)
        if (debug := self._config.pluginmanager.get_plugin(DEBUGGER)) is not None:
            debug(bench)
        self._opened.append(OpenedBench(name, bench, trace, process_time()))
        return bench

    def _new_trace(self, stem: str) -> Path:
        stem = file_name(stem) or "rack"
        used_paths = {opened.trace for opened in self._opened}
        names = [stem, *(f"{stem}-{number}" for number in range(2, len(used_paths) + 2))]
        return next(path for name in names if (path := self.folder.path / f"{name}.mcap") not in used_paths)

    def close(self) -> None:
        """Close all benches, the last one first, even if one of them raises."""
        with ExitStack() as stack:
            for opened in self._opened:
                stack.callback(opened.bench.close)

    def reported(
        self, report: pytest.TestReport, call: pytest.CallInfo[None], *, of_subtest: bool = False
    ) -> None:
        """Extend the report of a failure; after the teardown, remove artifacts that are not to be kept.

        Args:
            of_subtest: the test continues, and so do the recordings of its benches.
        """
        error: BaseException | None = None
        if report.failed:
            error = AssertionError() if call.excinfo is None else call.excinfo.value
            self._failed = self._failed or error
        elif report.when == "call" and not of_subtest:
            error = self._failed  # of a subtest: the test fails with it
        if error is not None and not self._ended:
            self._ended = not of_subtest
            if self._opened:
                report.sections.append((SECTION, "\n".join(self._explanations(error))))
        if report.when == "teardown":
            if self._keep == "all" or (self._keep == "failed" and self._failed):
                if not self._failed:
                    self.folder.keep_passed()
                self.folder.remove_if_unused()
            else:
                self.folder.remove()

    def _explanations(self, error: BaseException) -> Iterator[str]:
        now_s = process_time()
        yield from self._whys(error)
        for opened in self._opened:
            if self._ended:
                opened.bench.end_recording()
            yield from self._places(opened, error, now_s - opened.since_s)

    # --- why

    def _whys(self, error: BaseException) -> Iterator[str]:
        explained = 0
        for opened in reversed(self._opened):
            for tag in tags_of(error, opened.bench):
                if explained < MOST_WHYS and (answer := _answer(opened.bench, tag)):
                    explained += 1
                    yield answer

    # --- where

    def _places(self, opened: OpenedBench, error: BaseException, run_s: float) -> Iterator[str]:
        name, bench, trace, _ = opened
        fault = bench.cpu.fault
        scan, now_ns = (bench.scans - 1, bench.now_ns) if fault is None else (fault.scan, fault.now_ns)
        if scan < 0:
            yield f"{name}: no scan has run"
            return
        yield f"{name}: scan {scan:,}, {seconds(now_ns)} s"
        if trace is not None:
            path = relative(trace, self._near)
            yield f"  scanrack watch {shlex.quote(f'{path}#scan={scan}')}"
            if not self._ended:
                return  # a page has the whole recording
            test = FailedTest(self._test, _message(error), self.folder.passed_trace(trace))
            yield f"  {page_line(trace, path, scan, tags_of(error, bench), run_s, test)}"


def _message(error: BaseException) -> str:
    """Return the message of a failure, without the kind of an assertion."""
    message = str(error)
    return message if isinstance(error, AssertionError) and message else f"{type(error).__name__}: {message}"


def tags_of(error: BaseException, bench: Bench) -> list[str]:
    """Return the tags that a failure is about, two at most, the most relevant first.

    These are the tags of a `NotReachedError` or of a false ASSERT, or else the tags that the test has read
    since the latest scan, those in the message first.
    """
    cause = error.__cause__ if isinstance(error, CpuFault) else error
    if isinstance(cause, (NotReachedError, LadderFault)):
        tags = list(cause.tags)
    else:
        words = re.findall(r"[\w.:\[\]/]+", str(error))
        latest_first = [*bench.read][::-1]
        tags = sorted(latest_first, key=lambda tag: tag not in words)
    return [tag for tag in tags if _is_one_value(bench, tag)][:MOST_WHYS]


def _is_one_value(bench: Bench, tag: str) -> bool:
    """Whether a tag is a number, a bit or a text; a structure has no single cause."""
    try:
        return isinstance(bench[tag], (bool, int, float, str))
    except Exception:  # no such tag
        return False


def _answer(bench: Bench, tag: str) -> str:
    """Return why a tag has its value; "" if the bench can't tell, since a report must not fail itself."""
    try:
        return bench.why(tag)
    except Exception:
        return ""
