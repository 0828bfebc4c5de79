"""Requests of `scanrack drive`: the keys for image targets, and errors for all targets.

Numbers are read as decimals, so that times are exact.
"""

from __future__ import annotations

import difflib
import json
from decimal import Decimal
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from scanrack.io_images.amci3601.words import WORDS_3601, Profile
from scanrack.io_images.doors import json_value
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MIN, WORDS

SCAN_STEP_MS = Decimal("0.25")

Word = Annotated[int, Field(ge=WORD_MIN, le=UNSIGNED_MAX, strict=True)]
Level = Annotated[int, Field(ge=0, le=1, strict=True)]
Steps = Annotated[int, Field(strict=True)]
Model = TypeVar("Model", bound=BaseModel)
Milliseconds = Annotated[Decimal, Field(ge=0, le=Decimal(10) ** 12)]


class Strict(BaseModel):
    """A table that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


def _ordered(span: tuple[int | None, int | None]) -> tuple[int | None, int | None]:
    first, last = span
    if first is not None and last is not None and first > last:
        raise ValueError("the first end of the range must not be above the last")
    return span


Span = Annotated[tuple[Steps | None, Steps | None], AfterValidator(_ordered)]
"""A closed range of steps; null is open-ended."""


class SwitchRanges(Strict):
    """Closed ranges of the physical step count at which an input is energized."""

    capture: Span | None = None
    external: Span | None = None
    home: Span | None = None
    estop: Span | None = None
    cw_limit: Span | None = None
    ccw_limit: Span | None = None

    @property
    def wired(self) -> dict[str, tuple[int | None, int | None]]:
        """The ranges of the inputs that have a switch, by input."""
        return {name: span for name, span in self if span is not None}


class Levels(Strict):
    """Electrical levels of the discrete inputs, 1 = energized."""

    capture: Level | None = None
    external: Level | None = None
    home: Level | None = None
    estop: Level | None = None
    cw_limit: Level | None = None
    ccw_limit: Level | None = None


class ImageBenchOptions(Strict):
    """Options of a fresh bench."""

    firmware: Literal["2.0", "2.1", "2.2", "3.1", "4.1"] = "4.1"
    scan_ms: Annotated[Decimal, Field(gt=0, le=10_000)] = Decimal(2)
    machine: SwitchRanges = SwitchRanges()
    wiring: Literal["diagnostic"] | None = None
    options: dict[str, bool | int | str] = {}

    @field_validator("scan_ms")
    @classmethod
    def _multiple(cls, value: Decimal) -> Decimal:
        if value % SCAN_STEP_MS:
            raise ValueError(f"must be a multiple of {SCAN_STEP_MS}")
        return value


class Encoder(Strict):
    """A hand turns the encoder during this request."""

    counts: Steps = 0
    markers_ms: list[Milliseconds] = []


class Until(Strict):
    """Status bits that end the request when they have these values."""

    set: list[str] = []
    clear: list[str] = []

    @field_validator("set", "clear")
    @classmethod
    def _known(cls, names: list[str], info: ValidationInfo) -> list[str]:
        profile: Profile = info.context or WORDS_3601
        for name in names:
            if name not in profile.masks:
                closest = difflib.get_close_matches(name.upper(), sorted(profile.masks), n=1)
                hint = f"; did you mean {closest[0]}?" if closest else ""
                raise ValueError(f"{name} is not the name of a status bit{hint}")
        return names


class Request(Strict):
    """One request to an image target."""

    new: ImageBenchOptions | None = None
    power_cycle: Literal[True] | None = None
    plc_mode: Literal["run", "program"] | None = None
    out: Annotated[list[Word], Field(min_length=WORDS, max_length=WORDS)] | None = None
    inputs: Levels = Levels()
    encoder: Encoder | None = None
    for_ms: Milliseconds = Decimal(0)
    until: Until | None = None
    changes: Annotated[bool, Field(strict=True)] = False

    @model_validator(mode="after")
    def _turning_takes_time(self) -> Request:
        if self.encoder is not None:
            if self.encoder.counts and not self.for_ms:
                raise ValueError(
                    "encoder: counts are spread over the request's time, so for_ms must be above 0"
                )
            late = [str(marker_ms) for marker_ms in self.encoder.markers_ms if marker_ms > self.for_ms]
            if late:
                raise ValueError(f"encoder.markers_ms: {', '.join(late)} is beyond for_ms = {self.for_ms}")
        return self


class RequestError(ValueError):
    """The request is illegal; the message names the key, the value and the allowed values."""


def bytes_of(text: str) -> bytes:
    """Return the bytes of `tx`; raise RequestError for text that is not hex."""
    try:
        return bytes.fromhex(text)
    except ValueError:
        raise RequestError(f'tx: "{text[:60]}" is not allowed: bytes in hex are') from None


def read(line: str, model: type[Model], profile: Profile = WORDS_3601) -> Model:
    """Read one line.

    Args:
        profile: profile of the module, with the names of its status bits.

    Raises:
        RequestError: the line is not a JSON object, has an unknown key, or has a value that is not allowed.
    """
    try:
        data = json_value(line, parse_float=Decimal, parse_constant=_no_constant)
    except ValueError as error:
        raise RequestError(f"not a JSON object: {error}") from None
    if not isinstance(data, dict):
        raise RequestError(f"not a JSON object: {line.strip()[:60]}")
    try:
        return model.model_validate(data, context=profile)
    except ValidationError as error:
        raise RequestError("; ".join(_explain(fault, model) for fault in error.errors())) from None


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is not a number")


def _table(model: type[BaseModel], place: tuple[str, ...]) -> type[BaseModel] | None:
    """Return the model of the object at a place in a request; None if the value there has no single model."""
    for name in place:
        if name not in model.model_fields:
            return None
        kind = model.model_fields[name].annotation
        inner = [type_ for type_ in (kind, *get_args(kind)) if hasattr(type_, "model_fields")]
        if len(inner) != 1:
            return None
        model = inner[0]
    return model


def _explain(fault: Any, model: type[BaseModel]) -> str:
    """Return a validation error as one line of text: key, value, allowed values."""
    key = ".".join(str(part) for part in fault["loc"]) or "request"
    if fault["type"] == "extra_forbidden":
        table = _table(model, fault["loc"][:-1])
        choices_text = f"; choose from {', '.join(table.model_fields)}" if table is not None else ""
        return f"{key}: unknown key{choices_text}"
    value = "" if isinstance(fault["input"], BaseModel | dict) else f" {_shown(fault['input'])}"
    message = fault.get("ctx", {}).get("error") or fault["msg"]
    return f"{key}:{value} is not allowed: {message}" if value else f"{key}: {message}"


def _shown(value: Any) -> str:
    return json.dumps(value, default=lambda other: float(other) if isinstance(other, Decimal) else "")[:80]
