"""`scanrack device pcl601`: read, set and move a real or simulated PCL601."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Annotated

import typer
from scanrack.io_images.pcl601 import Code
from scanrack.io_images.pcl601.errors import CAUSES
from scanrack.jobs.serve.line import socket_address
from scanrack.runtime.controllers.pcl601.controller import Protocol
from scanrack.runtime.controllers.pcl601.line import FORMATS
from scanrack.runtime.controllers.pcl601.program import read_program
from scanrack.runtime.line.clients.link import checked_answer_s
from scanrack.runtime.line.clients.modbus import ModbusLine, RtuLine
from scanrack.runtime.line.clients.modbus_tcp import ModbusTcpLine
from scanrack.runtime.line.clients.pcl601 import READABLE, Pcl601Client
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.terminal import say

from .link_commands import (
    TIMEOUT_S,
    LinkPlace,
    NameArgument,
    PortOption,
    ProgramArgument,
    TimeoutOption,
    ValueArgument,
    add_move,
    add_read,
    add_stop_and_clear,
    add_write,
    opened_client,
    search_home,
    show_state,
)
from .pclt import listing

app = typer.Typer(
    help="Read, set and move a PCL601 over Modbus.\n\n"
    "Examples:\n    scanrack device pcl601 --serial /dev/ttyUSB0 --address 1 move 2000",
    no_args_is_help=True,
    rich_markup_mode=None,
)
programs = typer.Typer(
    help="Check, list, write and run stored programs.", no_args_is_help=True, rich_markup_mode=None
)
app.add_typer(programs, name="program")


@contextmanager
def client_at(context: typer.Context) -> Iterator[Pcl601Client]:
    """Open the line given by the group's options; report a failure."""
    link_place: LinkPlace
    link_place, rtu_over_tcp = context.obj

    def open_line() -> ModbusLine:
        answer_s = checked_answer_s(link_place.answer_s)
        if link_place.tcp is not None and link_place.port is None and not rtu_over_tcp:
            return ModbusTcpLine(*socket_address(link_place.tcp), answer_s)
        # `open` raises ValueError unless exactly one of port and TCP address is given
        return RtuLine(link_place.open(FORMATS[Protocol.MODBUS]), answer_s)

    with opened_client(open_line, lambda line: Pcl601Client(line, link_place.address)) as client:
        yield client


@app.callback()
def _set_link(
    context: typer.Context,
    port: PortOption = None,
    tcp: Annotated[
        str | None, typer.Option("--tcp", metavar="HOST:PORT", help="Modbus TCP instead of a serial port.")
    ] = None,
    rtu_over_tcp: Annotated[
        bool, typer.Option("--rtu-over-tcp", help="With --tcp: serial bytes instead of Modbus TCP.")
    ] = False,
    address: Annotated[int, typer.Option("--address", metavar="N", help="Address, 1 to 99.")] = 1,
    timeout: TimeoutOption = TIMEOUT_S,
) -> None:
    context.obj = LinkPlace(port, tcp, address, timeout), rtu_over_tcp


@app.command()
def status(context: typer.Context) -> None:
    """Show position, motion, errors, inputs, outputs and all registers."""
    with client_at(context) as client:
        show_state(_state(client))


def _state(client: Pcl601Client) -> Iterator[tuple[str, str]]:
    """Yield the rows of `status`: decoded registers, then all others as numbers."""
    yield "motion", "moving" if client.busy else "idle"
    errors = client.errors
    yield "errors", "; ".join(f"{error.name}: {CAUSES[error]}" for error in errors) or "-"
    yield "inputs active", f"{client.inputs:b}"
    yield "outputs on", f"{client.outputs:08b}"
    yield "firmware", client.firmware
    for name, row in READABLE.items():
        if name not in ("command", "busy", "error_code", "firmware"):
            yield name, f"{client.read(name):,}  ({row.meaning})"


add_read(app, client_at, "Print one register, such as position or base_speed.")


@app.command("set")
def set_register(
    context: typer.Context,
    name: NameArgument,
    value: ValueArgument,
) -> None:
    """Set a register; put -- before a negative VALUE."""
    with client_at(context) as client:
        client.set(name, value)


@app.command()
def output(
    context: typer.Context,
    number: Annotated[int, typer.Argument(metavar="N", show_default=False)],
    on: Annotated[bool, typer.Option("--on/--off", help="Whether it is on.")] = True,
) -> None:
    """Switch output N, 1 to 8."""
    with client_at(context) as client:
        client.set_output(number, on)


add_move(app, client_at, "scanrack device pcl601 --tcp 192.168.0.9:502 move --speed 4000 -- -2000")


@app.command()
def home(
    context: typer.Context,
    kind: Annotated[int, typer.Option("--type", metavar="0|1", help="Home type of the manual.")] = 1,
    quiet: QuietOption = False,
) -> None:
    """Home the axis; Ctrl-C stops the motor at once."""
    with client_at(context) as client:
        search_home(client, partial(client.home, kind), quiet=quiet)


add_stop_and_clear(app, client_at, "Stop motion and program at once.", "Clear the error register.")


@programs.command("run")
def run_program(context: typer.Context) -> None:
    """Start the stored program."""
    with client_at(context) as client:
        client.command(Code.RUN_PROGRAM)


@programs.command("list", no_args_is_help=True)
def list_program(file: ProgramArgument) -> None:
    """Print a program line by line: address and size in program memory (bytes), and the instruction.

    The sizes apply to this simulator; for the real unit, only "2 to 7 bytes" is published.

    Examples:
        scanrack device pcl601 program list program.pclt
    """
    with reported_mistakes():
        say(listing(read_program(file)), whole=True)


add_write(
    programs,
    lambda file: len(read_program(file).steps),
    "how a program is written into a PCL601 is not documented: load it with the maker's tool, "
    "or into the simulated controller with scanrack serve pcl601 --program",
)
