"""`scanrack watch TRACE`: a recording in the same page as a rack that runs."""

from __future__ import annotations

import asyncio
import re
import secrets
import socket
import tempfile
import webbrowser
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qs, quote

from ....traces.reader import Trace, open_trace
from ...app.attachments import job_of, spec_of
from ...app.editions import editions_of
from ...app.loading import Job
from ...app.repeating import RecordedOrder, is_session, orders_of
from ...app.replaying import lost_edits, lost_notes
from ...app.trust import UntrustedError
from ...config.rackspec import RackSpec
from ...live.orders import Edit
from ...loop.pace import interrupted_by
from ..status import BAD_INPUT, INTERRUPTED, complain
from ..terminal import say
from .gate import Gate
from .monitor import About
from .play import HOST, KEY_BYTES
from .trace_monitor import Source, TraceMonitor


class Place(NamedTuple):
    """What `TRACE#scan=12345&rung=Main.6` names.

    Attributes:
        path: of the trace.
        scan: the scan; None = the last one.
        rung: the rung; "" = none.
    """

    path: Path
    scan: int | None
    rung: str


def place_of(text: str) -> Place:
    """Return what names a place in a trace.

    >>> place_of("run.mcap#scan=12&rung=Main.6")
    Place(path=PosixPath('run.mcap'), scan=12, rung='Main.6')

    Raises:
        ValueError: the scan is not a number.
    """
    path, _, rest = text.partition("#")
    fields = {key: values[-1] for key, values in parse_qs(rest).items()}
    scan = fields.get("scan")
    if scan is not None and not re.fullmatch(r"\d{1,10}", scan):
        raise ValueError(f"{text}: scan {scan!r} is not the number of a scan")
    return Place(Path(path), None if scan is None else int(scan), fields.get("rung", ""))


def watch_trace(place: Place, *, port: int, trust: bool, opened: bool) -> int:
    """Serve a recording until Ctrl-C; return the exit status."""
    from .server import Server  # imported late: no other command needs websockets in its own process

    with (
        open_trace(place.path) as trace,
        tempfile.TemporaryDirectory(prefix="scanrack") as folder,
        socket.create_server((HOST, port)) as listening,
    ):
        for note in trace.notes:
            complain(f"note: {note}")
        monitor = _monitor(trace, place, Path(folder), trust=trust)
        key, number = secrets.token_hex(KEY_BYTES), listening.getsockname()[1]
        link = f"http://{HOST}:{number}/#key={key}{_fragment(place)}"
        say(f"{link} - Ctrl-C ends it")
        if opened:
            webbrowser.open(link)
        try:
            asyncio.run(Server(monitor, Gate(HOST, number, key)).run(listening))
        except KeyboardInterrupt:
            return complain(f"stopped by {interrupted_by()}", INTERRUPTED)
    return INTERRUPTED


def _fragment(place: Place) -> str:
    scan = "" if place.scan is None else f"&scan={place.scan}"
    return scan + (f"&rung={quote(place.rung)}" if place.rung else "")


def _monitor(trace: Trace, place: Place, folder: Path, *, trust: bool) -> TraceMonitor:
    """Load the rack and program of a trace, as far as trust allows.

    Raises:
        ValueError: the trace does not say what its rack is, or its files can't be used.
    """
    job: Job | None = None
    orders = orders_of(trace.events()) if is_session(trace) else []
    try:
        job = job_of(trace, folder / "files", trust=trust)
        spec: RackSpec = job.spec
        edited = _edited(trace, orders, job, folder / "edits", trust=trust)
    except UntrustedError as error:
        complain(f"note: the program is not shown: {error}", BAD_INPUT)
        spec, job, edited = spec_of(trace, folder / "rack", trust=trust), None, []
    for note in lost_notes(lost_edits(trace.events())):
        complain(f"note: {note}")
    begins = Source(0, None, None) if job is None else Source(0, job.logic, job.program)
    about = About(
        version("scanrack"), trace.head.metadata.get("name", place.path.stem), str(place.path),
        "trace", True, False, str(place.path),
    )  # fmt: skip
    return TraceMonitor(about, trace, place.path, spec, [begins, *edited], orders, place.scan)


def _edited(
    trace: Trace, orders: Sequence[RecordedOrder], begins: Job, folder: Path, *, trust: bool
) -> list[Source]:
    """Return the programs that edits made, in the order of their scans; unknown ones without their logic.

    Raises:
        ValueError: one can't be loaded.
    """
    editions = editions_of(trace, orders, begins, folder, trust=trust)
    found = []
    for each in orders:
        if isinstance(each.order, Edit):
            job = editions.job(each.order.number)
            found.append(Source(each.scan, job.logic, job.program))
    lost = [Source(scan, None, None) for scan in lost_edits(trace.events())]
    return sorted([*found, *lost], key=lambda each: each.first)
