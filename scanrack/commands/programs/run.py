"""`scanrack run RACK` for typer: its page of help."""

from __future__ import annotations

import typer
from scanrack.io_images.times import DEFAULT_RUN
from scanrack.terminal.grouped import grouped

from .run_command import RunArguments, run_command

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
    app.command("run", help=_HELP, no_args_is_help=True)(grouped(run_command, options=RunArguments))
