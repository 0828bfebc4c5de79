"""Answers long questions: a separate process answers each, in bounded time."""

from __future__ import annotations

import json
import pickle
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import IO, Any, NamedTuple

from scanrack.jobs.trust.launcher import Helper, launch
from scanrack.runtime.loop.pace import wall_ns
from scanrack.traces.read.columns import Columns

from .page import Page
from .stretched import ReplayPackage

PATIENCE_S, WANT_PATIENCE_S, SHARE_PATIENCE_S = 20, 60, 120
"""Time limits, s: for a question, for what it would take to get a value, and for a page to share."""

HELPER = f"{__package__}.answering:main"
"""Main function of the processes."""


class LongQuestion(NamedTuple):
    """A question that a process answers, by the function `answer` of a module."""

    module: str
    arguments: tuple[Any, ...]
    command: str  # for messages: the same as a command, or the work that takes long
    patience_s: int
    own: bool = False  # whether the page asks on its own, not for a person


def why(trace: str, tag: str, more: Columns) -> LongQuestion:
    """Ask for the cause of a Python program's recorded value.

    Args:
        more: the latest scans, which may not be written yet; the question is about the last one.
    """
    command = f"scanrack why {trace} {tag} --at {more.scan[-1]} --trust"
    return LongQuestion(f"{__package__}.why_process", (trace, tag, more), command, PATIENCE_S)


def want(trace: str, tag: str, value: object, scan: int, latest: Sequence[tuple[int, str]]) -> LongQuestion:
    """Ask what it would take to get a value with actions after a scan.

    Args:
        latest: orders, see `want_process`.
    """
    command = f"scanrack why {trace} {tag} --at {scan} --want {value} --trust"
    arguments = trace, tag, value, scan, latest
    return LongQuestion(f"{__package__}.want_process", arguments, command, WANT_PATIENCE_S)


def share(trace: str, scan: int, *, trust: bool, rack: str) -> LongQuestion:
    """Ask for a shareable page of a recording that shows a scan first.

    Args:
        trust: whether the program in the recording may run.
        rack: see `share.command.shared`.
    """
    command, arguments = f"scanrack share {trace} --at {scan}{' --trust' * trust}", (trace, scan, trust, rack)
    return LongQuestion("scanrack.watch.share.share_process", arguments, command, SHARE_PATIENCE_S)


def effects(package: ReplayPackage) -> LongQuestion:
    """Ask what an edit would have done in the last scans."""
    return LongQuestion(f"{__package__}.effects_process", (package,), "the scans again", PATIENCE_S)


def lines(
    trace: str, scans: tuple[int, int], more: Columns, latest: Sequence[tuple[int, str]]
) -> LongQuestion:
    """Ask for the lines of a Python program executed in scans; see `lines_process`."""
    arguments, command = (trace, *scans, more, latest), f"the program again up to scan {scans[1]:,}"
    return LongQuestion(f"{__package__}.lines_process", arguments, command, PATIENCE_S, own=True)


@dataclass(frozen=True, slots=True)
class _Open:
    """A question that is not answered yet."""

    page: Page
    number: object
    question: LongQuestion
    process: Helper
    files: ExitStack
    out: IO[bytes]  # output of the process: a file, since a pipe would fill up
    err: IO[bytes]
    until_ns: int


class QuestionProcesses:
    """The questions in process: per page, the latest one, and one that the page asks on its own."""

    def __init__(self) -> None:
        self._open: list[_Open] = []

    def ask(self, page: Page, number: object, question: LongQuestion) -> None:
        """Start a process for a question; the answer goes to the page."""
        for running in [
            running for running in self._open if running.page is page and running.question.own is question.own
        ]:
            self._end(running, "another question was asked meanwhile")
        with ExitStack() as files:
            out, err = (files.enter_context(tempfile.TemporaryFile()) for _ in range(2))
            # not a pipe, since this must not wait for the process
            with tempfile.TemporaryFile() as stdin_file:
                pickle.dump(question.arguments, stdin_file)
                stdin_file.seek(0)
                process = launch(HELPER, question.module, stdin=stdin_file, stdout=out, stderr=err)
            until = wall_ns() + question.patience_s * 1_000_000_000
            self._open.append(_Open(page, number, question, process, files.pop_all(), out, err, until))

    def tick(self) -> None:
        """Pass on received answers."""
        for running in list(self._open):
            if running.process.poll() is not None:
                self._finish(running)
            elif wall_ns() > running.until_ns:
                patience_s, command = running.question.patience_s, running.question.command
                self._end(running, f"the answer takes longer than {patience_s} s: {command}")

    def close(self) -> None:
        """End the processes of all questions."""
        for running in list(self._open):
            self._end(running, "the session has ended")

    def _finish(self, pending: _Open) -> None:
        with pending.files:
            out, err = map(_read, (pending.out, pending.err))
        self._open.remove(pending)
        try:
            self._answer(pending, json.loads(out))
        except ValueError:
            last = err.decode(errors="replace").strip().rpartition("\n")[2]
            self._answer(pending, {"refused": f"{pending.question.command} failed: {last}"})

    def _end(self, pending: _Open, reason: str) -> None:
        pending.process.kill()
        pending.process.wait()
        pending.files.close()
        self._open.remove(pending)
        self._answer(pending, {"refused": reason})

    def _answer(self, pending: _Open, answer: dict[str, Any]) -> None:
        ok = {} if "refused" in answer else {"ok": True}
        pending.page.send({"answer": {"id": pending.number, **ok, **answer}})


def _read(file: IO[bytes]) -> bytes:
    file.seek(0)
    return file.read()
