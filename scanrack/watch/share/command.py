"""`scanrack share TRACE`: a page of a trace in one file that any browser can open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer
from scanrack.io_images.times import parse_time
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import itself, print_notes
from scanrack.terminal.status import size_of
from scanrack.terminal.terminal import say
from scanrack.traces.files.guard import check_output
from scanrack.traces.files.newfile import new_file
from scanrack.traces.read.reader import Trace

from ..panels.kept_panel import KeptPanel
from ..recorded_session import open_to_read
from .collecting import LATEST_ANSWERS, SharedStretch, collect
from .failure import Failure
from .page_file import SHARED_PAGE, page_of

WHOLE_SCANS = 50_000
"""Maximum number of scans in a trace that is shared completely."""

BEFORE, AFTER = 20_000, 2_000
"""Numbers of scans before and after the scan shown first, for a longer trace."""


class ShareOptions(NamedTuple):
    """The options of a page, of which at most one of scan and time is set."""

    scan: int | None = None  # the scan shown first; None = the last one
    time_ns: int | None = None  # the time shown first
    before: int = BEFORE  # number of scans before the scan shown first
    after: int = AFTER  # number of scans after it
    all_scans: bool = False
    most: int = WHOLE_SCANS  # with more scans, only `before` and `after` are shared
    latest_answers: int = LATEST_ANSWERS  # number of explained tags in addition to `tags`
    latest: bool = False  # whether to use the last scan instead of one that is not in the trace yet
    recording: bool = False  # whether to include the trace
    trust: bool = False  # whether Python in the trace may run
    tags: Sequence[str] = ()  # tags whose values the page explains
    failure: Failure | None = None  # the failed test of the trace, with which the page opens
    report_notes: Callable[[Trace], None] | None = (
        None  # reports the notes of the trace, even if it is refused
    )
    rack: str = ""  # path of the running rack, whose present panel is shown; "" = the panel in the trace

    def within(self, first: int, last: int, period_ns: int) -> SharedStretch:
        """Return the stretch of a trace to share; raise ValueError if the trace lacks the requested scan."""
        scan = last if self.scan is None else self.scan
        if self.time_ns is not None:
            scan = self.time_ns // period_ns
        if self.latest:
            scan = min(scan, last)
        if not first <= scan <= last:
            raise ValueError(f"no scan {scan}: the recording has {first} to {last}")
        if self.all_scans or last - first < self.most:
            return SharedStretch(first, last, scan)
        return SharedStretch(max(first, scan - self.before), min(last, scan + self.after), scan)


def share(trace: Path, output: Path, options: ShareOptions) -> Any:
    """Write the page of a trace; return its data.

    Raises:
        ValueError: the trace or the output can't be used, or the page would be too large.
        OSError: a file can't be read or written.
    """
    check_output(output, SHARED_PAGE, itself(trace))
    data, page = shared(trace, options)
    with new_file(output, SHARED_PAGE, "wb", used=itself(trace)) as file:
        file.write(page)
    return data


def shared(trace: Path, options: ShareOptions) -> tuple[Any, bytes]:
    """Return the data of a trace's page, and the page; see `share`."""
    with ExitStack() as stack:
        monitor = open_to_read(stack, trace, trust=options.trust, report_notes=options.report_notes)
        if options.rack:
            monitor.panel = KeptPanel(options.rack)
        extent = monitor.subject.timeline.extent
        if extent is None:
            raise ValueError(f"{trace}: no scan in it" + (" yet" if options.latest else ""))
        stretch = options.within(*extent, monitor.subject.spec.scan_ns)
        failed, failure = None, options.failure
        if failure is not None:
            earlier = failure.passed
            passed_monitor = None if earlier is None else open_to_read(stack, earlier, trust=options.trust)
            failed = partial(failure.described, stretch, passed_monitor)
        data = collect(monitor, stretch, options.tags, options.latest_answers, failed)
    return data, page_of(data, trace.read_bytes() if options.recording else None)


def disclosed(data: Any, *, recording: bool) -> list[str]:
    """Return sentences about the contents that every recipient of a page can read."""
    first, last = data["range"]
    routines = [routine for program in data["programs"] for routine in program["described"]["routines"]]
    tags = {tag["name"] for program in data["programs"] for tag in program["described"]["tags"]}
    program_text = f"the program with its comments ({_many(len(routines), 'routine')}), " if routines else ""
    lines = [
        f"Everyone who gets it can read {program_text}the words of scans {first:,} to {last:,}, "
        f"{_many(len(tags), 'tag')}, {_many(len(data['events']), 'event')}, "
        f"and explanations of {_many(len(data['whys']), 'value')}."
    ]
    if recording:
        lines.append("The recording is inside, with the files of its rack and program.")
    return lines


def _many(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def _share_command(
    trace: Annotated[Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="OUT", help="Output file.", show_default="beside the trace, as .html"
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            metavar="TIME|SCAN",
            help="Scan to show first, or a time such as '8.2 s'.",
            show_default="the last scan",
        ),
    ] = None,
    before: Annotated[
        int,
        typer.Option("--before", metavar="N", min=0, help="Scans before it, if there are more than 50,000."),
    ] = BEFORE,
    after: Annotated[
        int,
        typer.Option("--after", metavar="N", min=0, help="Scans after it, if there are more than 50,000."),
    ] = AFTER,
    whole: Annotated[bool, typer.Option("--all", help="Share all scans.")] = False,
    recording: Annotated[
        bool, typer.Option("--with-recording", help="Include the trace, which scanrack watch can open.")
    ] = False,
    trust: Annotated[bool, typer.Option("--trust", help="Run Python from the trace.")] = False,
) -> None:
    """Export as one HTML file that any browser can open without a network.

    The page has rungs with power, tags, words, machine, timing strip and events of each scan. It explains the
    values of up to 20 tags in the scan shown first. It needs no server, and a content policy blocks all
    connections. Its size is at most 10 MB. The command prints what readers of the page can see.

    Examples:
        scanrack share run.mcap
        scanrack share run.mcap --at "8.2 s" -o failure.html

    Exit status: 0 done, 2 the trace or an option can't be used, 3 the file can't be written.
    """
    with reported_mistakes():
        scan = int(at) if at is not None and at.strip().isdecimal() else None
        time_ns = None if at is None or scan is not None else parse_time(at)
        options = ShareOptions(
            scan=scan,
            time_ns=time_ns,
            before=before,
            after=after,
            all_scans=whole,
            recording=recording,
            trust=trust,
            report_notes=print_notes,
        )
        target = trace.with_suffix(".html") if out is None else out
        data = share(trace, target, options)
        say(f"{target}: {size_of(target)}, scan {data['scan']:,} is shown first")
        for line in disclosed(data, recording=recording):
            say(line)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("share", no_args_is_help=True)(_share_command)
