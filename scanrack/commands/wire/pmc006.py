"""`scanrack device pmc006`: read, set and move a real or simulated PMC006x3s."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntFlag
from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.pmc006.program import UserProgram
from scanrack.io_images.pmc006.status import Level
from scanrack.jobs.run.served_units import user_program
from scanrack.runtime.line.clients.link import Link, Progress
from scanrack.runtime.line.clients.pmc006 import BY_ZERO, READABLE, SETTABLE, Pmc006Client
from scanrack.runtime.line.pmc006_frames import LINE_FORMAT
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.status import complain
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
    reported_faults,
    search_home,
    show_state,
)

app = typer.Typer(
    help="Read, set and move a PMC006x3s on a serial port.\n\n"
    "Examples:\n    scanrack device pmc006 --serial /dev/ttyUSB0 --address 1 move 2000",
    no_args_is_help=True,
    rich_markup_mode=None,
)
programs = typer.Typer(help="User programs.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(programs, name="program")


@contextmanager
def client_at(context: typer.Context) -> Iterator[Pmc006Client]:
    """Open the port given by the group's options; report a failure."""
    link_place: LinkPlace
    link_place, by_zero = context.obj

    def client_on(link: Link) -> Pmc006Client:
        return Pmc006Client(link, link_place.address, answer_s=link_place.answer_s, by_zero=by_zero)

    with opened_client(lambda: link_place.open(LINE_FORMAT), client_on) as client:
        yield client


@app.callback()
def _set_link(
    context: typer.Context,
    port: PortOption = None,
    tcp: Annotated[
        str | None,
        typer.Option("--tcp", metavar="HOST:PORT", help="Serial bytes over TCP instead of a serial port."),
    ] = None,
    address: Annotated[
        int, typer.Option("--address", metavar="N", help="Address, 1 to 120, or 255, the factory address.")
    ] = 255,
    timeout: TimeoutOption = TIMEOUT_S,
    by_zero: Annotated[
        bool,
        typer.Option(
            "--by-zero",
            help=f"Also read {', '.join(BY_ZERO)} by their setting instructions with data 0. "
            "By the manual, some of these instructions then read [4.1.1]; the others set 0.",
        ),
    ] = False,
) -> None:
    context.obj = LinkPlace(port, tcp, address, timeout), by_zero


@app.command()
def status(context: typer.Context) -> None:
    """Show position, status registers, pins and parameters that can be read.

    It sends only read instructions. With --by-zero before the command, it also shows the speeds, the current
    and the encoder counts.
    """
    with client_at(context) as client:
        show_state(_state(client))


def _state(client: Pmc006Client) -> Iterator[tuple[str, str]]:
    """Yield the rows of `status`: decoded values, then all others that can be read."""
    yield "position", f"{client.position:,} steps"
    yield "status 1", _names(client.status1)
    yield "status 2", _names(client.status2)
    yield "pins high", _names(Level(client.read("levels") & 0xF))
    yield "firmware", client.firmware
    for name in client.readable:
        if name not in ("position", "status1", "status2", "levels", "firmware"):
            yield name, _shown(name, client.read(name))


def _names(bits: IntFlag) -> str:
    return " ".join(str(bit.name) for bit in bits) or "-"


def _shown(name: str, value: int) -> str:
    row = SETTABLE.get(name) or READABLE[name]
    return f"{value:,} {row.unit}".rstrip()


add_read(app, client_at, "Print one value, such as position or microstepping.")


@app.command("set")
def set_parameter(
    context: typer.Context,
    name: NameArgument,
    value: ValueArgument,
    keep: Annotated[bool, typer.Option("--save", help="Also save all parameters to the EEPROM.")] = False,
) -> None:
    """Set a parameter; put -- before a negative VALUE."""
    with client_at(context) as client:
        client.set(name, value)
        if keep:
            client.save()


@app.command()
def save(context: typer.Context) -> None:
    """Save the parameters to the EEPROM, which allows a limited number of writes."""
    with client_at(context) as client:
        client.save()


add_move(app, client_at, "scanrack device pmc006 --serial /dev/ttyUSB0 move --speed 4000 -- -2000")


@app.command()
def home(
    context: typer.Context,
    stroke: Annotated[
        int, typer.Option("--stroke", metavar="STEPS", help="Maximum travel.", show_default=False)
    ],
    speed: Annotated[
        int | None, typer.Option("--speed", metavar="V", help="Speed back to zero, steps/s.")
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Home to the switch on EXT1; Ctrl-C stops the motor at once."""
    with client_at(context) as client:

        def find(progress: Progress) -> int:
            if speed is not None:
                client.set("zero_back_speed", speed)
            return client.home(stroke, progress)

        search_home(client, find, quiet=quiet)


add_stop_and_clear(
    app, client_at, "Stop at once, without a ramp.", "Clear the emergency stops of EXT1 and EXT2."
)


def _listing(file: Path) -> UserProgram:
    """Assemble a listing, and print its warnings."""
    program = user_program(file)
    for warning in program.warnings:
        complain(f"{file}: {warning}")
    return program


@programs.command("check")
def check(file: ProgramArgument) -> None:
    """Assemble a listing and print the program, line by line."""
    with reported_faults():
        for number, line in enumerate(_listing(file).lines):
            say(f"{number:3}  {line}")


add_write(
    programs,
    lambda file: len(_listing(file).lines),
    "the frames that write a program into a PMC006 are not documented: load it with the maker's tool, "
    "or into the simulated controller with scanrack serve pmc006 --program",
)
