"""Initial values from a document, in the form of `Tag.initial`.

| form | content |
|---|---|
| bytes, `<Data>3C 00</Data>` | the whole tag, if its memory layout is known, see `raw` |
| L5K | the whole tag in memory order, if the order is known, see `l5k` |
| Decorated | members by name without local tags of add-ons; zeros may be missing |
| String | the characters of a string, or of an array's first element |
| Message, Alarm, Axis | members as attributes |

The value of a tag is the first of these forms that it has. If another form has a different value, that is
reported.

    <Structure DataType="Recipe">
      <DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5"/>
      <ArrayMember Name="Steps" DataType="DINT" Dimensions="2"><Element Index="[0]" Value="7"/>...
      <StructureMember Name="Delay" DataType="TIMER"><DataValueMember Name="PRE" .../>...

Zeros are omitted unless the type has other initial values. A value that does not fit its type is reported and
then truncated or omitted.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

from scanrack.ladder.model.types import BOOL, DataType, Elementary, Member, Structure, count_of
from scanrack.ladder.state.named_parts import alias_target

from ..xml.data import Data, DecoratedValue
from ..xml.records import Element
from .agreement import first_difference, value_at
from .datatypes import Types
from .initials import ValueReading, nested, scalar
from .l5k import OtherVersionError, filled, from_l5k
from .raw import RawReader, bytes_in, fits
from .value_texts import TRUTH, ValueTextError, ignored, unquoted_or_raise, value_of

_INDEX = re.compile(r"\d{1,9}")


def initial_of(
    data: Sequence[Data],
    kind: DataType,
    dims: tuple[int, ...],
    types: Types,
    remark: Callable[[str], None] = ignored,
) -> Any:
    """Return an initial value from `Data` elements; None for the type's own initial value.

    Args:
        remark: called with a text for each omitted or truncated value.

    Raises:
        ValueTextError: the value can't be read.
    """
    if len(data) == 1 and data[0].value is not None and isinstance(kind, Elementary) and not dims:
        return scalar(data[0].value, kind, ValueReading(remark=remark))
    return _Forms(data, kind, dims, types, remark).value()


class _Forms:
    """The forms of a tag's value."""

    def __init__(
        self,
        data: Sequence[Data],
        kind: DataType,
        dims: tuple[int, ...],
        types: Types,
        remark: Callable[[str], None],
    ) -> None:
        self._kind, self._dims, self._remark, self._types = kind, dims, remark, types
        self._data = {part.form: part for part in data}
        self._reading = ValueReading(types.has_initials(kind), remark, types.layouts)

    def value(self) -> Any:
        """Return the value of the first form; report forms that differ from it."""
        values = self._complete_forms()
        if not values:
            if "Decorated" in self._data:
                return self._decorated_form(keep_zeros=self._reading.keep_zeros)
            return self._incomplete_form()
        form = next(iter(values))
        if "Decorated" in self._data:
            values["Decorated"] = self._decorated_form(keep_zeros=True)
        elif "String" in self._data and not self._dims and "L5K" in values:
            values["String"] = self._string_form()
        self._report_difference(values)
        return values[form]

    def _complete_forms(self) -> dict[str, Any]:
        """Return the values of the readable forms that contain the tag's whole memory, by form."""
        kind, dims, layouts = self._kind, self._dims, self._types.layouts
        values: dict[str, Any] = {}
        raw = self._raw_bytes() if layouts.is_known(kind) else None
        # bytes beside another form are read only if the places of arrays in them are certain
        if raw and fits(raw, kind, dims, layouts) and (len(self._data) == 1 or layouts.is_certain(kind)):
            values["bytes"] = RawReader(raw, layouts, keep_zeros=self._reading.keep_zeros).read(kind, dims)
        if "L5K" in self._data and self._data.keys().isdisjoint(_PARAMETER_FORMS):
            text = "".join(self._data["L5K"].element.itertext())
            try:
                value = from_l5k(text, kind, dims, self._reading)
                values["L5K"] = self._with_unread_members(value) if self._reading.unread else value
            except OtherVersionError as error:
                if "Decorated" not in self._data or self._types.has_locals(kind):
                    self._remark(str(error))
        return values

    def _with_unread_members(self, value: Any) -> Any:
        """Return a value with its unread members filled in from decorated data."""
        if self._types.has_locals(self._kind):
            names = ", ".join(dict.fromkeys(self._reading.unread))
            self._remark(f"{names} in local tags start with their defaults: their memory is not known")
        return filled(value, self._decorated_form(keep_zeros=True) if "Decorated" in self._data else None)

    def _raw_bytes(self) -> bytes | None:
        return bytes_in(self._data[""].element) if "" in self._data else None

    def _decorated_form(self, *, keep_zeros: bool) -> Any:
        """Return the value in decorated data; None if the data is empty."""
        kind, dims, data = self._kind, self._dims, self._data["Decorated"]
        reading = replace(self._reading, keep_zeros=keep_zeros)
        if isinstance(kind, Elementary) and not dims:
            expected_tag = "DataValue"
            if data.value is not None:
                return scalar(data.value, kind, reading)
        else:
            expected_tag = "Array" if dims else "Structure"
        inner = next(iter(data.values(zeros=keep_zeros)), None)
        if inner is None:
            return None
        if inner.tag != expected_tag:
            raise ValueTextError(f"its data are of the form {inner.tag}, not {expected_tag}")
        return _value(inner, kind, dims, reading)

    def _string_form(self) -> str | None:
        """Return the characters of a string; None if it is empty, or the type is not a string."""
        kind = self._kind
        if not isinstance(kind, Structure) or not kind.is_string:
            return None
        return _truncated(unquoted_or_raise((self._data["String"].element.text or "").strip()), kind) or None

    def _incomplete_form(self) -> Any:
        """Return the value of another form; None if there is none."""
        kind, dims = self._kind, self._dims
        for form in _PARAMETER_FORMS:
            if form in self._data:
                return None if dims else _parameters(self._data[form].element, kind)
        if "String" in self._data and isinstance(kind, Structure) and kind.is_string:
            if not dims:
                return self._string_form()
            self._remark("the file has its first text only")
            return nested([self._string_form()], kind, ())
        if self._data.keys() == {""}:
            is_known = self._types.layouts.is_known(kind)
            _refuse_bytes(self._data[""].element, self._raw_bytes(), kind, known=is_known)
        return None

    def _report_difference(self, values: Mapping[str, Any]) -> None:
        """Report the first value in the first form that differs from another form."""
        first = next(iter(values))
        for form in values:
            path = first_difference(self._kind, self._dims, values[first], values[form])
            if form != first and path is not None:
                texts = (f"{name} {value_at(self._kind, value, path)}" for name, value in values.items())
                place = f" at {''.join(path)}" if path else ""
                self._remark(f"its forms differ{place}: {', '.join(texts)}; the {first} count")
                return


_PARAMETER_FORMS = ("Message", "Alarm", "Axis", "CoordinateSystem")
"""Forms with members as attributes."""


def _refuse_bytes(element: Element, raw: bytes | None, kind: DataType, *, known: bool) -> None:
    """Raise a ValueTextError for unreadable bytes, unless they are zeros.

    Args:
        known: whether the memory layout of the type is known.
    """
    if raw is None:
        raise ValueTextError(f"{(element.text or '').strip()[:20]!r} is not a list of bytes")
    if any(raw) and known:
        raise ValueTextError(f"it has {len(raw)} bytes; its type has another size")
    if any(raw):
        text = f"the order of the bytes of a {kind.name} is not known; export decorated data"
        raise ValueTextError(text)


# --- decorated


def _value(data: DecoratedValue, kind: DataType, dims: tuple[int, ...], reading: ValueReading) -> Any:
    """Return a decorated value as in `Tag.initial`; None for zeros that may be omitted."""
    if dims:
        return _array(data, kind, dims, reading)
    if isinstance(kind, Elementary):
        return scalar(data.value, kind, reading)
    return _structure(data, kind, reading)


_ZEROS = ("0", "0.0", "0.00000000e+000")
"""The most frequent values in an export; comparing them is faster than reading them."""


class _MemberEntry(NamedTuple):
    """A member of a structure, prepared for reading."""

    member: Member
    elementary: Elementary | None  # its type if it is a single value
    mistake: str  # why it can't have a value; "" if it can


def _structure(data: DecoratedValue, kind: Structure, reading: ValueReading) -> Any:
    """Return the values of members by name, or the characters of a string; None for zeros."""
    entries, is_string = _members_of(kind)
    if is_string and not _has_elements(data):
        return _characters(data, kind, reading)
    members = {}
    for inner in data.inner:
        _, name, text, _, _ = inner
        entry = entries.get(name) or entries.get(name.upper())
        if entry is None:
            continue
        member, elementary, mistake = entry
        if elementary is None:
            value = _value(inner, member.type, member.dims, reading)
        else:
            value = None if text in _ZEROS and not reading.keep_zeros else scalar(text, elementary, reading)
        if value is not None and mistake:
            reading.remark(mistake)
        elif value is not None:
            members[member.name] = value
    return members or None


def _characters(data: DecoratedValue, kind: Structure, reading: ValueReading) -> str | None:
    """Return the characters of a string; None if it is empty or has no DATA."""
    text = next((inner.text for inner in data.inner if inner.name == "DATA"), None)
    characters = None if text is None else _truncated(unquoted_or_raise(text.strip()), kind)
    return characters if characters or reading.keep_zeros else None


def _has_elements(data: DecoratedValue) -> bool:
    """Return whether the characters of a string are array elements instead of text."""
    arrays = (inner for inner in data.inner if inner.tag == "ArrayMember")
    return any(element.tag == "Element" for array in arrays for element in array.inner)


@lru_cache(maxsize=1024)
def _members_of(kind: Structure) -> tuple[dict[str, _MemberEntry], bool]:
    """Return the members by name, both as written and in capitals, and whether the structure is a string."""
    entries: dict[str, _MemberEntry] = {}
    for member in kind.members:
        elementary = None if member.dims or isinstance(member.type, Structure) else member.type
        entry = _MemberEntry(member, elementary, _mistake_of(kind, member) if member.at else "")
        entries.setdefault(member.name.upper(), entry)
    return entries | {entry.member.name: entry for entry in entries.values()}, kind.is_string


def _mistake_of(kind: Structure, member: Member) -> str:
    """Return why a member with `at` can't have a value; "" if it can."""
    try:
        place = alias_target("", kind, member, 0)
    except ValueError as error:
        return str(error)
    if place.bit is None and (place.type, place.dims) == (member.type, member.dims):
        return ""
    is_bit = place.bit is not None and member.type is BOOL and isinstance(place.type, Elementary)
    if is_bit and place.type.is_integer:  # type: ignore[union-attr]
        return ""
    return f"{member.name} of {kind.name} is a {member.type.name}, and at {member.at}, a {place.type.name}"


def _truncated(text: str, kind: Structure) -> str:
    return text[: kind.members[1].dims[0]]


def _array(data: DecoratedValue, kind: DataType, dims: tuple[int, ...], reading: ValueReading) -> Any:
    """Return nested lists; None if all elements have the type's initial value."""
    flat: list[Any] = [None] * count_of(dims)
    elements = (inner for inner in data.inner if inner.tag == "Element")
    for position, (_, index, text, _, inner) in enumerate(elements):
        offset = _offset_at(position, index, dims)
        if offset is None:
            reading.remark(f"no element {index}")
        elif isinstance(kind, Elementary):
            is_zero = text in _ZEROS and not reading.keep_zeros
            flat[offset] = None if is_zero else scalar(text, kind, reading)
        else:
            structure = next((child for child in inner if child.tag == "Structure"), None)
            flat[offset] = None if structure is None else _structure(structure, kind, reading)
    return nested(flat, kind, dims) if any(value is not None for value in flat) else None


def _offset_at(position: int, index: str, dims: tuple[int, ...]) -> int | None:
    """Return `_offset` of an element's index; a one-dimensional array is mostly in order."""
    is_in_order = len(dims) == 1 and position < dims[0] and index == f"[{position}]"
    return position if is_in_order else _offset(index, dims)


def _offset(index: str, dims: tuple[int, ...]) -> int | None:
    """Return the offset in the flat array of an index such as `[1,2]`; None if it is out of range."""
    subscripts = [int(number) for number in _INDEX.findall(index)]
    if len(subscripts) != len(dims):
        return None
    offset = 0
    for subscript, length in zip(subscripts, dims, strict=True):
        if subscript >= length:
            return None
        offset = offset * length + subscript
    return offset


def _parameters(element: Element | None, kind: DataType) -> Any:
    """Return members from attributes of `MessageParameters`, `AxisParameters` or others; None for zeros."""
    inner = None if element is None else next(element.iterchildren("*"), None)
    if inner is None or not isinstance(kind, Structure):
        return None
    values = {}
    for name, text in inner.items():
        member = kind.member(_ATTRIBUTES.get(name, name))
        if member is not None and isinstance(member.type, Elementary) and not member.dims:
            try:
                values[member.name] = value_of(TRUTH.get(text.lower(), text), member.type)
            except ValueTextError:
                continue
    return values or None


_ATTRIBUTES = {"ObjectType": "Class", "TargetObject": "Instance", "AttributeNumber": "Attribute"}
"""Attributes of MessageParameters whose members have other names."""
