"""`scanrack compare A B`: the first scan in which two traces differ, and how they differ altogether."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ...terminal.as_json import JsonOption
from ...terminal.grouped import grouped
from ...terminal.trace_options import QuietOption

ToleranceTimeOption = Annotated[
    str,
    typer.Option(
        "--tolerance-time", metavar="TIME", help="By how much anything may come earlier or later: 4ms."
    ),
]
ToleranceCountsOption = Annotated[
    int,
    typer.Option(
        "--tolerance-counts",
        min=0,
        metavar="N",
        help="By how much position, encoder and captured may differ.",
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
            help="What is at the same time in both: their first scans, or the first rise of a bit.",
            show_default="power-up",
        ),
    ] = None
    realign_at: Annotated[
        str | None,
        typer.Option(
            "--realign",
            metavar="SIGNAL",
            help="Every rise of this bit is at the same time in both: what comes late does not add up.",
            show_default="no",
        ),
    ] = None
    as_json: JsonOption = False
    quiet: QuietOption = False


def _compare_command(options: CompareOptions) -> None:
    """Find where two traces differ: the first scan, what led to it, and a summary of all differences.

    Scans are paired by number, and every bit and time counts. With a tolerance, as for traces of real
    hardware, they are paired by time: a bit or word has to be found in the other trace within the time,
    a position may be off by the counts beside what it moves within the time.

    Exit status: 0 they show the same, 1 they differ, 2 a file or option can't be used.

    Example: scanrack compare simulated.mcap machine.mcap --tolerance-time 4ms --tolerance-counts 2
    """
    from .compare_job import compare_traces

    compare_traces(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("compare", no_args_is_help=True)(grouped(_compare_command, options=CompareOptions))
