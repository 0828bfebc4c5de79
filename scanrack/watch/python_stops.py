"""Breakpoints of a Python program or a list of steps: on a line that runs, or a value that changes.

The session pauses after the scan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from scanrack.jobs.record.logic_wrapper import unwrapped
from scanrack.jobs.record.tag_names import namespace_of
from scanrack.ladder.files.steps import Steps
from scanrack.ladder.python.line_marks import WATCH, Observer, marked_lines
from scanrack.runtime.loop.scan import ScanLogic
from typing_extensions import override

EXECUTES = ("true", "executes")
"""Conditions of a breakpoint on a line; both mean that the line runs."""


class PythonStops(Observer):
    """The breakpoints of a program; satisfies `runtime.live.session.Stops`.

    Args:
        logic: returns the program, which an edit may replace.
        file: file of the program; a copy with the same name may run.

    Attributes:
        ran: the lines that ran in the latest scan, while any line has a breakpoint.
    """

    def __init__(self, logic: Callable[[], ScanLogic], file: Path) -> None:
        self._logic, self._file = logic, file
        self._breaks: set[int] = set()
        self._values: dict[str, tuple[CodeType, Any]] = {}  # by name: code that reads it, previous value
        self._running: set[int] = set()
        self.ran: tuple[int, ...] = ()
        self._watch = WATCH.get()
        self._watch.only()  # a branch begins without its session's observers

    @property
    def stops(self) -> tuple[str, ...]:
        """Sentences about the breakpoints that were hit since this was last read."""
        self.ran, self._running = tuple(sorted(self._running)), set()
        lines = [f"{self._file.name} line {line} has run" for line in self.ran if line in self._breaks]
        return (*lines, *self._changes())

    def break_at(self, routine: str, rung: int, when: str = "executes") -> None:
        """Set a breakpoint at a line.

        Args:
            routine: name of the program's file.
            rung: line number, from 1.

        Raises:
            ValueError: it is another file, or the line has no statement in a function.
        """
        if routine.casefold() != self._file.name.casefold():
            raise ValueError(f"no file {routine}; the program is {self._file.name}")
        if when not in EXECUTES:
            raise ValueError(f"a line of Python has no {when!r}; it executes")
        program: object = unwrapped(self._logic())
        steps = program.steps if isinstance(program, Steps) else ()
        known_lines = [step.line for step in steps] or marked_lines(self._file.read_bytes())
        if rung not in known_lines:
            raise ValueError(f"{self._file.name} line {rung}: nothing runs there in a scan")
        self._breaks.add(rung)
        self._watch.add(self)

    def break_on(self, tag: str) -> None:
        """Set a breakpoint on a value of the program; raise ValueError if it can't be read."""
        try:
            code = compile(tag, "<breakpoint>", "eval")
            self._values[tag] = code, self._read(code)
        except Exception as error:  # a user's property may raise anything
            raise ValueError(f"{tag} can't be read: {error}") from error

    def remove_breakpoint(self, at: str, rung: int | None = None, when: str = "executes") -> None:
        """Remove a breakpoint from a line or value."""
        if rung is None:
            self._values.pop(at, None)
            return
        self._breaks.discard(rung)
        if not self._breaks:
            self._watch.remove(self)

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""
        self._values.clear()
        self._breaks.clear()
        self._watch.remove(self)

    @override
    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        if file == self._file.name:
            self._running.add(line)

    def _changes(self) -> Iterator[str]:
        for name, (code, before) in self._values.items():
            try:
                now = self._read(code)
            except Exception as error:  # there is no value now: a user's property raises
                now = f"not known: {error}"
            if now != before:
                self._values[name] = code, now
                yield f"{name} was {before!r} and is {now!r}"

    def _read(self, code: CodeType) -> Any:
        return eval(code, namespace_of(self._logic()))
