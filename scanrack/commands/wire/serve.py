"""`scanrack serve CONTROLLER`: a simulated controller at a port, in step with the wall clock."""

from __future__ import annotations

import os
import select
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from queue import SimpleQueue
from typing import Annotated, Any, NamedTuple

import typer
from rich.console import Console
from rich.live import Live
from rich.table import Table
from scanrack.io_images.drives.models import MODELS
from scanrack.io_images.enip.io_frames import IO_PORT
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
from scanrack.jobs.serve.line import GATEWAY_MS, LineService, PortChoice, ServedLine, begin, wire
from scanrack.jobs.serve.machines import on_machines
from scanrack.jobs.serve.memory_file import ControllerMemory
from scanrack.jobs.serve.remote import SILENCE_MS
from scanrack.runtime.config.rackspec import KEPT_TRACES
from scanrack.runtime.line.ports import LONGEST_S, Server, serve_until_interrupted
from scanrack.runtime.loop.pace import Clock, wall_ns
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.shared_options import QuietOption, ReplaceOption
from scanrack.terminal.status import INTERRUPTED, complain
from scanrack.terminal.tables import Cells
from scanrack.terminal.terminal import say
from scanrack.traces.files.keeping import RecordingKeeper, check_recordings
from scanrack.traces.write.line import LineRecorder, UnitColumns

from .serve_remote import RemoteOptions, serve_remote

LOOKED_EVERY_S = 0.01
"""Longest time between two records of changing registers, or two looks at the control channel."""

REFRESH_NS = 250_000_000
"""Time between two refreshes of the status."""


class ServedDevice(StrEnum):
    """What can be served."""

    AMCI3601 = "amci3601"
    PCL601 = "pcl601"
    PMC006 = "pmc006"
    SMD23E2 = "smd23e2"
    SMD24E2 = "smd24e2"
    SD17060E2 = "sd17060e2"
    ANG1 = "ang1"
    ANF2 = "anf2"


MAKERS: dict[ServedDevice, Callable[[list[int], list[Path], float, list[str], float], list[Unit]]] = {
    ServedDevice.PCL601: pcl601_units,
    ServedDevice.PMC006: pmc006_units,
}


def status_table(units: Sequence[ServedUnit]) -> Table:
    """Return the state of the units, one row for each."""
    rows = [unit.status() for unit in units]
    table = Cells(*rows[0], box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row.values())
    return table


class TypedInputs:
    """Lines typed during the service: each sets an input."""

    def __init__(self, units: Sequence[ServedUnit]) -> None:
        self._units = units
        self._open = sys.stdin is not None and sys.stdin.isatty()
        self._due_ns = 0
        self._take = _line_at_terminal if hasattr(os, "tcgetpgrp") else ConsoleLines().take

    def look(self) -> None:
        """Process a line, if there is one; a mistake prints a message and changes nothing."""
        if not self._open or wall_ns() < self._due_ns:
            return
        self._due_ns = wall_ns() + REFRESH_NS
        try:
            line = self._take()
        except OSError:  # the terminal has been closed: its SIGHUP ends the service, unless it is ignored
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
    """Return a typed line, empty at the end; None if there is none, or this process is in the background."""
    system: Any = os  # type checkers know these functions on POSIX only
    if system.tcgetpgrp(0) != system.getpgrp() or not select.select([0], [], [], 0)[0]:
        return None
    return sys.stdin.readline()


class ConsoleLines:
    """Lines typed at a console of Windows, which `select` does not take: a thread waits for them."""

    def __init__(self) -> None:
        self._lines: SimpleQueue[str] | None = None

    def take(self) -> str | None:
        """Return a typed line, empty at the end; None if there is none."""
        if self._lines is None:
            self._lines = SimpleQueue()
            threading.Thread(target=self._read, args=(self._lines,), daemon=True).start()
        return None if self._lines.empty() else self._lines.get()

    def _read(self, lines: SimpleQueue[str]) -> None:
        # not `sys.stdin`: Python can't end while a thread is inside it
        typed = b""
        while data := os.read(0, 1 << 12):
            *whole, typed = (typed + data).split(b"\n")
            for each in whole:
                lines.put(each.decode("utf-8", "replace") + "\n")
        lines.put("")


@contextmanager
def recording(
    path: Path | None,
    controller: str,
    units: Sequence[ServedUnit],
    programs: Sequence[Path],
    *,
    replace: bool,
) -> Iterator[LineRecorder | None]:
    """Record the line and the units into a file, if there is a path.

    Args:
        replace: keep no earlier recordings.

    Raises:
        OwnedError: it would replace an owned file.
        OSError: it can't be written.
    """
    if path is None:
        yield None
        return
    used = dict.fromkeys(programs, "a stored program")
    keeping = None if replace else RecordingKeeper(path, KEPT_TRACES)
    check_recordings([path], keeping, used)
    columns = [UnitColumns(unit.address, tuple(unit.values())) for unit in units]
    with closing(LineRecorder(path, columns, {"controller": controller}, keeping)) as recorder:
        yield recorder


@contextmanager
def shown_status(units: Sequence[ServedUnit], *, quiet: bool) -> Iterator[Callable[[], None]]:
    """Show the units' state on standard error, if that is a terminal; yield the refresh function."""
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


FOR_ALL = ("controller", "tcp", "record", "replace", "quiet")
REMOTE_ONLY = ("rack", "slot", "silence", "whole")
DRIVES_ONLY = ("axes", "ethernet_ip", "io_port")
ALSO_DRIVES = ("speed", "machine", "memory", "pin", "control")


def _has_option(controller: ServedDevice, name: str) -> bool:
    if controller in MODELS:
        return name in (*FOR_ALL, *DRIVES_ONLY, *ALSO_DRIVES)
    if controller is ServedDevice.AMCI3601:
        return name in (*FOR_ALL, *REMOTE_ONLY)
    return name not in (*REMOTE_ONLY, *DRIVES_ONLY)


def _check_options(context: typer.Context, controller: ServedDevice) -> None:
    """Refuse an option that this device does not have.

    Raises:
        ValueError: such an option was given.
    """
    for each in context.command.params:
        source = context.get_parameter_source(each.name or "")
        given = source is not None and source.name == "COMMANDLINE"
        if given and not _has_option(controller, each.name or ""):
            raise ValueError(f"{each.opts[0]}: {controller} does not have it")


@dataclass(frozen=True, slots=True, kw_only=True)
class ServeOptions:
    """The argument and the options of `scanrack serve`."""

    controller: Annotated[
        ServedDevice,
        typer.Argument(
            metavar="DEVICE",
            help="amci3601, pcl601, pmc006, smd23e2, smd24e2, sd17060e2, ang1 or anf2.",
            show_default=False,
        ),
    ]
    rack: Annotated[
        str | None,
        typer.Argument(
            metavar="[RACK]", help="amci3601: rack file with the module and its machine.", show_default=False
        ),
    ] = None
    pty: Annotated[bool, typer.Option("--pty", help="On a pseudo-terminal, whose path is printed.")] = False
    serial: Annotated[
        str | None, typer.Option("--serial", metavar="DEVICE", help="On a serial port of this machine.")
    ] = None
    tcp: Annotated[
        str | None,
        typer.Option(
            "--tcp", metavar="[HOST:]PORT", help="Over TCP; on the loopback address unless a host is given."
        ),
    ] = None
    rtu_over_tcp: Annotated[
        bool, typer.Option("--rtu-over-tcp", help="With --tcp: the line's own bytes, not Modbus TCP.")
    ] = False
    address: Annotated[
        list[str] | None,
        typer.Option("--address", metavar="N", help="Address; several, or 1-5, for several units on a line."),
    ] = None
    program: Annotated[
        list[Path] | None,
        typer.Option("--program", metavar="FILE", help="A stored program, as if saved earlier."),
    ] = None
    speed: Annotated[
        float, typer.Option("--time-scale", metavar="FACTOR", help="How many times as fast as real time.")
    ] = 1.0
    machine: Annotated[
        list[str] | None,
        typer.Option(
            "--machine",
            metavar="RACK",
            help="The machine in a rack file moves with the motor and acts on the inputs; of several 2:RACK.",
        ),
    ] = None
    memory: Annotated[
        Path | None,
        typer.Option(
            "--memory",
            metavar="FILE",
            help="What the controllers keep without power: address, stored program, parameters.",
        ),
    ] = None
    pin: Annotated[
        list[str] | None,
        typer.Option("--pin", metavar="NAME=STATE", help="State of an input: in1=ground, home=..-3000."),
    ] = None
    thumbwheel: Annotated[
        list[str] | None,
        typer.Option("--thumbwheel", metavar="DIGITS", help="PCL601: a thumbwheel; of several 2:DIGITS."),
    ] = None
    gap_ms: Annotated[
        float | None,
        typer.Option(
            "--gap-ms",
            metavar="MS",
            help="PCL601: silence after which another frame may begin; 5, on a serial port 25.",
        ),
    ] = None
    axes: Annotated[int, typer.Option("--axes", metavar="N", help="Drives: axes in the stack, up to 12.")] = 1
    ethernet_ip: Annotated[
        str | None,
        typer.Option(
            "--ethernet-ip",
            metavar="[HOST:]PORT",
            help="SMD23E2: EtherNet/IP, usually at 44818.",
        ),
    ] = None
    io_port: Annotated[
        int,
        typer.Option("--io-port", metavar="PORT", min=0, max=65535, help="UDP port of its class 1 packets."),
    ] = IO_PORT
    slot: Annotated[
        int | None,
        typer.Option("--slot", metavar="N", help="amci3601: its slot, if the rack has several of them."),
    ] = None
    silence: Annotated[
        float,
        typer.Option("--silence", metavar="MS", help="amci3601: time without a write that ends run mode."),
    ] = SILENCE_MS
    whole: Annotated[
        bool, typer.Option("--whole-writes", help="amci3601: refuse writes of fewer than eight words.")
    ] = False
    line_time: Annotated[
        bool,
        typer.Option("--line-time", help="Characters take the time of the baud rate on TCP and ptys, too."),
    ] = False
    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="FAULT",
            help="A fault of the line: drop=N, drop=N/M, crc=N, crc=N/M, delay=MS or silence=on.",
        ),
    ] = None
    gateway_ms: Annotated[
        float,
        typer.Option(
            "--gateway-ms",
            metavar="MS",
            help="With --line-time, --fault or --test-port: time to exception 0Bh over Modbus TCP.",
        ),
    ] = GATEWAY_MS
    control: Annotated[
        int | None,
        typer.Option(
            "--test-port",
            metavar="PORT",
            min=0,
            max=65535,
            help="A port of this machine for JSON lines of faults and inputs, the printed key first.",
        ),
    ] = None
    record: Annotated[
        Path | None, typer.Option("--record", metavar="FILE", help="Record line and registers as MCAP.")
    ] = None
    replace: ReplaceOption = False
    ascii_mode: Annotated[
        bool, typer.Option("--ascii", help="PCL601: the line is in AA ASCII, as after code 11.")
    ] = False
    start: Annotated[
        bool, typer.Option("--start", help="PCL601: stored programs are started, as by SMC60WIN.")
    ] = False
    quiet: QuietOption = False


def _serve_command(
    context: typer.Context,
    options: ServeOptions,
) -> None:
    """Simulate a device on a port, or a 3601 as remote I/O, until Ctrl-C.

    The first line printed says where it is to be found. On a terminal its state is shown meanwhile, and
    inputs change by typing NAME=STATE: ground, open, high, 2.5V at in1, or the positions at which a
    switch is closed: 9000.. or ..-3000 or 5..10. With several units: ADDRESS:NAME=STATE.

    Example: scanrack serve pcl601 --tcp 5020 --program program.pclt

    Exit status: 130 ended by Ctrl-C, SIGTERM or SIGHUP, 2 an option, a file or a port can't be used, 3 the
    recording can't be written.
    """
    with reported_mistakes(), ExitStack() as stack:
        _check_options(context, options.controller)
        if options.controller is ServedDevice.AMCI3601:
            remote = RemoteOptions(
                options.rack,
                options.tcp,
                options.slot,
                options.silence,
                options.whole,
                options.record,
                options.replace,
                options.quiet,
            )
            raise typer.Exit(serve_remote(remote))
        clock, kept = Clock(options.speed), None
        if options.memory is not None:
            used = dict.fromkeys(options.program or (), "a stored program")
            kept = stack.enter_context(ControllerMemory(options.memory, options.controller, used))
        line = _drives(options, clock, kept) if options.controller in MODELS else _line(options, kept)
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
            recording(
                options.record, options.controller, units, options.program or (), replace=options.replace
            ) as recorder,
            _controlled(line, clock, options.control) as channel,
            suppress(KeyboardInterrupt),
        ):
            server, place = line.server(choice, clock, recorder)
            _record(units, clock, recorder)  # before anything can end it
            also = "" if channel is None else f"; control at {channel.name}; key {channel.key}"
            say(f"{place}  {line.title}{also}; Ctrl-C ends")
            sys.stdout.flush()  # a reader of the path through a pipe waits for it
            _serve(server, units, clock, _Watchers(recorder, channel, kept), quiet=options.quiet)
        if kept is not None:
            kept.look()
        raise typer.Exit(INTERRUPTED)


def _drives(options: ServeOptions, clock: Clock, kept: ControllerMemory | None) -> LineService:
    """Make the drives of the options."""
    model = MODELS[options.controller]
    service = DriveService(model, clock, options.axes, options.machine or (), kept)
    for each in options.pin or ():
        wire(service.units, each)
    return service


def _line(options: ServeOptions, kept: ControllerMemory | None) -> LineService:
    """Make the controllers of the options, on their line."""
    usual_ms = PORT_GAP_MS if options.serial is None else SERIAL_GAP_MS
    gap = usual_ms if options.gap_ms is None else options.gap_ms
    addresses = addresses_in(options.address or []) or ([] if kept is None else kept.addresses)
    units = MAKERS[options.controller](
        addresses, options.program or [], options.speed, options.thumbwheel or [], gap
    )
    if kept is not None:
        kept.restore(units, addressed=bool(options.address))
    units = on_machines(units, options.machine or [])
    for each in options.pin or []:
        wire(units, each)
    begin(units, ascii_mode=options.ascii_mode, start=options.start)
    line = ServedLine(
        units,
        options.controller,
        timed=options.line_time,
        faulty=bool(options.fault) or options.control is not None,
        gateway_ms=options.gateway_ms,
    )
    for each in options.fault or []:
        line.set_fault(each)
    return line


class _Watchers(NamedTuple):
    """What looks at the units while they are served."""

    recorder: LineRecorder | None
    channel: ControlChannel | None
    memory: ControllerMemory | None


@contextmanager
def _controlled(line: LineService, clock: Clock, port: int | None) -> Iterator[ControlChannel | None]:
    """Open the control channel, if there is a port."""
    if port is None:
        yield None
        return
    with closing(ControlChannel(line, clock, port)) as channel:
        yield channel


def _serve(
    server: Server, units: Sequence[ServedUnit], clock: Clock, watchers: _Watchers, *, quiet: bool
) -> None:
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
        calm = all(each is None for each in watchers)
        serve_until_interrupted(server, each_step, longest_s=LONGEST_S if calm else LOOKED_EVERY_S)


def _record(units: Sequence[ServedUnit], clock: Clock, recorder: LineRecorder | None) -> None:
    """Record the present state of the units, and flush it, so that it survives a kill."""
    if recorder is not None:
        recorder.draft()
        now_ns = clock.now_ns()
        for unit in units:
            recorder.unit(now_ns, unit.address, unit.values())


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("serve", no_args_is_help=True)(grouped(_serve_command, options=ServeOptions))
