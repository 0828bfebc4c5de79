"""A run of a session that is ready to begin."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from scanrack.jobs.record.order_repeater import RecordedOrder
from scanrack.jobs.record.program_versions import ProgramVersions
from scanrack.jobs.run.running import JobRun
from scanrack.runtime.loop.pace import AdjustablePace


@dataclass(frozen=True, slots=True)
class Start:
    """The starting point of a session."""

    scan: int = 0  # the first scan that is not repeated; 0 without a parent
    orders: Sequence[RecordedOrder] | None = None  # orders of the parent and its ancestors before that scan
    metadata: dict[str, str] = field(default_factory=dict)
    paused: bool = False  # whether it begins paused


@dataclass(frozen=True, slots=True)
class PreparedRun:
    """A run that is ready to begin."""

    start: Start
    run: JobRun
    pacer: AdjustablePace
    trace: Path
    editions: ProgramVersions
    ports: ExitStack
