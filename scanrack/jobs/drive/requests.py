"""Requests of `scanrack drive`: the keys for modules with 8 + 8 words, and errors for all targets.

Numbers with fractions are read as decimals, so that times are exact.
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
        raise ValueError("the first position of the range must not be above the last position")
    return span


Span = Annotated[tuple[Steps | None, Steps | None], AfterValidator(_ordered)]
"""First and last position of a range, steps; null = no limit."""


class SwitchRanges(Strict):
    """The ranges of shaft positions where inputs are energized."""

    capture: Span | None = None
    external: Span | None = None
    home: Span | None = None
    estop: Span | None = None
    cw_limit: Span | None = None
    ccw_limit: Span | None = None

    @property
    def wired(self) -> dict[str, tuple[int | None, int | None]]:
        """The ranges by input; only inputs with a switch."""
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
    """Manual turns of the encoder during a request."""

    counts: Steps = 0  # evenly spread over the request's time
    markers_ms: list[Milliseconds] = []  # times of marker pulses after the begin of the request


class Until(Strict):
    """Status bits that end the request when they have these values."""

    set: list[str] = []
    clear: list[str] = []

    @field_validator("set", "clear")
    @classmethod
    def _are_status_bits(cls, names: list[str], info: ValidationInfo) -> list[str]:
        """Return the names; raise ValueError for a name that is not a status bit of the module's words."""
        profile: Profile = info.context or WORDS_3601
        for name in names:
            if name not in profile.masks:
                closest = difflib.get_close_matches(name.upper(), sorted(profile.masks), n=1)
                hint = f"; did you mean {closest[0]}?" if closest else ""
                raise ValueError(f"{name} is not the name of a status bit{hint}")
        return names


class Request(Strict):
    """A request to a module with 8 + 8 words."""

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
        """Refuse encoder counts in a request without a duration, and marker pulses after its end."""
        if self.encoder is not None:
            if self.encoder.counts and not self.for_ms:
                raise ValueError(
                    "encoder: counts are spread over the request's time, so for_ms must be above 0"
                )
            late_markers = [
                str(marker_ms) for marker_ms in self.encoder.markers_ms if marker_ms > self.for_ms
            ]
            if late_markers:
                late_text = ", ".join(late_markers)
                raise ValueError(f"encoder.markers_ms: {late_text} is beyond for_ms = {self.for_ms}")
        return self


class RequestError(ValueError):
    """The request is illegal; the message names the key, the value and the allowed values."""


def bytes_of(text: str) -> bytes:
    """Return the bytes of `tx`; raise RequestError for text that is not hex."""
    try:
        return bytes.fromhex(text)
    except ValueError:
        raise RequestError(f'tx: "{text[:60]}" is not allowed: must be bytes in hex') from None


def read(line: str, model: type[Model], profile: Profile = WORDS_3601) -> Model:
    """Return the request in a line.

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


def _model_at(model: type[BaseModel], path: tuple[str, ...]) -> type[BaseModel] | None:
    """Return the model of the object at a path in a request; None if it has no single model."""
    for name in path:
        if name not in model.model_fields:
            return None
        annotation = model.model_fields[name].annotation
        models = [kind for kind in (annotation, *get_args(annotation)) if hasattr(kind, "model_fields")]
        if len(models) != 1:
            return None
        model = models[0]
    return model


def _explain(fault: Any, model: type[BaseModel]) -> str:
    """Return a validation error as one line of text: key, value, allowed values."""
    key = ".".join(str(part) for part in fault["loc"]) or "request"
    if fault["type"] == "extra_forbidden":
        table = _model_at(model, fault["loc"][:-1])
        choices = "" if table is None else f"; choose from {', '.join(table.model_fields)}"
        return f"{key}: unknown key{choices}"
    value = "" if isinstance(fault["input"], BaseModel | dict) else f" {_shown(fault['input'])}"
    message = fault.get("ctx", {}).get("error") or fault["msg"]
    return f"{key}:{value} is not allowed: {message}" if value else f"{key}: {message}"


def _shown(value: Any) -> str:
    return json.dumps(value, default=lambda other: float(other) if isinstance(other, Decimal) else "")[:80]
