"""`scanrack plot TRACE`: a timing chart as a page that zooms, or as a PNG or SVG picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...traces.plot import Envelope, read_chart, save_figure, save_page
from ...traces.reader import open_trace
from .complaints import reported_mistakes
from .terminal import say
from .trace_options import (
    QuietOption,
    ScansOption,
    TimeOption,
    check_target,
    reading,
    selection,
    tell_notes,
    writing,
)

_PICTURES = (".png", ".svg")
_PAGES = (".html", ".htm")


def _plot_command(
    trace: Annotated[Path, typer.Argument(help="The trace to draw, an MCAP file.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="OUT",
            help="Where to: .html, .png or .svg.",
            show_default="beside the trace, as .html",
        ),
    ] = None,
    slot: Annotated[
        list[int] | None,
        typer.Option("--slot", metavar="N", help="Only this slot; may be repeated.", show_default="all"),
    ] = None,
    title: Annotated[
        str | None, typer.Option("--title", help="What to write above it.", show_default="the rack's name")
    ] = None,
    scans: ScansOption = None,
    time: TimeOption = None,
    quiet: QuietOption = False,
) -> None:
    """Draw a timing chart: position, speed, ramp state, and the command and status bits that change.

    An HTML page needs nothing but a browser, holds every scan and zooms with the wheel; .png and .svg
    need matplotlib: pip install 'scanrack[plot]'.

    Example: scanrack plot run.mcap --out run.png --time 1.5s:3s

    Exit status: 0 done, 2 the trace or an option can't be used, 3 the file can't be written.
    """
    with reported_mistakes():
        wanted = selection(scans, time)
        target = trace.with_suffix(".html") if out is None else out
        kind = target.suffix.lower()
        if kind not in _PICTURES + _PAGES:
            allowed = ", ".join(_PICTURES + _PAGES)
            raise ValueError(f"{target}: the file's suffix says what to draw: {allowed}")
        check_target(target, trace)
        with open_trace(trace) as opened, reading(opened, wanted, quiet=quiet) as progress, writing(target):
            if kind in _PAGES:
                save_page(opened, target, wanted, slots=slot or (), title=title, progress=progress)
            else:
                chart = read_chart(opened, Envelope, wanted, slots=slot or (), title=title, progress=progress)
                save_figure(chart, target)
        if not quiet:
            say(f"{target}: {target.stat().st_size:,} bytes")
        tell_notes(opened)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("plot", no_args_is_help=True)(_plot_command)
