"""Simulated controllers as `scanrack serve` puts them on a line: made from options, shown in a few words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ...io_images.pmc006.frame import FACTORY_ADDRESS
from ...io_images.pmc006.program import UserProgram, assemble
from ..pmc006.controller import Controller
from ..pmc006.line import Pmc006
from ..wire import Device


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
    answer: Callable[[bytes], bytes] | None = None


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


def pmc006_units(addresses: list[int], programs: list[Path]) -> list[Unit]:
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
