"""Describes changes in recorded tags as text: `+Run`, `-Lamp`, `Step IDLE -> FILL`, `Counts[2] 7 -> 9`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.tag_names import element_of

from ..format.tagplan import TagField, TagPlan

DISCRETE = ("BOOL", "ENUM", "TEXT")
"""Types for which every change is shown. Other types are numbers, which can change in every scan."""


class TagText:
    """Describes the changes from one row of tags to the next.

    Args:
        texts: the recorded texts by code.
        every: whether to show changes in numbers.
    """

    def __init__(self, plan: TagPlan, texts: Mapping[int, str], *, every: bool = False) -> None:
        self._dtype = plan.dtype
        self._texts = texts
        self._fields = [field for field in plan.fields if every or field.tag.type in DISCRETE]

    def changed(self, rows: NDArray[np.void]) -> NDArray[np.bool_]:
        """Return a mask of the rows that differ from the previous row in a shown value.

        The first row counts as changed.
        """
        is_changed = np.zeros(len(rows), bool)
        is_changed[:1] = True
        for field in self._fields:
            is_different = _differs(rows[field.name][1:], rows[field.name][:-1])
            is_changed[1:] |= is_different if is_different.ndim == 1 else is_different.any(axis=1)
        return is_changed

    def changes(self, before: bytes, after: bytes) -> str:
        """Return the changes as text; if there is no previous row, return the values that are not 0."""
        if before == after:
            return ""
        new_values = np.frombuffer(after, self._dtype)
        old_values = np.frombuffer(before, self._dtype) if before else None
        return " ".join(text for field in self._fields for text in self._field(field, old_values, new_values))

    def _field(self, field: TagField, old: NDArray[np.void] | None, new: NDArray[np.void]) -> Iterator[str]:
        """Yield the changed values of a field as text; without a previous row, yield nonzero values."""
        values = np.atleast_1d(new[field.name][0])
        old_values = np.zeros_like(values) if old is None else np.atleast_1d(old[field.name][0])
        is_shown = _differs(values, old_values)
        if old is None and field.tag.type in ("ENUM", "TEXT"):
            is_shown[:] = True  # code 0 is a name or a text
        for index in np.flatnonzero(is_shown).tolist():
            name = element_of(field.tag.name, index) if field.tag.length else field.tag.name
            if field.tag.type == "BOOL":
                yield f"{'+' if values[index] else '-'}{name}"
            elif old is None:
                yield f"{name} {self._value(field, values[index])}"
            else:
                yield f"{name} {self._value(field, old_values[index])} -> {self._value(field, values[index])}"

    def _value(self, field: TagField, value: Any) -> str:
        """Return a value as text: a recorded text in quotes, the name of an enum's code, or a number."""
        if field.tag.type == "TEXT":
            return repr(self._texts.get(int(value), f"text {value}"))
        if field.tag.type == "ENUM" and int(value) < len(field.constants):
            return field.constants[int(value)]
        return str(value)


def _differs(new: NDArray[Any], old: NDArray[Any]) -> NDArray[np.bool_]:
    """Return a mask of the elements that differ; NaN equals NaN."""
    is_different: NDArray[np.bool_] = new != old
    if new.dtype.kind == "f":
        is_different &= ~(np.isnan(new) & np.isnan(old))
    return is_different
