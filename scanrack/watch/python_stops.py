"""Breakpoints of a program in Python, or a list of steps: a line that runs, a value that changes.

The session pauses after the scan. Lines are traced only while something observes them, and only in
functions of the user's files.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Set
from contextlib import contextmanager
from functools import cache
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from scanrack.jobs.record.logic_wrapper import unwrapped
from scanrack.jobs.record.tag_names import namespace_of
from scanrack.ladder.files.steps import Steps
from scanrack.runtime.loop.faults import is_the_users
from scanrack.runtime.loop.scan import ScanLogic

EXECUTES = ("true", "executes")
"""What a breakpoint on a line may wait for: that it runs."""


class Observer:
    """Sees the lines of the user's files before they run.

    Attributes:
        lines: of functions without one of these lines it sees none; None = it sees all.
    """

    lines: Set[int] | None = None

    def begins(self, frame: FrameType) -> None:
        """See a line before it runs."""

    def began(self, file: str, line: int) -> None:
        """See that a step of a list of steps has begun."""


class LineTrace:
    """Traces the lines of the user's files for observers, in this thread."""

    def __init__(self) -> None:
        self._observers: list[Observer] = []
        self._seeing: dict[CodeType, list[Observer]] = {}

    @staticmethod
    @cache
    def is_own(code: CodeType) -> bool:
        """Whether code is a function of the user's."""
        return is_the_users(code.co_filename) and not code.co_filename.startswith("<")

    @staticmethod
    @cache
    def name(file: str) -> str:
        """Return the name of a file without its folder: a copy of a program runs in another one."""
        return Path(file).name

    def add(self, observer: Observer) -> None:
        """Trace for an observer, also after its lines have changed.

        Raises:
            ValueError: another tool traces.
        """
        if sys.gettrace() not in (None, self._trace):
            raise ValueError("another debugger traces the program")
        self._seeing.clear()
        if observer not in self._observers:
            self._observers.append(observer)
        sys.settrace(self._trace)

    def remove(self, observer: Observer) -> None:
        """Trace no longer for an observer."""
        self._seeing.clear()
        self._observers = [each for each in self._observers if each is not observer]
        if not self._observers and sys.gettrace() == self._trace:
            sys.settrace(None)

    @staticmethod
    @contextmanager
    def only(observer: Observer | None) -> Iterator[None]:
        """Trace for this observer alone within the context; None = trace nothing."""
        before = sys.gettrace()
        sys.settrace(None)
        own = LineTrace()
        if observer is not None:
            own.add(observer)
        try:
            yield
        finally:
            sys.settrace(before)

    def _trace(self, frame: FrameType, _event: str, _given: object) -> Callable[..., Any] | None:
        code = frame.f_code
        seeing = self._seeing.get(code)
        if seeing is None:
            seeing = self._seeing[code] = [each for each in self._observers if self._sees(each, code)]
        return self._line if seeing else None

    def _sees(self, observer: Observer, code: CodeType) -> bool:
        if not self.is_own(code):
            return False
        return observer.lines is None or any(line in observer.lines for _, _, line in code.co_lines())

    def _line(self, frame: FrameType, event: str, _given: object) -> Callable[..., Any]:
        if event == "line":
            for each in self._seeing.get(frame.f_code, ()):
                each.begins(frame)
        return self._line


class PythonStops(Observer):
    """Breakpoints of a program; satisfies `runtime.live.session.Stops`.

    Args:
        logic: returns the program, which an edit may replace.
        file: its file; a copy of it with the same name may run.

    Attributes:
        ran: the lines that ran in the latest scan, while there is a breakpoint on one.
        trace: what traces its lines, and those of a debug adapter.
    """

    def __init__(self, logic: Callable[[], ScanLogic], file: Path) -> None:
        self._logic, self._file = logic, file
        self._breaks: set[int] = set()
        self._values: dict[str, tuple[CodeType, Any]] = {}  # by name: how to read it, and the value before
        self._met: set[int] = set()
        self._running: set[int] = set()
        self._begun = 0  # steps of a list that have begun
        self.ran: tuple[int, ...] = ()
        self.trace = LineTrace()

    @property
    def stops(self) -> tuple[str, ...]:
        """The breakpoints that were met since this was read last, as sentences."""
        if self._breaks:
            self._note_step()
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
        steps = self._steps()
        known = (
            lines_with_code(self._file.read_bytes()) if steps is None else {each.line for each in steps.steps}
        )
        if rung not in known:
            raise ValueError(f"{self._file.name} line {rung}: nothing runs there in a scan")
        if steps is None:
            self.trace.add(self)
        else:
            self._begun = steps.resumed
        self._breaks.add(rung)

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
        self._breaks.discard(rung)
        if not self._breaks:
            self.trace.remove(self)

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""
        self._values.clear()
        self._breaks.clear()
        self.trace.remove(self)

    def begins(self, frame: FrameType) -> None:
        """Note a line of the program."""
        if LineTrace.name(frame.f_code.co_filename) == self._file.name:
            self._running.add(frame.f_lineno)
            if frame.f_lineno in self._breaks:
                self._met.add(frame.f_lineno)

    def _steps(self) -> Steps | None:
        """Return the program if it is a list of steps."""
        logic: object = unwrapped(self._logic())
        return logic if isinstance(logic, Steps) else None

    def _note_step(self) -> None:
        """Note a step of a list that has begun."""
        steps = self._steps()
        if steps is not None and steps.resumed != self._begun:
            self._begun = steps.resumed
            self._running.add(steps.line)
            self._met |= self._breaks & {steps.line}

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


def lines_with_code(source: bytes) -> frozenset[int]:
    """Return the lines that run in the functions of a module, not those that run while it is loaded."""
    return frozenset(_lines_of(compile(source, "<program>", "exec")))


def _lines_of(code: CodeType) -> Iterator[int]:
    if code.co_flags & CO_OPTIMIZED:  # a function, not the text of a module or a class
        lines = {line for _, _, line in code.co_lines() if line}
        yield from lines - {code.co_firstlineno} or lines
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _lines_of(each)
