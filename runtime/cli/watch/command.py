"""`scanrack watch RACK`: a rack that runs, in the browser."""

from __future__ import annotations

import secrets
import socket
import tempfile
import webbrowser
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from importlib.metadata import version
from os.path import realpath
from pathlib import Path
from typing import Annotated

import typer

from ....ladder.debug import Debugger
from ...app.loading import Job, load_job, scans_to_run
from ...app.running import JobRun
from ...app.sequence_watch import watching
from ...app.watched_machines import PER_SLOT, MachineFigures
from ...app.watched_program import LadderNotes
from ...app.watched_python import PythonNotes
from ...live.orders import MAX, SPEED_LEAST, SPEED_MOST
from ...live.ring import Ring
from ...live.session import Session
from ...live.tap import Notes, PipeInbox, Tap
from ...loop.faults import CpuFault
from ...loop.pace import Paced, interrupted_by
from ...loop.realtime import frozen_collector
from ..run import check_ports, complain_of_fault
from ..status import BAD_INPUT, CANNOT_WRITE, DONE, INTERRUPTED, complain, reason
from ..terminal import say
from .keeper import Keeper
from .monitor import Setup

HOST = "127.0.0.1"
KEY_BYTES = 16


@dataclass(frozen=True, slots=True)
class Wanted:
    """What the command line asks for.

    Attributes:
        rack: path of the rack file.
        port: of the server; 0 = any free one.
        speed: times real time; None = as fast as possible.
        paused: begin with a pause.
        read_only: refuse orders.
        record: where the recording is kept; None = it is not.
        scans: how many scans; None = until Ctrl-C.
        live: real ports may be driven.
        opened: open the page in the browser.
    """

    rack: str
    port: int
    speed: float | None
    paused: bool
    read_only: bool
    record: Path | None
    scans: int | None
    live: bool
    opened: bool


def watch_job(job: Job, wanted: Wanted) -> int:
    """Run a job in a session that pages can look at; return the exit status."""
    with ExitStack() as stack:
        try:
            listening = stack.enter_context(socket.create_server((HOST, wanted.port)))
        except OSError as error:
            return complain(f"port {wanted.port}: {error.strerror}", BAD_INPUT)
        trace = wanted.record or _passing(stack)
        pacer = Paced(wanted.speed)
        try:
            run = JobRun(
                job,
                stack,
                trace=trace,
                live=wanted.live,
                pacer=pacer,
                warn=lambda hint: _warn(hint),
                handled=True,
            )
        except ValueError as error:
            return complain(str(error), BAD_INPUT)
        except OSError as error:
            return complain(f"the trace can't be written: {reason(error)}", CANNOT_WRITE)
        for each in job.warnings:
            complain(each)
        return _watch(run, job, wanted, pacer, listening, stack)


def _passing(stack: ExitStack) -> Path:
    """Return where a recording goes that is not kept: the page looks back in it."""
    return Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="scanrack"))) / "session.mcap"


def _warn(hint: str) -> None:
    complain(str(hint))


def _watch(
    run: JobRun, job: Job, wanted: Wanted, pacer: Paced, listening: socket.socket, stack: ExitStack
) -> int:
    figures = MachineFigures(run.rack)
    ring = Ring(len(run.rack.memory), PER_SLOT * len(figures.slots))
    stack.callback(ring.close)
    key, port = secrets.token_hex(KEY_BYTES), listening.getsockname()[1]
    setup = Setup(
        ring.shape,
        wanted.rack,
        job.spec.name,
        key,
        HOST,
        port,
        wanted.read_only,
        wanted.live,
        None if wanted.record is None else str(wanted.record),
        tuple(figures.slots),
        version("scanrack"),
    )
    keeper = Keeper(setup, ring, listening, complain)
    stack.callback(keeper.end)
    link = f"http://{HOST}:{port}/#key={key}"
    say(f"{link} - Ctrl-C ends the session")
    if wanted.opened:
        webbrowser.open(link)
    inbox = PipeInbox(ring, keeper.pipe)
    program = run.logic if isinstance(run.logic, Debugger) else None
    tap = Tap(ring, run.rack, run.cpu.period_ns, figures)
    tap.notes = _notes(run, job, ring, tap)
    session = Session(run.cpu, run.hands, pacer, inbox, tap.tell, stops=program, live=wanted.live)
    tap.session, session.attend = session, tap.attend
    run.cpu.add_listener(watching(tap, run.logic))
    keeper.keep(inbox)
    return _run(run, session, wanted)


def _notes(run: JobRun, job: Job, ring: Ring, tap: Tap) -> Notes:
    """Return what tells the monitor of the program."""
    if isinstance(run.logic, Debugger):
        return LadderNotes(run.logic, ring.snapshots)
    return PythonNotes(run.logic, job.spec.tags, tap.tell)


def _run(run: JobRun, session: Session, wanted: Wanted) -> int:
    """Run the session to its end, whatever that is; return the exit status."""
    try:
        with frozen_collector() if wanted.live else nullcontext(), run.cpu:
            session.run(wanted.scans, paused=wanted.paused)
    except CpuFault as error:
        return complain_of_fault(error)
    except OSError as error:
        return complain(f"the trace can't be finished: {reason(error)}", CANNOT_WRITE)
    except KeyboardInterrupt:
        return complain(f"stopped by {interrupted_by()} in scan {run.cpu.scan}", INTERRUPTED)
    if session.over:
        return complain(f"stopped by {interrupted_by()} after {run.cpu.scan} scans", INTERRUPTED)
    return DONE


def _speed(text: str) -> float | None:
    """Return a speed; None = as fast as possible.

    Raises:
        ValueError: it is none.
    """
    if text == MAX:
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not SPEED_LEAST <= speed <= SPEED_MOST:
        raise ValueError(f"--speed {text} is not allowed: {SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}")
    return speed


def _watch_command(
    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK", help="Rack file: TOML, or Python that defines rack().", show_default=False
        ),
    ],
    port: Annotated[
        int, typer.Option("--port", help="Port of the page; 0 = any free one.", min=0, max=65535)
    ] = 0,
    speed: Annotated[
        str, typer.Option("--speed", help=f"Times real time, {SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}.")
    ] = "1",
    paused: Annotated[bool, typer.Option("--paused", help="Begin with a pause before scan 0.")] = False,
    read_only: Annotated[bool, typer.Option("--read-only", help="Refuse everything but looking.")] = False,
    record: Annotated[
        Path | None, typer.Option("--record", help="Keep the recording there.", show_default=False)
    ] = None,
    duration: Annotated[
        str | None,
        typer.Option("--for", metavar="TIME", help="Machine time to run for; without it until Ctrl-C."),
    ] = None,
    scans: Annotated[int | None, typer.Option("--scans", help="Number of scans to run, instead.")] = None,
    live: Annotated[
        bool,
        typer.Option("--live", help="Real ports may move real motors. This is not a safety system."),
    ] = False,
    control: Annotated[
        bool,
        typer.Option("--control", help="With --live: take orders, too; without it the page is read-only."),
    ] = False,
    opened: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
) -> None:
    try:
        factor = _speed(speed)
        job = load_job(rack)
        check_ports(job.spec, realtime=True, live=live)
        if live and (paused or factor != 1):
            raise ValueError("--live: a real controller does not wait: no --paused and no --speed")
        if control and not live:
            raise ValueError("--control goes with --live")
        if record is not None and realpath(record) in (realpath(job.rack_file), realpath(job.program)):
            raise ValueError(f"the trace would replace {record}: give it a name of its own")
        endless = scans is None and duration is None
        count = None if endless else scans_to_run(job.spec, duration, scans, endless=True)
    except ValueError as error:
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    looking = read_only or (live and not control)
    wanted = Wanted(rack, port, factor, paused, looking, record, count, live, opened)
    raise typer.Exit(watch_job(job, wanted))


_HELP = """Run a rack and show it in the browser: rungs with power, words, machine, timing.

The first word printed is the link; the page comes from this machine, and works without a network. Scans keep
step with the wall clock, or at --speed. What is ordered on the page is recorded, so that the session can run
again: see scanrack rerun.

Exit status: 0 done, 1 the CPU faulted, 2 a file or option can't be used, 3 the trace can't be written, 130
stopped by Ctrl-C, which ends a session without --for."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("watch", help=_HELP, no_args_is_help=True)(_watch_command)
