"""Simulated controllers as `scanrack serve` puts them on a line: made from options, shown in a few words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ...io_images.pcl601 import Register
from ...io_images.pcl601.program import Program
from ...io_images.pmc006.frame import FACTORY_ADDRESS
from ...io_images.pmc006.program import UserProgram, assemble
from ..pcl601.line import PORT_TIMING, Pcl601
from ..pcl601.program import ProgramMachine
from ..pcl601.rtu import Timing
from ..pmc006.controller import Controller
from ..pmc006.line import Pmc006
from ..wire import Device
from .pclt import read_program


@dataclass(frozen=True, slots=True)
class Unit:
    """One controller.

    Attributes:
        device: what is on the line.
        address: as it was made.
        status: says how it is at this moment: a word or two for each column of the status table.
        answer: answers a Modbus request PDU; None for what speaks no Modbus.
    """

    device: Device
    address: int
    status: Callable[[], dict[str, str]]
    answer: Callable[[bytes], bytes | None] | None = None


def addresses_in(texts: list[str]) -> list[int]:
    """Return the addresses that are meant.

    >>> addresses_in(["7", "1-3"])
    [7, 1, 2, 3]

    Args:
        texts: each an address, or the first and the last of a row of them.

    Raises:
        ValueError: this is no address, or one is given twice.
    """
    found: list[int] = []
    for text in texts:
        first, _, last = text.partition("-")
        if not (first.isdecimal() and (last or first).isdecimal()) or int(last or first) > 255:
            raise ValueError(f"--address {text}: an address is a number, such as 7, or several, such as 1-3")
        found += range(int(first), int(last or first) + 1)
    for address in found:
        if found.count(address) > 1:
            raise ValueError(f"--address {address} is given twice: two units can't share an address")
    return found


def pcl601_units(addresses: list[int], programs: list[Path], speed: float) -> list[Unit]:
    """Make PCL601s, one for each address, 1 if there is none; frames are told by their length.

    A program goes to the unit that its `.axis` names; without that directive, to the only unit.

    Raises:
        ValueError: no such address, or a program that can't be used.
    """
    timing = Timing(int(PORT_TIMING.gap_ns * max(speed, 1)), PORT_TIMING.pause_ns, PORT_TIMING.by_length)
    devices = {address: Pcl601(address, timing=timing) for address in addresses or [1]}
    for file in programs:
        program = read_program(file)
        _load(devices[_axis(file, program, list(devices))], program)
    return [
        Unit(device, address, partial(_pcl601_status, device), device.answer)
        for address, device in devices.items()
    ]


def _axis(file: Path, program: Program, addresses: list[int]) -> int:
    """Return the address of the unit that a program is for."""
    if program.axis is None and len(addresses) == 1:
        return addresses[0]
    if program.axis not in addresses:
        said = "has no .axis" if program.axis is None else f"is for axis {program.axis}"
        raise ValueError(f"{file} {said}; the units have the addresses {', '.join(map(str, addresses))}")
    return program.axis


def _load(device: Pcl601, program: Program) -> None:
    """Put a program into memory as if saved earlier, and switch the power on."""
    device.controller.runner = ProgramMachine(program)
    if program.autostart is not None:
        device.controller.autorun = program.autostart
        device.power_cycle(0)


def _pcl601_status(device: Pcl601) -> dict[str, str]:
    controller = device.controller
    registers = controller.read()
    running = controller.program_running
    return {
        "address": str(registers[Register.ADDRESS]),
        "line": "Modbus RTU" if device.line_format.parity == "E" else "AA ASCII",
        "position": f"{registers[Register.POSITION]:,}",
        "motion": "moving" if controller.busy else "idle",
        "program": "running" if running else "-",
        "outputs": f"{controller.output_pins:08b}"[::-1],
        "error": str(registers[Register.ERROR_CODE]),
    }


def pmc006_units(addresses: list[int], programs: list[Path], _speed: float) -> list[Unit]:
    """Make one PMC006; its line is RS-232, point to point.

    Raises:
        ValueError: several are asked for, or the address or the program can't be used.
    """
    if len(addresses) > 1 or len(programs) > 1:
        raise ValueError("a PMC006 is alone on its line: give one --address and one --program at most")
    program = _user_program(programs[0]) if programs else None
    controller = Controller(address=addresses[0] if addresses else FACTORY_ADDRESS, program=program)
    return [Unit(Pmc006(controller), controller.address, lambda: _pmc006_status(controller))]


def _user_program(file: Path) -> UserProgram:
    try:
        return assemble(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def _pmc006_status(controller: Controller) -> dict[str, str]:
    return {
        "address": str(controller.address),
        "position": f"{controller.axis.position:,}",
        "motion": "moving" if controller.axis.moving else "idle",
        "status 1": f"{int(controller.status1):#04x}",
        "status 2": f"{int(controller.status2):#04x}",
    }
