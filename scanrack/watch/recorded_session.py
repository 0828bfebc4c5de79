"""`scanrack watch TRACE`: shows a trace on the same page as a running rack."""

from __future__ import annotations

import re
import secrets
import tempfile
import webbrowser
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import parse_qs, quote

from scanrack.io_images.versions import distribution_version
from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.record.edits_and_forces import is_set
from scanrack.jobs.record.order_repeater import is_session, lost_edits, orders_of
from scanrack.jobs.record.program_versions import ProgramVersions, edits_of, version_of, versions_of
from scanrack.jobs.trust.attachments import job_of, spec_of
from scanrack.jobs.trust.trust import UntrustedError
from scanrack.jobs.why.traced_run import Load
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import Edit
from scanrack.runtime.loop.pace import interrupted_by
from scanrack.runtime.loop.scan import ScanFlag
from scanrack.terminal.status import BAD_INPUT, INTERRUPTED, complain, reason
from scanrack.terminal.terminal import say
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.read.arrays import extent, read_columns
from scanrack.traces.read.columns import Selection
from scanrack.traces.read.reader import Trace, open_trace

from .gate import HOST, KEY_BYTES, Gate, listen
from .monitors.comparison import OpenedBeside
from .monitors.monitor import SessionFacts
from .monitors.trace_monitor import Source, TraceMonitor
from .watch_options import WatchArguments, WatchOptions

if TYPE_CHECKING:
    from .play import Play

Prepare = Callable[..., None]
"""A function that prepares branches: `Play.prepare_branch`."""

UNTRUSTED = (
    "The program is not shown, since Python that came with a trace must run to show its values. "
    "Read the program first: scanrack show {0} --extract FOLDER. Then use: scanrack watch {0} --trust"
)


class TracePlace(NamedTuple):
    """A place in a trace, as in `TRACE#scan=12345&rung=Main.6`."""

    path: Path
    scan: int | None  # None = the last scan
    rung: str  # routine and number; "" = none


def parse_trace_place(text: str) -> TracePlace:
    """Parse a place in a trace; raise ValueError if the scan is not a number.

    >>> parse_trace_place("run.mcap#scan=12&rung=Main.6")
    TracePlace(path=PosixPath('run.mcap'), scan=12, rung='Main.6')
    """
    path, _, fragment = text.partition("#")
    fields = {key: values[-1] for key, values in parse_qs(fragment).items()}
    scan = fields.get("scan")
    if scan is not None and not re.fullmatch(r"\d{1,10}", scan):
        raise ValueError(f"{text}: scan {scan!r} is not the number of a scan")
    return TracePlace(Path(path), None if scan is None else int(scan), fields.get("rung", ""))


def watch_trace(place: TracePlace, *, port: int, trust: bool, opened: bool) -> int:
    """Show a trace until Ctrl-C, or run a branch of it; return the exit status.

    Raises:
        ValueError: the trace or the port can't be used.
    """
    from .server import Server  # imported late, since only this command needs websockets in its own process

    with ExitStack() as stack:
        trace = stack.enter_context(open_trace(place.path))
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="scanrack")))
        listening = stack.enter_context(listen(port))
        key, number = secrets.token_hex(KEY_BYTES), listening.getsockname()[1]
        branches: list[Play] = []

        def prepare(*arguments: Any, **options: Any) -> None:
            """Prepare a branch, which runs when the page of the trace ends; a later branch replaces it."""
            from .play import Play  # imported late, since its imports would delay the first page

            watch_options = WatchOptions(
                WatchArguments(rack=str(place.path), port=port, record=place.path), editable=False
            )
            branches[:] = [Play(watch_options, listening, folder, stack, key)]
            branches[0].prepare_branch(*arguments, **options)

        recording = OpenedRecording(trace, place, folder, trust=trust)
        monitor = recording.monitor(prepare)
        for note in trace.notes:
            complain(f"note: {note}")
        monitor.opener = open_beside
        link = f"http://{HOST}:{number}/#key={key}{_fragment(place)}"
        say(f"{link} - Ctrl-C ends it")
        if opened:
            webbrowser.open(link)
        try:
            Server(monitor, Gate(HOST, number, key)).run(listening.dup())
        except KeyboardInterrupt:
            return complain(f"stopped by {interrupted_by()}", INTERRUPTED)
        assert recording.job is not None
        return branches[0].play_prepared(recording.job)


def _fragment(place: TracePlace) -> str:
    scan = "" if place.scan is None else f"&scan={place.scan}"
    return scan + (f"&rung={quote(place.rung)}" if place.rung else "")


def open_beside(path: Path) -> OpenedBeside:
    """Open a trace for comparison, without running Python that came with it.

    Raises:
        ValueError: the trace can't be used.
        OSError: the trace can't be read.
    """
    with ExitStack() as stack:
        monitor = open_to_read(stack, path, trust=False)
        stack.callback(monitor.processes.close)
        return OpenedBeside(monitor, stack.pop_all().close)


def open_to_read(
    stack: ExitStack,
    path: Path,
    *,
    trust: bool,
    report_notes: Callable[[Trace], None] | None = None,
    prepare: Prepare | None = None,
) -> TraceMonitor:
    """Return the monitor of a trace, which stays open until the stack is closed.

    Args:
        prepare: prepares branches; None = no branches.
        report_notes: called with the trace when the stack is closed, even if the trace can't be used.
    """
    trace = stack.enter_context(open_trace(path))
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="scanrack")))
    if report_notes is not None:
        stack.callback(report_notes, trace)
    return OpenedRecording(trace, TracePlace(path, None, ""), folder, trust=trust).monitor(prepare)


class OpenedRecording:
    """A trace, with its rack and its programs if they can be used.

    Args:
        place: path of the trace, and the scan that pages show first.
        folder: folder for the files in the trace.
        trust: whether Python that came with the trace may run.

    Attributes:
        job: the rack and the first program; None if it may not run.

    Raises:
        ValueError: the trace does not name its rack, or its files can't be used.
    """

    def __init__(self, trace: Trace, place: TracePlace, folder: Path, *, trust: bool) -> None:
        self._trace, self._place = trace, place
        self._edits = edits_of(trace)
        self.job: LoadedRack | None = None
        self._editions: ProgramVersions | None = None
        try:
            self.job = job_of(trace, folder / "files", trust=trust)
            self._editions = versions_of(trace, self._edits, self.job, folder / "programs", trust=trust)
            self._spec: RackSpec = self.job.spec
        except UntrustedError as error:
            complain(f"note: the program is not shown: {error}", BAD_INPUT)
            # pages show images and events; `job_of` or `versions_of` has refused the Python in the trace
            self.job, self._spec = None, spec_of(trace, folder / "rack", trust=trust)
        self._load: Load | None = None
        job, editions = self.job, self._editions
        if job is not None and editions is not None:
            self._load = Load(
                program=job.program,
                logic=lambda: job_of(trace, folder / "files", trust=trust).logic,
                edited=lambda number: editions.again(number).logic,
            )

    def monitor(self, prepare: Prepare | None = None) -> TraceMonitor:
        """Return the monitor of the trace; without `prepare`, it can't branch."""
        trace, path = self._trace, str(self._place.path)
        name = trace.head.metadata.get("name", self._place.path.stem)
        facts = SessionFacts(
            version=distribution_version("scanrack"),
            name=name,
            path=path,
            kind="trace",
            read_only=True,
            live=False,
            record=path,
            branches=self.job is not None,
        )
        monitor = TraceMonitor(
            facts,
            trace,
            self._place.path,
            self._spec,
            sources=self._sources(),
            first=self._place.scan,
            branch=lambda scan, paused: self._branch(prepare, scan, paused=paused),
        )
        monitor.job, monitor.again = self.job, self._load
        return monitor

    def _sources(self) -> list[Source]:
        """Return the programs in the order of their scans; a program that can't be used has no logic."""
        if self.job is None or self._editions is None:
            return [Source(0, logic=None, file=None, lacks=UNTRUSTED.format(self._place.path))]
        sources = [Source(0, self.job.logic, self.job.program)]
        for edit in self._edits:
            if isinstance(edit.order, Edit):
                job = self._editions.job(edit.order.number)
                sources.append(Source(edit.scan, job.logic, job.program))
        return sorted(sources, key=lambda source: source.first)

    def _branch(self, prepare: Prepare | None, scan: int, *, paused: bool) -> None:
        """Prepare a session that repeats the trace up to a scan; raise ValueError if that is impossible."""
        if prepare is None:
            raise ValueError("a branch can begin only in the page of the trace itself")
        if self.job is None or self._editions is None:
            raise ValueError("running the program needs --trust")
        first_scan = extent(self._trace).scan.tolist()[0]
        if first_scan:
            raise ValueError(f"the trace begins with scan {first_scan}; a branch needs it from scan 0 on")
        lost = lost_edits(self._trace.events())
        if lost and lost[0] <= scan:
            raise ValueError(f"the trace lacks the program that ran from scan {lost[0]} on")
        if not is_session(self._trace):
            self._check_untouched(scan)
        try:
            editions = self._editions.of_a_session(version_of(self.job))
        except OSError as error:
            raise ValueError(f"the programs of a branch can't be written: {reason(error)}") from error
        orders = orders_of(self._trace.events(topics={ORDERS.name, "/events"}))
        prepare(scan, orders, editions, self._place.path, paused=paused)

    def _check_untouched(self, scan: int) -> None:
        """Refuse a trace in which a script operated the rack, since such actions are not recorded.

        Raises:
            ValueError: a script set tags or pressed inputs.
        """
        flags = read_columns(self._trace, Selection(0, scan)).flags
        touched = (flags & (ScanFlag.TAGS_FROM_OUTSIDE | ScanFlag.INPUT_FORCES | ScanFlag.OUTPUT_FORCES)) != 0
        events = self._trace.events(topics={"/events"})
        touched[[event.scan for event in events if is_set(event) and event.scan < len(touched)]] = False
        if touched.any() and not self._spec.force:
            first = int(touched.argmax())
            raise ValueError(
                f"a script set tags or images in scan {first}, and the trace does not contain the script"
            )
