"""The options of `scanrack compare`; `replay` has some of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from ...terminal.as_json import JsonOption
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
