"""`scanrack export TRACE --csv|--parquet|--vcd|--mcap OUT`: a trace for other programs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, Annotated, Any

import typer

from ...terminal.complaints import reported_mistakes
from ...terminal.terminal import say
from ...terminal.trace_options import (
    QuietOption,
    ScansOption,
    TimeOption,
    itself,
    reading,
    selection,
    tell_notes,
)
from ...traces.export import write_csv, write_mcap, write_parquet, write_vcd
from ...traces.files.guard import CSV, PARQUET, TRACE, VCD, check_output
from ...traces.files.newfile import Target
from ...traces.read.reader import Trace, open_trace
from ...traces.signals import Selection

_TABLES = {"--csv": write_csv, "--parquet": write_parquet, "--vcd": write_vcd}
"""Writers of chosen signals."""

_KINDS = {"--csv": CSV, "--parquet": PARQUET, "--vcd": VCD, "--mcap": TRACE}

STDOUT = Path("-")
"""The file name that means standard output."""

_STREAMS: dict[str, Callable[[], IO[Any]]] = {
    "--csv": lambda: sys.stdout,
    "--parquet": lambda: sys.stdout.buffer,
    "--vcd": lambda: sys.stdout,
    "--mcap": lambda: sys.stdout.buffer,
}


def _export_command(
    trace: Annotated[Path, typer.Argument(help="The trace, an MCAP file.", show_default=False)],
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="OUT", help="Write a CSV file, a row per scan.")
    ] = None,
    parquet: Annotated[
        Path | None, typer.Option("--parquet", metavar="OUT", help="Write a Parquet file, a row per scan.")
    ] = None,
    vcd: Annotated[
        Path | None,
        typer.Option("--vcd", metavar="OUT", help="Write a value change dump, for GTKWave and its like."),
    ] = None,
    mcap: Annotated[
        Path | None,
        typer.Option(
            "--mcap",
            metavar="OUT",
            help="Write a copy with decoded position, speed and bits of each 3601, for any viewer.",
        ),
    ] = None,
    signal: Annotated[
        list[str] | None,
        typer.Option(
            "--signal",
            metavar="PATTERN",
            help="Only signals of this name, such as 'slot1.in.*'; may be repeated.",
            show_default="all bits and values",
        ),
    ] = None,
    scans: ScansOption = None,
    time: TimeOption = None,
    quiet: QuietOption = False,
) -> None:
    """Write a trace in a format that other programs read.

    Example: scanrack export run.mcap --vcd run.vcd --time 1.5s:3s

    OUT is a file, or - for standard output.

    Exit status: 0 done, 2 the trace or an option can't be used, 3 a file can't be written.
    """
    with reported_mistakes():
        wanted = selection(scans, time)
        targets = {"--csv": csv, "--parquet": parquet, "--vcd": vcd, "--mcap": mcap}
        if signal and not any(targets[option] for option in _TABLES):
            raise ValueError("--signal chooses columns; a copy as MCAP has all of the trace")
        if not any(targets.values()):
            raise ValueError(f"nothing to write: give {', '.join(targets)} or several of them")
        if sum(target == STDOUT for target in targets.values()) > 1:
            raise ValueError("only one of them can go to standard output")
        for option, target in targets.items():
            if target not in (None, STDOUT):
                check_output(target, _KINDS[option], itself(trace))
        for option, target in targets.items():
            if target is None:
                continue
            to_stdout = target == STDOUT
            with open_trace(trace) as opened, reading(opened, wanted, quiet=quiet) as progress:
                into = _STREAMS[option]() if to_stdout else target
                count = _write(opened, option, into, signal or (), wanted, progress)
            if not quiet:
                size = "" if to_stdout else f", {target.stat().st_size:,} bytes"
                say(f"{target}: {count:,} scans{size}", err=to_stdout)
            tell_notes(opened)


def _write(
    trace: Trace,
    option: str,
    into: Target,
    signals: Sequence[str],
    wanted: Selection,
    progress: Callable[[int], None],
) -> int:
    """Write a trace in the format of an option; return the number of scans."""
    if option == "--mcap":
        return write_mcap(trace, into, wanted, progress=progress)
    return _TABLES[option](trace, into, signals, wanted, progress=progress)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("export", no_args_is_help=True)(_export_command)
