"""Initial values from a document, in the form of `Tag.initial`.

| form | content |
|---|---|
| bytes, `<Data>3C 00</Data>` | all of the tag, if its memory layout is known, see `raw` |
| L5K | all of the tag in memory order, if that is known, see `l5k` |
| Decorated | members by name without local tags of add-ons; zeros may be left out |
| String | the characters of a string, or of an array's first element |
| Message, Alarm, Axis | members as attributes |

The first of these forms that a tag has is its value. A difference in another form is reported.

    <Structure DataType="Recipe">
      <DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5"/>
      <ArrayMember Name="Steps" DataType="DINT" Dimensions="2"><Element Index="[0]" Value="7"/>...
      <StructureMember Name="Delay" DataType="TIMER"><DataValueMember Name="PRE" .../>...

Zeros are omitted if zero is the initial value. A value that does not fit is reported, and truncated to its
type or omitted.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
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
    """Return an initial value from `Data` elements; None for the type's own.

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
        self._how = ValueReading(types.has_initials(kind), remark, types.layouts)

    def value(self) -> Any:
        """Return the value of the first form; report forms that differ from it."""
        values = dict(self._whole())
        if values:
            form = next(iter(values))
            if "Decorated" in self._data:
                values["Decorated"] = self._decorated(keep=True)
            elif "String" in self._data and not self._dims and "L5K" in values:
                values["String"] = self._string()
            if len(values) > 1:
                self._compare(values)
            return values[form]
        if "Decorated" in self._data:
            return self._decorated(keep=self._how.keep)
        return self._other()

    def _whole(self) -> Iterator[tuple[str, Any]]:
        """Yield the readable forms that have all of the memory, with their values."""
        kind, dims, layouts = self._kind, self._dims, self._types.layouts
        raw = self._raw() if layouts.is_known(kind) else None
        if raw and fits(raw, kind, dims, layouts) and (len(self._data) == 1 or layouts.is_certain(kind)):
            yield "bytes", RawReader(raw, layouts, keep=self._how.keep).read(kind, dims)
        if "L5K" in self._data and _OTHERS.isdisjoint(self._data):
            yield from self._l5k()

    def _l5k(self) -> Iterator[tuple[str, Any]]:
        try:
            text = "".join(self._data["L5K"].element.itertext())
            value = from_l5k(text, self._kind, self._dims, self._how)
            yield "L5K", self._filled(value) if self._how.unread else value
        except OtherVersionError as error:
            if "Decorated" not in self._data or self._types.has_locals(self._kind):
                self._remark(str(error))

    def _filled(self, value: Any) -> Any:
        """Fill in, from decorated data, the members of a value whose memory layout is unknown."""
        if self._types.has_locals(self._kind):
            names = ", ".join(dict.fromkeys(self._how.unread))
            self._remark(f"{names} in local tags start with their defaults: their memory is not known")
        return filled(value, self._decorated(keep=True) if "Decorated" in self._data else None)

    def _raw(self) -> bytes | None:
        return bytes_in(self._data[""].element) if "" in self._data else None

    def _decorated(self, *, keep: bool) -> Any:
        kind, dims, data = self._kind, self._dims, self._data["Decorated"]
        how = replace(self._how, keep=keep) if keep != self._how.keep else self._how
        if data.value is not None and isinstance(kind, Elementary) and not dims:
            return scalar(data.value, kind, how)
        inner = next(iter(data.values(zeros=keep)), None)
        if inner is None:
            return None
        expected_tag = "Array" if dims else "DataValue" if isinstance(kind, Elementary) else "Structure"
        if inner.tag != expected_tag:
            raise ValueTextError(f"its data are of the form {inner.tag}, not {expected_tag}")
        return _decorated(inner, kind, dims, how)

    def _string(self) -> str | None:
        kind = self._kind
        if not isinstance(kind, Structure) or not kind.is_string:
            return None
        return _cut(unquoted_or_raise((self._data["String"].element.text or "").strip()), kind) or None

    def _other(self) -> Any:
        kind, dims = self._kind, self._dims
        for form in _PARAMETERS:
            if form in self._data:
                return None if dims else _parameters(self._data[form].element, kind)
        if "String" in self._data and isinstance(kind, Structure) and kind.is_string:
            if not dims:
                return self._string()
            self._remark("the file has its first text only")
            return nested([self._string()], kind, ())
        if self._data.keys() == {""}:
            is_known = self._types.layouts.is_known(kind)
            _refuse_bytes(self._data[""].element, self._raw(), kind, known=is_known)
        return None

    def _compare(self, found: Mapping[str, Any]) -> None:
        """Report the first value that differs between two forms, with both values."""
        (first, value), *others = found.items()
        for _form, other_value in others:
            path = first_difference(self._kind, self._dims, value, other_value)
            if path is not None:
                forms = (
                    f"{name} {value_at(self._kind, form_value, path)}" for name, form_value in found.items()
                )
                place = f" at {''.join(path)}" if path else ""
                self._remark(f"its forms differ{place}: {', '.join(forms)}; the {first} count")
                return


_PARAMETERS = ("Message", "Alarm", "Axis", "CoordinateSystem")
_OTHERS = frozenset(_PARAMETERS)


def _refuse_bytes(element: Element, raw: bytes | None, kind: DataType, *, known: bool) -> None:
    """Raise ValueTextError for unreadable bytes, unless they are zeros."""
    if raw is None:
        raise ValueTextError(f"{(element.text or '').strip()[:20]!r} is not a list of bytes")
    if any(raw) and known:
        raise ValueTextError(f"it has {len(raw)} bytes; its type has another size")
    if any(raw):
        text = f"the order of the bytes of a {kind.name} is not known; export decorated data"
        raise ValueTextError(text)


# --- decorated


def _decorated(values: DecoratedValue, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    if dims:
        return _array(values, kind, dims, how)
    if isinstance(kind, Elementary):
        return scalar(values.value, kind, how)
    return _structure(values, kind, how)


_ZEROS = ("0", "0.0", "0.00000000e+000")
"""Texts of most values of an export."""


class _Part(NamedTuple):
    """A member, and why it can't have a value; "" if it can."""

    member: Member
    plain: Elementary | None  # its type if it is a single value
    wrong: str


def _structure(values: DecoratedValue, kind: Structure, how: ValueReading) -> Any:
    parts, is_string = _parts(kind)
    if is_string and not _has_elements(values):
        return _characters(values, kind, how)
    members = {}
    for inner in values.inner:
        _, name, text, _, _ = inner
        part = parts.get(name) or parts.get(name.upper())
        if part is None:
            continue
        member, elementary, mistake = part
        if elementary is None:
            value = _decorated(inner, member.type, member.dims, how)
        else:
            value = None if text in _ZEROS and not how.keep else scalar(text, elementary, how)
        if value is not None and mistake:
            how.remark(mistake)
        elif value is not None:
            members[member.name] = value
    return members or None


def _characters(values: DecoratedValue, kind: Structure, how: ValueReading) -> str | None:
    text = next((part.text for part in values.inner if part.name == "DATA"), None)
    characters = None if text is None else _cut(unquoted_or_raise(text.strip()), kind)
    return characters if characters or how.keep else None


def _has_elements(values: DecoratedValue) -> bool:
    """Return whether the characters of a string are given as elements, not as text."""
    return any(
        inner.tag == "Element" for part in values.inner if part.tag == "ArrayMember" for inner in part.inner
    )


@lru_cache(maxsize=1024)
def _parts(kind: Structure) -> tuple[dict[str, _Part], bool]:
    """Return the members by name, both as written and in capitals, and whether the structure is a string."""
    parts: dict[str, _Part] = {}
    for member in kind.members:
        elementary = None if member.dims or isinstance(member.type, Structure) else member.type
        part = _Part(member, elementary, _wrong_alias(kind, member) if member.at else "")
        parts.setdefault(member.name.upper(), part)
    return parts | {entry.member.name: entry for entry in parts.values()}, kind.is_string


def _wrong_alias(kind: Structure, member: Member) -> str:
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


def _cut(text: str, kind: Structure) -> str:
    return text[: kind.members[1].dims[0]]


def _array(values: DecoratedValue, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    """Return nested lists; None if all elements have the type's initial value."""
    flat: list[Any] = [None] * count_of(dims)
    has_value = False
    row = dims[0] if len(dims) == 1 else 0
    position = -1
    for tag, index, text, _, inner in values.inner:
        if tag != "Element":
            continue
        position += 1
        offset = position if position < row and index == f"[{position}]" else _flat(index, dims)
        if offset is None:
            how.remark(f"no element {index}")
            continue
        if isinstance(kind, Elementary):
            value = None if text in _ZEROS and not how.keep else scalar(text, kind, how)
        else:
            value = next(
                (_structure(structure, kind, how) for structure in inner if structure.tag == "Structure"),
                None,
            )
        flat[offset] = value
        has_value = has_value or value is not None
    return nested(flat, kind, dims) if has_value else None


def _flat(index: str, dims: tuple[int, ...]) -> int | None:
    offset = 0
    places = _INDEX.findall(index)
    if len(places) != len(dims):
        return None
    for place, length in zip(places, dims, strict=True):
        if int(place) >= length:
            return None
        offset = offset * length + int(place)
    return offset


def _parameters(element: Element | None, kind: DataType) -> Any:
    """Return members given as attributes: `MessageParameters`, `AxisParameters`."""
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
