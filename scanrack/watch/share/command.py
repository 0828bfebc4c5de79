"""`scanrack share TRACE`: a recording and its page in one file that any browser opens."""

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
from .collecting import OTHER_ANSWERS, SharedStretch, collect
from .failure import Failure
from .page_file import SHARED_PAGE, page_of

WHOLE_SCANS = 50_000
"""A recording with up to this many scans is shared as a whole."""

BEFORE, AFTER = 20_000, 2_000
"""Numbers of scans of a longer recording before and after the scan shown first."""


class ShareOptions(NamedTuple):
    """The choices for a page; at most one of scan and time."""

    scan: int | None = None  # None = the last one
    time_ns: int | None = None
    before: int = BEFORE
    after: int = AFTER
    whole: bool = False
    most: int = WHOLE_SCANS  # a recording with more scans is cut
    others: int = OTHER_ANSWERS  # number of tags that are explained without a request
    latest: bool = False  # whether to use the last scan in place of one that is not written yet
    recording: bool = False  # whether to include the trace
    trust: bool = False  # whether Python in the trace may run
    tags: Sequence[str] = ()  # tags that are explained in the page
    failure: Failure | None = None  # failure of the test that made the recording; the page opens on it
    report_notes: Callable[[Trace], None] | None = (
        None  # reports the notes of the trace, even if it is refused
    )
    rack: str = ""  # address of the running rack, whose current panel is shown; "" = the recording's

    def within(self, first: int, last: int, period_ns: int) -> SharedStretch:
        """Return the stretch of a recording to share; raise ValueError if it lacks the requested scan."""
        scan = last if self.scan is None else self.scan
        if self.time_ns is not None:
            scan = self.time_ns // period_ns
        if self.latest:
            scan = min(scan, last)
        if not first <= scan <= last:
            raise ValueError(f"no scan {scan}: the recording has {first} to {last}")
        if self.whole or last - first < self.most:
            return SharedStretch(first, last, scan)
        return SharedStretch(max(first, scan - self.before), min(last, scan + self.after), scan)


def share(trace: Path, out: Path, wish: ShareOptions) -> Any:
    """Write the page of a recording; return its data.

    Raises:
        ValueError: the recording or the output can't be used, or the page would be too large.
        OSError: a file can't be read or written.
    """
    check_output(out, SHARED_PAGE, itself(trace))
    data, page = shared(trace, wish)
    with new_file(out, SHARED_PAGE, "wb", used=itself(trace)) as file:
        file.write(page)
    return data


def shared(trace: Path, wish: ShareOptions) -> tuple[Any, bytes]:
    """Return the data of a recording's page, and the page, see `share`."""
    with ExitStack() as stack:
        monitor = open_to_read(stack, trace, trust=wish.trust, report_notes=wish.report_notes)
        if wish.rack:
            monitor.panel = KeptPanel(wish.rack)
        extent = monitor.subject.timeline.extent
        if extent is None:
            raise ValueError(f"{trace}: no scan in it" + (" yet" if wish.latest else ""))
        stretch = wish.within(*extent, monitor.subject.spec.scan_ns)
        failed, failure = None, wish.failure
        if failure is not None:
            earlier = failure.passed
            passed_monitor = None if earlier is None else open_to_read(stack, earlier, trust=wish.trust)
            failed = partial(failure.described, stretch, passed_monitor)
        data = collect(monitor, stretch, wish.tags, wish.others, failed)
    return data, page_of(data, trace.read_bytes() if wish.recording else None)


def disclosed(data: Any, *, recording: bool) -> list[str]:
    """Return sentences about what a page discloses to anyone who has it."""
    first, last = data["range"]
    routines = [routine for program in data["programs"] for routine in program["described"]["routines"]]
    tags = {tag["name"] for program in data["programs"] for tag in program["described"]["tags"]}
    program_text = f"the program with its comments ({_many(len(routines), 'routine')}), " if routines else ""
    lines = [
        f"Whoever has it reads {program_text}the words of scans {first:,} to {last:,}, "
        f"{_many(len(tags), 'tag')}, {_many(len(data['events']), 'event')}, "
        f"{_many(len(data['whys']), 'answer')} of why."
    ]
    if recording:
        lines.append("The recording is inside, with the files of its rack and program.")
    return lines


def _many(count: int, thing: str) -> str:
    return f"{count:,} {thing}{'' if count == 1 else 's'}"


def _share_command(
    trace: Annotated[Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="OUT", help="Where to.", show_default="beside the trace, as .html"
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            metavar="TIME|SCAN",
            help="Show this time first, such as '8.2 s', or this scan.",
            show_default="the last scan",
        ),
    ] = None,
    before: Annotated[
        int, typer.Option("--before", metavar="N", min=0, help="Scans before it, of more than 50,000.")
    ] = BEFORE,
    after: Annotated[
        int, typer.Option("--after", metavar="N", min=0, help="Scans after it, of more than 50,000.")
    ] = AFTER,
    whole: Annotated[bool, typer.Option("--all", help="All scans, however many.")] = False,
    recording: Annotated[
        bool, typer.Option("--with-recording", help="Put the trace inside, too: scanrack watch opens it.")
    ] = False,
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False,
) -> None:
    """Export as one HTML file, which any browser opens without a network.

    The page has rungs with power, tags, words, machine, timing strip and events of each scan, and says why
    for up to twenty tags of the scan shown first. It asks no server, and a content policy lets it connect to
    nothing. More than 10 MB are refused. What the page discloses is printed.

    Examples: scanrack share run.mcap; scanrack share run.mcap --at "8.2 s" -o failure.html

    Exit status: 0 done, 2 the trace or an option can't be used, 3 the file can't be written.
    """
    with reported_mistakes():
        scan = int(at) if at is not None and at.strip().isdecimal() else None
        time_ns = None if at is None or scan is not None else parse_time(at)
        wish = ShareOptions(
            scan, time_ns, before, after, whole, recording=recording, trust=trust, report_notes=print_notes
        )
        target = trace.with_suffix(".html") if out is None else out
        data = share(trace, target, wish)
        say(f"{target}: {size_of(target)}, scan {data['scan']:,} is shown first")
        for line in disclosed(data, recording=recording):
            say(line)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("share", no_args_is_help=True)(_share_command)
