"""Long questions: a process of its own answers each, in bounded time."""

from __future__ import annotations

import json
import pickle
import tempfile
from dataclasses import dataclass
from typing import Any

from ...jobs.trust.launcher import PIPE, Helper, launch
from ...runtime.loop.pace import wall_ns
from ...traces.read.columns import Columns
from .page import Page

PATIENCE_NS = 20_000_000_000
"""Time limit of a question."""


@dataclass(frozen=True, slots=True)
class _Open:
    """A question without an answer yet."""

    page: Page
    number: object
    process: Helper
    until_ns: int
    command: str


class QuestionProcesses:
    """The questions in work by processes; one per page, the latest."""

    def __init__(self) -> None:
        self._open: list[_Open] = []

    def why(self, page: Page, number: object, trace: str, what: str, more: Columns) -> None:
        """Ask for the cause of a Python program's recorded value; the answer goes to the page.

        Args:
            more: the latest scans, which may not be written yet; the question is about the last one.
        """
        scan = more.scan[-1]
        for each in [each for each in self._open if each.page is page]:
            self._end(each, "another question was asked meanwhile")
        command = f"scanrack why {trace} {what} --at {scan} --trust"
        with tempfile.TemporaryFile() as given:  # not a pipe: this must not wait for the process
            pickle.dump(more, given)
            given.seek(0)
            main = f"{__package__}.why_process:main"
            process = launch(main, trace, what, scan, stdin=given, stdout=PIPE, stderr=PIPE)
        self._open.append(_Open(page, number, process, wall_ns() + PATIENCE_NS, command))

    def tick(self) -> None:
        """Pass on the received answers."""
        for each in list(self._open):
            if each.process.poll() is not None:
                self._finish(each)
            elif wall_ns() > each.until_ns:
                self._end(each, f"the answer takes longer than {PATIENCE_NS // 10**9} s: {each.command}")

    def close(self) -> None:
        """End all questions."""
        for each in list(self._open):
            self._end(each, "the session has ended")

    def _finish(self, question: _Open) -> None:
        out, err = question.process.communicate()
        self._open.remove(question)
        try:
            self._answer(question, json.loads(out))
        except ValueError:
            last = err.decode(errors="replace").strip().rpartition("\n")[2]
            self._answer(question, {"refused": f"{question.command} failed: {last}"})

    def _end(self, question: _Open, reason: str) -> None:
        question.process.kill()
        question.process.communicate()
        self._open.remove(question)
        self._answer(question, {"refused": reason})

    def _answer(self, question: _Open, told: dict[str, Any]) -> None:
        ok = {} if "refused" in told else {"ok": True}
        question.page.send({"answer": {"id": question.number, **ok, **told}})
