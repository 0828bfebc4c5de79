"""`scanrack run RACK`, parsed with typer."""

from __future__ import annotations

import typer
from scanrack.io_images.times import DEFAULT_RUN
from scanrack.terminal.grouped import grouped

from .run_command import RunArguments, run_command

_HELP = f"""Run a rack and record every scan: its logic, its modules and its machine.

Time is virtual, and scans do not wait for the wall clock, unless with --realtime. In real time the scans run
under SCHED_FIFO and in locked memory, if the system allows it; the first lines report this, and the summary
reports late scans. The length of a run is --for, --scans, run_for_s in the rack file, or {DEFAULT_RUN} of
machine time. The trace file is --record, or the trace of the rack file, or in the current folder a file named
after the rack file.

Examples:
    scanrack new feeder --from feeder
    scanrack run feeder/feeder.toml --for "5 s"
    scanrack run feeder/feeder.toml --scans 500 --tag "Home*"

Exit status: 0 done, 1 the controller faulted (program exception or watchdog timeout), 2 a file or
option can't be used, 3 the trace can't be written or a server has not started, 130 stopped by Ctrl-C.
The trace is always readable up to the end of the run."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("run", help=_HELP, no_args_is_help=True)(grouped(run_command, options=RunArguments))
