"""`scanrack rerun TRACE`: repeat the run of a trace, and compare."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ...terminal.as_json import JsonOption
from ...terminal.grouped import grouped
from ...terminal.trace_options import QuietOption, ReplaceOption


@dataclass(frozen=True, slots=True, kw_only=True)
class RerunOptions:
    """The argument and the options of `scanrack rerun`."""

    path: Annotated[Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)]
    record: Annotated[
        Path | None,
        typer.Option("--record", help="Keep the trace of the rerun there.", show_default=False),
    ] = None
    replace: ReplaceOption = False
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False
    as_json: JsonOption = False
    quiet: QuietOption = False


def _rerun_command(options: RerunOptions) -> None:
    """Run a recorded session again and check for differences: same rack file, program and number of scans.

    The orders of a session of scanrack watch are given again before the same scans, edits of its program
    among them.

    Python that came with the trace is run only if it is the same as in the current folder, or you say
    --trust: a program may do anything that you may.

    Exit status: 0 the same, 1 something differs, 2 a file or option can't be used.
    """
    from .rerun_job import rerun_trace

    rerun_trace(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("rerun", no_args_is_help=True)(grouped(_rerun_command, options=RerunOptions))
