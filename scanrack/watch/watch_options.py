"""The options of `scanrack watch`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from scanrack.runtime.live.speeds import MAX, SPEED_LEAST, SPEED_MOST
from scanrack.terminal.shared_options import (
    ForcesOption,
    KeepValuesOption,
    MemoryOption,
    ReplaceOption,
    ScansOption,
    ServerOption,
    UaSecurityOption,
    UaUsersOption,
)

if TYPE_CHECKING:  # not needed to list the command
    from collections.abc import Callable

    from scanrack.jobs.run.running import JobRun
    from scanrack.jobs.run.servers.kinds import ServerAddress
    from scanrack.runtime.live.actions import Force
    from scanrack.runtime.live.session import Session


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchArguments:
    """The argument and the options of `scanrack watch`."""

    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK|EXPORT|TRACE",
            help="Rack file: TOML, or Python with rack(). Or an export, or a trace.",
            show_default=False,
        ),
    ]
    port: Annotated[
        int,
        typer.Option("--port", metavar="PORT", help="Port of the page; 0 = any free one.", min=0, max=65535),
    ] = 0
    speed: Annotated[
        str,
        typer.Option(
            "--time-scale",
            metavar="FACTOR",
            help=f"Times real time, {SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}.",
        ),
    ] = "1"
    spin: Annotated[
        bool,
        typer.Option(
            "--spin",
            help="Wait the last tenth of a period, 0.2 ms at most, without sleeping: fewer late scans.",
        ),
    ] = False
    paused: Annotated[bool, typer.Option("--paused", help="Start paused.")] = False
    read_only: Annotated[bool, typer.Option("--read-only", help="Make the page read-only.")] = False
    record: Annotated[
        Path | None, typer.Option("--record", metavar="TRACE", help="Trace file.", show_default=False)
    ] = None
    replace: ReplaceOption = False
    duration: Annotated[
        str | None,
        typer.Option("--for", metavar="TIME", help="Machine time to run for; without it until Ctrl-C."),
    ] = None
    scans: ScansOption = None
    live: Annotated[
        bool,
        typer.Option("--live", help="Real ports may move real motors. This is not a safety system."),
    ] = False
    control: Annotated[
        bool,
        typer.Option(
            "--allow-writes", help="With --live: let the page change the rack; read-only without it."
        ),
    ] = False
    opened: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False
    text: Annotated[
        bool, typer.Option("--text", help="Show bits, values and events in the terminal, too, at 4 Hz.")
    ] = False
    forces: ForcesOption = False
    keep_values: KeepValuesOption = False
    memory: MemoryOption = None
    server: ServerOption = None
    ua_security: UaSecurityOption = None
    ua_users: UaUsersOption = None
    trust: Annotated[
        bool, typer.Option("--trust", help="Run Python that came with a trace, or is typed in the page.")
    ] = False
    preview: Annotated[
        bool, typer.Option("--preview", help="Show a saved program in the page before it is accepted.")
    ] = False


@dataclass(frozen=True, slots=True)
class WatchOptions:
    """The settings of a session, derived from the options."""

    arguments: WatchArguments
    speed: float | None = 1.0  # multiple of real time; None = as fast as possible
    read_only: bool = False  # whether to refuse orders and edits of the program
    scans: int | None = None  # number of scans; None = until Ctrl-C
    editable: bool = True  # whether the program's files are on disk and saved changes are used
    keep: int | None = None  # number of earlier recordings to keep; None = as in the rack file
    forces: tuple[Force, ...] = ()  # forces of tags and images from the first scan
    servers: tuple[ServerAddress, ...] = ()  # servers through which clients read and write tags
    door: Callable[[Session, JobRun], object] | None = None  # called with each session, by a debug adapter
    saved: Callable[[str], None] | None = None  # called with a saved program file's name, which then waits
    remembered: int = 0  # number of snapshots from which a debug adapter reruns scans, see `Debugger`
    page: bool = True  # whether there is a page
