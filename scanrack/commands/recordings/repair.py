"""`scanrack repair TRACE`: completes a trace whose recording was killed, or that is damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import itself
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.status import DONE, NO, size_of
from scanrack.terminal.terminal import say
from scanrack.traces.files.guard import TRACE, check_output
from scanrack.traces.repair import Repair, repair


def tell(found: Repair, trace: Path, target: Path) -> None:
    """Print the result of a repair."""
    if not found.needed:
        say(f"{trace}: {_size(found)}, nothing to repair")
        return
    for note in found.notes:
        say(f"note: {note}", err=True)
    if found.original is not None:
        say(f"note: the original is kept as {found.original.name}", err=True)
    say(f"{target}: repaired, {_size(found)}, {size_of(target)}")


def _size(found: Repair) -> str:
    return f"{found.messages:,} messages of a line" if found.scans is None else f"{found.scans:,} scans"


@contextmanager
def _bar(trace: Path, *, quiet: bool) -> Iterator[Callable[[int], None]]:
    console = Console(stderr=True)
    if quiet or not console.is_terminal or not trace.is_file():
        yield lambda size: None
        return
    columns = (TextColumn("bytes"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("bytes", total=trace.stat().st_size)
        yield lambda size: bar.advance(task, size)


def _repair_command(
    trace: Annotated[Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)],
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
        with _bar(trace, quiet=quiet) as progress:
            found = repair(trace, output, progress=progress)
    if not quiet:
        tell(found, trace, trace if output is None else output)
    raise typer.Exit(NO if found.damaged else DONE)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("repair", no_args_is_help=True)(_repair_command)
