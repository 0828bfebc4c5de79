"""Breakpoints of a program in Python: a line that runs, a value that changes; the session pauses after it.

Lines are traced only while there is a breakpoint on one, and only in functions of the program's file.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from scanrack.jobs.record.tag_names import namespace_of
from scanrack.runtime.loop.scan import ScanLogic

EXECUTES = ("true", "executes")
"""What a breakpoint on a line may wait for: that it runs."""


class PythonStops:
    """Breakpoints of a program; satisfies `runtime.live.session.Stops`.

    Args:
        logic: returns the program, which an edit may replace.
        file: its file; a copy of it with the same name may run.

    Attributes:
        ran: the lines that ran in the latest scan, while there is a breakpoint on one.
    """

    def __init__(self, logic: Callable[[], ScanLogic], file: Path) -> None:
        self._logic, self._file = logic, file
        self._lines: set[int] = set()
        self._values: dict[str, tuple[CodeType, Any]] = {}  # by name: how to read it, and the value before
        self._met: set[int] = set()
        self._running: set[int] = set()
        self.ran: tuple[int, ...] = ()
        self._own: dict[CodeType, bool] = {}

    @property
    def stops(self) -> tuple[str, ...]:
        """The breakpoints that were met since this was read last, as sentences."""
        met, self._met = sorted(self._met), set()
        self.ran, self._running = tuple(sorted(self._running)), set()
        lines = [f"{self._file.name} line {line} has run" for line in met]
        return (*lines, *self._changes())

    def break_at(self, routine: str, rung: int, when: str = "executes") -> None:
        """Set a breakpoint at a line.

        Args:
            routine: the name of the program's file.
            rung: the number of the line, from 1.

        Raises:
            ValueError: another file, a line without a statement of a function, or another tool traces.
        """
        if routine.casefold() != self._file.name.casefold():
            raise ValueError(f"no file {routine}; the program is {self._file.name}")
        if when not in EXECUTES:
            raise ValueError(f"a line of Python has no {when!r}; it executes")
        known = set(_lines_of(compile(self._file.read_bytes(), self._file.name, "exec")))
        if rung not in known:
            raise ValueError(f"{self._file.name} line {rung}: nothing runs there in a scan")
        if not self._lines and sys.gettrace() is not None:
            raise ValueError("another debugger traces the program")
        self._lines.add(rung)
        sys.settrace(self._trace)

    def break_on(self, tag: str) -> None:
        """Set a breakpoint on a value of the program; ValueError if it can't be read."""
        try:
            code = compile(tag, "<breakpoint>", "eval")
            self._values[tag] = code, self._read(code)
        except Exception as error:  # whatever a property of the user's raises
            raise ValueError(f"{tag} can't be read: {error}") from error

    def remove_breakpoint(self, at: str, rung: int | None = None, when: str = "executes") -> None:
        """Remove a breakpoint at a line, or on a value."""
        if rung is None:
            self._values.pop(at, None)
            return
        self._lines.discard(rung)
        if not self._lines:
            self._end()

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""
        self._values.clear()
        self._lines.clear()
        self._own.clear()
        self._end()

    def _end(self) -> None:
        if sys.gettrace() == self._trace:
            sys.settrace(None)

    def _changes(self) -> Iterator[str]:
        for name, (code, before) in self._values.items():
            try:
                now = self._read(code)
            except Exception as error:  # it has no value now: a property of the user's raises
                now = f"not known: {error}"
            if now != before:
                self._values[name] = code, now
                yield f"{name} was {before!r} and is {now!r}"

    def _read(self, code: CodeType) -> Any:
        return eval(code, namespace_of(self._logic()))

    def _trace(self, frame: FrameType, _event: str, _given: object) -> Callable[..., Any] | None:
        code = frame.f_code
        if code not in self._own:
            self._own[code] = Path(code.co_filename).name == self._file.name
        return self._line if self._own[code] else None

    def _line(self, frame: FrameType, event: str, _given: object) -> Callable[..., Any]:
        if event == "line":
            self._running.add(frame.f_lineno)
            if frame.f_lineno in self._lines:
                self._met.add(frame.f_lineno)
        return self._line


def _lines_of(code: CodeType) -> Iterator[int]:
    """Yield the lines that run in the functions of a module, not those that run while it is loaded."""
    if code.co_flags & CO_OPTIMIZED:  # a function, not the text of a module or a class
        lines = {line for _, _, line in code.co_lines() if line}
        yield from lines - {code.co_firstlineno} or lines
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _lines_of(each)
