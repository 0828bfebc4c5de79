"""Breakpoints in a Python program or list of steps, at a line that runs or on a value that changes.

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
"""Conditions of a breakpoint on a line. Both are true when the line runs."""


class PythonStops(Observer):
    """The breakpoints of a program, as `runtime.live.session.Stops`.

    Args:
        logic: returns the running program, which an edit may replace.
        file: the program's file. A copy with the same name may run.

    Attributes:
        ran: the lines that ran in the latest scan; empty without a breakpoint on a line.
    """

    def __init__(self, logic: Callable[[], ScanLogic], file: Path) -> None:
        self._logic, self._file = logic, file
        self._line_breakpoints: set[int] = set()
        self._values: dict[str, tuple[CodeType, Any]] = {}  # by name: code that reads it, latest value
        self._running: set[int] = set()  # lines that have run since the last look at `stops`
        self.ran: tuple[int, ...] = ()
        self._watch = WATCH.get()
        self._watch.only()  # no observers: a branch is a copy of a session, with that session's observers

    @property
    def stops(self) -> tuple[str, ...]:
        """Sentences about the breakpoints that the program has reached since the last call."""
        self.ran, self._running = tuple(sorted(self._running)), set()
        reached = [line for line in self.ran if line in self._line_breakpoints]
        return (*(f"{self._file.name} line {line} has run" for line in reached), *self._changes())

    def break_at(self, routine: str, rung: int, when: str = "executes") -> None:
        """Set a breakpoint at a line.

        Args:
            routine: name of the program's file.
            rung: line number, from 1.

        Raises:
            ValueError: the file is not the program's, or the line has no statement that a scan runs.
        """
        if routine.casefold() != self._file.name.casefold():
            raise ValueError(f"no file {routine}; the program is {self._file.name}")
        if when not in EXECUTES:
            raise ValueError(f"a breakpoint on a line can't have the condition {when!r}; must be 'executes'")
        program: object = unwrapped(self._logic())
        steps = program.steps if isinstance(program, Steps) else ()
        known_lines = [step.line for step in steps] or marked_lines(self._file.read_bytes())
        if rung not in known_lines:
            raise ValueError(f"{self._file.name} line {rung}: nothing runs there in a scan")
        self._line_breakpoints.add(rung)
        self._watch.add(self)

    def break_on(self, tag: str) -> None:
        """Set a breakpoint on a change of an expression; raise ValueError if it can't be read."""
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
        self._line_breakpoints.discard(rung)
        if not self._line_breakpoints:
            self._watch.remove(self)

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""
        self._values.clear()
        self._line_breakpoints.clear()
        self._watch.remove(self)

    @override
    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        if file == self._file.name:
            self._running.add(line)

    def _changes(self) -> Iterator[str]:
        """Yield sentences about values that have changed since the last call; keep the new values."""
        for name, (code, old_value) in self._values.items():
            try:
                value = self._read(code)
            except Exception as error:  # a user's property may raise anything
                value = f"not known: {error}"
            if value != old_value:
                self._values[name] = code, value
                yield f"{name} was {old_value!r} and is {value!r}"

    def _read(self, code: CodeType) -> Any:
        return eval(code, namespace_of(self._logic()))
