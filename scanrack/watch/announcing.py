"""Announcements of edited programs and branches to the monitor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from scanrack.jobs.record.order_repeater import RecordedOrder
from scanrack.jobs.record.program_versions import ProgramVersion, ProgramVersions
from scanrack.jobs.run.editing import ProgramEdit
from scanrack.jobs.run.running import JobRun
from scanrack.runtime.live.actions import Edit
from scanrack.runtime.live.ring import Ring

from .monitor_supervisor import MonitorSupervisor, NoMonitor
from .monitors.stretched import SessionProgram


def programs_of(
    run: JobRun, editions: ProgramVersions, orders: Sequence[RecordedOrder]
) -> tuple[SessionProgram, ...]:
    """Return the programs of a run so far, each with its first scan."""
    edits = [order.scan for order in orders if isinstance(order.order, Edit)][: run.program.edits]
    return tuple(_session_program(editions[number], first) for number, first in enumerate((0, *edits)))


class Announcer:
    """Announcements of a run. A restarted monitor starts with the latest one."""

    def __init__(
        self,
        run: JobRun,
        editions: ProgramVersions,
        orders: Sequence[RecordedOrder],
        send: Callable[[Mapping[str, object]], None],
        supervisor: MonitorSupervisor | NoMonitor,
    ) -> None:
        self._run, self._editions, self._send, self._supervisor = run, editions, send, supervisor
        self._programs = programs_of(run, editions, orders)
        self._last_repeated_scan = orders[-1].scan if orders else -1

    def announce_edit(self, edited: ProgramEdit) -> None:
        """Announce an edit."""
        program = _session_program(self._editions[edited.number], edited.at_ns // self._run.cpu.period_ns)
        self._programs += (program,)
        self._supervisor.replace_programs(programs=self._programs)
        is_repeated = program.first <= self._last_repeated_scan
        fields = {"number": edited.number, "program": program, "again": is_repeated}
        self._send({"edited": {"text": edited.text, **edited.tags, **fields}})

    def announce_branch(self, ring: Ring, trace: Path, record: str | None) -> None:
        """Announce a branch to this monitor and to later ones.

        Args:
            ring: ring into which the branch writes.
            trace: path of the branch's recording.
            record: the same path if the user keeps the recording, otherwise None.
        """
        self._supervisor.replace_programs(trace=str(trace), record=record, programs=self._programs)
        positions = {"rows": ring.written, "snapshots": ring.snapshots.end}  # where the branch begins
        recording = {"trace": str(trace), "record": record}
        self._send({"branch": {**recording, "programs": self._programs, **positions}})


def _session_program(edition: ProgramVersion, first: int) -> SessionProgram:
    assert edition.place is not None, "a monitor needs a copy on disk"
    return SessionProgram(first, str(edition.place), edition.rack, edition.program)
