"""What a PMC006x3s keeps without power: parameters in its EEPROM [4.2, 4.3.17] and its program [5]."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator
from scanrack.io_images.pmc006.program import assemble

from .controller import Pmc006Controller
from .memory import Memory


class Pmc006Memory(BaseModel):
    """The EEPROM of a controller.

    Attributes:
        parameters: parameters by name, as in `scanrack device pmc006 read`.
        program: lines of the user program, `OP option data`.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    parameters: dict[str, int]
    program: Annotated[tuple[str, ...], Field(strict=False)]

    @field_validator("parameters")
    @classmethod
    def _fit(cls, parameters: dict[str, int]) -> dict[str, int]:
        memory = Memory()
        memory.restore(parameters)
        return memory.kept

    @field_validator("program")
    @classmethod
    def _can_be_stored(cls, lines: tuple[str, ...]) -> tuple[str, ...]:
        assemble("\n".join(lines))
        return lines

    @classmethod
    def of(cls, controller: Pmc006Controller) -> Self:
        """Return the present memory of a controller."""
        memory = controller.memory
        return cls.model_construct(parameters=memory.kept, program=tuple(map(str, memory.lines)))

    @property
    def address(self) -> int:
        """The address."""
        return self.parameters["device_address"]

    def addressed(self, address: int) -> Self:
        """Return this memory with another address."""
        return self.model_copy(update={"parameters": self.parameters | {"device_address": address}})

    def restore(self, controller: Pmc006Controller) -> None:
        """Power up a fresh controller with this memory; a program that it already has is newer and stays."""
        memory = controller.memory
        memory.restore(self.parameters)
        memory.lines = memory.lines or assemble("\n".join(self.program)).lines
        controller.power_cycle()
