"""Describes changes of recorded tags as text: `+Run`, `-Lamp`, `Step IDLE -> FILL`, `Counts[2] 7 -> 9`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.tag_names import element_of

from ..format.tagplan import TagField, TagPlan

DISCRETE = ("BOOL", "ENUM", "TEXT")
"""Types whose every change is shown; numbers may change in every scan."""


class TagText:
    """Describes the changes from row to row.

    Args:
        texts: meanings of the codes of texts.
    """

    def __init__(self, plan: TagPlan, texts: Mapping[int, str], *, every: bool = False) -> None:
        self._dtype = plan.dtype
        self._texts = texts
        self._fields = [field for field in plan.fields if every or field.tag.type in DISCRETE]

    def changed(self, rows: NDArray[np.void]) -> NDArray[np.bool_]:
        """Return which rows differ from the previous one in a shown value; the first counts as changed."""
        is_changed = np.zeros(len(rows), bool)
        is_changed[:1] = True
        for field in self._fields:
            is_different = _differs(rows[field.name][1:], rows[field.name][:-1])
            is_changed[1:] |= is_different if is_different.ndim == 1 else is_different.any(axis=1)
        return is_changed

    def changes(self, before: bytes, after: bytes) -> str:
        """Return the changes as text; without a previous row, the values that are not 0."""
        if before == after:
            return ""
        new_values = np.frombuffer(after, self._dtype)
        old_values = np.frombuffer(before, self._dtype) if before else None
        return " ".join(text for field in self._fields for text in self._field(field, old_values, new_values))

    def _field(self, field: TagField, old: NDArray[np.void] | None, new: NDArray[np.void]) -> Iterator[str]:
        values = np.atleast_1d(new[field.name][0])
        zeros = np.zeros_like(values)
        old_values = zeros if old is None else np.atleast_1d(old[field.name][0])
        codes = old is None and field.tag.type in ("ENUM", "TEXT")  # code 0 is also a name
        for index in np.flatnonzero(
            np.ones(len(values), bool) if codes else _differs(values, old_values)
        ).tolist():
            name = element_of(field.tag.name, index) if field.tag.length else field.tag.name
            if field.tag.type == "BOOL":
                yield f"{'+' if values[index] else '-'}{name}"
            elif old is None:
                yield f"{name} {self._value(field, values[index])}"
            else:
                yield f"{name} {self._value(field, old_values[index])} -> {self._value(field, values[index])}"

    def _value(self, field: TagField, value: Any) -> str:
        if field.tag.type == "TEXT":
            return repr(self._texts.get(int(value), f"text {value}"))
        if field.tag.type == "ENUM" and int(value) < len(field.constants):
            return field.constants[int(value)]
        return str(value)


def _differs(one: NDArray[Any], other: NDArray[Any]) -> NDArray[np.bool_]:
    """Return where two arrays differ; NaN equals NaN."""
    is_different: NDArray[np.bool_] = one != other
    if one.dtype.kind == "f":
        is_different &= ~(np.isnan(one) & np.isnan(other))
    return is_different
