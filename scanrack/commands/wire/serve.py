"""`scanrack serve CONTROLLER`: run a simulated controller on a port, in real time."""

from __future__ import annotations

import os
import select
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

import typer
from rich.console import Console
from rich.live import Live
from rich.table import Table
from scanrack.io_images.drives.models import MODELS
from scanrack.jobs.run.served_units import (
    PORT_GAP_MS,
    SERIAL_GAP_MS,
    ServedUnit,
    Unit,
    addresses_in,
    pcl601_units,
    pmc006_units,
)
from scanrack.jobs.serve.control import ControlChannel
from scanrack.jobs.serve.drives import DriveService
from scanrack.jobs.serve.line import LineService, PortChoice, ServedLine, begin, wire
from scanrack.jobs.serve.machines import on_machines
from scanrack.jobs.serve.memory_file import ControllerMemory
from scanrack.runtime.config.rackspec import KEPT_TRACES
from scanrack.runtime.line.ports import LONGEST_S, Server, serve_until_interrupted
from scanrack.runtime.loop.pace import Clock, wall_ns
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.status import INTERRUPTED, complain
from scanrack.terminal.tables import Cells
from scanrack.terminal.terminal import say
from scanrack.traces.files.keeping import RecordingKeeper, check_recordings
from scanrack.traces.write.line import LineRecorder, UnitColumns

from .serve_options import ServedDevice, ServeOptions, check_options
from .serve_remote import serve_remote

LOOKED_EVERY_S = 0.01
"""Longest time between two recordings of registers, or two checks of the control channel, s."""

REFRESH_NS = 250_000_000
"""Time between two refreshes of the status, ns."""


MAKERS: dict[ServedDevice, Callable[[list[int], list[Path], float, list[str], float], list[Unit]]] = {
    ServedDevice.PCL601: pcl601_units,
    ServedDevice.PMC006: pmc006_units,
}


def status_table(units: Sequence[ServedUnit]) -> Table:
    """Return a table with the state of the units, one row each."""
    rows = [unit.status() for unit in units]
    table = Cells(*rows[0], box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row.values())
    return table


class TypedInputs:
    """Lines typed while serving; each line sets an input."""

    def __init__(self, units: Sequence[ServedUnit]) -> None:
        self._units = units
        self._open = sys.stdin is not None and sys.stdin.isatty()
        self._due_ns = 0
        self._take = _line_at_terminal if hasattr(os, "tcgetpgrp") else ConsoleLines().take

    def look(self) -> None:
        """Process the next line, if any; an invalid line prints a message and changes nothing."""
        if not self._open or wall_ns() < self._due_ns:
            return
        self._due_ns = wall_ns() + REFRESH_NS
        try:
            line = self._take()
        except OSError:  # the terminal is closed; its SIGHUP ends the service, unless it is ignored
            line = ""
        if line is None:
            return
        self._open = bool(line)
        try:
            if line.strip():
                wire(self._units, line.strip())
        except ValueError as error:
            complain(str(error))


def _line_at_terminal() -> str | None:
    """Return a typed line, or "" at the end of input; None without a line or in the background."""
    system: Any = os  # type checkers know these functions on POSIX only
    if system.tcgetpgrp(0) != system.getpgrp() or not select.select([0], [], [], 0)[0]:
        return None
    return sys.stdin.readline()


class ConsoleLines:
    """Lines typed at a Windows console; a thread reads them because `select` does not support consoles."""

    def __init__(self) -> None:
        self._lines: SimpleQueue[str] | None = None

    def take(self) -> str | None:
        """Return a typed line; "" at the end of input; None without a line."""
        if self._lines is None:
            self._lines = SimpleQueue()
            threading.Thread(target=self._read, args=(self._lines,), daemon=True).start()
        return None if self._lines.empty() else self._lines.get()

    def _read(self, lines: SimpleQueue[str]) -> None:
        """Put each typed line into the queue, and "" at the end of input."""
        # not `sys.stdin`: Python can't end while a thread is inside it
        typed = b""
        while data := os.read(0, 1 << 12):
            *lines_read, typed = (typed + data).split(b"\n")
            for line in lines_read:
                lines.put(line.decode("utf-8", "replace") + "\n")
        lines.put("")


@contextmanager
def recording(options: ServeOptions, units: Sequence[ServedUnit]) -> Iterator[LineRecorder | None]:
    """Record the line and the units if --record is given.

    Raises:
        OwnedError: the recording would replace an owned file.
        OSError: the recording can't be written.
    """
    path = options.record
    if path is None:
        yield None
        return
    keeping = None if options.replace else RecordingKeeper(path, KEPT_TRACES)
    check_recordings([path], keeping, options.programs_in_use)
    columns = [UnitColumns(unit.address, tuple(unit.values())) for unit in units]
    with closing(LineRecorder(path, columns, {"controller": options.controller}, keeping)) as recorder:
        yield recorder


@contextmanager
def shown_status(units: Sequence[ServedUnit], *, quiet: bool) -> Iterator[Callable[[], None]]:
    """Show the units' state if standard error is a terminal; yield the function that refreshes it."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda: None
        return
    due_ns = 0

    def refresh() -> None:
        nonlocal due_ns
        if wall_ns() >= due_ns:
            due_ns = wall_ns() + REFRESH_NS
            live.update(status_table(units), refresh=True)

    with Live(console=console, auto_refresh=False) as live:
        yield refresh


def _serve_command(
    context: typer.Context,
    options: ServeOptions,
) -> None:
    """Simulate a device on a port, or a 3601 as remote I/O, until Ctrl-C.

    The first line is the address of the device. On a terminal, the command shows the state, and NAME=STATE
    sets an input: ground, open, high, 2.5V at in1, or the positions at which a
    switch is closed: 9000.. or ..-3000 or 5..10. With several units: ADDRESS:NAME=STATE.

    Examples:
        scanrack serve pcl601 --tcp 5020 --program program.pclt

    Exit status: 130 ended by Ctrl-C, SIGTERM or SIGHUP, 2 an option, a file or a port can't be used, 3 the
    recording can't be written.
    """
    with reported_mistakes(), ExitStack() as stack:
        check_options(context, options.controller)
        if options.controller is ServedDevice.AMCI3601:
            raise typer.Exit(serve_remote(options))
        clock, memory_kept = Clock(options.speed), None
        if options.memory is not None:
            memory = ControllerMemory(options.memory, options.controller, options.programs_in_use)
            memory_kept = stack.enter_context(memory)
        line = (
            _make_drives(options, clock, memory_kept)
            if options.controller in MODELS
            else _make_line(options, memory_kept)
        )
        units = line.units
        choice = PortChoice(
            options.pty,
            options.serial,
            options.tcp,
            options.rtu_over_tcp,
            options.ethernet_ip,
            options.io_port,
        )
        # Ctrl-C may come between the line with the address and the first step
        with (
            recording(options, units) as recorder,
            _control_channel(line, clock, options.control) as channel,
            suppress(KeyboardInterrupt),
        ):
            server, place = line.server(choice, clock, recorder)
            _record(units, clock, recorder)  # before anything can end it
            also = "" if channel is None else f"; control at {channel.name}; key {channel.key}"
            say(f"{place}  {line.title}{also}; Ctrl-C ends")
            sys.stdout.flush()  # a reader of the path through a pipe waits for it
            _serve(server, units, clock, _Watchers(recorder, channel, memory_kept), quiet=options.quiet)
        if memory_kept is not None:
            memory_kept.look()
        raise typer.Exit(INTERRUPTED)


def _make_drives(options: ServeOptions, clock: Clock, memory: ControllerMemory | None) -> LineService:
    """Make the drives that the options specify."""
    model = MODELS[options.controller]
    service = DriveService(model, clock, options.axes, options.machine or (), memory)
    for pin in options.pin or ():
        wire(service.units, pin)
    return service


def _make_line(options: ServeOptions, memory: ControllerMemory | None) -> LineService:
    """Make the controllers that the options specify, on their line."""
    usual_ms = PORT_GAP_MS if options.serial is None else SERIAL_GAP_MS
    gap = usual_ms if options.gap_ms is None else options.gap_ms
    addresses = addresses_in(options.address or []) or ([] if memory is None else memory.addresses)
    units = MAKERS[options.controller](
        addresses, options.program or [], options.speed, options.thumbwheel or [], gap
    )
    if memory is not None:
        memory.restore(units, addressed=bool(options.address))
    units = on_machines(units, options.machine or [])
    for option in options.pin or []:
        wire(units, option)
    begin(units, ascii_mode=options.ascii_mode, start=options.start)
    line = ServedLine(
        units,
        options.controller,
        timed=options.line_time,
        faulty=bool(options.fault) or options.control is not None,
        gateway_ms=options.gateway_ms,
    )
    for option in options.fault or []:
        line.set_fault(option)
    return line


class _Watchers(NamedTuple):
    """The observers of the units while they are served."""

    recorder: LineRecorder | None
    channel: ControlChannel | None
    memory: ControllerMemory | None


@contextmanager
def _control_channel(line: LineService, clock: Clock, port: int | None) -> Iterator[ControlChannel | None]:
    """Open the control channel on a port; yield None without a port."""
    if port is None:
        yield None
        return
    with closing(ControlChannel(line, clock, port)) as channel:
        yield channel


def _serve(
    server: Server, units: Sequence[ServedUnit], clock: Clock, watchers: _Watchers, *, quiet: bool
) -> None:
    """Serve until Ctrl-C; after each step, refresh the status, obey a typed line, and record."""
    typed = TypedInputs(units)

    def each_step() -> None:
        refresh()
        typed.look()
        if watchers.channel is not None:
            watchers.channel.look()
        _record(units, clock, watchers.recorder)
        if watchers.memory is not None:
            watchers.memory.look()

    with shown_status(units, quiet=quiet) as refresh:
        each_step()  # the initial state
        is_unwatched = all(watcher is None for watcher in watchers)
        serve_until_interrupted(server, each_step, longest_s=LONGEST_S if is_unwatched else LOOKED_EVERY_S)


def _record(units: Sequence[ServedUnit], clock: Clock, recorder: LineRecorder | None) -> None:
    """Record the units' current state, and write it to the file so that a kill does not lose it."""
    if recorder is not None:
        recorder.draft()
        now_ns = clock.now_ns()
        for unit in units:
            recorder.unit(now_ns, unit.address, unit.values())


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("serve", no_args_is_help=True)(grouped(_serve_command, options=ServeOptions))
