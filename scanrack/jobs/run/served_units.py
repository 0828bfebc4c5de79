"""The simulated controllers of `scanrack serve`, made from options."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from scanrack.io_images.input_files import read_checked
from scanrack.io_images.pcl601 import MAP, Register
from scanrack.io_images.pcl601.program import Program
from scanrack.io_images.pmc006.frame import FACTORY_ADDRESS
from scanrack.io_images.pmc006.program import UserProgram, assemble
from scanrack.io_images.text_limits import TextKind
from scanrack.io_images.times import exact_ns
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pcl601.pinstates import connect
from scanrack.runtime.controllers.pcl601.program import load, read_program
from scanrack.runtime.controllers.pcl601.program.machine import ProgramMachine
from scanrack.runtime.controllers.pcl601.wiring import Wiring
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.line.rtu import Timing
from scanrack.runtime.line.wire import ControllerDevice

NO_PROGRAM = "-"
THUMBWHEEL_DIGITS = 7

PORT_GAP_MS = 5.0
"""Silence between frames on transports without exact timing, ms."""

SERIAL_GAP_MS = 25.0
"""Silence between frames on a serial port, ms. USB adapters deliver received bytes every 16 ms."""

GAP_MS_MAX = 10_000
RECORDED = [row for row in MAP if row.register not in (Register.COMMAND, Register.FIRMWARE)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ServedUnit:
    """One controller, or one axis of a stack of drives.

    Attributes:
        address: address on the line, or number of the axis.
        status: returns the texts of its row in the status table, by column.
        values: returns its current values by name, for the recording.
        wire: sets an input to a state, both by name; raises ValueError for an unknown name.
    """

    address: int
    status: Callable[[], dict[str, str]]
    values: Callable[[], dict[str, int]]
    wire: Callable[[str, str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit(ServedUnit):
    """One controller on a line.

    Attributes:
        answer: answers a Modbus request PDU; None for a unit without Modbus.
        do: carries out a command code as if it had been received; None for a unit without command codes.
    """

    device: ControllerDevice
    answer: Callable[[bytes], bytes | None] | None = None
    do: Callable[[int], None] | None = None


def addresses_in(texts: list[str]) -> list[int]:
    """Return unit addresses; raise ValueError for an invalid or repeated address.

    >>> addresses_in(["7", "1-3"])
    [7, 1, 2, 3]

    Args:
        texts: addresses, or ranges such as "1-3".
    """
    addresses: list[int] = []
    for text in texts:
        first, _, last = text.partition("-")
        if not (first.isdecimal() and (last or first).isdecimal()) or int(last or first) > 255:
            raise ValueError(f"--address {text}: must be a number, such as 7, or a range, such as 1-3")
        addresses += range(int(first), int(last or first) + 1)
    for address in addresses:
        if addresses.count(address) > 1:
            raise ValueError(f"--address {address} occurs twice: two units can't share an address")
    return addresses


def pcl601_units(
    addresses: list[int],
    programs: list[Path],
    speed: float,
    thumbwheels: Sequence[str] = (),
    gap_ms: float = PORT_GAP_MS,
) -> list[Unit]:
    """Create a PCL601 for each address, by default 1. Length and CRC determine the end of a frame.

    Another frame can begin after `gap_ms` of silence in real time. A program is loaded into the unit that its
    `.axis` directive names, or else into the only unit.

    Raises:
        ValueError: an address is invalid, or a program or thumbwheel is unusable.
    """
    if not 0 < gap_ms <= GAP_MS_MAX:
        raise ValueError(f"--gap-ms {gap_ms:g}: must be above 0, and at most {GAP_MS_MAX}")
    timing = Timing(round(exact_ns(gap_ms, "ms", "--gap-ms") * max(speed, 1)), by_length=True)
    wirings = _wirings(addresses or [1], thumbwheels)
    devices = {address: Pcl601(address, wiring=wiring, timing=timing) for address, wiring in wirings.items()}
    for file in programs:
        program = read_program(file)
        device = devices[_address_for(file, program, list(devices))]
        load(device.controller, program)
        device.power_cycle(0)
    return [
        Unit(
            device=device,
            address=address,
            status=partial(_pcl601_status, device),
            values=partial(pcl601_values, device),
            wire=partial(_wire_pcl601, device),
            answer=device.answer,
            do=partial(_do_pcl601, device),
        )
        for address, device in devices.items()
    ]


def _wirings(addresses: list[int], thumbwheels: Sequence[str]) -> dict[int, Wiring]:
    """Return the wiring of units from thumbwheels given as DIGITS or ADDRESS:DIGITS."""
    wirings = dict.fromkeys(addresses, Wiring())
    for text in thumbwheels:
        address, _, digits = text.rpartition(":")
        matches = [unit_address for unit_address in addresses if not address or str(unit_address) == address]
        if not matches or not (digits.isdecimal() and len(digits) <= THUMBWHEEL_DIGITS):
            raise ValueError(f"--thumbwheel {text}: must be up to 7 digits, or ADDRESS:DIGITS")
        wirings[matches[0]] = Wiring(True, int(digits))
    return wirings


def _address_for(file: Path, program: Program, addresses: list[int]) -> int:
    """Return the address of the unit for a program."""
    if program.axis is None and len(addresses) == 1:
        return addresses[0]
    if program.axis not in addresses:
        problem = "has no .axis" if program.axis is None else f"is for axis {program.axis}"
        raise ValueError(f"{file} {problem}; the units have the addresses {', '.join(map(str, addresses))}")
    return program.axis


def _pcl601_status(device: Pcl601) -> dict[str, str]:
    """Return the texts of a PCL601 in the status table, by column."""
    controller = device.controller
    registers = controller.read()
    return {
        "address": str(registers[Register.ADDRESS]),
        "line": "Modbus RTU" if device.line_format.parity == "E" else "AA ASCII",
        "position": f"{registers[Register.POSITION]:,}",
        "motion": "moving" if controller.busy else "idle",
        "program": _program_state(controller.runner),
        "outputs": f"{controller.output_pins:08b}"[::-1],
        "error": str(registers[Register.ERROR_CODE]),
    }


def _program_state(runner: ProgramMachine | None) -> str:
    if runner is None:
        return NO_PROGRAM
    return "running" if runner.running else "stored"


def pcl601_values(device: Pcl601) -> dict[str, int]:
    """Return registers, inputs and outputs by name, for the recording."""
    controller = device.controller
    registers = controller.read()
    return {
        **{row.register.name.lower(): registers[row.register] for row in RECORDED},
        "inputs": controller.inputs.active(),
        "outputs": controller.output_pins,
        "program_running": int(controller.program_running),
    }


def _do_pcl601(device: Pcl601, code: int) -> None:
    device.controller.do(code)
    device.controller.settle(device.controller.now_ns)


def _wire_pcl601(device: Pcl601, name: str, state: str) -> None:
    connect(device.controller.pins, name, state)
    device.controller.settle(device.controller.now_ns)


def pmc006_units(
    addresses: list[int],
    programs: list[Path],
    _speed: float,
    thumbwheels: Sequence[str] = (),
    _gap_ms: float = PORT_GAP_MS,
) -> list[Unit]:
    """Create one PMC006 on a point-to-point RS-232 line. The parameters are those of `pcl601_units`.

    Raises:
        ValueError: there are several units, or the address or program is unusable.
    """
    if thumbwheels:
        raise ValueError("--thumbwheel: a PMC006 has no thumbwheel")
    if len(addresses) > 1 or len(programs) > 1:
        raise ValueError("a line has one PMC006: give at most one --address and one --program")
    program = user_program(programs[0]) if programs else None
    controller = Pmc006Controller(address=addresses[0] if addresses else FACTORY_ADDRESS, program=program)
    return [
        Unit(
            device=Pmc006(controller),
            address=controller.address,
            status=lambda: _pmc006_status(controller),
            values=lambda: _pmc006_values(controller),
            wire=lambda name, state: _wire_pmc006(controller, name, state),
        )
    ]


def user_program(file: Path) -> UserProgram:
    """Read the listing of a PMC006 user program; raise ValueError if it can't be read or assembled."""
    try:
        return assemble(read_checked(file, TextKind.STORED))
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def _pmc006_status(controller: Pmc006Controller) -> dict[str, str]:
    """Return the texts of a PMC006 in the status table, by column."""
    return {
        "address": str(controller.address),
        "position": f"{controller.axis.position:,}",
        "motion": "moving" if controller.axis.moving else "idle",
        "status 1": f"{int(controller.status1):#04x}",
        "status 2": f"{int(controller.status2):#04x}",
    }


def _pmc006_values(controller: Pmc006Controller) -> dict[str, int]:
    """Return the values of a PMC006 by name, for the recording."""
    return {
        "position": controller.axis.position,
        "status1": int(controller.status1),
        "status2": int(controller.status2),
        "levels": int(controller.levels),
        "gpio8": int(controller.gpio8),
    }


def _wire_pmc006(controller: Pmc006Controller, name: str, state: str) -> None:
    """Set a pin to "high" or "low"; raise ValueError for an unknown pin or state."""
    pins = {pin.name.lower(): pin for pin in Pin if pin.name is not None}
    if name not in pins:
        raise ValueError(f"no input {name}; choose from {', '.join(pins)}")
    if state not in ("high", "low"):
        raise ValueError(f"{state!r} is not a state of an input: must be high or low")
    controller.set_pin(pins[name], state == "high")
