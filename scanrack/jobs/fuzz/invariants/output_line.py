"""Finds the line of the user's program that last changed an output word.

If no rule of the manual fired, this line distinguishes the failures of one invariant.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ...record.logic_wrapper import LogicWrapper
from ...why.source.lines import Line, Lines


class OutputLine(LogicWrapper):
    """Logic that is traced line by line, starting with a given scan. A traced scan takes ten times as long.

    Attributes:
        last: file name and line of the last change, such as "line.py:37"; empty if the change belongs to no
            line; None before the first traced change.
        changed_in: the last untraced scan in which outputs changed; 0 if there is none. A run that traces
            from this scan on finds the last change.

    Args:
        since: number of the first traced scan.
    """

    def __init__(self, logic: ScanLogic, rack: Rack, since: int) -> None:
        super().__init__(logic)
        self._images = [slot.outputs.raw for slot in rack.slots.values()]
        self._lines = Lines(self._outputs, self._record_line)
        self._since = since
        self.last: str | None = None
        self.changed_in = 0

    def __call__(self, scan: Any) -> None:
        """Call the logic; trace it once the first traced scan is reached."""
        if scan.number >= self._since:
            self._lines.call(self._logic, scan)
            return
        before = self._outputs()
        self._logic(scan)
        if self._outputs() != before:
            self.changed_in = scan.number

    @property
    def is_complete(self) -> bool:
        """Whether `last` is final: a change or every scan was traced."""
        return self.last is not None or self._since == 0

    def _outputs(self) -> bytes:
        return b"".join(self._images)

    def _record_line(self, line: Line, _before: bytes, _after: bytes) -> None:
        self.last = f"{Path(line.file).name}:{line.number}" if line.number else ""
