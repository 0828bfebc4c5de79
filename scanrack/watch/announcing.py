"""Announces programs, with their first scans, and branches to the monitor."""

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
    """Return the programs that a run has had so far."""
    edits = [order.scan for order in orders if isinstance(order.order, Edit)][: run.program.edits]
    return tuple(_ran(editions[number], first) for number, first in enumerate((0, *edits)))


class Announcer:
    """Announces the programs of a run; later monitors start with the latest announcement."""

    def __init__(
        self,
        run: JobRun,
        editions: ProgramVersions,
        orders: Sequence[RecordedOrder],
        tell: Callable[[Mapping[str, object]], None],
        supervisor: MonitorSupervisor | NoMonitor,
    ) -> None:
        self._run, self._editions, self._tell, self._supervisor = run, editions, tell, supervisor
        self._programs = programs_of(run, editions, orders)
        self._again = orders[-1].scan if orders else -1

    def tell_edit(self, edited: ProgramEdit) -> None:
        """Announce an edit."""
        program = _ran(self._editions[edited.number], edited.at_ns // self._run.cpu.period_ns)
        self._programs += (program,)
        self._supervisor.replace_programs(programs=self._programs)
        is_again = program.first <= self._again
        fields = {"number": edited.number, "program": program, "again": is_again}
        self._tell({"edited": {"text": edited.text, **edited.tags, **fields}})

    def tell_branch(self, ring: Ring, trace: Path, record: str | None) -> None:
        """Announce a branch, also to monitors that start later.

        Args:
            ring: ring into which the branch writes.
            trace: path of the branch's recording.
            record: the same path, if the recording is kept.
        """
        self._supervisor.replace_programs(trace=str(trace), record=record, programs=self._programs)
        places = {"rows": ring.written, "snapshots": ring.snapshots.end}
        self._tell({"branch": {"trace": str(trace), "record": record, "programs": self._programs, **places}})


def _ran(edition: ProgramVersion, first: int) -> SessionProgram:
    assert edition.place is not None, "a monitor reads a copy"
    return SessionProgram(first, str(edition.place), edition.rack, edition.program)
