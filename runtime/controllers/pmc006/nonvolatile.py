"""The non-volatile memory of a PMC006x3s: parameters in its EEPROM [4.2, 4.3.17] and its program [5]."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator
from scanrack.io_images.pmc006.program import assemble

from .controller import Pmc006Controller
from .memory import Memory


class Pmc006Memory(BaseModel):
    """The EEPROM of a device.

    Attributes:
        parameters: parameters by name, as in `scanrack device pmc006 read`.
        program: lines of the user program, `OP option data`.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    parameters: dict[str, int]
    program: Annotated[tuple[str, ...], Field(strict=False)]

    @field_validator("parameters")
    @classmethod
    def _complete(cls, parameters: dict[str, int]) -> dict[str, int]:
        memory = Memory()
        memory.restore(parameters)
        return memory.saved

    @field_validator("program")
    @classmethod
    def _check_program(cls, lines: tuple[str, ...]) -> tuple[str, ...]:
        assemble("\n".join(lines))
        return lines

    @classmethod
    def of(cls, controller: Pmc006Controller) -> Self:
        """Return the current memory of a controller."""
        memory = controller.memory
        return cls.model_construct(parameters=memory.saved, program=tuple(map(str, memory.lines)))

    @property
    def address(self) -> int:
        """The address in the EEPROM."""
        return self.parameters["device_address"]

    def addressed(self, address: int) -> Self:
        """Return this memory with another address."""
        return self.model_copy(update={"parameters": self.parameters | {"device_address": address}})

    def restore(self, controller: Pmc006Controller) -> None:
        """Power up a new device with this memory; a program already in the device is newer, so it is kept."""
        memory = controller.memory
        memory.restore(self.parameters)
        memory.lines = memory.lines or assemble("\n".join(self.program)).lines
        controller.power_cycle()
