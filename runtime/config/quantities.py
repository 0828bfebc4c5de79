"""Exact decimals for the numbers in rack files."""

from __future__ import annotations

from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema
from scanrack.io_images.dataclass import dataclass

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue


def decimal_of(value: object) -> Decimal:
    """Convert a number to a decimal; a float is converted through its shortest decimal form.

    >>> decimal_of(0.1), decimal_of(2)
    (Decimal('0.1'), Decimal('2'))

    Raises:
        PydanticCustomError: the value is not a finite number.
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
        """Return the value, or raise PydanticCustomError if it is outside the range."""
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


Number = Annotated[Decimal, BeforeValidator(decimal_of)]
"""A number of any type, as a decimal."""

Milliseconds = Annotated[Number, between("0", "1000000000")]
Seconds = Annotated[Number, between("0", "1000000")]
