"""The options of a session, and a run of it that is ready to begin."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from ..jobs.record.order_repeater import RecordedOrder
from ..jobs.record.program_versions import ProgramVersions
from ..jobs.run.running import JobRun
from ..jobs.run.servers.kinds import ServerAddress
from ..runtime.live.actions import Force
from ..runtime.loop.pace import AdjustablePace


@dataclass(frozen=True, slots=True)
class WatchOptions:
    """The options of the command line."""

    rack: str
    port: int  # of the server; 0 = any free one
    speed: float | None  # times real time; None = as fast as possible
    paused: bool
    read_only: bool  # refuse orders, and edits of the program
    record: Path | None  # path of a permanent recording, or None
    scans: int | None  # their number; None = until Ctrl-C
    live: bool  # real ports may be driven
    opened: bool  # open the page in the browser
    text: bool = False  # show the session in the terminal, too
    editable: bool = True  # the program's files are on the disk, and saved changes are used
    keep: int | None = None  # number of earlier recordings to keep; None = the rack file's
    preview: bool = False  # a saved program waits until a page takes it over
    trust: bool = False  # Python that is typed in a page may run
    forces: tuple[Force, ...] = ()  # of tags and images, held from the first scan on
    spin: bool = False  # wait the end of each period without sleeping
    servers: tuple[ServerAddress, ...] = ()  # where clients read and write tags


@dataclass(frozen=True, slots=True)
class Start:
    """The begin of a session."""

    scan: int = 0  # the first scan that is not a repetition; 0 without a parent
    orders: Sequence[RecordedOrder] | None = None  # of the parent before that scan, and of its ancestors
    metadata: dict[str, str] = field(default_factory=dict)
    paused: bool = False  # it begins with a pause


@dataclass(frozen=True, slots=True)
class PreparedRun:
    """A run that is ready to begin."""

    start: Start
    run: JobRun
    pacer: AdjustablePace
    trace: Path
    editions: ProgramVersions
    ports: ExitStack
