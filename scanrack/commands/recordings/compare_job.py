"""Comparison of two traces: report and exit status."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import typer
from scanrack.io_images.times import parse_time
from scanrack.terminal.as_json import say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import print_notes, reading
from scanrack.terminal.status import DONE, NO
from scanrack.terminal.terminal import on_a_line, say
from scanrack.traces.compare import (
    SAME_CLOCK,
    Comparison,
    TimeMap,
    Tolerance,
    align,
    compare,
    realign,
    report,
)
from scanrack.traces.read.reader import Trace, open_trace

from .comparison_options import CompareOptions


def tolerance(time: str, counts: int) -> Tolerance:
    """Return the tolerance that the options specify.

    >>> tolerance("4 ms", 2)
    Tolerance(time_ns=4000000, counts=2)

    Raises:
        ValueError: `time` is not a time.
    """
    return Tolerance(parse_time(time), counts)


def print_comparison(comparison: Comparison, names: tuple[str, str], *, as_json: bool) -> int:
    """Print a comparison; return the exit status."""
    if as_json:
        say_json({"same": comparison.same, "names": names, **asdict(comparison)})
    else:
        say("\n".join(map(on_a_line, report(comparison, names))))
    return DONE if comparison.same else NO


def names_of(a: Path, b: Path) -> tuple[str, str]:
    """Return the names of two traces: their file names if these differ, otherwise their paths.

    >>> names_of(Path("old/line.mcap"), Path("new.mcap")), names_of(Path("a/x.mcap"), Path("b/x.mcap"))
    (('line.mcap', 'new.mcap'), ('a/x.mcap', 'b/x.mcap'))
    """
    return (a.name, b.name) if a.name != b.name else (str(a), str(b))


def compare_traces(options: CompareOptions) -> None:
    """Find where two traces differ: the first scan, the events before it, and a summary of all differences.

    Raises:
        typer.Exit: with the status of the command, unless it is 0.
    """
    with reported_mistakes():
        tolerances = tolerance(options.tolerance_time, options.tolerance_counts)
        with open_trace(options.a) as trace_a, open_trace(options.b) as trace_b:
            clock = _clock(trace_a, trace_b, options.align_at, options.realign_at)
            with reading(trace_a, quiet=options.quiet) as progress:
                comparison = compare(trace_a, trace_b, tolerances, clock=clock, progress=progress)
            for trace in (trace_a, trace_b):
                trace.check_data()
            print_notes(trace_a, trace_b)
        status = print_comparison(comparison, names_of(options.a, options.b), as_json=options.as_json)
    raise typer.Exit(status)


def _clock(trace_a: Trace, trace_b: Trace, align_at: str | None, realign_at: str | None) -> TimeMap:
    """Return the map from times of trace B to times of trace A that --align or --realign selects."""
    if align_at is not None and realign_at is not None:
        raise ValueError("--align and --realign: give only one of them")
    if realign_at is not None:
        return realign(trace_a, trace_b, realign_at)
    return SAME_CLOCK if align_at is None else align(trace_a, trace_b, align_at)
