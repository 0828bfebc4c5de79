"""`scanrack why RACK TAG` and `scanrack xref FILE [TAG]`: questions about a ladder program."""

from __future__ import annotations

from typing import Annotated

import typer

from ...ladder import LadderError
from ...ladder.debug import cross_reference
from ...ladder.resolver import AddressError
from ..app.bench import Bench, NotReachedError
from ..app.bench.opening import open_bench
from ..config.quantities import parse_duration
from ..loop.faults import CpuFault
from .ladder import load_rungs
from .status import BAD_INPUT, NO, complain
from .terminal import say


def _run(bench: Bench, at: str | None, scans: int | None, until: str | None) -> None:
    """Run a bench to where the question is asked.

    Raises:
        ValueError: several of the options are given, or one of them can't be used.
        NotReachedError: `until` does not come about.
    """
    given = [
        name for name, value in (("--at", at), ("--scans", scans), ("--until", until)) if value is not None
    ]
    if len(given) > 1:
        raise ValueError(f"{' and '.join(given)} say the same thing: give one of them")
    if until is not None:
        bench.run_until(until, within=f"{bench.spec.run_for_s or 10:f} s")
    elif scans is not None:
        bench.scan(scans)
    else:
        time = at if at is not None else f"{bench.spec.run_for_s or 10:f} s"
        # the scan at that very time is one of them
        bench.scan(parse_duration(time) // bench.cpu.period_ns + 1)


def _why_command(
    rack: Annotated[str, typer.Argument(metavar="RACK", help="Rack file with a ladder program.")],
    tag: Annotated[str, typer.Argument(metavar="TAG", help="A tag: Run, Fill.DN, axis.command.HOLD_MOVE.")],
    at: Annotated[
        str | None, typer.Option("--at", metavar="TIME", help="Ask at this time, such as '1.5 s'.")
    ] = None,
    scans: Annotated[int | None, typer.Option("--scans", min=1, help="Ask after so many scans.")] = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="TAG", help="Ask when this bit is on.")
    ] = None,
) -> None:
    """Say why a tag is as it is: the scan and the rung that last changed it, and what was false there.

    The rack is run from power-up to the time asked for, or for as long as its file says.

    Example: scanrack why examples/feeder/feeder.toml Feeding --at "8.2 s"

    Exit status: 0 answered, 1 --until has not come about, 2 a file or an option can't be used.
    """
    try:
        bench = open_bench(rack, watched=True)
        _ = bench[tag]  # refuse an unknown tag before the run
        try:
            _run(bench, at, scans, until)
        except CpuFault as error:
            say(f"the CPU has faulted in {error}", err=True)
        say(f"after {bench.scans:,} scans, {bench.now_s:g} s: {bench.why(tag)}")
    except NotReachedError as error:
        raise typer.Exit(complain(str(error), NO)) from error
    except (LadderError, ValueError) as error:
        raise _refused(error) from error


def _xref_command(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A .rung or .st file, a Python program, or a rack file.")
    ],
    tag: Annotated[
        str | None, typer.Argument(metavar="[TAG]", help="Only this tag and what it is a part of.")
    ] = None,
) -> None:
    """List where the tags of a ladder program are read and written.

    Example: scanrack xref examples/feeder/feeder.rung Homing

    Exit status: 0 listed, 1 nothing mentions the tag, 2 the file can't be used or has no such tag.
    """
    try:
        found = cross_reference(load_rungs(file).build())
        mentions = found.mentions if tag is None else found.of(tag)
    except (LadderError, ValueError, OSError) as error:
        raise _refused(error) from error
    for each in sorted(mentions, key=lambda mention: mention.text.upper()) if tag is None else mentions:
        site = each.site
        say(f"{each.text:<28} {each.way:<14} {site.routine}, {site.place}: {site.instruction}")
    if not mentions:
        say(f"nothing in the program mentions {tag}", err=True)
        raise typer.Exit(NO)


def _refused(error: Exception) -> typer.Exit:
    """Report what is wrong, and what helps; return the end of the command."""
    remedy = f"; {error.remedy}" if isinstance(error, AddressError) else ""
    return typer.Exit(complain(f"{error}{remedy}", BAD_INPUT))


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command("why", no_args_is_help=True)(_why_command)
    app.command("xref", no_args_is_help=True)(_xref_command)
