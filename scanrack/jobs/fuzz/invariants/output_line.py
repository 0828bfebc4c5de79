"""The line of the user's program that last changed an output word.

It distinguishes failures of one invariant where no rule of the manual fired.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ...record.logic_wrapper import LogicWrapper
from ...why.source.lines import Line, Lines


class Places(LogicWrapper):
    """A logic that is traced line by line."""

    def __init__(self, logic: ScanLogic, rack: Rack) -> None:
        super().__init__(logic)
        self._outputs = [slot.outputs.raw for slot in rack.slots.values()]
        self._lines = Lines(lambda: b"".join(self._outputs), self._changed)
        self.last = ""  # file name and line, such as "line.py:37"; empty before the first change

    def __call__(self, scan: Any) -> None:
        """Call the logic."""
        self._lines.call(self._logic, scan)

    def _changed(self, line: Line, _before: bytes, _after: bytes) -> None:
        self.last = f"{Path(line.file).name}:{line.number}" if line.number else ""
