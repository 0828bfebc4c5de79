"""The tables `[prove]` and `[[prove.property]]` of a rack file: what to prove, and what to assume.

[prove]
scan_ms = [1, 1000]                  # time between two scans
free = ["Recipe.*"]                  # numbers that change from outside
written_outside = ["Mode", "Hmi.*"]  # tags that both the program and an operator write
happens = ["program mode"]           # other events between two scans

[[prove.property]]
name = "one direction"
never = "Fwd AND Rev"                # structured text; applies to the state after a scan
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, PlainValidator, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError
from scanrack.io_images.site import SettingError

from .machine_tables import Table

LONGEST_SCAN_MS = 1000
"""Longest time between two scans, the same as the limit of a rack."""

CLAIMS = ("never", "always", "reachable")
"""Keys of a property; each property has exactly one of them."""


def _scan_range(value: object) -> tuple[float, float]:
    """Return the shortest and longest scan, ms; refuse any value except two numbers in ascending order."""
    if isinstance(value, list | tuple) and len(value) == 2:
        shortest, longest = value
        are_numbers = all(type(limit) in (int, float) for limit in value)
        if are_numbers and 1 <= shortest <= longest <= LONGEST_SCAN_MS and all(map(_is_whole_us, value)):
            return shortest, longest
    limit = str(LONGEST_SCAN_MS)
    raise PydanticCustomError(
        "allowed", "shortest and longest, milliseconds from 1 to {limit}, of whole µs", {"limit": limit}
    )


def _is_whole_us(ms: float) -> bool:
    """Return whether a number of ms is a whole number of µs; rounding errors of a float are allowed."""
    return abs(ms * 1000 - round(ms * 1000)) < 1e-6


def _not_empty(text: str) -> str:
    if text.strip():
        return text
    raise PydanticCustomError("allowed", "a condition of structured text")


Condition = Annotated[str, AfterValidator(_not_empty)]
Conditions = Annotated[tuple[Condition, ...], Field(strict=False)]
Patterns = Annotated[tuple[str, ...], Field(strict=False)]


Happening = Literal["program mode", "retained start", "lost link"]


class PropertyTable(Table):
    """A property: one of `never`, `always` and `reachable`.

    Attributes:
        name: unique name in reports, and name of its folder.
        never: a condition that is false after every scan.
        always: a condition that is true after every scan.
        reachable: a condition that is true in at least one run; the scenario shows one of these runs.
        assume: conditions to assume in every scan.
    """

    name: Annotated[str, Field(min_length=1)]
    never: Condition | None = None
    always: Condition | None = None
    reachable: Condition | None = None
    assume: Conditions = ()

    @property
    def claim(self) -> str:
        """Key of the property's condition: "never", "always" or "reachable"."""
        return self._claims[0]

    @property
    def condition(self) -> str:
        """The condition of the claim."""
        text: str = getattr(self, self.claim)
        return text

    @property
    def _claims(self) -> list[str]:
        """The keys of claims that the table has; a valid table has one."""
        return [claim for claim in CLAIMS if getattr(self, claim) is not None]

    @model_validator(mode="after")
    def _has_one_claim(self) -> Self:
        """Refuse a property without a claim, or with several."""
        claims = self._claims
        if len(claims) != 1:
            problem = f"this property has {claims[0]} already" if claims else "this property has no condition"
            key = claims[1] if claims else "name"
            raise SettingError(key, f"{problem}: write one of {', '.join(CLAIMS)}")
        return self


class ProveTable(Table):
    """What to prove about a rack, and what to assume.

    Attributes:
        scan_ms: shortest and longest time between two scans, ms.
        free: patterns of numbers that the program does not write and that can change between scans.
        written_outside: patterns of tags that the program writes and that can also change between scans.
        assume: conditions to assume in every scan, for all properties.
        happens: events that can happen between two scans: "program mode": the key is turned to program mode
            and back; "retained start": a run ends, and the next run starts with the tag values that it left;
            "lost link": a module loses its link.
        property: the properties to prove.
    """

    scan_ms: Annotated[
        tuple[float, float],
        PlainValidator(_scan_range),
        WithJsonSchema(
            {
                "type": "array",
                "items": {"type": "number", "minimum": 1, "maximum": LONGEST_SCAN_MS},
                "minItems": 2,
                "maxItems": 2,
            }
        ),
    ] = (1, LONGEST_SCAN_MS)
    free: Patterns = ()
    written_outside: Patterns = ()
    assume: Conditions = ()
    happens: Annotated[tuple[Happening, ...], Field(strict=False)] = ("program mode",)
    property: Annotated[tuple[PropertyTable, ...], Field(strict=False)] = ()
