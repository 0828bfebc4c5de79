"""The options of `scanrack serve`, and the options of each device."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.drives.models import MODELS
from scanrack.io_images.enip.io_frames import IO_PORT
from scanrack.jobs.serve.line import GATEWAY_MS
from scanrack.jobs.serve.remote import SILENCE_MS
from scanrack.terminal.shared_options import QuietOption, ReplaceOption


class ServedDevice(StrEnum):
    """A simulated device that can be served."""

    AMCI3601 = "amci3601"
    PCL601 = "pcl601"
    PMC006 = "pmc006"
    SMD23E2 = "smd23e2"
    SMD24E2 = "smd24e2"
    SD17060E2 = "sd17060e2"
    ANG1 = "ang1"
    ANF2 = "anf2"


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


def check_options(context: typer.Context, controller: ServedDevice) -> None:
    """Refuse the options that this device does not have.

    Raises:
        ValueError: such an option was given.
    """
    for param in context.command.params:
        source = context.get_parameter_source(param.name or "")
        is_given = source is not None and source.name == "COMMANDLINE"
        if is_given and not _has_option(controller, param.name or ""):
            raise ValueError(f"{param.opts[0]}: {controller} does not have it")


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
        float, typer.Option("--time-scale", metavar="FACTOR", help="Speed relative to real time.")
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
            help="File of the nonvolatile memory of the controllers: address, stored program, parameters.",
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
        typer.Option("--slot", metavar="N", help="amci3601: its slot, if the rack has several."),
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
        typer.Option("--line-time", help="Characters also take the time of the baud rate on TCP and ptys."),
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
            help="Port of this machine for JSON lines of faults and inputs, after the printed key.",
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

    @property
    def programs_in_use(self) -> dict[Path, str]:
        """The stored programs, which no output may replace, each with its role."""
        return dict.fromkeys(self.program or (), "a stored program")
