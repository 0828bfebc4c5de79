"""Long questions, each answered by a separate process within a time limit."""

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
"""Time limits for a question, for finding actions that lead to a value, and for a page to share, s."""

HELPER = f"{__package__}.answering:main"
"""Main function of the processes."""


class LongQuestion(NamedTuple):
    """A question for a process, which calls a module's function `answer`."""

    module: str
    arguments: tuple[Any, ...]
    command: str  # for messages: the equivalent command, or a description of the work
    patience_s: int
    automatic: bool = False  # whether the page asks without an operator


def why(trace: str, tag: str, more: Columns) -> LongQuestion:
    """Return the question about the cause of a Python program's recorded value.

    Args:
        more: the latest scans, which may not be in the trace yet; the question is about the last one.
    """
    command = f"scanrack why {trace} {tag} --at {more.scan[-1]} --trust"
    return LongQuestion(f"{__package__}.why_process", (trace, tag, more), command, PATIENCE_S)


def want(trace: str, tag: str, value: object, scan: int, latest: Sequence[tuple[int, str]]) -> LongQuestion:
    """Return the question about the actions after a scan that lead to a value.

    Args:
        latest: the latest actions, see `want_process`.
    """
    command = f"scanrack why {trace} {tag} --at {scan} --want {value} --trust"
    arguments = trace, tag, value, scan, latest
    return LongQuestion(f"{__package__}.want_process", arguments, command, WANT_PATIENCE_S)


def share(trace: str, scan: int, *, trust: bool, rack: str) -> LongQuestion:
    """Return the request for a shareable page of a trace that shows a scan first.

    Args:
        trust: whether the program in the trace may run.
        rack: see `share.command.shared`.
    """
    command, arguments = f"scanrack share {trace} --at {scan}{' --trust' * trust}", (trace, scan, trust, rack)
    return LongQuestion("scanrack.watch.share.share_process", arguments, command, SHARE_PATIENCE_S)


def effects(package: ReplayPackage) -> LongQuestion:
    """Return the question about the effects that an edit would have had in the latest scans."""
    return LongQuestion(f"{__package__}.effects_process", (package,), "repeating the scans", PATIENCE_S)


def lines(
    trace: str, scans: tuple[int, int], more: Columns, latest: Sequence[tuple[int, str]]
) -> LongQuestion:
    """Return the question about the executed lines of a Python program, see `lines_process`."""
    arguments, command = (trace, *scans, more, latest), f"running the program again up to scan {scans[1]:,}"
    return LongQuestion(f"{__package__}.lines_process", arguments, command, PATIENCE_S, automatic=True)


@dataclass(frozen=True, slots=True)
class _Pending:
    """A question that has not been answered yet."""

    page: Page
    number: object
    question: LongQuestion
    process: Helper
    files: ExitStack
    output: IO[bytes]  # standard output of the process: a file, since a pipe could fill up
    errors: IO[bytes]  # standard error
    until_ns: int


class QuestionProcesses:
    """The pending questions. A page has at most one operator question and one automatic question."""

    def __init__(self) -> None:
        self._pending: list[_Pending] = []

    def start(self, page: Page, number: object, question: LongQuestion) -> None:
        """Start a process to answer a page's question; end the page's earlier question of the same kind."""
        for pending in list(self._pending):
            if pending.page is page and pending.question.automatic is question.automatic:
                self._end(pending, "another question was asked meanwhile")
        with ExitStack() as files:
            output, errors = (files.enter_context(tempfile.TemporaryFile()) for _ in range(2))
            # a file, since a pipe could make this process wait for the other one
            with tempfile.TemporaryFile() as input_file:
                pickle.dump(question.arguments, input_file)
                input_file.seek(0)
                process = launch(HELPER, question.module, stdin=input_file, stdout=output, stderr=errors)
            pending = _Pending(
                page,
                number,
                question,
                process=process,
                files=files.pop_all(),
                output=output,
                errors=errors,
                until_ns=wall_ns() + question.patience_s * 1_000_000_000,
            )
            self._pending.append(pending)

    def tick(self) -> None:
        """Send the answers of processes that have ended; end processes that take too long."""
        for pending in list(self._pending):
            if pending.process.poll() is not None:
                self._finish(pending)
            elif wall_ns() > pending.until_ns:
                patience_s, command = pending.question.patience_s, pending.question.command
                self._end(pending, f"the answer takes longer than {patience_s} s: {command}")

    def close(self) -> None:
        """End the processes of all questions."""
        for pending in list(self._pending):
            self._end(pending, "the session has ended")

    def _finish(self, pending: _Pending) -> None:
        """Send the answer of a process that has ended, or the last line of its errors."""
        with pending.files:
            output, errors = _read(pending.output), _read(pending.errors)
        self._pending.remove(pending)
        try:
            self._send_answer(pending, json.loads(output))
        except ValueError:
            last_line = errors.decode(errors="replace").strip().rpartition("\n")[2]
            self._send_answer(pending, {"refused": f"{pending.question.command} failed: {last_line}"})

    def _end(self, pending: _Pending, reason: str) -> None:
        """End a process, and refuse its question with a reason."""
        pending.process.kill()
        pending.process.wait()
        pending.files.close()
        self._pending.remove(pending)
        self._send_answer(pending, {"refused": reason})

    def _send_answer(self, pending: _Pending, answer: dict[str, Any]) -> None:
        ok = {} if "refused" in answer else {"ok": True}
        pending.page.send({"answer": {"id": pending.number, **ok, **answer}})


def _read(file: IO[bytes]) -> bytes:
    file.seek(0)
    return file.read()
