"""The line of the user's program that last changed an output word.

    line.py:37    out.load(OUT)        the words change here
    line.py:38    line.step = "back"   a later change counts; the same words once more do not

It distinguishes failures of one invariant where no rule of the manual fired.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from ...loop.faults import is_the_users
from ...loop.rack import Rack
from ...loop.scan import Logic


class Places:
    """A logic that is traced line by line.

    Attributes:
        last: file name and line, such as "line.py:37"; empty before the first change.
    """

    def __init__(self, logic: Logic, rack: Rack) -> None:
        self._logic = logic
        self._outputs = [slot.outputs.raw for slot in rack.slots.values()]
        self._seen = self._words()
        self._at = ""
        self.last = ""

    def __call__(self, scan: Any) -> None:
        """Call the logic."""
        self._seen = self._words()
        with _traced_by(self._enter):
            self._logic(scan)
        self._look()

    def _words(self) -> bytes:
        return b"".join(self._outputs)

    def _look(self) -> None:
        """Blame the line that was executed last for what has changed."""
        words = self._words()
        if words != self._seen:
            self._seen, self.last = words, self._at

    def _enter(self, frame: FrameType, _event: str, _arg: object) -> Any:
        """Trace the functions of the user's files only."""
        name = frame.f_code.co_filename
        return self._line if is_the_users(name) and not name.startswith("<") else None

    def _line(self, frame: FrameType, event: str, _arg: object) -> Any:
        self._look()
        if event == "line":
            self._at = f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}"
        return self._line


@contextmanager
def _traced_by(function: Any) -> Iterator[None]:
    """Trace what is called, and give a debugger or a coverage tool its trace function back."""
    before = sys.gettrace()
    sys.settrace(function)
    try:
        yield
    finally:
        sys.settrace(before)
