"""`scanrack replay TRACE`: play a trace, or repeat its session, and compare."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ...jobs.replay.targets import ReplayTarget, Stimuli
from ...terminal.as_json import JsonOption
from ...terminal.grouped import grouped
from ...terminal.status import BAD_INPUT, complain
from ...terminal.trace_options import QuietOption, ReplaceOption
from .compare import ToleranceCountsOption, ToleranceTimeOption


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions:
    """The argument and the options of `scanrack replay`."""

    path: Annotated[Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)]
    into: Annotated[
        ReplayTarget,
        typer.Option(
            "--into",
            metavar="module|program|rack|session",
            help="Recorded outputs into the modules, recorded inputs into the program, recorded stimuli "
            "into the whole rack; or the whole session again, operator actions and edits included.",
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
            metavar="machine|recorded|inputs",
            help="What acts on the machine: the rack file's timeline and stations, the recorded stimuli, or "
            "the recorded levels of the inputs.",
            show_default="machine; recorded, into a rack; inputs, if the trace begins in operation",
        ),
    ] = None
    tolerance_time: ToleranceTimeOption = "0s"
    tolerance_counts: ToleranceCountsOption = 0
    to_the_end: Annotated[
        bool, typer.Option("--to-the-end", help="Continue after the first scan that differs.")
    ] = False
    record: Annotated[
        Path | None, typer.Option("--record", metavar="TRACE", help="With --into session: trace file.")
    ] = None
    replace: ReplaceOption = False
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False
    configuration: Annotated[
        str | None,
        typer.Option(
            "--configuration",
            metavar="WORDS",
            help="Configuration of a 3601 at the beginning: '843Ch 003Ch 0 500'.",
            show_default="the first in the trace",
        ),
    ] = None
    as_json: JsonOption = False
    quiet: QuietOption = False


def _replay_command(options: ReplayOptions) -> None:
    """Replay and check for differences; stop at the first scan whose response differs.

    Rack and program are those that came with the trace, or what --rack and --program say: so a changed
    program is checked against an old trace. With a tolerance the whole trace is replayed and
    compared by time, see scanrack compare.

    --into session runs the same rack file and program for the same number of scans, and repeats the
    operator actions and edits of a session of scanrack watch before the same scans. Python that came with
    the trace runs only if it is the same as in the current folder, or with --trust.

    A 3601 that was in operation before the trace is taken as an image shows it at rest, and compared from the
    scan after that. Its configuration is the first that the trace shows, or --configuration.

    Exit status: 0 the same, 1 something differs, 2 a file or option can't be used, 130 stopped by Ctrl-C.

    Example: scanrack replay line.mcap --into program --program new.rung
    """
    own = {
        "--slot": options.slot is not None,
        "--rack": options.rack is not None,
        "--program": options.program is not None,
        "--stimuli": options.stimuli is not None,
        "--tolerance-time": options.tolerance_time != "0s",
        "--tolerance-counts": options.tolerance_counts != 0,
        "--to-the-end": options.to_the_end,
    }
    session = {"--record": options.record is not None, "--replace": options.replace}
    of_others = own if options.into is ReplayTarget.SESSION else session
    wrong = next((option for option, given in of_others.items() if given), None)
    if wrong is not None:
        say = f"{wrong} does not go with --into {options.into.value}"
        raise typer.Exit(complain(say, BAD_INPUT))
    if options.into is ReplayTarget.SESSION:
        from .session_job import rerun_trace

        rerun_trace(options)
        return
    from .replay_job import replay_trace

    replay_trace(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("replay", no_args_is_help=True)(grouped(_replay_command, options=ReplayOptions))
