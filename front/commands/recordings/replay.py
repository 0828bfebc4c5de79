"""`scanrack replay TRACE`: play a recording to a module, a program or a rack, and compare the answer."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ...jobs.replay.targets import ReplayTarget, Stimuli
from ...terminal.as_json import JsonOption
from ...terminal.grouped import grouped
from ...terminal.trace_options import QuietOption
from .compare import ToleranceCountsOption, ToleranceTimeOption


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions:
    """The argument and the options of `scanrack replay`."""

    path: Annotated[Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)]
    into: Annotated[
        ReplayTarget,
        typer.Option(
            "--into",
            help="Recorded outputs into the modules, recorded inputs into the program, or recorded stimuli "
            "into the whole rack.",
        ),
    ] = ReplayTarget.MODULE
    slot: Annotated[
        int | None, typer.Option("--slot", metavar="N", help="Compare this slot only.", show_default="all")
    ] = None
    rack: Annotated[
        str | None,
        typer.Option("--rack", metavar="RACK", help="Another rack file.", show_default="the trace's"),
    ] = None
    program: Annotated[
        str | None,
        typer.Option("--program", metavar="FILE", help="Another program.", show_default="the trace's"),
    ] = None
    stimuli: Annotated[
        Stimuli | None,
        typer.Option(
            "--stimuli",
            help="What acts on the machine: the rack file's timeline and stations, the recorded stimuli, or "
            "the recorded levels of the inputs.",
            show_default="machine; recorded, into a rack",
        ),
    ] = None
    tolerance_time: ToleranceTimeOption = "0s"
    tolerance_counts: ToleranceCountsOption = 0
    to_the_end: Annotated[
        bool, typer.Option("--to-the-end", help="Continue after the first scan that differs.")
    ] = False
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False
    as_json: JsonOption = False
    quiet: QuietOption = False


def _replay_command(options: ReplayOptions) -> None:
    """Replay and check for differences; stop at the first scan whose response differs.

    Rack and program are those that came with the trace, or what --rack and --program say: so a changed
    program is checked against an old trace. With a tolerance the whole trace is replayed and
    compared by time, see scanrack compare.

    Exit status: 0 the same, 1 something differs, 2 a file or option can't be used, 130 stopped by Ctrl-C.

    Example: scanrack replay line.mcap --into program --program new.rung
    """
    from .replay_job import replay_trace

    replay_trace(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("replay", no_args_is_help=True)(grouped(_replay_command, options=ReplayOptions))
