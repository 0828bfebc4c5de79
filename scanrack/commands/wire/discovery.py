"""`scanrack device list` and `scanrack device identify PORT`: list serial ports, and identify a device."""

from __future__ import annotations

from functools import partial
from itertools import islice
from typing import Annotated

import typer
from rich.progress import BarColumn, TextColumn
from scanrack.jobs.run.served_units import addresses_in
from scanrack.runtime.line.clients.probing import probe, questions
from scanrack.runtime.line.liveport import open_port
from scanrack.terminal.bars import shown_bar
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.status import NO, complain
from scanrack.terminal.terminal import say
from serial.tools.list_ports import comports

from .link_commands import reported_faults


def list_command() -> None:
    """List the serial ports.

    Examples:
        scanrack device list

    Exit status: 0 listed, 1 no serial port.
    """
    devices = sorted(comports(), key=lambda port: port.device)
    for device in devices:
        descriptions = [text for text in (device.description, device.manufacturer) if text and text != "n/a"]
        say("  ".join([device.device, *descriptions]))
    if not devices:
        raise typer.Exit(complain("no serial device", NO))


def identify_command(
    port: Annotated[
        str,
        typer.Argument(metavar="PORT", help="Serial device, or tcp:HOST:PORT.", show_default=False),
    ],
    address: Annotated[
        list[str] | None,
        typer.Option("--address", metavar="N", help="Only this address, or a range 1-5; repeatable."),
    ] = None,
    everyone: Annotated[bool, typer.Option("--all", help="Continue after the first response.")] = False,
    quiet: QuietOption = False,
) -> None:
    """Identify the device on a port.

    The search finds a PCL601 in Modbus RTU or ASCII, or a PMC006, and its address.

    The requests only read: they change nothing, and nothing moves. Without a response, the search takes about
    25 s; with --address, it takes less time.

    Examples:
        scanrack device identify /dev/ttyUSB0

    Exit status: 0 a device responds, 1 no device responds or the line fails, 2 an address or PORT is invalid.
    """
    with reported_faults():
        addresses = addresses_in(address) if address else None
        columns = TextColumn("asking {task.description}"), BarColumn()
        with shown_bar(*columns, quiet=quiet, total=lambda: questions(addresses)) as update:

            def show(language: str, number: int) -> None:
                update(advance=1, description=f"{language} {number}" if number else language)

            found_devices = probe(partial(open_port, port), addresses, show)
            devices = list(found_devices if everyone else islice(found_devices, 1))
    for device in devices:
        say(device)
    if not devices:
        raise typer.Exit(complain(f"no device responds on {port}", NO))
