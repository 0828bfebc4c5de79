"""Numbers as people write them: decimals, and times that are converted to whole nanoseconds exactly."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from ...io_images.site import SettingError
from ...io_images.times import UNITS_NS

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue


def decimal_of(value: object) -> Decimal:
    """Return a number as a decimal; a float by its shortest decimal form.

    >>> decimal_of(0.1), decimal_of(2)
    (Decimal('0.1'), Decimal('2'))

    Raises:
        PydanticCustomError: not a finite number.
    """
    if isinstance(value, int | float | Decimal) and not isinstance(value, bool):
        number = Decimal(str(value))
        if number.is_finite():
            return number
    raise PydanticCustomError("allowed", "a number")


@dataclass(frozen=True, slots=True)
class between:  # noqa: N801 - a validator, written as a function of pydantic
    """A validator for decimals from `least` to `most`."""

    least: str
    most: str

    def check(self, value: Decimal) -> Decimal:
        """Return an allowed value; PydanticCustomError for any other."""
        if not Decimal(self.least) <= value <= Decimal(self.most):
            raise PydanticCustomError(
                "allowed", "{least} to {most}", {"least": self.least, "most": self.most}
            )
        return value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {**handler(schema), "minimum": float(self.least), "maximum": float(self.most)}


def exact_ns(value: Decimal, unit: str, key: str = "time") -> int:
    """Return a time in whole nanoseconds; ValueError if it is not a whole number of nanoseconds.

    >>> exact_ns(Decimal("0.25"), "ms"), exact_ns(Decimal("600"), "s")
    (250000, 600000000000)
    """
    whole, rest = divmod(value * UNITS_NS[unit], 1)
    if rest:
        raise SettingError(key, f"{key} of {value} {unit} is not a whole number of nanoseconds")
    return int(whole)


def parse_duration(text: str) -> int:
    """Return a duration with its unit, in ns.

    >>> parse_duration("10 s"), parse_duration("2.5ms"), parse_duration("1 min")
    (10000000000, 2500000, 60000000000)

    Raises:
        ValueError: no number, no unit, or less than 1 ns.
    """
    duration = parse_time(text)
    if duration < 1:
        raise ValueError(f"{text!r} is not a time to run for: it must be more than 0")
    return duration


def parse_time(text: str) -> int:
    """Return a time with its unit in ns, 0 or more.

    >>> parse_time("0 s"), parse_time("250us")
    (0, 250000)

    Raises:
        ValueError: no number, no unit, or no whole number of ns.
    """
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([a-zµ]+)\s*", text)
    if match is None or match[2] not in UNITS_NS:
        raise ValueError(
            f"{text!r} is not a time: write a number and a unit ({', '.join(UNITS_NS)}), such as '10 s'"
        )
    return exact_ns(Decimal(match[1]), match[2])


Number = Annotated[Decimal, BeforeValidator(decimal_of)]
"""A field that takes any number and keeps it as a decimal."""

Milliseconds = Annotated[Number, between("0", "1000000000")]
Seconds = Annotated[Number, between("0", "1000000")]
