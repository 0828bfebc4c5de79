"""`scanrack why RACK|TRACE [WHAT]` and `scanrack xref FILE [TAG]`: questions about a program."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from ...jobs.bench import Bench, NotReachedError
from ...jobs.bench.moment import ScanChoice
from ...jobs.bench.of_trace import why_of_trace
from ...jobs.bench.opening import open_bench
from ...jobs.load.loading import recording_of, runs
from ...ladder import LadderError
from ...ladder.debug import CauseLink, Remedies, cross_reference
from ...ladder.debug.crossref import Mention
from ...ladder.model.resolver import AddressError
from ...runtime.loop.faults import CpuFault
from ...terminal.as_json import JsonOption, say_json
from ...terminal.status import BAD_INPUT, NO, complain, reason
from ...terminal.terminal import say
from ...terminal.trace_options import tell_notes
from ...traces.read.image_text import short_seconds
from ...traces.read.reader import open_trace
from .ladder import load_rungs


def _run(bench: Bench, moment: ScanChoice) -> None:
    """Run a bench to the scan of the question.

    Raises:
        ValueError: a time or a tag can't be used.
        NotReachedError: the bit does not become true.
    """
    own = f"{bench.spec.run_for_s or 10:f} s"
    if moment.until is not None:
        bench.run_until(moment.until, within=own)
    else:
        scans = moment.scans_from_power_up(bench.cpu.period_ns)
        bench.scan(scans or ScanChoice(own).scans_from_power_up(bench.cpu.period_ns) or 1)


def _why_command(
    file: Annotated[
        str, typer.Argument(metavar="RACK|TRACE", help="A rack file, or a trace of a run, or of a scenario.")
    ],
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]",
            help="A tag (Run, Fill.DN), a bit or word of an image (slot1.command.HOLD_MOVE, O:1.2), or a "
            "value of a Python program (line.step). Left out: what every module waits for.",
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="TIME|SCAN", help="Ask at this time, such as '1.5 s', or in this scan."),
    ] = None,
    scans: Annotated[int | None, typer.Option("--scans", min=1, help="Ask after so many scans.")] = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="BIT", help="Ask when this tag or bit of an image is on.")
    ] = None,
    deep: Annotated[
        bool, typer.Option("--deep", help="Show the rungs inside of add-on instructions in the chain, too.")
    ] = False,
    want: Annotated[
        str | None,
        typer.Option(
            "--want",
            metavar="VALUE",
            help="Say which inputs would give the tag this value (on, off or a number) within ten scans.",
        ),
    ] = None,
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Say why something is as it is: since which scan, by which rung or line, and what that had read.

    A chain of causes follows, back to the first input, operator, incident or power-up: `A <- B` means that B
    made A, `and` that all were needed, `or` that each would have done.

    A rack runs from power-up to the scan asked for, or for as long as its file says. The program of a
    trace runs on the recorded inputs; Python that came with the trace is run only if it is the same as in
    the current folder, or you say --trust. A Python program then runs once more, and the scan in which the
    change was made is traced line by line.

    Examples: scanrack why examples/feeder/feeder.toml Feeding --at "8.2 s";
    scanrack why examples/feeder/feeder.toml Feeding --at "8.2 s" --want on;
    scanrack why examples/three_stations/line.toml --at 3400

    Exit status: 0 answered, 1 --until has not become true, 2 a file or an option can't be used.
    """
    try:
        moment = ScanChoice(at, scans, until)
        if runs(file):
            asked = _ask_bench(open_bench(file, watched=True), what, moment, deep, want)
        else:
            asked = _ask_trace(Path(recording_of(file)), what, moment, trust=trust, deep=deep, want=want)
    except NotReachedError as error:
        raise typer.Exit(complain(str(error), NO)) from error
    except (LadderError, ValueError) as error:
        raise _refused(error) from error
    except OSError as error:
        raise typer.Exit(complain(f"{file}: {reason(error)}", BAD_INPUT)) from error
    if as_json:
        say_json({"what": what, **_as_json(asked)})
    else:
        gap = "\n" if what is None else " "  # about the whole rack, its scan has a line of its own
        say(f"{asked.when}{gap}{asked.text}")
        if asked.chain is not None:
            say(f"chain: {asked.chain}")
        if asked.remedies is not None:
            say(str(asked.remedies))


class _Answer(NamedTuple):
    """An answer."""

    scan: int
    now_ns: int
    fault: str | None  # the earlier fault of the CPU, or None
    notes: Sequence[str]  # omissions, a sentence each
    when: str  # the scan and its time, in words
    text: str
    chain: CauseLink | None = None  # of causes
    remedies: Remedies | None = None  # what it would take


def _as_json(asked: _Answer) -> dict[str, object]:
    fields = {name: each for name, each in asked._asdict().items() if name not in ("chain", "remedies")}
    if asked.chain is not None:
        fields |= {"since": asked.chain.since, "chain": asked.chain.as_json()}
    if asked.remedies is not None:
        fields["takes"] = asked.remedies.as_json()
    return fields


def _ask_bench(bench: Bench, what: str | None, moment: ScanChoice, deep: bool, want: str | None) -> _Answer:
    bench.check(*(each for each in (what, moment.until) if each is not None))
    fault = None
    try:
        _run(bench, moment)
    except CpuFault as error:
        fault = str(error)
        say(f"the CPU has faulted in {error}", err=True)
    when = f"after {bench.scans:,} scans, {short_seconds(bench.now_ns)} s:"
    chain = None if what is None else bench.chain(what, deep=deep)
    remedies = None if what is None or want is None else bench.what_would(what, want)
    return _Answer(bench.scans - 1, bench.now_ns, fault, (), when, bench.why(what), chain, remedies)


def _ask_trace(
    path: Path, what: str | None, moment: ScanChoice, *, trust: bool, deep: bool, want: str | None
) -> _Answer:
    with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
        tell_notes(trace)
        asked = why_of_trace(trace, Path(folder), what, moment, trust=trust, deep=deep, want=want)
    for note in asked.notes:
        say(f"note: {note}", err=True)
    when = f"scan {asked.scan:,}, {short_seconds(asked.now_ns)} s:"
    return _Answer(asked.scan, asked.now_ns, None, asked.notes, when, asked.text, asked.chain, asked.remedies)


def _xref_command(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A .rung or .st file, a Python program, or a rack file.")
    ],
    tag: Annotated[
        str | None, typer.Argument(metavar="[TAG]", help="Only this tag and what it is a part of.")
    ] = None,
    as_json: JsonOption = False,
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
    if tag is None:
        mentions = tuple(sorted(mentions, key=lambda mention: mention.text.upper()))
    if as_json:
        say_json({"tag": tag, "mentions": [_mention(each) for each in mentions]})
    for each in () if as_json else mentions:
        site = each.site
        say(f"{each.text:<28} {each.way:<14} {site.routine}, {site.place}: {site.instruction}")
    if not mentions:
        say(f"nothing in the program mentions {tag}", err=True)
        raise typer.Exit(NO)


def _mention(each: Mention) -> dict[str, object]:
    """Return a mention for --json; `number` is that of the rung or line."""
    site = each.site
    where = {"program": site.program, "routine": site.routine, "unit": site.unit, "number": site.rung}
    return {"tag": each.text, "reads": each.reads, "writes": each.writes, **where, "text": site.instruction}


def _refused(error: Exception) -> typer.Exit:
    """Report the mistake and its remedy; return the end of the command."""
    remedy = f"; {error.remedy}" if isinstance(error, AddressError) else ""
    return typer.Exit(complain(f"{error}{remedy}", BAD_INPUT))


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command("why", no_args_is_help=True)(_why_command)
    app.command("xref", no_args_is_help=True)(_xref_command)
