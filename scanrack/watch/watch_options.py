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
            help="Rack file (TOML, or Python with rack()), export, or trace.",
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
            help="Wait up to 0.2 ms before each scan without sleep, for fewer late scans.",
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
        typer.Option("--for", metavar="TIME", help="Machine time to run. [default: until Ctrl-C]"),
    ] = None
    scans: ScansOption = None
    live: Annotated[
        bool,
        typer.Option("--live", help="Real ports may move real motors. This is not a safety system."),
    ] = False
    control: Annotated[
        bool,
        typer.Option(
            "--allow-writes", help="With --live: let the page change the rack. [default: read-only]"
        ),
    ] = False
    opened: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False
    text: Annotated[
        bool, typer.Option("--text", help="Also show bits, values and events in the terminal.")
    ] = False
    forces: ForcesOption = False
    keep_values: KeepValuesOption = False
    memory: MemoryOption = None
    server: ServerOption = None
    ua_security: UaSecurityOption = None
    ua_users: UaUsersOption = None
    trust: Annotated[bool, typer.Option("--trust", help="Run Python from a trace or typed in the page.")] = (
        False
    )
    preview: Annotated[
        bool, typer.Option("--preview", help="Preview a saved program in the page before it runs.")
    ] = False


@dataclass(frozen=True, slots=True)
class WatchOptions:
    """The settings of a session, derived from the options."""

    arguments: WatchArguments
    speed: float | None = 1.0  # multiple of real time; None = as fast as possible
    read_only: bool = False  # whether to refuse actions and edits of the program
    scans: int | None = None  # number of scans; None = until Ctrl-C
    editable: bool = True  # whether the program's files are on disk, and saved changes run
    keep: int | None = None  # number of earlier traces to keep; None = as in the rack file
    forces: tuple[Force, ...] = ()  # forces of tags and images from the first scan
    servers: tuple[ServerAddress, ...] = ()  # servers through which clients read and write tags
    door: Callable[[Session, JobRun], object] | None = None  # called with each session, for a debug adapter
    saved: Callable[[str], None] | None = None  # called with the name of a saved program, which does not run
    remembered: int = 0  # number of snapshots for a debug adapter to rerun scans, see `Debugger`
    page: bool = True  # whether there is a page
