"""The table `[[unit]]` of a rack file: a controller outside the rack, on a serial line.

    [[unit]]
    controller = "pcl601"
    address = 1
    program = "sample3.pclt"
    start = true
    pins = { home = "..-3000", soft_minus = "..-2000", in1 = "ground" }

A switch on its machine is a pin that is closed while the motor is within a range of positions.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator
from scanrack.io_images.site import SettingError

from .machine_tables import Table

if TYPE_CHECKING:
    from ..controllers.pcl601.line import Pcl601


STORED = ".pclt"
"""Suffix of a stored program. No other files are read, so no message can show their contents."""


class UnitSpec(Table):
    """A controller outside the rack.

    Attributes:
        controller: type of the controller.
        address: address on the serial line, 0 to 99.
        program: path of its stored program, relative to the rack file.
        start: whether the stored program starts at power-up.
        ascii: whether the line starts in AA ASCII.
        thumbwheel: the seven digits of a thumbwheel, with switch SW2 at TWS; no thumbwheel if omitted.
        pins: states of its inputs by name, as in `env` of `scanrack drive pcl601`.
    """

    controller: Literal["pcl601"] = "pcl601"
    address: Annotated[int, Field(ge=0, le=99)] = 1
    program: str | None = None
    start: bool = False
    ascii: bool = False
    thumbwheel: Annotated[str, Field(pattern="^[0-9]{7}$")] | None = None
    pins: Mapping[str, str] = Field(default_factory=dict)

    def make(self, folder: Path) -> Pcl601:
        """Return the unit, powered up; raise ValueError if the program can't be used.

        Args:
            folder: folder of the rack file.
        """
        from scanrack.io_images.pcl601 import Code

        from ..controllers.pcl601.line import Pcl601  # pymodbus takes time to import
        from ..controllers.pcl601.pinstates import connect
        from ..controllers.pcl601.program import load, read_program
        from ..controllers.pcl601.wiring import Wiring

        digits = None if self.thumbwheel is None else int(self.thumbwheel)
        unit = Pcl601(self.address, wiring=Wiring(digits is not None, digits))
        for name, state in self.pins.items():
            connect(unit.controller.pins, name, state)
        if self.program is not None:
            load(unit.controller, read_program(folder / self.program))
            unit.power_cycle(0)
        for is_on, code in ((self.ascii, Code.SWITCH_TO_ASCII), (self.start, Code.RUN_PROGRAM)):
            if is_on:
                unit.controller.do(code)
        unit.controller.settle(0)
        return unit

    @model_validator(mode="after")
    def _can_be_wired(self) -> Self:
        """Refuse unknown pins and states, a program with another suffix, and a start without a program."""
        from ..controllers.pcl601.pins import Pcl601Pins
        from ..controllers.pcl601.pinstates import connect

        for name, state in self.pins.items():
            connect(Pcl601Pins(), name, state)
        if self.program is not None and not self.program.endswith(STORED):
            raise SettingError("program", f"a stored program has the suffix {STORED}")
        if self.start and self.program is None:
            raise SettingError("start", "no program to start: add a key `program`")
        return self
