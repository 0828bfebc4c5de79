"""The artifacts of a test: the recordings of its benches, and the report lines about them."""

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
"""Maximum number of tags that a report explains."""


class OpenedBench(NamedTuple):
    """A bench that a test has opened, and its recording, if any."""

    name: str  # of the rack file
    bench: Bench
    trace: Path | None
    since_s: float  # processor time after it was opened, s


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
        self._invocation_folder = item.config.invocation_params.dir
        self._keep = item.config.getoption("--scanrack-keep")
        self.folder = ArtifactFolder(base, item.nodeid)
        self._benches: list[OpenedBench] = []
        self._failure: BaseException | None = None  # the first one, of a subtest or of the test
        self._is_recording_complete = False  # whether a failure has ended the recordings

    def open(self, rack: Path) -> Bench:
        """Open a rack on a bench, and record it if recordings can be kept; see `open_bench`."""
        return self.add(rack.stem, partial(open_bench, rack))

    def add(self, name: str, open_with: Callable[[Path | None], Bench]) -> Bench:
        """Open a named bench, and record it if recordings can be kept.

        Args:
            open_with: opens the bench with the path of its recording.
        """
        trace = None if self._keep == "never" else self._new_trace(name)
        bench = open_with(trace)
        if (debug := self._config.pluginmanager.get_plugin(DEBUGGER)) is not None:
            debug(bench)
        self._benches.append(OpenedBench(name, bench, trace, process_time()))
        return bench

    def _new_trace(self, stem: str) -> Path:
        """Return an unused path for a recording; a number distinguishes benches with the same name."""
        stem = file_name(stem) or "rack"
        used_paths = {opened.trace for opened in self._benches}
        path, number = self.folder.path / f"{stem}.mcap", 1
        while path in used_paths:
            number += 1
            path = self.folder.path / f"{stem}-{number}.mcap"
        return path

    def close(self) -> None:
        """Close all benches in reverse order, even if one of them raises an exception."""
        with ExitStack() as stack:
            for opened in self._benches:
                stack.callback(opened.bench.close)

    def reported(
        self, report: pytest.TestReport, call: pytest.CallInfo[None], *, of_subtest: bool = False
    ) -> None:
        """Extend the report of a failure; after the teardown, remove artifacts that are not kept.

        Args:
            of_subtest: whether the report is about a subtest; the test and its recordings continue after a
                subtest.
        """
        error: BaseException | None = None
        if report.failed:
            error = AssertionError() if call.excinfo is None else call.excinfo.value
            self._failure = self._failure or error
        elif report.when == "call" and not of_subtest:
            error = self._failure  # a failed subtest also fails the test
        if error is not None and not self._is_recording_complete:
            self._is_recording_complete = not of_subtest
            if self._benches:
                report.sections.append((SECTION, "\n".join(self._explanations(error))))
        if report.when == "teardown":
            if self._keep == "all" or (self._keep == "failed" and self._failure):
                if not self._failure:
                    self.folder.keep_passed()
                self.folder.remove_if_unused()
            else:
                self.folder.remove()

    def _explanations(self, error: BaseException) -> Iterator[str]:
        """Yield the report lines about an error; end the recordings if the error ends the test."""
        now_s = process_time()
        yield from self._explanations_of_tags(error)
        for opened in self._benches:
            if self._is_recording_complete:
                opened.bench.end_recording()
            yield from self._scan_lines(opened, error, now_s - opened.since_s)

    def _explanations_of_tags(self, error: BaseException) -> Iterator[str]:
        """Yield explanations of at most `MOST_WHYS` tags of an error, starting with the latest bench."""
        explained = 0
        for opened in reversed(self._benches):
            for tag in tags_of(error, opened.bench):
                if explained < MOST_WHYS and (answer := _why(opened.bench, tag)):
                    explained += 1
                    yield answer

    def _scan_lines(self, opened: OpenedBench, error: BaseException, run_s: float) -> Iterator[str]:
        """Yield report lines with a bench's last scan, and the commands and pages that show it."""
        name, bench, trace, _ = opened
        fault = bench.cpu.fault
        scan, now_ns = (bench.scans - 1, bench.now_ns) if fault is None else (fault.scan, fault.now_ns)
        if scan < 0:
            yield f"{name}: no scan has run"
            return
        yield f"{name}: scan {scan:,}, {seconds(now_ns)} s"
        if trace is not None:
            path = relative(trace, self._invocation_folder)
            yield f"  scanrack watch {shlex.quote(f'{path}#scan={scan}')}"
            if not self._is_recording_complete:
                return  # a page needs the complete recording
            test = FailedTest(self._test, _message(error), self.folder.passed_trace(trace))
            yield f"  {page_line(trace, path, scan, tags_of(error, bench), run_s, test)}"


def _message(error: BaseException) -> str:
    """Return the message of a failure; its type is included unless it is an assertion with a message."""
    message = str(error)
    return message if isinstance(error, AssertionError) and message else f"{type(error).__name__}: {message}"


def tags_of(error: BaseException, bench: Bench) -> list[str]:
    """Return at most `MOST_WHYS` tags of a failure, the most relevant first.

    These are the tags of a `NotReachedError` or of a false ASSERT. For other failures they are the tags that
    the test has read since the latest scan, starting with the tags in the message.
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
    """Return whether a tag is a number, a bit or a text; a structure has no single cause."""
    try:
        return isinstance(bench[tag], (bool, int, float, str))
    except Exception:  # no such tag
        return False


def _why(bench: Bench, tag: str) -> str:
    """Return why a tag has its value; "" if the explanation fails, since a report must not fail itself."""
    try:
        return bench.why(tag)
    except Exception:
        return ""
