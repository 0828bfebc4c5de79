"""Options of `scanrack l5x`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from scanrack.terminal.as_json import JsonOption
from scanrack.terminal.shared_options import KeepValuesOption, MemoryOption


@dataclass(frozen=True)
class L5xOptions:
    """The options of `scanrack l5x`; see its --help."""

    as_json: JsonOption = False
    rack: Annotated[bool, typer.Option("--print-rack", help="Print a rack file for the export.")] = False
    against: Annotated[
        Path | None, typer.Option(metavar="OLDER", help="List the differences from an older version.")
    ] = None
    html: Annotated[
        Path | None,
        typer.Option("--html", metavar="OUT", help="With --against: also write a side-by-side page."),
    ] = None
    text: Annotated[
        bool, typer.Option("--text", help="Print the file as sorted text without dates, for git.")
    ] = False
    export: Annotated[
        str | None,
        typer.Option(metavar="PROGRAM[.ROUTINE]", help="Print this part as an L5X for partial import."),
    ] = None
    stepper: Annotated[
        list[str] | None,
        typer.Option(metavar="MODULE", help="With --print-rack: this module, by name or slot, is a 3601."),
    ] = None
    run: Annotated[bool, typer.Option("--run", help="Run it on a rack, and list its open waits.")] = False
    scans: Annotated[
        int | None,
        typer.Option(
            "--scans", metavar="N", min=1, help="Scans of the trial [default: 100], or of --run [1000]."
        ),
    ] = None
    stand_in: Annotated[
        bool,
        typer.Option("--stand-in", help="Declare tags, members and routines that the L5X uses but lacks."),
    ] = False
    keep_values: KeepValuesOption = False
    memory: MemoryOption = None
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="COPY", help="Write the export, or the part of --export, to this file."
        ),
    ] = None
