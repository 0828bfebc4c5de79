"""`scanrack repair TRACE`: completes a damaged trace, or one whose recording was killed."""

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


def print_repair(found: Repair, trace: Path, target: Path) -> None:
    """Print the result of a repair."""
    if not found.needed:
        say(f"{trace}: {_size(found)}, nothing to repair")
        return
    print_notes(found)
    if found.original is not None:
        say(f"note: the original is kept as {found.original.name}", err=True)
    say(f"{target}: repaired, {_size(found)}, {size_of(target)}")


def _size(found: Repair) -> str:
    return f"{found.messages:,} messages of a line" if found.scans is None else f"{found.scans:,} scans"


def _repair_command(
    trace: TraceArgument,
    output: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="OUT", help="Where to.", show_default="in place of the trace"),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Recover a damaged trace, or one whose process was killed, so that every MCAP tool opens it.

    Traces of serial lines, as `serve --record` writes them, too.

    All whole chunks stay as they are. The repaired trace is written beside the original and takes its
    place when it is on the disk. The original stays as TRACE.orig unless the repaired trace begins with all
    of it but a torn end.

    Example: scanrack repair run.mcap

    Exit status: 0 it is whole now, or was; 1 it is whole now, but damaged chunks are left out; 2 it can't
    be used; 3 the repaired trace can't be written.
    """
    with reported_mistakes():
        if output is not None:
            check_output(output, TRACE, itself(trace))
        columns = (TextColumn("bytes"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
        is_hidden = quiet or not trace.is_file()
        with shown_bar(*columns, quiet=is_hidden, total=lambda: trace.stat().st_size) as update:
            found = repair(trace, output, progress=lambda size: update(advance=size))
    if not quiet:
        print_repair(found, trace, trace if output is None else output)
    raise typer.Exit(NO if found.damaged else DONE)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("repair", no_args_is_help=True)(_repair_command)
