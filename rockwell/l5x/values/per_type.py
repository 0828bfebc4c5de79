"""Caches the results of methods by type."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Protocol, TypeVar

from scanrack.ladder.model.types import DataType


class _Owner(Protocol):
    # the type and the result, by method and `id` of the type; the type is kept so that its id stays unique
    by_type: dict[tuple[str, int], tuple[DataType, Any]]


Owner = TypeVar("Owner", bound=_Owner)
Kind = TypeVar("Kind", bound=DataType)
Result = TypeVar("Result")


def per_type(method: Callable[[Owner, Kind], Result]) -> Callable[[Owner, Kind], Result]:
    """Cache a method's results by type identity, because equal types may have different initial values."""
    name = method.__name__

    @wraps(method)
    def cached(owner: Owner, kind: Kind) -> Result:
        entry = owner.by_type.get((name, id(kind)))
        if entry is None:
            entry = owner.by_type[name, id(kind)] = kind, method(owner, kind)
        result: Result = entry[1]
        return result

    return cached
