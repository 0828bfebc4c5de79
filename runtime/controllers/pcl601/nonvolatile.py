"""The non-volatile memory of a PCL601: address [command %], program, and autorun [codes 13, 14]."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator
from scanrack.io_images.pcl601 import Register
from scanrack.io_images.pcl601.program import Program, format_program, parse_program

from .line import Pcl601
from .program.machine import ProgramMachine


class Pcl601Memory(BaseModel):
    """The non-volatile memory of a device.

    Attributes:
        address: 0 to 99.
        autorun: whether the program starts at power-up.
        program: lines of the stored program; empty if the memory is empty.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    address: Annotated[int, Field(ge=0, le=99)]
    autorun: bool
    program: Annotated[tuple[str, ...], Field(strict=False)]

    @field_validator("program")
    @classmethod
    def _check_program(cls, lines: tuple[str, ...]) -> tuple[str, ...]:
        if lines:
            parse_program("\n".join(lines))
        return lines

    def addressed(self, address: int) -> Self:
        """Return this memory with another address."""
        return self.model_copy(update={"address": address})

    def restore(self, unit: Pcl601) -> None:
        """Power up a new device with this memory; a program already in the device is newer, so it is kept."""
        controller = unit.controller
        controller.values[Register.ADDRESS] = self.address
        newer_program = program_of(unit)
        if newer_program is None and self.program:
            controller.runner = ProgramMachine(parse_program("\n".join(self.program)))
        if newer_program is None or newer_program.autostart is None:
            controller.autorun = self.autorun
        unit.power_cycle(0)


class Pcl601MemoryReader:
    """Reads a device's current memory, and formats each program only once."""

    def __init__(self, unit: Pcl601) -> None:
        self._unit = unit
        self._program: Program | None = None
        self._lines: tuple[str, ...] = ()

    def read(self) -> Pcl601Memory:
        """Return the current memory."""
        program = program_of(self._unit)
        if program is not self._program:
            self._program = program
            self._lines = () if program is None else tuple(format_program(program).splitlines())
        controller = self._unit.controller
        return Pcl601Memory.model_construct(
            address=controller.values[Register.ADDRESS], autorun=controller.autorun, program=self._lines
        )


def program_of(unit: Pcl601) -> Program | None:
    """Return the program in a device's memory, or None."""
    runner = unit.controller.runner
    return None if runner is None else runner.program
