"""The tables in `[stubs]` of a rack file: results of messages, and data of consumed tags.

[stubs]
Order = { after_ms = 20, value = [1, 2, 3] }             # a message, with its data
Fetch = { after_ms = 20, rack = "line2.toml", tag = "Counts", to = "Copy[0]" }
Lost = { after_ms = 500, error = 0xCB }
FromLine2 = { rack = "line2.toml" }                      # a consumed tag, which another rack produces
Recipe = { value = { Speed = 5 } }
Level = { table = [{ value = 5 }, { at_s = 2, value = 7 }, { at_s = 4, faulted = true }] }
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from typing import Annotated, Any, Self

from pydantic import Field, PlainValidator, model_validator
from scanrack.io_images.site import SettingError
from scanrack.io_images.times import exact_ns

from .machine_tables import Table
from .quantities import Milliseconds, Number, Seconds, between


def _plain(value: object) -> Any:
    """Convert a rack file's decimals to floats, at any depth."""
    if isinstance(value, Decimal):
        return float(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, list | tuple) else value


Data = Annotated[Any, PlainValidator(_plain)]


class StubStep(Table):
    """The data of a consumed tag from a point in time on.

    Attributes:
        at_ms: start of this entry, ms; or use `at_s`. 0 if omitted.
        value: the data, which is a number, true or false, a string, an array, or a table of members.
        faulted: whether the connection is broken until the next entry.
        running: whether the producer is in run mode.
    """

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    value: Data = None
    faulted: bool = False
    running: bool = True

    @property
    def at_ns(self) -> int:
        """Start of this entry, ns."""
        return 0 if self.at_ms is None and self.at_s is None else self.ns("at")


class StubTable(Table):
    """The result and data of a message, or the data of a consumed tag.

    Attributes:
        after_ms: for a message, its duration, ms; or use `after_s`. A consumed tag does not have this key.
        error: for a message, its ERR, 1 to 65,535; 0 if it succeeds.
        value: data that never changes.
        table: data over time.
        rack: rack file of the program that has the data; both racks run in the same virtual time.
        tag: the tag in the other rack; if omitted, a consumed tag uses the tag named in its export.
        to: for a message, the tag that receives the data; if omitted, the tag named in the export.
        rpi_ms: for a consumed tag, its RPI, ms; if omitted, the RPI in the export, else 20.
    """

    after_ms: Milliseconds | None = None
    after_s: Seconds | None = None
    error: Annotated[int, Field(ge=0, le=0xFFFF)] = 0
    value: Data = None
    table: Annotated[tuple[StubStep, ...], Field(strict=False)] = ()
    rack: str = ""
    tag: str = ""
    to: str = ""
    rpi_ms: Annotated[Number, between("0.01", "1000000")] | None = None

    @property
    def after_ns(self) -> int | None:
        """Duration of a message, ns; None for a consumed tag."""
        return None if self.after_ms is None and self.after_s is None else self.ns("after")

    @property
    def rpi_ns(self) -> int:
        """The RPI of a consumed tag, ns; 0 if omitted."""
        return 0 if self.rpi_ms is None else exact_ns(self.rpi_ms, "ms")

    @model_validator(mode="after")
    def _has_only_its_keys(self) -> Self:
        """Refuse a table with several sources of data, with keys of the other kind, or without data.

        A table with a duration is for a message; any other table is for a consumed tag.
        """
        sources = [name for name in ("value", "table", "rack") if name in self.model_fields_set]
        if len(sources) > 1:
            problem = f"this table has {sources[0]} already: write one of value, table and rack"
            raise SettingError(sources[1], problem)
        is_message = self.after_ns is not None
        wrong_keys = self.model_fields_set & ({"rpi_ms"} if is_message else {"error", "to"})
        if wrong_keys:
            other_kind = "consumed tag" if is_message else "message"
            raise SettingError(min(wrong_keys), f"only a {other_kind} has this key")
        if not is_message and not sources:
            raise SettingError("value", "a consumed tag needs value, table or rack; a message needs after_ms")
        if self.tag and not self.rack:
            raise SettingError("tag", "this is a tag of another rack: add a key `rack`")
        times = [step.at_ns for step in self.table]
        if times != sorted(set(times)):
            raise SettingError("table", "each entry must be later than the entry before it")
        return self
