"""`scanrack plot TRACE`: draw a timing chart as a zoomable HTML page, or as a PNG or SVG picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import itself, print_notes, reading
from scanrack.terminal.shared_options import QuietOption, RangeOption, TraceArgument, selection
from scanrack.terminal.status import size_of
from scanrack.terminal.terminal import say
from scanrack.traces.files.guard import PAGE, PNG, SVG, check_output
from scanrack.traces.plot import Envelope, read_chart, save_figure, save_page
from scanrack.traces.read.reader import open_trace

_KINDS = {".png": PNG, ".svg": SVG, ".html": PAGE, ".htm": PAGE}
"""Format of a chart, by file suffix."""


def _plot_command(
    trace: TraceArgument,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="OUT",
            help="Output file: .html, .png or .svg.",
            show_default="beside the trace, as .html",
        ),
    ] = None,
    slot: Annotated[
        list[int] | None,
        typer.Option("--slot", metavar="N", help="Only this slot; may be repeated.", show_default="all"),
    ] = None,
    tag: Annotated[
        list[str] | None,
        typer.Option(
            "--tag",
            metavar="PATTERN",
            help="Only recorded tags that match, such as 'Dwell.*'; may be repeated.",
            show_default="as many as there is room for; none with --slot",
        ),
    ] = None,
    title: Annotated[
        str | None,
        typer.Option("--title", metavar="TEXT", help="Title of the chart.", show_default="the rack's name"),
    ] = None,
    ranges: RangeOption = None,
    quiet: QuietOption = False,
) -> None:
    """Draw a timing chart: position, speed, ramp state, the bits that change, and recorded tags.

    An HTML page needs only a browser, has every scan, and zooms with the wheel; .png and .svg need the extra
    `plot`; `scanrack doctor` prints how to install it.

    Examples:
        scanrack plot run.mcap --out run.png --range 1.5s:3s

    Exit status: 0 done, 2 the trace or an option can't be used, 3 the file can't be written.
    """
    with reported_mistakes():
        selected = selection(ranges)
        target = trace.with_suffix(".html") if out is None else out
        kind = target.suffix.lower()
        if kind not in _KINDS:
            suffixes = ", ".join(_KINDS)
            raise ValueError(f"{target}: the suffix must be {suffixes}")
        check_output(target, _KINDS[kind], itself(trace))
        with open_trace(trace) as opened, reading(opened, selected, quiet=quiet) as progress:
            chart_options: Any = {
                "slots": slot or (),
                "tags": tag or (),
                "title": title,
                "progress": progress,
            }
            if _KINDS[kind] is PAGE:
                left_out = save_page(opened, target, selected, **chart_options).left_out
            else:
                chart = read_chart(opened, Envelope, selected, **chart_options)
                save_figure(chart, target)
                left_out = chart.left_out
        if not quiet:
            say(f"{target}: {size_of(target)}")
            if left_out:
                tags_are = "tag is" if left_out == 1 else "tags are"
                say(f"{left_out:,} recorded {tags_are} not drawn; choose with --tag", err=True)
        print_notes(opened)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("plot", no_args_is_help=True)(_plot_command)
