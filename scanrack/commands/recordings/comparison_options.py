"""The options of `scanrack compare` and `scanrack replay`, without the imports of the commands."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from scanrack.jobs.replay.targets import ReplayTarget, Stimuli
from scanrack.terminal.as_json import JsonOption
from scanrack.terminal.shared_options import QuietOption, ReplaceOption, TraceArgument, TrustOption

ToleranceTimeOption = Annotated[
    str,
    typer.Option("--tolerance-time", metavar="TIME", help="Allowed difference in time, such as 4ms."),
]
ToleranceCountsOption = Annotated[
    int,
    typer.Option(
        "--tolerance-counts",
        min=0,
        metavar="N",
        help="Allowed difference of position, encoder and captured.",
    ),
]


@dataclass(frozen=True, slots=True, kw_only=True)
class CompareOptions:
    """The arguments and the options of `scanrack compare`."""

    a: Annotated[Path, typer.Argument(metavar="A", help="Trace, an MCAP file.", show_default=False)]
    b: Annotated[Path, typer.Argument(metavar="B", help="Another trace.", show_default=False)]
    tolerance_time: ToleranceTimeOption = "0s"
    tolerance_counts: ToleranceCountsOption = 0
    align_at: Annotated[
        str | None,
        typer.Option(
            "--align",
            metavar="start|SIGNAL",
            help="Align the first scans, or the first rise of a bit.",
            show_default="power-up",
        ),
    ] = None
    realign_at: Annotated[
        str | None,
        typer.Option(
            "--realign",
            metavar="SIGNAL",
            help="Align the traces at every rise of this bit, so that delays do not add up.",
            show_default="no",
        ),
    ] = None
    as_json: JsonOption = False
    quiet: QuietOption = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions:
    """The argument and the options of `scanrack replay`."""

    path: TraceArgument
    into: Annotated[
        ReplayTarget,
        typer.Option(
            "--into",
            metavar="module|program|rack|session",
            help="Replay outputs into the modules, inputs into the program, stimuli into the rack, or the "
            "session with operator actions and edits.",
        ),
    ] = ReplayTarget.MODULE
    slot: Annotated[
        int | None, typer.Option("--slot", metavar="N", help="Compare only this slot.", show_default="all")
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
            help="Stimuli of the machine: the rack file's timeline and stations, the recorded stimuli, or "
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
        Path | None, typer.Option("--record", metavar="TRACE", help="Trace file of the replay.")
    ] = None
    replace: ReplaceOption = False
    trust: TrustOption = False
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
