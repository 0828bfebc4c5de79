"""The tables `[axes.NAME]` of a rack file: axes for a program's motion instructions, each a 3601 or ideal."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, Self

from pydantic import Field, model_validator
from scanrack.io_images.site import SettingError

from .machine_tables import Table
from .quantities import Number, between

IDEAL = ("max_speed", "max_acceleration", "unwind")
"""Keys of an ideal axis."""


class AxisTable(Table):
    """An axis.

    Attributes:
        slot: slot of its 3601; omitted for an ideal axis.
        counts_per_unit: steps per unit of the axis.
        max_speed: 100 % of the maximum, units/s; 0 means MaximumSpeed of the tag.
        max_acceleration: 100 % of the maximum, units/s²; 0 means MaximumAcceleration of the tag.
        home_speed: speed of homing, units/s; 0 means HomeSpeed of the tag.
        home_acceleration: acceleration and deceleration of homing, units/s²; 0 means `max_acceleration`.
        home_direction: 1 clockwise, -1 counterclockwise.
        configuration: the eight configuration words, which MSO sends to the module; empty if the program
            configures the module.
        unwind: units per turn of an ideal rotary axis, which limit its positions; 0 for a linear axis.
    """

    slot: Annotated[int, Field(ge=1)] | None = None
    counts_per_unit: Annotated[Number, between("0.000001", "1000000000")] = Decimal(1)
    max_speed: Annotated[Number, between("0", "1000000000")] = Decimal(0)
    max_acceleration: Annotated[Number, between("0", "1000000000000")] = Decimal(0)
    home_speed: Annotated[Number, between("0", "1000000000")] = Decimal(0)
    home_acceleration: Annotated[Number, between("0", "1000000000000")] = Decimal(0)
    home_direction: int = 1
    configuration: Annotated[tuple[int, ...], Field(strict=False)] = ()
    unwind: Annotated[Number, between("0", "1000000000")] = Decimal(0)

    @model_validator(mode="after")
    def _has_only_its_keys(self) -> Self:
        """Refuse the keys of a 3601 for an ideal axis, and the keys of an ideal axis for a 3601."""
        keys = self.model_fields_set
        wrong_keys = keys & {"unwind"} if self.slot is not None else keys - {*IDEAL, "slot"}
        if wrong_keys:
            kind = "an ideal axis" if self.slot is not None else "an axis with a slot"
            raise SettingError(min(wrong_keys), f"only {kind} has this key")
        return self

    def values(self) -> dict[str, Any]:
        """Return the values by name, with decimals as floats."""
        numbers = ("counts_per_unit", "max_speed", "max_acceleration", "home_speed", "home_acceleration")
        plain_numbers = {name: float(getattr(self, name)) for name in (*numbers, "unwind")}
        return {
            **plain_numbers,
            "slot": self.slot or 0,
            "home_direction": self.home_direction,
            "configuration": self.configuration,
        }
