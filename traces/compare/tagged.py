"""Converts the recorded tags of two traces to rows with the same layout, so that they can be compared.

first trace     | Run | Step (0 = IDLE, 1 = FILL) | Level |
second trace    | Step (0 = FILL, 1 = IDLE) | Run |
both            | Run | Step (one number per name) |
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
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
        dtype: type of a row of the tags, with a field per value under its full name.
        only_a: full names of the tags that only the first trace has.
        only_b: full names of the tags that only the second trace has.
    """

    def __init__(self, a: Trace, b: Trace) -> None:
        fields_a, fields_b = _by_name(a), _by_name(b)
        self._texts = [trace.texts() for trace in (a, b)]
        # by full name: the fields of both traces
        self._pairs = {
            name: (field, fields_b[name])
            for name, field in fields_a.items()
            if name in fields_b and _are_comparable(field, fields_b[name])
        }
        self._codes: dict[str, int] = {}  # code of each name or text, for both traces
        types = {name: kind for pair in self._pairs.values() for name, kind in _value_types(*pair)}
        self.dtype: np.dtype[np.void] = np.dtype(list(types.items()))
        self.only_a = sorted(fields_a.keys() - self._pairs.keys())
        self.only_b = sorted(fields_b.keys() - self._pairs.keys())

    def rows(self, parts: Iterable[Columns], side: int) -> Iterator[Columns]:
        """Yield the parts of a trace, with the shared tags in place of its own tags.

        Args:
            parts: scans of the trace, with its recorded tags.
            side: 0 for the first trace, 1 for the second.
        """
        for columns in parts:
            tags = np.zeros(len(columns.scan), self.dtype)
            for name, field_pair in self._pairs.items():
                field, named_field = field_pair[side], field_pair[0]  # both sides use the first trace's names
                assert columns.tags is not None, "the trace has tags"
                values = columns.tags[field.name]
                if field.tag.type in CODES:
                    values = self._shared_codes(values, code_names(field, self._texts[side]))
                values = wide(values) if _are_mixed(*field_pair) else values
                if field.tag.length:
                    for index, address in enumerate(named_field.tag.addresses):
                        tags[address] = values[:, index]
                else:
                    tags[name] = values
            yield columns._replace(tags=tags)

    def fields(self) -> Iterator[Field]:
        """Yield a compared field for each tag value."""
        for field_pair in self._pairs.values():
            text_of = self._name_of if field_pair[0].tag.type in CODES else _number_text
            for name, _ in _value_types(*field_pair):
                key, text = partial(_key, name), partial(_text, name, text_of)
                yield Field(None, "tags", name, FieldKind.TAG, word=0, words=0, key=key, text=text)

    def _shared_codes(self, codes: Array, names: Mapping[int, str]) -> Array:
        """Convert one trace's codes to codes that both traces share."""
        distinct_codes, indexes = np.unique(codes, return_inverse=True)
        texts = [names.get(code, str(code)) for code in distinct_codes.tolist()]
        shared_codes = np.array([self._codes.setdefault(text, len(self._codes)) for text in texts], np.int64)
        return shared_codes[indexes].reshape(codes.shape)

    def _name_of(self, code: int) -> str:
        return list(self._codes)[code]  # codes are consecutive, in the order of the dictionary


def _by_name(trace: Trace) -> dict[str, TagField]:
    if trace.head.tags is None:
        return {}
    return {without_ranges(field.tag.name): field for field in trace.head.tags.fields}


def _are_comparable(a: TagField, b: TagField) -> bool:
    """Return whether two tags have equal lengths, and both or neither have codes for names."""
    return a.tag.length == b.tag.length and (a.tag.type in CODES) == (b.tag.type in CODES)


def _value_types(a: TagField, b: TagField) -> Iterator[tuple[str, str]]:
    """Yield the full name and the shared numpy type of each value of two tags with the same name."""
    kind = "<i8" if a.tag.type in CODES else np.result_type(*_dtypes(a, b)).str
    kind = WIDE if _are_mixed(a, b) else kind
    yield from ((address, kind) for address in a.tag.addresses)


def _dtypes(*fields: TagField) -> list[np.dtype[Any]]:
    return [np.dtype(f"<{field.letters[-1]}") for field in fields]


def _are_mixed(a: TagField, b: TagField) -> bool:
    """Return whether numpy has no exact common type, as for LINT with ULINT, or either with a float."""
    types = _dtypes(a, b)
    has_64_bit_integer = any(dtype.kind in "iu" and dtype.itemsize == 8 for dtype in types)
    return has_64_bit_integer and np.result_type(*types).kind == "f"


def wide(values: Array) -> Array:
    """Return numbers of any type as pairs of floats, which are equal only if the numbers are equal.

    The number is the real part times 2**32 plus the imaginary part; both parts have its sign.

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
        # `high` is rounded down; for a negative number, 1 moves from `low` to `high`, so that signs are equal
        is_moved = (values < 0) & (low != 0)
        result.real = high.astype(np.float64) + is_moved
        result.imag = low.astype(np.float64) - is_moved * 2.0**32
    return result + 0.0  # -0.0 is 0.0


def _number_text(value: Any) -> str:
    """Return a number, or a pair from `wide`, as text."""
    if not isinstance(value, complex):
        return str(value)
    if np.isinf(value.real):
        return "nan" if value.imag else str(value.real)
    if value.imag.is_integer() and abs(value.real) <= 2**32:
        return str((int(value.real) << 32) + int(value.imag))
    return str(value.real * 2.0**32 + value.imag)


def _key(name: str, rows: Array) -> Array:
    """Return values in a form that == can compare, where NaN equals NaN and 0.0 equals -0.0."""
    values: Array = rows[name]
    if values.dtype.kind != "f":
        return values
    floats = values.astype(np.float64) + 0.0
    floats[np.isnan(floats)] = np.nan
    keys: Array = floats.view(np.int64)
    return keys


def _text(name: str, text_of: Callable[[Any], str], row: Array) -> str:
    return text_of(row[name].item())
