"""Runs the units on a rack's serial line in step with its scans, and records them beside the rack's trace."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.line.ports import BusSegment
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.traces.write.line import LineRecorder, UnitColumns

from ..trust.owned import line_path
from .served_units import pcl601_values


class UnitsBeside(QuietListener):
    """A listener of the scan loop that advances the units with the scans.

    Args:
        units: the units by address, at least one.
        trace: trace of the rack; the line's recording is beside it, see `line_path`.

    Raises:
        OSError: the recording can't be written.
    """

    def __init__(self, units: Mapping[int, Pcl601], trace: Path | None) -> None:
        self.units = units
        self._line = BusSegment(*self.units.values())
        self._recorder = None if trace is None else self._recording(line_path(trace))
        self._record(0)

    def _recording(self, path: Path) -> LineRecorder:
        columns = [UnitColumns(address, tuple(pcl601_values(unit))) for address, unit in self.units.items()]
        return LineRecorder(path, columns, {"controller": "pcl601"})

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Advance the line to this scan and record its traffic."""
        bytes_sent = self._line.advance(now_ns)
        if bytes_sent and self._recorder is not None:
            self._recorder.sent(now_ns, bytes_sent)
        self._record(now_ns)

    def draft(self) -> None:
        """Write the recorded data uncompressed, so that it survives if the process is killed."""
        if self._recorder is not None:
            self._recorder.draft()

    def close(self) -> None:
        """Finish the recording."""
        if self._recorder is not None:
            self._recorder.close()

    def _record(self, now_ns: int) -> None:
        if self._recorder is not None:
            for address, unit in self.units.items():
                self._recorder.unit(now_ns, address, pcl601_values(unit))
