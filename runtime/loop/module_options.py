"""Options of modules and controllers: checked values by name, from rack files and requests."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails
from scanrack.io_images.site import SettingError

from .events import JsonValue


class Options(BaseModel):
    """Base class of options. A subclass declares the name, type, range and default of each option.

    Raises:
        ValueError: a name is unknown, or a value is illegal. The message lists the allowed names or values.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, defer_build=True)

    owner: ClassVar[str]  # name of the device in messages

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            first_mistake = error.errors(include_url=False)[0]
            path = first_mistake["loc"]
            key = str(path[0]) if path else "options"
            raise SettingError(key, self._mistake(first_mistake)) from None

    @classmethod
    def of(cls, values: Mapping[str, JsonValue] | None) -> Self:
        """Return options from values by name; None = all defaults.

        Raises:
            ValueError: see the class.
        """
        return cls(**(values or {}))

    @classmethod
    def _mistake(cls, details: ErrorDetails) -> str:
        """Return the sentence about a mistake that pydantic found."""
        error = details.get("ctx", {}).get("error")
        if not details["loc"]:
            return f"options: {error}"
        name = ".".join(map(str, details["loc"]))
        if len(details["loc"]) > 1:
            return f"option {name}: {error or details['msg']}"
        if details["type"] == "extra_forbidden":
            close_names = difflib.get_close_matches(name, cls.model_fields, n=1)
            hint = f"choose from {', '.join(cls.model_fields)}"
            if close_names:
                hint = f"did you mean {close_names[0]}?"
            return f"option {name}: the {cls.owner} has no such option; {hint}"
        return f"option {name}: {error or _problem(cls.model_fields[name], details)}"


def _problem(field: FieldInfo, details: ErrorDetails) -> str:
    """Return the problem with an option's value, and the allowed values, as text."""
    value = details["input"]
    if get_origin(field.annotation) is Literal:
        return f"{value!r} is not allowed: {', '.join(map(str, get_args(field.annotation)))}"
    if details["type"] == "bool_type":
        return f"{value!r} is not true or false"
    if details["type"] == "int_type":
        return f"{value!r} is not a whole number"
    return f"{value!r} is out of range: {_range(field)}"


def _range(field: FieldInfo) -> str:
    """Return the range of a number, such as `1 to 8` or `0 and more`."""
    lower = next(limit.ge for limit in field.metadata if hasattr(limit, "ge"))
    upper = next((f"to {limit.le}" for limit in field.metadata if hasattr(limit, "le")), "and more")
    return f"{lower} {upper}"
