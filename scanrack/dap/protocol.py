"""Checked arguments of requests, and the error that a request can raise."""

from __future__ import annotations

from typing import Any, TypeVar

Json = dict[str, Any]
T = TypeVar("T")


class DebugError(ValueError):
    """A request can't be carried out; the message is shown to the user."""


def whole(arguments: Json, name: str, default: int | None = None) -> int:
    """Return a whole number from a request; raise DebugError if it is missing or has another type."""
    return _argument(arguments, name, default, int, "a whole number")


def text(arguments: Json, name: str, default: str | None = None) -> str:
    """Return a text from a request; raise DebugError if it is missing or has another type."""
    return _argument(arguments, name, default, str, "a text")


def _argument(arguments: Json, name: str, default: T | None, kind: type[T], meaning: str) -> T:
    value = arguments.get(name, default)
    if type(value) is not kind:
        raise DebugError(f"{name} {value!r}: must be {meaning}")
    return value


def objects(arguments: Json, name: str) -> list[Json]:
    """Return a list of objects from a request, or an empty list; raise DebugError for another type."""
    value = arguments.get(name) or []
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise DebugError(f"{name} must be a list of objects")
    return value
