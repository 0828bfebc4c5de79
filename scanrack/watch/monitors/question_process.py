"""Answers long questions: a separate process answers each, in bounded time."""

from __future__ import annotations

import json
import pickle
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import IO, Any

from scanrack.jobs.trust.launcher import Helper, launch
from scanrack.runtime.loop.pace import wall_ns
from scanrack.traces.read.columns import Columns

from .page import Page
from .stretched import ReplayPackage

PATIENCE_S, WANT_PATIENCE_S, SHARE_PATIENCE_S = 20, 60, 120
"""Time limits, s: for a question, for what it would take to get a value, and for a page to share."""

HELPER = f"{__package__}.answering:main"
"""Main function of the processes."""


@dataclass(frozen=True, slots=True)
class _Open:
    """A question that is not answered yet."""

    page: Page
    number: object
    process: Helper
    files: ExitStack
    out: IO[bytes]  # output of the process: a file, since a pipe would fill up
    err: IO[bytes]
    patience_s: int
    until_ns: int
    command: str
    own: bool  # whether the page asks on its own, not for a person


class QuestionProcesses:
    """The questions in process: per page, the latest one, and one that the page asks on its own."""

    def __init__(self) -> None:
        self._open: list[_Open] = []

    def why(self, page: Page, number: object, trace: str, what: str, more: Columns) -> None:
        """Ask for the cause of a Python program's recorded value; the answer goes to the page.

        Args:
            more: the latest scans, which may not be written yet; the question is about the last one.
        """
        command = f"scanrack why {trace} {what} --at {more.scan[-1]} --trust"
        self._begin(page, number, f"{__package__}.why_process", (trace, what, more), PATIENCE_S, command)

    def want(
        self,
        page: Page,
        number: object,
        trace: str,
        question: tuple[str, object, int],
        latest: Sequence[tuple[int, str]],
    ) -> None:
        """Ask what it would take to get a value; the answer goes to the page.

        Args:
            question: the tag, its target value, and the scan after which actions are possible.
            latest: orders, see `want_process`.
        """
        tag, requested, scan = question
        command = f"scanrack why {trace} {tag} --at {scan} --want {requested} --trust"
        given = trace, *question, latest
        self._begin(page, number, f"{__package__}.want_process", given, WANT_PATIENCE_S, command)

    def share(self, page: Page, number: object, trace: str, scan: int, *, trust: bool, rack: str) -> None:
        """Ask for a shareable page of a recording that shows a scan first; the result goes to the page.

        Args:
            trust: whether the program in the recording may run.
            rack: see `share.command.shared`.
        """
        command = f"scanrack share {trace} --at {scan}{' --trust' if trust else ''}"
        given = trace, scan, trust, rack
        self._begin(page, number, "scanrack.watch.share.share_process", given, SHARE_PATIENCE_S, command)

    def effects(self, page: Page, number: object, given: ReplayPackage) -> None:
        """Ask what an edit would have done in the last scans; the answer goes to the page."""
        self._begin(page, number, f"{__package__}.effects_process", (given,), PATIENCE_S, "the scans again")

    def lines(
        self,
        page: Page,
        number: object,
        trace: str,
        scans: tuple[int, int],
        more: Columns,
        latest: Sequence[tuple[int, str]],
    ) -> None:
        """Ask for the lines of a Python program executed in scans; the answer goes to the page.

        Args:
            more, latest: see `lines_process`.
        """
        given, command = (trace, *scans, more, latest), f"the program again up to scan {scans[1]:,}"
        self._begin(page, number, f"{__package__}.lines_process", given, PATIENCE_S, command, own=True)

    def _begin(
        self,
        page: Page,
        number: object,
        module: str,
        given: tuple[Any, ...],
        patience_s: int,
        command: str,
        *,
        own: bool = False,
    ) -> None:
        """Start a process that calls `answer` of a module with these arguments."""
        for each in [each for each in self._open if each.page is page and each.own is own]:
            self._end(each, "another question was asked meanwhile")
        with ExitStack() as files:
            out, err = (files.enter_context(tempfile.TemporaryFile()) for _ in range(2))
            with tempfile.TemporaryFile() as queried:  # not a pipe, since this must not wait for the process
                pickle.dump(given, queried)
                queried.seek(0)
                process = launch(HELPER, module, stdin=queried, stdout=out, stderr=err)
            until = wall_ns() + patience_s * 1_000_000_000
            self._open.append(
                _Open(page, number, process, files.pop_all(), out, err, patience_s, until, command, own)
            )

    def tick(self) -> None:
        """Pass on received answers."""
        for each in list(self._open):
            if each.process.poll() is not None:
                self._finish(each)
            elif wall_ns() > each.until_ns:
                self._end(each, f"the answer takes longer than {each.patience_s} s: {each.command}")

    def close(self) -> None:
        """End the processes of all questions."""
        for each in list(self._open):
            self._end(each, "the session has ended")

    def _finish(self, question: _Open) -> None:
        with question.files:
            out, err = map(_read, (question.out, question.err))
        self._open.remove(question)
        try:
            self._answer(question, json.loads(out))
        except ValueError:
            last = err.decode(errors="replace").strip().rpartition("\n")[2]
            self._answer(question, {"refused": f"{question.command} failed: {last}"})

    def _end(self, question: _Open, reason: str) -> None:
        question.process.kill()
        question.process.wait()
        question.files.close()
        self._open.remove(question)
        self._answer(question, {"refused": reason})

    def _answer(self, question: _Open, answer: dict[str, Any]) -> None:
        ok = {} if "refused" in answer else {"ok": True}
        question.page.send({"answer": {"id": question.number, **ok, **answer}})


def _read(file: IO[bytes]) -> bytes:
    file.seek(0)
    return file.read()
