"""The machine in a rack file: tables that become a `MachineSpec`.

Names, types and meanings are as in `runtime.machine.spec`. Parts with times have separate tables, because a
file uses milliseconds (`at_ms`) or seconds (`at_s`).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetPydanticSchema,
    PlainValidator,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import PydanticCustomError, core_schema
from scanrack.io_images.site import SettingError
from scanrack.io_images.times import exact_ns

from ..machine.spec import (
    EncoderSpec,
    InputName,
    Jam,
    MachineSpec,
    MasterTurn,
    Slip,
    Station,
    Switch,
    TimelineEntry,
    press,
)
from .quantities import Milliseconds, Seconds


class Table(BaseModel):
    """A table of a rack file; it allows no unknown keys and no conversions between types."""

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, arbitrary_types_allowed=True, defer_build=True
    )

    def ns(self, name: str) -> int:
        """Return the time in the key `name_ms` or `name_s`, in ns.

        Raises:
            ValueError: the table has neither of the keys, or both.
        """
        values = {unit: getattr(self, f"{name}_{unit}") for unit in ("ms", "s")}
        units = [unit for unit, value in values.items() if value is not None]
        if len(units) != 1:
            text = f"write one of {name}_ms and {name}_s, not {'both' if units else 'none'}"
            raise SettingError(f"{name}_ms", text)
        return exact_ns(values[units[0]], units[0], key=f"{name}_{units[0]}")


def _validated_later(table: type[Table], _handler: Any) -> core_schema.CoreSchema:
    """Return a validator for a table that builds the table's own validator on first use."""

    def validated(value: object, info: ValidationInfo) -> Table:
        return table.model_validate(value, context=info.context)

    return core_schema.with_info_plain_validator_function(validated, metadata={TABLE: table})


TABLE = "table"
"""Name of a table in the metadata of its validator, for `rack_schema`."""

AnyTable = TypeVar("AnyTable", bound=Table)
Rare = Annotated[AnyTable, GetPydanticSchema(_validated_later)]
"""A table that most files lack; pydantic builds its validator when a file has one."""


class Part(Table):
    """A table for parts of a machine with times."""

    def parts(self) -> tuple[Any, ...]:
        """Return the parts of the machine."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _has_valid_parts(self) -> Self:
        self.parts()
        return self


def _level_or_wired(value: object) -> bool | Literal["wired"]:
    """Return a level or "wired" unchanged; refuse any other value."""
    if isinstance(value, bool):
        return value
    if value == "wired":
        return "wired"
    raise PydanticCustomError("allowed", 'true, false or "wired"')


class TimelineTable(Part):
    """An event at an input; with `for_ms` or `for_s`, it is a button that is released after that time.

    Attributes:
        at_ms: time since power-up, ms; or `at_s`.
        input: the module's input.
        energized: level from this time on; "wired" connects the input to its switch or station again.
        for_ms: duration of a button press, ms; or `for_s`.
    """

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    input: InputName
    energized: Annotated[
        bool | Literal["wired"],
        PlainValidator(_level_or_wired),
        WithJsonSchema({"enum": [True, False, "wired"]}),
    ] = True
    for_ms: Milliseconds | None = None
    for_s: Seconds | None = None

    def parts(self) -> tuple[TimelineEntry, ...]:
        """Return the entries."""
        if self.for_ms is None and self.for_s is None:
            level = None if self.energized == "wired" else self.energized
            return (TimelineEntry(self.ns("at"), self.input, level),)
        if self.energized == "wired":
            raise SettingError("energized", 'energized = "wired" has no end: remove for_ms and for_s')
        return press(self.ns("at"), self.input, self.ns("for"), normally_closed=not self.energized)


class StationTable(Part):
    """A station that signals the end of its work.

    Attributes:
        position: position at which the shaft stops at the station, steps.
        input: the module's input that receives its signal.
        work_ms: duration of its work, ms; or `work_s`.
        pulse_ms: duration of the signal, ms; or `pulse_s`.
    """

    position: int
    input: InputName
    work_ms: Milliseconds | None = None
    work_s: Seconds | None = None
    pulse_ms: Milliseconds | None = None
    pulse_s: Seconds | None = None

    def parts(self) -> tuple[Station]:
        """Return the station."""
        return (Station(self.position, self.input, self.ns("work"), self.ns("pulse")),)


class TurnTable(Part):
    """A movement of a master encoder.

    Attributes:
        at_ms: time of its start since power-up, ms; or `at_s`.
        counts: x4 counts, evenly spread; negative values count down.
        for_ms: duration, ms; or `for_s`.
    """

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    counts: int
    for_ms: Milliseconds | None = None
    for_s: Seconds | None = None

    def parts(self) -> tuple[MasterTurn]:
        """Return the movement."""
        return (MasterTurn(self.ns("at"), self.counts, self.ns("for")),)


class MachineTable(Table):
    """A machine.

    Attributes:
        switches: switches and sensors that the shaft operates.
        timeline: operator actions; simultaneous actions happen in the order of the file.
        encoder: an encoder on the shaft.
        slips: positions where the motor loses steps.
        jams: positions that the shaft can't pass.
        stations: stations that signal the end of their work.
        turns: successive movements of a follower's master encoder.
        master_speed: maximum speed of the master encoder, x4 counts/s; `scanrack fuzz` turns the encoder only
            with this key.
    """

    switches: Annotated[tuple[Switch, ...], Field(strict=False)] = ()
    timeline: Annotated[tuple[Rare[TimelineTable], ...], Field(strict=False)] = ()
    encoder: EncoderSpec | None = None
    slips: Annotated[tuple[Slip, ...], Field(strict=False)] = ()
    jams: Annotated[tuple[Jam, ...], Field(strict=False)] = ()
    stations: Annotated[tuple[Rare[StationTable], ...], Field(strict=False)] = ()
    turns: Annotated[tuple[Rare[TurnTable], ...], Field(strict=False)] = ()
    master_speed: int | None = None

    def spec(self) -> MachineSpec:
        """Return the machine; raise a ValueError if the parts are incompatible."""
        return MachineSpec(
            switches=self.switches,
            timeline=tuple(entry for table in self.timeline for entry in table.parts()),
            encoder=self.encoder,
            slips=self.slips,
            jams=self.jams,
            stations=tuple(station for table in self.stations for station in table.parts()),
            turns=tuple(turn for table in self.turns for turn in table.parts()),
            master_speed=self.master_speed,
        )
