"""The machine in a rack file: tables that become a `MachineSpec`.

Names, types and meanings are those of `runtime.machine.spec`. Only parts with times have
tables of their own: a file gives milliseconds (`at_ms`) or seconds (`at_s`).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, model_validator
from pydantic_core import PydanticCustomError

from ...io_images.site import SettingError
from ..machine.spec import (
    EncoderSpec,
    InputName,
    Jam,
    MachineSpec,
    Slip,
    Station,
    Switch,
    TimelineEntry,
    press,
)
from .quantities import Milliseconds, Seconds, exact_ns


class Table(BaseModel):
    """A table of a rack file: no unknown keys, no conversions between types."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, arbitrary_types_allowed=True)

    def ns(self, name: str) -> int:
        """Return the time given as `name_ms` or `name_s`, in ns.

        Raises:
            ValueError: neither or both are given.
        """
        given = {unit: getattr(self, f"{name}_{unit}") for unit in ("ms", "s")}
        units = [unit for unit, value in given.items() if value is not None]
        if len(units) != 1:
            text = f"one of {name}_ms and {name}_s is needed, not {'both' if units else 'none'}"
            raise SettingError(f"{name}_ms", text)
        return exact_ns(given[units[0]], units[0], key=f"{name}_{units[0]}")


class Part(Table):
    """A table with its own notation of times; errors of its part are reported here."""

    def parts(self) -> tuple[Any, ...]:
        """Return the parts that the table describes."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        self.parts()
        return self


def _energised_of(value: object) -> bool | Literal["wired"]:
    if isinstance(value, bool):
        return value
    if value == "wired":
        return "wired"
    raise PydanticCustomError("allowed", 'true, false or "wired"')


class TimelineTable(Part):
    """An event of an input; with `for_ms` or `for_s` it is a button, released after that time."""

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    input: InputName
    energised: Annotated[bool | Literal["wired"], PlainValidator(_energised_of)] = True
    for_ms: Milliseconds | None = None
    for_s: Seconds | None = None

    def parts(self) -> tuple[TimelineEntry, ...]:
        """Return the entries."""
        if self.for_ms is None and self.for_s is None:
            level = None if self.energised == "wired" else self.energised
            return (TimelineEntry(self.ns("at"), self.input, level),)
        if self.energised == "wired":
            raise SettingError("energised", 'energised = "wired" has no end: leave for_ms and for_s out')
        return press(self.ns("at"), self.input, self.ns("for"), normally_closed=not self.energised)


class StationTable(Part):
    """A station that signals the end of its work."""

    position: int
    input: InputName
    work_ms: Milliseconds | None = None
    work_s: Seconds | None = None
    pulse_ms: Milliseconds | None = None
    pulse_s: Seconds | None = None

    def parts(self) -> tuple[Station]:
        """Return the station."""
        return (Station(self.position, self.input, self.ns("work"), self.ns("pulse")),)


class MachineTable(Table):
    """All of a machine."""

    switches: Annotated[tuple[Switch, ...], Field(strict=False)] = ()
    timeline: Annotated[tuple[TimelineTable, ...], Field(strict=False)] = ()
    encoder: EncoderSpec | None = None
    slips: Annotated[tuple[Slip, ...], Field(strict=False)] = ()
    jams: Annotated[tuple[Jam, ...], Field(strict=False)] = ()
    stations: Annotated[tuple[StationTable, ...], Field(strict=False)] = ()

    def spec(self) -> MachineSpec:
        """Return the machine; ValueError if the parts are incompatible."""
        return MachineSpec(
            switches=self.switches,
            timeline=tuple(part for table in self.timeline for part in table.parts()),
            encoder=self.encoder,
            slips=self.slips,
            jams=self.jams,
            stations=tuple(part for table in self.stations for part in table.parts()),
        )
