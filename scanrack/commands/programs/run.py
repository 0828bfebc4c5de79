"""`scanrack run RACK` for typer: its options and its page of help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.times import DEFAULT_RUN
from scanrack.terminal.as_json import JsonOption
from scanrack.terminal.grouped import grouped
from scanrack.terminal.shared_options import (
    ForcesOption,
    KeepValuesOption,
    MemoryOption,
    ReplaceOption,
    ServerOption,
    UaSecurityOption,
    UaUsersOption,
)

from .run_command import RunArguments, run_command

DECLARED = {
    "rack": Annotated[
        str,
        typer.Argument(
            metavar="RACK",
            help="Rack file: TOML, or Python that defines rack(). Or an .L5X or .SLC export.",
            show_default=False,
        ),
    ],
    "duration": Annotated[
        str | None,
        typer.Option("--for", metavar="TIME", help="Machine time to run for, such as '10 s' or '250 ms'."),
    ],
    "scans": Annotated[
        int | None, typer.Option("--scans", metavar="N", help="Number of scans to run, instead.")
    ],
    "realtime": Annotated[
        bool, typer.Option("--realtime", help="Run in real time; until Ctrl-C without --for and run_for_s.")
    ],
    "spin": Annotated[
        bool,
        typer.Option(
            "--spin",
            help="With --realtime: wait the last tenth of a period, 0.2 ms at most, without sleeping.",
        ),
    ],
    "record": Annotated[
        Path | None, typer.Option("--record", metavar="TRACE", help="Trace file.", show_default=False)
    ],
    "no_record": Annotated[bool, typer.Option("--no-record", help="Record nothing.")],
    "replace": ReplaceOption,
    "live": Annotated[
        bool,
        typer.Option(
            "--live", help="Real ports in the rack file may move real motors. This is not a safety system."
        ),
    ],
    "retain": Annotated[
        Path | None,
        typer.Option(
            "--retain",
            metavar="FILE",
            help="Begin with the ladder tags in this file, if there is one, and write them to it at the end.",
        ),
    ],
    "forces": ForcesOption,
    "keep_values": KeepValuesOption,
    "memory": MemoryOption,
    "tag": Annotated[
        list[str] | None,
        typer.Option(
            "--tag",
            metavar="PATTERN",
            help="Record tags of the program beside those that the rack file names; '*' is all.",
            show_default=False,
        ),
    ],
    "server": ServerOption,
    "ua_security": UaSecurityOption,
    "ua_users": UaUsersOption,
    "as_json": JsonOption,
    "quiet": Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")],
}
"""What typer has to know of the arguments, by their names."""

_HELP = f"""Run a rack and record every scan: its logic, its modules and its machine.

Time is virtual and does not wait, unless --realtime says so. In real time the scans run under
SCHED_FIFO and in locked memory where the system lets them; the first lines say whether it does, and
the summary how late scans began. A run takes as long as --for or
--scans says, or run_for_s in the rack file, or {DEFAULT_RUN} of machine time. The trace goes where
--record or the rack file says, or into the current folder, named after the rack file.

Exit status: 0 done, 1 the controller faulted (program exception or watchdog timeout), 2 a file or
option can't be used, 3 the trace can't be written or a server never began, 130 stopped by Ctrl-C.
In every case the trace is readable up to that point."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("run", help=_HELP, no_args_is_help=True)(grouped(run_command, DECLARED, options=RunArguments))
