"""Brings recorded tags of two traces into one row: tags match by full name, and codes by meaning.

first trace     | Run | Step (0 = IDLE, 1 = FILL) | Level |
second trace    | Step (0 = FILL, 1 = IDLE) | Run |
both            | Run | Step (one number per name) |
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.tag_names import without_ranges

from ..format.tagplan import TagField
from ..read.columns import Columns
from ..read.reader import Trace
from ..signals.tags import CODES, code_names
from .fields import Field, FieldKind

Array = NDArray[Any]

WIDE = "<c16"
"""Numpy type of pairs of floats, for numbers without a common numpy type."""


class CommonTags:
    """The tags that two traces share.

    Attributes:
        dtype: type of a row of them, with a field per value under its full name.
        only: full names of the tags that only the first trace has, and those that only the second has.
    """

    def __init__(self, one: Trace, other: Trace) -> None:
        fields_by_name = [_by_name(trace) for trace in (one, other)]
        self._texts = [trace.texts() for trace in (one, other)]
        self._pairs = {
            name: (fields_by_name[0][name], fields_by_name[1][name])
            for name in fields_by_name[0]
            if _alike(name, *fields_by_name)
        }
        self._codes: dict[str, int] = {}
        layout = dict(field_layout for pair in self._pairs.values() for field_layout in _values(*pair))
        self.dtype: np.dtype[np.void] = np.dtype(list(layout.items()))
        names_a, names_b = (sorted(names.keys() - self._pairs.keys()) for names in fields_by_name)
        self.only = (tuple(names_a), tuple(names_b))

    def rows(self, parts: Iterable[Columns], side: int) -> Iterator[Columns]:
        """Yield the parts of a trace, with the shared tags in place of its own tags.

        Args:
            parts: scans of the trace with its tags, if it has any.
            side: 0 for the first trace, 1 for the second.
        """
        for columns in parts:
            tags = np.zeros(len(columns.scan), self.dtype)
            for name, field_pair in self._pairs.items():
                field = field_pair[side]
                assert columns.tags is not None, "the trace has tags"
                values = columns.tags[field.name]
                if field.tag.type in CODES:
                    values = self._shared(values, code_names(field, self._texts[side]))
                values = wide(values) if _are_mixed(*field_pair) else values
                if field.tag.length:
                    for index, address in enumerate(field_pair[0].tag.addresses):
                        tags[address] = values[:, index]
                else:
                    tags[name] = values
            yield columns._replace(tags=tags)

    def fields(self) -> Iterator[Field]:
        """Yield a compared field for each tag value."""
        for field_pair in self._pairs.values():
            codes = field_pair[0].tag.type in CODES
            for value, _ in _values(*field_pair):
                key, text = partial(_key, value), self._name if codes else _number
                yield Field(None, "tags", value, FieldKind.TAG, 0, 0, key, text=partial(_text, value, text))

    def _shared(self, codes: Array, names: Mapping[int, str]) -> Array:
        """Convert codes of one trace to codes that both traces share."""
        distinct, places = np.unique(codes, return_inverse=True)
        texts = [names.get(code, str(code)) for code in distinct.tolist()]
        shared_codes = np.array([self._codes.setdefault(text, len(self._codes)) for text in texts], np.int64)
        return shared_codes[places].reshape(codes.shape)

    def _name(self, code: int) -> str:
        return next(text for text, text_code in self._codes.items() if text_code == code)


def _by_name(trace: Trace) -> dict[str, TagField]:
    return (
        {}
        if trace.head.tags is None
        else {without_ranges(field.tag.name): field for field in trace.head.tags.fields}
    )


def _alike(name: str, one: Mapping[str, TagField], other: Mapping[str, TagField]) -> bool:
    """Return whether both have a comparable tag with that name."""
    if name not in other:
        return False
    tag_a, tag_b = one[name].tag, other[name].tag
    return tag_a.length == tag_b.length and (tag_a.type in CODES) == (tag_b.type in CODES)


def _values(one: TagField, other: TagField) -> Iterator[tuple[str, str]]:
    kind = "<i8" if one.tag.type in CODES else np.result_type(*_dtypes(one, other)).str
    kind = WIDE if _are_mixed(one, other) else kind
    yield from ((address, kind) for address in one.tag.addresses)


def _dtypes(*fields: TagField) -> list[np.dtype[Any]]:
    return [np.dtype(f"<{field.letters[-1]}") for field in fields]


def _are_mixed(one: TagField, other: TagField) -> bool:
    """Return whether numpy has no exact common type: for LINT with ULINT, and either with a float."""
    kinds = _dtypes(one, other)
    widest = any(kind.kind in "iu" and kind.itemsize == 8 for kind in kinds)
    return widest and np.result_type(*kinds).kind == "f"


def wide(values: Array) -> Array:
    """Return numbers of any type as pairs of floats that are equal exactly where the numbers are.

    The real part is a multiple of 2**32, the imaginary part the rest, with the same sign.

    >>> wide(np.array([2**64 - 1], np.uint64)), wide(np.array([-0.5]))
    (array([4.2949673e+09+4.2949673e+09j]), array([0.-0.5j]))
    """
    result = np.zeros(values.shape, WIDE)
    if values.dtype.kind == "f":
        floats = values.astype(np.float64)
        finite = np.isfinite(floats)
        remainders = np.fmod(floats, 2.0**32, where=finite, out=np.zeros_like(floats))
        result.real = np.where(np.isnan(floats), np.inf, (floats - remainders) / 2.0**32)
        result.imag = np.where(np.isnan(floats), 1, remainders)
    else:
        integers = values.astype(np.uint64 if values.dtype.kind == "u" else np.int64)
        high, low = integers >> integers.dtype.type(32), integers & integers.dtype.type(0xFFFF_FFFF)
        negative = (values < 0) & (low != 0)
        result.real = high.astype(np.float64) + negative
        result.imag = low.astype(np.float64) - negative * 2.0**32
    return result + 0.0  # -0.0 is 0.0


def _number(value: Any) -> str:
    """Return a number, or a pair of `wide`, as text."""
    if not isinstance(value, complex):
        return str(value)
    if np.isinf(value.real):
        return "nan" if value.imag else str(value.real)
    if value.imag.is_integer() and abs(value.real) <= 2**32:
        return str((int(value.real) << 32) + int(value.imag))
    return str(value.real * 2.0**32 + value.imag)


def _key(name: str, rows: Array) -> Array:
    """Return values as integers that are equal where the values are; NaN equals NaN, and 0.0 equals -0.0."""
    values: Array = rows[name]
    if values.dtype.kind != "f":
        return values
    floats = values.astype(np.float64) + 0.0
    floats[np.isnan(floats)] = np.nan
    keys: Array = floats.view(np.int64)
    return keys


def _text(name: str, text: Any, row: Array) -> str:
    return str(text(row[name].item()))
