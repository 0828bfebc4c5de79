"""The executed lines of a Python program in scans of a recording.

scans     0 ............ 7,999    8,000 ...... 8,999
program   runs on their inputs    the same, traced: the lines of each scan
"""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.scan import LogicScan, ScanLogic
from scanrack.traces.replay import PackedTrace

from ..record.logic_wrapper import LogicWrapper
from ..replay.replaying import score_of
from ..replay.tag_orders import TagOrders
from .input_replay import InputReplay
from .source.lines import Lines
from .traced_run import Load, fresh


@dataclass(frozen=True, slots=True)
class ExecutedLines:
    """The lines that ran.

    Attributes:
        lines: by scan, sorted; of a scan without one the controller did not run the program.
        departs: the first scan with other outputs than recorded; None without one.
    """

    lines: dict[int, tuple[int, ...]]
    departs: int | None


def executed_lines(recording: PackedTrace, spec: RackSpec, load: Load, rows: range) -> ExecutedLines:
    """Run a program again on the inputs of a recording; return the lines of its file that run.

    Args:
        rows: the scans in question, by their places in the recording.
    """
    following = InputReplay(recording, spec, rows[-1])
    with fresh(load) as logic:
        traced = _TracedLines(logic, load.program.name, following, rows)
        following.play(traced, TagOrders(score_of(recording), recording.events, load.edited))
    numbers, departs = recording.numbers, following.departs
    lines = {numbers[row]: tuple(sorted(ran)) for row, ran in traced.ran.items()}
    return ExecutedLines(lines, None if departs is None else numbers[departs])


class _TracedLines(LogicWrapper):
    """Notes the lines of one file in the scans in question."""

    def __init__(self, logic: ScanLogic, file: str, following: InputReplay, rows: range) -> None:
        super().__init__(logic)
        self._following, self._rows = following, rows
        self.ran: dict[int, set[int]] = {}
        suffixes = f"/{file}", f"\\{file}"
        self._lines = Lines(
            bool,
            lambda *_: None,
            lambda line, _: self._running.add(line.number) if line.file.endswith(suffixes) else None,
        )
        self._running: set[int]

    def __call__(self, scan: LogicScan) -> None:
        row = self._following.row
        if row in self._rows:
            self._running = self.ran[row] = set()
            self._lines.call(self._logic, scan)
        else:
            self._logic(scan)
