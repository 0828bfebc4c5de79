"""The tables `[axes.NAME]` of a rack file: axes of a program's motion instructions, and their 3601s."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any

from pydantic import Field

from .machine_tables import Table
from .quantities import Number, between


class AxisTable(Table):
    """An axis.

    Attributes:
        slot: slot of its 3601.
        counts_per_unit: steps per unit of the axis.
        max_speed: 100 % of maximum, units/s; 0 takes MaximumSpeed of the tag.
        max_acceleration: 100 % of maximum, units/s²; 0 takes MaximumAcceleration of the tag.
        home_speed: speed of a search for home, units/s; 0 takes HomeSpeed of the tag.
        home_acceleration: its rates, units/s²; 0 takes `max_acceleration`.
        home_direction: 1 clockwise, -1 counterclockwise.
        configuration: the eight words of the module, which MSO sends; none if the program configures it.
    """

    slot: Annotated[int, Field(ge=1)]
    counts_per_unit: Annotated[Number, between("0.000001", "1000000000")] = Decimal(1)
    max_speed: Annotated[Number, between("0", "1000000000")] = Decimal(0)
    max_acceleration: Annotated[Number, between("0", "1000000000000")] = Decimal(0)
    home_speed: Annotated[Number, between("0", "1000000000")] = Decimal(0)
    home_acceleration: Annotated[Number, between("0", "1000000000000")] = Decimal(0)
    home_direction: int = 1
    configuration: Annotated[tuple[int, ...], Field(strict=False)] = ()

    def values(self) -> dict[str, Any]:
        """Return the values by name, decimals as floats."""
        numbers = ("counts_per_unit", "max_speed", "max_acceleration", "home_speed", "home_acceleration")
        plain = {name: float(getattr(self, name)) for name in numbers}
        return {
            **plain,
            "slot": self.slot,
            "home_direction": self.home_direction,
            "configuration": self.configuration,
        }
