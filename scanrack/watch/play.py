"""A session and its branches, run in the scan process of `scanrack watch RACK`.

    session    0 ------------- 12,345 ------------- 20,000
    branch                     `- 12,345 ----------------- ...     a new rack, with the same actions up to
                                                                   this scan

A branch uses the same ring, link and monitor. Its rack, program and trace are new.
"""

from __future__ import annotations

import secrets
import socket
import tempfile
import webbrowser
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from scanrack.io_images.versions import distribution_version
from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.record.order_repeater import RecordedOrder
from scanrack.jobs.record.program_versions import ProgramVersions, version_of
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.jobs.run.servers.tag_service import TagServices
from scanrack.runtime.live.actions import Edit
from scanrack.runtime.live.ring import Ring
from scanrack.runtime.live.session import Session
from scanrack.runtime.live.tap import NoInbox, Notes, PipeInbox, Tap
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.pace import AdjustablePace
from scanrack.runtime.loop.realtime import frozen_collector, real_time
from scanrack.terminal.run_end import complain_of_fault, run_to_end
from scanrack.terminal.status import BAD_INPUT, CANNOT_WRITE, DONE, complain, complain_of_helper, reason
from scanrack.terminal.terminal import say

from .announcing import Announcer, programs_of
from .editor import EditManner, Editor, Takeover
from .gate import HOST, KEY_BYTES, listen
from .history.watched_machines import PER_SLOT, MachineFigures
from .history.watched_program import LadderNotes, written_to
from .history.watched_python import PythonNotes
from .monitor_supervisor import MonitorSupervisor, NoMonitor
from .monitors.monitor import SessionFacts
from .monitors.session_monitor import Setup
from .python_stops import PythonStops
from .text import TextView
from .watch_options import WatchOptions


@dataclass(frozen=True, slots=True)
class Start:
    """The start of a session."""

    scan: int = 0  # the first scan that is not a repetition; 0 for the first session
    orders: Sequence[RecordedOrder] | None = None  # actions before that scan in the sessions it branches from
    metadata: dict[str, str] = field(default_factory=dict)  # of the trace
    paused: bool = False  # whether it begins paused


@dataclass(frozen=True, slots=True)
class PreparedRun:
    """A session's run that is ready to begin."""

    start: Start
    run: JobRun
    pacer: AdjustablePace
    trace: Path
    editions: ProgramVersions
    ports: ExitStack


def watch_job(job: LoadedRack, options: WatchOptions) -> int:
    """Run a rack in a session with pages; return the exit status."""
    with ExitStack() as stack:
        try:
            listening = stack.enter_context(listen(options.arguments.port))
        except ValueError as error:
            return complain(str(error), BAD_INPUT)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="scanrack")))
        return Play(options, listening, folder, stack).play(job)


class Play:
    """The sessions of one command.

    Args:
        listening: the socket for pages.
        folder: folder for temporary traces and copies of programs.
        stack: closes shared objects of the sessions at the end of the command.
        key: key of an existing link, which pages must send; None = create a key.
    """

    def __init__(
        self,
        options: WatchOptions,
        listening: socket.socket,
        folder: Path,
        stack: ExitStack,
        key: str | None = None,
    ) -> None:
        self._options, self._listening, self._folder, self._stack = options, listening, folder, stack
        self._key = key
        self._ring: Ring | None = None
        self._supervisor: MonitorSupervisor | NoMonitor | None = None
        self._inbox: PipeInbox | NoInbox | None = None
        self._next: PreparedRun | None = None  # begins when the present run has ended
        self._services: TagServices | None = None

    def play(self, job: LoadedRack) -> int:
        """Play the session and its branches; return the exit status."""
        try:
            self._open_services(job)
            self._next = self._prepared_first(job)
        except ValueError as error:
            return complain(str(error), BAD_INPUT)
        except OSError as error:
            return complain(f"the trace can't be written: {reason(error)}", CANNOT_WRITE)
        for warning in job.warnings:
            complain(warning)
        return self.play_prepared(job)

    def _open_services(self, job: LoadedRack) -> None:
        """Open the ports for tag clients; raise ValueError if one can't be used."""
        options = self._options
        self._services = TagServices(job, options.servers, complain, writes=not options.read_only)
        self._stack.callback(self._services.end)

    def play_prepared(self, job: LoadedRack) -> int:
        """Play the prepared run and its branches; return the exit status."""
        status = DONE
        while self._next is not None:
            prepared, self._next = self._next, None
            with prepared.ports:
                status = self._run(prepared, self._session(prepared, job))
        started = [helper.end() for helper in (self._supervisor, self._services) if helper is not None]
        if not all(started) and status == DONE:
            return complain_of_helper()
        return status

    def _prepared_first(self, job: LoadedRack) -> PreparedRun:
        """Prepare the first session.

        Raises:
            ValueError: the rack can't be run.
            OSError: the trace can't be written.
        """
        editions = ProgramVersions(self._folder / "programs", self._options.arguments.rack)
        editions.keep(0, editions.with_copy(version_of(job)), job)
        return self._prepared(Start(paused=self._options.arguments.paused), editions)

    def _prepared(self, start: Start, editions: ProgramVersions) -> PreparedRun:
        """Create the rack, and open the ports and the trace of a session; return its prepared run.

        If the run never begins, the end of the command closes them.
        """
        with ExitStack() as ports:
            if self._options.arguments.live:
                for outcome in ports.enter_context(real_time()):  # before any port is opened
                    complain(str(outcome))
            speed, trace = self._options.speed if start.orders is None else None, self._trace(start)
            pacer = AdjustablePace(speed, spin=self._options.arguments.spin)
            run = JobRun(
                editions.job(0),
                ports,
                RunOptions(
                    trace=trace,
                    live=self._options.arguments.live,
                    pacer=pacer,
                    warn=complain,
                    handled=True,
                    metadata=start.metadata,
                    keep=self._options.keep,
                    orders=start.orders,
                    forces=self._options.forces,
                    editions=editions,
                    remembered=self._options.remembered,
                ),
            )
            ports.callback(run.cpu.close)  # removes the folder of the trace if the run never begins
            prepared = PreparedRun(start, run, pacer, trace, editions, ports.pop_all())
        self._stack.callback(prepared.ports.close)
        return prepared

    def prepare_branch(
        self,
        scan: int,
        orders: Iterable[RecordedOrder],
        editions: ProgramVersions,
        parent: Path,
        *,
        paused: bool = False,
    ) -> None:
        """Prepare a branch: a new rack that repeats the actions up to a scan.

        Args:
            scan: the first scan that may differ.
            paused: whether the branch starts paused.

        Raises:
            ValueError: a branch is impossible; nothing has changed.
        """
        earlier = [order for order in orders if order.scan <= scan]
        edits = sum(isinstance(order.order, Edit) for order in earlier)
        start = Start(scan, earlier, {"parent": parent.name, "parent_scan": str(scan)}, paused)
        try:
            self._next = self._prepared(start, editions.up_to(edits))
        except OSError as error:
            raise ValueError(f"the trace of a branch can't be written: {reason(error)}") from error

    def _trace(self, start: Start) -> Path:
        """Return the path of the trace, a temporary file unless `--record` is given."""
        record_path = self._options.arguments.record
        if record_path is None:
            return _unused(self._folder / "session.mcap")
        if start.orders is None:
            return record_path
        return _unused(record_path.with_name(f"{record_path.stem}-{start.scan}.mcap"))

    def _session(self, prepared: PreparedRun, job: LoadedRack) -> Session:
        """Return the session of a prepared run, connected to the monitor, pages, editor and tag clients.

        The first session also creates the ring and starts the monitor.
        """
        run, start, pacer, options = prepared.run, prepared.start, prepared.pacer, self._options
        figures = MachineFigures(run.rack)
        if self._ring is None:
            self._ring = Ring(len(run.rack.memory), PER_SLOT * len(figures.slots))
            self._stack.callback(self._ring.close)
            self._open(job, self._ring, figures, prepared)
        assert self._inbox is not None
        tap = Tap(self._ring, run.rack, run.cpu.period_ns, figures)
        tap.notes = _notes(run, job, self._ring, tap)
        hands = run.hands
        hands.applied.extend(start.orders or ())
        session: Session  # made below from the editor, which needs `hand_over`
        assert self._supervisor is not None
        announcer = Announcer(
            run, prepared.editions, start.orders or (), send=tap.send, supervisor=self._supervisor
        )
        run.program.on_edit = announcer.announce_edit

        def hand_over(takeover: Takeover) -> None:
            session.takeovers.append(takeover)

        editor = Editor(
            job,
            options.arguments.rack,
            run,
            prepared.editions,
            hand_over=hand_over,
            send=tap.send,
            manner=EditManner(
                preview=options.arguments.preview, trust=options.arguments.trust, saved=options.saved
            ),
        )
        session = Session(
            run.cpu,
            hands,
            pacer,
            self._inbox,
            tap.send,
            stops=run.program.debugger or PythonStops(lambda: run.program.logic, job.program),
            live=options.arguments.live,
            reload=editor.load_soon if options.editable else None,
            prepare=lambda scan, paused: self.prepare_branch(
                scan, hands.applied, prepared.editions, prepared.trace, paused=paused or session.state.paused
            ),
        )
        if options.editable and not options.read_only:
            session.edit = editor.request
            editor.start()
            prepared.ports.callback(editor.end)
            tap.lasting = editor.lasting
        tap.session, session.attend, session.send_values = session, tap.attend, tap.send_values
        if start.orders is not None:
            record = None if options.arguments.record is None else str(prepared.trace)
            announcer.announce_branch(self._ring, prepared.trace, record)
        if options.arguments.text:
            view = TextView(job.spec.name, run.rack, session, pacer)
            run.cpu.add_listener(view)
            view.begin()
        run.cpu.add_listener(run.program.following(tap))
        if self._services is not None:
            self._serve_tags(self._services, run, session)
        if options.door is not None:
            options.door(session, run)
        return session

    @staticmethod
    def _serve_tags(services: TagServices, run: JobRun, session: Session) -> None:
        """Serve the tags of a run, even while it is paused."""
        desks, attend = services.serve(run), session.attend

        def attend_all() -> None:
            attend()
            for desk in desks:
                desk.attend()

        session.attend = attend_all

    def _open(self, job: LoadedRack, ring: Ring, figures: MachineFigures, prepared: PreparedRun) -> None:
        """Start the monitor and print its link; without a page, use objects that do nothing."""
        options = self._options
        key, port = self._key or secrets.token_hex(KEY_BYTES), self._listening.getsockname()[1]
        record = None if options.arguments.record is None else str(prepared.trace)
        is_read_only, is_live = options.read_only, options.arguments.live
        facts = SessionFacts(
            version=distribution_version("scanrack"),
            name=job.spec.name,
            path=options.arguments.rack,
            kind="rack",
            read_only=is_read_only,
            live=is_live,
            record=record,
            branches=not is_read_only and not is_live,
        )
        setup = Setup(
            shape=ring.shape,
            about=facts,
            key=key,
            host=HOST,
            port=port,
            machines=tuple(figures.slots),
            trace=str(prepared.trace),
            programs=programs_of(prepared.run, prepared.editions, ()),
        )
        if not options.page:
            self._supervisor, self._inbox = NoMonitor(), NoInbox()
            return
        self._supervisor = supervisor = MonitorSupervisor(setup, ring, self._listening, complain)
        self._stack.callback(supervisor.end)
        self._inbox = PipeInbox(ring, supervisor.pipe)
        supervisor.watch(self._inbox)
        if self._key is not None:
            return
        link = f"http://{HOST}:{port}/#key={key}"
        say(f"{link} - Ctrl-C ends the session")
        if options.arguments.opened:
            webbrowser.open(link)

    def _hold_clients(self, on_hold: bool) -> None:
        """Make tag clients wait while actions are repeated."""
        if self._services is not None:
            self._services.rest(on_hold)

    def _run(self, prepared: PreparedRun, session: Session) -> int:
        """Run a session to its end; return the exit status."""
        options, run, start = self._options, prepared.run, prepared.start
        faulted: list[int] = []  # exit statuses of faults that the page shows

        def report(fault: CpuFault) -> None:
            faulted.append(complain_of_fault(fault))
            complain("the page shows the fault; branch there from an earlier scan, or end with Ctrl-C")

        def play() -> None:
            """Repeat the actions of a branch's parents, then run the session to its end."""
            with frozen_collector(), run.cpu:
                if start.orders is not None:
                    self._hold_clients(True)
                    session.repeat_to(start.scan)
                    self._hold_clients(False)
                    session.set_speed(options.speed)
                try:
                    session.run(options.scans, paused=start.paused)
                except CpuFault:
                    if not faulted:
                        raise

        session.on_fault = report
        by_signal = options.door is None  # otherwise a debug adapter ends the session
        status = run_to_end(run.cpu, play, lambda: by_signal and session.over and session.branch is None)
        return faulted[-1] if faulted else status


def _unused(path: Path) -> Path:
    """Return a path that does not exist yet, with a number if necessary."""
    number, tried = 2, path
    while tried.exists():
        tried = path.with_name(f"{path.stem}-{number}{path.suffix}")
        number += 1
    return tried


def _notes(run: JobRun, job: LoadedRack, ring: Ring, tap: Tap) -> Notes:
    """Return the object that sends the program's values to the monitor."""
    if run.program.debugger is not None:
        return LadderNotes(run.program.debugger, written_to(ring.snapshots))
    return PythonNotes(lambda: run.program.logic, job.spec.tags, tap.send)
