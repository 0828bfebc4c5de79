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


def _supports(controller: ServedDevice, name: str) -> bool:
    if controller in MODELS:
        return name in (*FOR_ALL, *DRIVES_ONLY, *ALSO_DRIVES)
    if controller is ServedDevice.AMCI3601:
        return name in (*FOR_ALL, *REMOTE_ONLY)
    return name not in (*REMOTE_ONLY, *DRIVES_ONLY)


def check_options(context: typer.Context, controller: ServedDevice) -> None:
    """Raise ValueError if an option is given that the device does not support."""
    for param in context.command.params:
        source = context.get_parameter_source(param.name or "")
        is_given = source is not None and source.name == "COMMANDLINE"
        if is_given and not _supports(controller, param.name or ""):
            raise ValueError(f"{param.opts[0]}: not supported by {controller}")


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
    pty: Annotated[bool, typer.Option("--pty", help="Serve on a pseudo-terminal; print its path.")] = False
    serial: Annotated[
        str | None, typer.Option("--serial", metavar="DEVICE", help="Serve on a serial port.")
    ] = None
    tcp: Annotated[
        str | None,
        typer.Option(
            "--tcp", metavar="[HOST:]PORT", help="Serve over TCP; without a host, on the loopback address."
        ),
    ] = None
    rtu_over_tcp: Annotated[
        bool, typer.Option("--rtu-over-tcp", help="With --tcp: serial bytes instead of Modbus TCP.")
    ] = False
    address: Annotated[
        list[str] | None,
        typer.Option("--address", metavar="N", help="Address, or a range 1-5 for several units; repeatable."),
    ] = None
    program: Annotated[
        list[Path] | None,
        typer.Option("--program", metavar="FILE", help="Stored program in the controller's memory."),
    ] = None
    speed: Annotated[
        float, typer.Option("--time-scale", metavar="FACTOR", help="Speed relative to real time.")
    ] = 1.0
    machine: Annotated[
        list[str] | None,
        typer.Option(
            "--machine",
            metavar="RACK",
            help="Connect the machine of a rack file; for one of several units 2:RACK.",
        ),
    ] = None
    memory: Annotated[
        Path | None,
        typer.Option(
            "--memory",
            metavar="FILE",
            help="File of the nonvolatile memory: address, stored program, parameters.",
        ),
    ] = None
    pin: Annotated[
        list[str] | None,
        typer.Option("--pin", metavar="NAME=STATE", help="State of an input: in1=ground, home=..-3000."),
    ] = None
    thumbwheel: Annotated[
        list[str] | None,
        typer.Option(
            "--thumbwheel", metavar="DIGITS", help="PCL601: thumbwheel; for one of several 2:DIGITS."
        ),
    ] = None
    gap_ms: Annotated[
        float | None,
        typer.Option(
            "--gap-ms",
            metavar="MS",
            help="PCL601: silence between frames [default: 5, on a serial port 25].",
        ),
    ] = None
    axes: Annotated[int, typer.Option("--axes", metavar="N", help="Drives: axes of the stack, 1 to 12.")] = 1
    ethernet_ip: Annotated[
        str | None,
        typer.Option(
            "--ethernet-ip",
            metavar="[HOST:]PORT",
            help="SMD23E2: serve EtherNet/IP, usually on port 44818.",
        ),
    ] = None
    io_port: Annotated[
        int,
        typer.Option(
            "--io-port", metavar="PORT", min=0, max=65535, help="SMD23E2: UDP port of class 1 packets."
        ),
    ] = IO_PORT
    slot: Annotated[
        int | None,
        typer.Option("--slot", metavar="N", help="amci3601: slot, if the rack has several 3601s."),
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
        typer.Option("--line-time", help="Transmit at the baud rate, also on TCP and ptys."),
    ] = False
    fault: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="FAULT",
            help="Line fault: drop=N, drop=N/M, crc=N, crc=N/M, delay=MS or silence=on.",
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
            help="Local port for JSON lines with faults and inputs; the first line is the printed key.",
        ),
    ] = None
    record: Annotated[
        Path | None, typer.Option("--record", metavar="FILE", help="Record line and registers as MCAP.")
    ] = None
    replace: ReplaceOption = False
    ascii_mode: Annotated[
        bool, typer.Option("--ascii", help="PCL601: use AA ASCII on the line, as after code 11.")
    ] = False
    start: Annotated[
        bool, typer.Option("--start", help="PCL601: start the stored programs, as SMC60WIN does.")
    ] = False
    quiet: QuietOption = False

    @property
    def programs_in_use(self) -> dict[Path, str]:
        """The stored programs, each with its role; no output may replace them."""
        return dict.fromkeys(self.program or (), "a stored program")
