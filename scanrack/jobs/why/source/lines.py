"""The lines of the user's program that change a watched value, found while the program runs.

    line.py:37    out.load(OUT)        the watched value changes here
    line.py:38    line.step = "back"   only a different value counts as a change

Only functions in the user's files are traced. A change in scanrack or in an installed package is attributed
to the user's line that called it. Only some scans are traced, in a run that answers a question.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.state.memory import same
from scanrack.runtime.loop.faults import is_the_users


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the user's program."""

    file: str
    number: int  # from 1
    function: str


NOWHERE = Line("", 0, "")
"""No line: before the first one, or not in the user's files."""


class Lines:
    """Traces calls, and reports each change in a watched value with its line.

    Args:
        watched: returns the value, which is compared with `same`.
        changed: called with the line, the value before and the value after.
        begins: called with each line before it runs, and with its frame.
    """

    def __init__(
        self,
        watched: Callable[[], Any],
        changed: Callable[[Line, Any, Any], None],
        begins: Callable[[Line, FrameType], None] = lambda _line, _frame: None,
    ) -> None:
        self._watched, self._changed, self._begins = watched, changed, begins
        self._seen: Any = None
        self._line_running = NOWHERE
        self._outermost: FrameType | None = None

    @property
    def in_program(self) -> bool:
        """Whether a line of the user's program, or a function that it called, is running."""
        return self._line_running is not NOWHERE

    def call(self, function: Callable[..., None], *arguments: Any) -> None:
        """Call a function and trace it; changes before the call are not attributed to a line."""
        self._seen = self._watched()
        self._line_running = NOWHERE
        self._outermost = sys._getframe()
        try:
            with _traced_by(self._trace_call):
                function(*arguments)
        finally:
            self._outermost = None
            self._report_change()

    def _report_change(self) -> None:
        """Report the running line if the value has changed."""
        value = self._watched()
        if not same(value, self._seen):
            before, self._seen = self._seen, value
            self._changed(self._line_running, before, value)

    def _trace_call(self, frame: FrameType, _event: str, _arg: object) -> Any:
        """Trace only functions in the user's files."""
        if not _is_of_a_file(frame):
            return None
        self._report_change()
        return self._trace_line

    def _trace_line(self, frame: FrameType, event: str, _arg: object) -> Any:
        """Report a change by the line that has just ended, and note the line that runs now."""
        self._report_change()
        if event == "line":
            self._line_running = _line_of(frame)
            self._begins(self._line_running, frame)
        elif event == "return":
            self._line_running = self._caller(frame)  # the calling line continues
        return self._trace_line

    def _caller(self, frame: FrameType) -> Line:
        """Return the user's line that made the call, directly or not; `NOWHERE` outside of `call`."""
        above = frame.f_back
        while above is not None and above is not self._outermost:
            if _is_of_a_file(above):
                return _line_of(above)
            above = above.f_back
        return NOWHERE


def _is_of_a_file(frame: FrameType) -> bool:
    name = frame.f_code.co_filename
    return is_the_users(name) and not name.startswith("<")


def _line_of(frame: FrameType) -> Line:
    code = frame.f_code
    return Line(code.co_filename, frame.f_lineno, code.co_name)


@contextmanager
def _traced_by(function: Any) -> Iterator[None]:
    """Trace calls, then restore the trace function of a debugger or coverage tool."""
    before = sys.gettrace()
    sys.settrace(function)
    try:
        yield
    finally:
        sys.settrace(before)
