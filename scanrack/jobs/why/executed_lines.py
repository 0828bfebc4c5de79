"""The lines of a Python program that ran in some scans of a recording.

scans     0 ............ 7,999    8,000 ...... 8,999
program   runs on their inputs    runs observed: the lines of each scan
"""

from __future__ import annotations

from types import FrameType

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.python.line_marks import Observer
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.traces.replay import PackedTrace
from typing_extensions import override

from .traced_run import Load
from .twin import Twin


@dataclass(frozen=True, slots=True)
class ExecutedLines:
    """The lines that ran in some scans.

    Attributes:
        lines: the sorted line numbers of each scan.
        departs: the first scan whose outputs differ from the recorded ones; None if there is none.
    """

    lines: dict[int, tuple[int, ...]]
    departs: int | None


def executed_lines(recording: PackedTrace, spec: RackSpec, load: Load, rows: range) -> ExecutedLines:
    """Run a program again on the inputs of a recording; return the lines of its file that ran.

    Args:
        rows: the scans in question, by their row in the recording.

    Raises:
        ValueError: the recording does not begin with scan 0.
    """
    twin, seen, found = Twin(load, spec, lambda: recording), _LinesOfFile(load.program.name), {}
    for scan, _ in twin.walk(rows[0], rows[-1], lambda _logic: seen):
        found[scan] = tuple(sorted(seen.numbers))
        seen.numbers.clear()
    return ExecutedLines(found, twin.departs)


class _LinesOfFile(Observer):
    """Notes the lines of a file that begin."""

    def __init__(self, file: str) -> None:
        self._file = file
        self.numbers: set[int] = set()

    @override
    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        if file == self._file:
            self.numbers.add(line)
