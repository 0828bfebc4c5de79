"""`scanrack repair TRACE`: recover a damaged trace, or the trace of a killed process."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, DownloadColumn, TextColumn, TimeRemainingColumn
from scanrack.terminal.bars import shown_bar
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import itself, print_notes
from scanrack.terminal.shared_options import QuietOption, TraceArgument
from scanrack.terminal.status import DONE, NO, size_of
from scanrack.terminal.terminal import say
from scanrack.traces.files.guard import TRACE, check_output
from scanrack.traces.repair import Repair, repair


def print_repair(result: Repair, trace: Path, target: Path) -> None:
    """Print the result of a repair."""
    if not result.needed:
        say(f"{trace}: {_size(result)}, nothing to repair")
        return
    print_notes(result)
    if result.original is not None:
        say(f"note: the original is kept as {result.original.name}", err=True)
    say(f"{target}: repaired, {_size(result)}, {size_of(target)}")


def _size(result: Repair) -> str:
    return f"{result.messages:,} messages of a line" if result.scans is None else f"{result.scans:,} scans"


def _repair_command(
    trace: TraceArgument,
    output: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="OUT", help="Output file.", show_default="replaces the trace"),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Recover a damaged trace, or the trace of a killed process, so that any MCAP tool can open it.

    The command also repairs traces of serial lines from `serve --record`.

    Complete chunks are unchanged. The repaired trace is written beside the original, and then replaces it.
    The original is kept as TRACE.orig, unless only its truncated end is missing from the repaired trace.

    Examples:
        scanrack repair run.mcap

    Exit status: 0 the trace is complete; 1 the trace is complete except for damaged chunks; 2 the trace can't
    be used; 3 the repaired trace can't be written.
    """
    with reported_mistakes():
        if output is not None:
            check_output(output, TRACE, itself(trace))
        columns = (TextColumn("bytes"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
        is_hidden = quiet or not trace.is_file()
        with shown_bar(*columns, quiet=is_hidden, total=lambda: trace.stat().st_size) as update:
            result = repair(trace, output, progress=lambda size: update(advance=size))
    if not quiet:
        print_repair(result, trace, trace if output is None else output)
    raise typer.Exit(NO if result.damaged else DONE)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("repair", no_args_is_help=True)(_repair_command)
