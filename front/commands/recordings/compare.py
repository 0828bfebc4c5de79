"""`scanrack compare A B`: the first scan in which two traces differ, and how they differ altogether."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from ...runtime.config.quantities import parse_time
from ...terminal.as_json import JsonOption, say_json
from ...terminal.complaints import reported_mistakes
from ...terminal.status import DONE, NO
from ...terminal.terminal import on_a_line, say
from ...terminal.trace_options import QuietOption, reading, tell_notes
from ...traces.compare import SAME_CLOCK, Comparison, TimeMap, Tolerance, align, compare, realign, report
from ...traces.read.reader import Trace, open_trace

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


def tolerance(time: str, counts: int) -> Tolerance:
    """Return the tolerance of the options.

    >>> tolerance("4 ms", 2)
    Tolerance(time_ns=4000000, counts=2)

    Raises:
        ValueError: `time` is not a time.
    """
    return Tolerance(parse_time(time), counts)


def tell(found: Comparison, names: tuple[str, str], *, as_json: bool) -> int:
    """Print a comparison; return the exit status."""
    if as_json:
        say_json({"same": found.same, "names": names, **asdict(found)})
    else:
        say("\n".join(map(on_a_line, report(found, names))))
    return DONE if found.same else NO


def names_of(a: Path, b: Path) -> tuple[str, str]:
    """Return the names of two traces: file names if these differ, else paths.

    >>> names_of(Path("old/line.mcap"), Path("new.mcap")), names_of(Path("a/x.mcap"), Path("b/x.mcap"))
    (('line.mcap', 'new.mcap'), ('a/x.mcap', 'b/x.mcap'))
    """
    return (a.name, b.name) if a.name != b.name else (str(a), str(b))


def _compare_command(
    a: Annotated[Path, typer.Argument(help="A trace, an MCAP file.", show_default=False)],
    b: Annotated[Path, typer.Argument(help="Another one.", show_default=False)],
    tolerance_time: ToleranceTimeOption = "0s",
    tolerance_counts: ToleranceCountsOption = 0,
    align_at: Annotated[
        str | None,
        typer.Option(
            "--align",
            metavar="start|SIGNAL",
            help="What is at the same time in both: their first scans, or the first rise of a bit.",
            show_default="power-up",
        ),
    ] = None,
    realign_at: Annotated[
        str | None,
        typer.Option(
            "--realign",
            metavar="SIGNAL",
            help="Every rise of this bit is at the same time in both: what comes late does not add up.",
            show_default="no",
        ),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Compare two traces: the first scan that differs, what led to it, and how they differ altogether.

    Scans are paired by number, and every bit and time counts. With a tolerance, as for traces of real
    hardware, they are paired by time: a bit or word has to be found in the other trace within the time,
    a position may be off by the counts beside what it moves within the time.

    Exit status: 0 they show the same, 1 they differ, 2 a file or option can't be used.

    Example: scanrack compare simulated.mcap machine.mcap --tolerance-time 4ms --tolerance-counts 2
    """
    with reported_mistakes():
        allowed = tolerance(tolerance_time, tolerance_counts)
        with open_trace(a) as one, open_trace(b) as other:
            clock = _clock(one, other, align_at, realign_at)
            with reading(one, quiet=quiet) as progress:
                found = compare(one, other, allowed, clock=clock, progress=progress)
            tell_notes(one, other)
        status = tell(found, names_of(a, b), as_json=as_json)
    raise typer.Exit(status)


def _clock(one: Trace, other: Trace, align_at: str | None, realign_at: str | None) -> TimeMap:
    if align_at is not None and realign_at is not None:
        raise ValueError("--align and --realign contradict each other: give one of them")
    if realign_at is not None:
        return realign(one, other, realign_at)
    return SAME_CLOCK if align_at is None else align(one, other, align_at)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("compare", no_args_is_help=True)(_compare_command)
