"""The machine as a rack file describes it: tables that become a `MachineSpec`.

Names and meanings are those of `runtime.machine.spec`; times are written in
milliseconds (`at_ms`) or seconds (`at_s`), inputs by their names in lower case.
"""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ...io_images.amci3601.bits import InputBit
from ..loop.addresses import allowed
from ..machine.spec import EncoderSpec, Jam, MachineSpec, Slip, Station, Switch, TimelineEntry, press
from .quantities import Milliseconds, Number, Seconds, decimal_of, exact_ns


def input_name(bit: InputBit) -> str:
    """Return the name of an input as files and requests write it.

    >>> input_name(InputBit.CW_LIMIT)
    'cw_limit'
    """
    return str(bit.name).lower()


INPUT_NAMES = {input_name(bit): bit for bit in InputBit}
"""The inputs by name: capture, external, home, estop, cw_limit, ccw_limit."""


def input_of(value: object) -> InputBit:
    """Return an input by its name.

    >>> input_of("cw_limit")
    <InputBit.CW_LIMIT: 16>

    Raises:
        PydanticCustomError: there is no such input.
    """
    bit = INPUT_NAMES.get(str(value).lower())
    if bit is None:
        raise PydanticCustomError("name", "{hint}", {"hint": allowed(value, INPUT_NAMES)})
    return bit


def _fraction_of(value: object) -> Fraction:
    try:
        return Fraction(value) if isinstance(value, str) else Fraction(decimal_of(value))
    except (ValueError, ZeroDivisionError):
        raise PydanticCustomError("allowed", 'a number, or a fraction such as "4/3"') from None


def _times_of(value: object) -> object:
    return None if value == "always" else value


InputName = Annotated[InputBit, PlainValidator(input_of), PlainSerializer(input_name)]
Ratio = Annotated[Fraction, PlainValidator(_fraction_of)]


class Table(BaseModel):
    """A table of a rack file: no unknown keys, no conversions between types."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, arbitrary_types_allowed=True)

    def ns(self, name: str) -> int:
        """Return the time given as `name_ms` or `name_s`, in ns.

        Raises:
            ValueError: none is given, or both.
        """
        given = {unit: getattr(self, f"{name}_{unit}") for unit in ("ms", "s")}
        units = [unit for unit, value in given.items() if value is not None]
        if len(units) != 1:
            raise ValueError(f"one of {name}_ms and {name}_s is needed, not {'both' if units else 'none'}")
        return exact_ns(given[units[0]], units[0], key=f"{name}_{units[0]}")


class Part(Table):
    """A table that describes a part of the machine; what the part refuses is refused here."""

    def parts(self) -> tuple[Any, ...]:
        """Return what the table describes."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        self.parts()
        return self


class SwitchTable(Part):
    """A switch; without `first` or `last` its range is open-ended."""

    input: InputName
    first: int | None = None
    last: int | None = None
    normally_closed: bool = False

    def parts(self) -> tuple[Switch]:
        """See `Part.parts`."""
        return (Switch(self.input, self.first, self.last, self.normally_closed),)


def _energised_of(value: object) -> bool | Literal["wired"]:
    if isinstance(value, bool):
        return value
    if value == "wired":
        return "wired"
    raise PydanticCustomError("allowed", 'true, false or "wired"')


class TimelineTable(Part):
    """What happens to an input at a time; with `for_ms` or `for_s` it is a button, let go after that."""

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    input: InputName
    energised: Annotated[bool | Literal["wired"], PlainValidator(_energised_of)] = True
    for_ms: Milliseconds | None = None
    for_s: Seconds | None = None

    def parts(self) -> tuple[TimelineEntry, ...]:
        """See `Part.parts`."""
        if self.for_ms is None and self.for_s is None:
            level = None if self.energised == "wired" else self.energised
            return (TimelineEntry(self.ns("at"), self.input, level),)
        if self.energised == "wired":
            raise ValueError('energised = "wired" has no end: leave for_ms and for_s out')
        return press(self.ns("at"), self.input, self.ns("for"), normally_closed=not self.energised)


class EncoderTable(Part):
    """The encoder; `counts_per_step` is a number or a fraction such as "4/3"."""

    counts_per_step: Ratio
    direction: int = 1
    marker_every: int | None = None
    marker_at: int = 0

    def parts(self) -> tuple[EncoderSpec]:
        """See `Part.parts`."""
        return (EncoderSpec(self.counts_per_step, self.direction, self.marker_every, self.marker_at),)


class SlipTable(Part):
    """A place where steps are lost; `times = "always"` has no end."""

    at: int
    steps: int
    direction: int = 0
    times: Annotated[int | None, BeforeValidator(_times_of)] = 1
    chance: Number = Decimal(1)

    def parts(self) -> tuple[Slip]:
        """See `Part.parts`."""
        return (Slip(self.at, self.steps, self.direction, self.times, Fraction(self.chance)),)


class JamTable(Part):
    """A position that can't be passed."""

    at: int
    direction: int

    def parts(self) -> tuple[Jam]:
        """See `Part.parts`."""
        return (Jam(self.at, self.direction),)


class StationTable(Part):
    """A station that says when it is done."""

    position: int
    input: InputName
    work_ms: Milliseconds | None = None
    work_s: Seconds | None = None
    pulse_ms: Milliseconds | None = None
    pulse_s: Seconds | None = None

    def parts(self) -> tuple[Station]:
        """See `Part.parts`."""
        return (Station(self.position, self.input, self.ns("work"), self.ns("pulse")),)


class MachineTable(Table):
    """All of a machine."""

    switches: Annotated[tuple[SwitchTable, ...], Field(strict=False)] = ()
    timeline: Annotated[tuple[TimelineTable, ...], Field(strict=False)] = ()
    encoder: EncoderTable | None = None
    slips: Annotated[tuple[SlipTable, ...], Field(strict=False)] = ()
    jams: Annotated[tuple[JamTable, ...], Field(strict=False)] = ()
    stations: Annotated[tuple[StationTable, ...], Field(strict=False)] = ()

    def spec(self) -> MachineSpec:
        """Return the machine.

        Raises:
            ValueError: the parts do not go together.
        """
        return MachineSpec(
            switches=tuple(part for table in self.switches for part in table.parts()),
            timeline=tuple(part for table in self.timeline for part in table.parts()),
            encoder=self.encoder.parts()[0] if self.encoder else None,
            slips=tuple(part for table in self.slips for part in table.parts()),
            jams=tuple(part for table in self.jams for part in table.parts()),
            stations=tuple(part for table in self.stations for part in table.parts()),
        )
