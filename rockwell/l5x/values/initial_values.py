"""Initial values from a document, in the form of `Tag.initial`.

| form | content | read |
|---|---|---|
| bytes, `<Data>3C 00</Data>` | all of the tag, see `raw` | first, where the order of bytes is known |
| Decorated | members by name; zeros may be left out | else |
| String | the characters of one string; of an array those of its first element | else |
| Message, Alarm, Axis | members as attributes | else |
| L5K | members in their order, see `l5k` | else |

    <Structure DataType="Recipe">
      <DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5"/>
      <ArrayMember Name="Steps" DataType="DINT" Dimensions="2"><Element Index="[0]" Value="7"/>...
      <StructureMember Name="Delay" DataType="TIMER"><DataValueMember Name="PRE" .../>...

Zeros are omitted if zero is the initial value. A value that does not fit is reported, and truncated to its
type or omitted.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from ....ladder.model.types import BOOL, DataType, Elementary, Member, Structure, count_of
from ....ladder.state.named_parts import meant_by
from ..xml.data import Data, DecoratedValue
from ..xml.records import Element
from .datatypes import Types
from .initials import ValueReading, nested, scalar
from .l5k import from_l5k
from .raw import bytes_in, fits, from_bytes, is_certain
from .value_texts import TRUTH, ValueTextError, unquoted_or_raise, unsaid, value_of

_INDEX = re.compile(r"\d{1,9}")


def initial_of(
    data: Sequence[Data],
    kind: DataType,
    dims: tuple[int, ...],
    types: Types,
    say: Callable[[str], None] = unsaid,
) -> Any:
    """Return an initial value from `Data` elements, None for the type's own, or raise a ValueTextError."""
    if isinstance(kind, Elementary) and not dims:
        only = {each.form: each.value for each in data}
        if (one := only.get("Decorated")) is not None and "" not in only:
            return scalar(one, kind, ValueReading(say=say))
    how = ValueReading(types.has_initials(kind), say)
    found = {each.form: each.element for each in data if each.form != "Decorated"}
    shown = [each.values(zeros=how.keep) for each in data if each.form == "Decorated"]
    inner = next(iter(shown[-1]), None) if shown else None
    raw = bytes_in(found[""]) if "" in found else None
    if raw and types.has_known_bytes(kind) and fits(raw, kind, dims) and (inner is None or is_certain(kind)):
        return from_bytes(raw, kind, dims)
    if inner is not None:
        wanted = "Array" if dims else "DataValue" if isinstance(kind, Elementary) else "Structure"
        if inner.tag != wanted:
            raise ValueTextError(f"its data are of the form {inner.tag}, not {wanted}")
        return _decorated(inner, kind, dims, how)
    if "String" in found and isinstance(kind, Structure) and kind.is_string and not dims:
        return _cut(_quoted(found["String"].text or ""), kind) or None
    for form in ("Message", "Alarm", "Axis", "CoordinateSystem"):
        if form in found:
            return None if dims else _parameters(found[form], kind)
    if "L5K" in found:
        return from_l5k("".join(found["L5K"].itertext()), kind, dims, how)
    if "String" in found and isinstance(kind, Structure) and kind.is_string:
        say("the file has its first text only")
        return nested([_cut(_quoted(found["String"].text or ""), kind)], kind, ())
    if found.keys() == {""} and not shown:
        _refuse_bytes(found[""], raw, kind, known=types.has_known_bytes(kind))
    return None


def _refuse_bytes(element: Element, raw: bytes | None, kind: DataType, *, known: bool) -> None:
    """Raise ValueTextError for unreadable bytes, unless they are zeros."""
    if raw is None:
        raise ValueTextError(f"{(element.text or '').strip()[:20]!r} are no bytes")
    if any(raw) and known:
        raise ValueTextError(f"it has {len(raw)} bytes, which are not as many as its type has")
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
    """A member, and why it can't have a value, "" if it can."""

    member: Member
    plain: Elementary | None  # its type if it is a single value
    wrong: str


def _structure(values: DecoratedValue, kind: Structure, how: ValueReading) -> Any:
    parts, is_string = _parts(kind)
    if is_string and not _has_elements(values):
        text = next((each.text for each in values.inner if each.name == "DATA"), None)
        return None if text is None else _cut(_quoted(text), kind) or None
    found = {}
    for each in values.inner:
        _, name, text, _, _ = each
        part = parts.get(name) or parts.get(name.upper())
        if part is None:
            continue
        member, plain, wrong = part
        if plain is None:
            value = _decorated(each, member.type, member.dims, how)
        else:
            value = None if text in _ZEROS and not how.keep else scalar(text, plain, how)
        if value is not None:
            if wrong:
                how.say(wrong)
            else:
                found[member.name] = value
    return found or None


def _has_elements(values: DecoratedValue) -> bool:
    """Whether the characters of a string are elements, not a text."""
    return any(
        inner.tag == "Element" for each in values.inner if each.tag == "ArrayMember" for inner in each.inner
    )


@lru_cache(maxsize=1024)
def _parts(kind: Structure) -> tuple[dict[str, _Part], bool]:
    """Return the members by name, as it is written and in capitals, and whether it is a string."""
    found: dict[str, _Part] = {}
    for each in kind.members:
        plain = None if each.dims or isinstance(each.type, Structure) else each.type
        part = _Part(each, plain, _wrong_alias(kind, each) if each.at else "")
        found.setdefault(each.name.upper(), part)
    return found | {each.member.name: each for each in found.values()}, kind.is_string


def _wrong_alias(kind: Structure, member: Member) -> str:
    """Return why a member with `at` can't have a value, "" if it can."""
    try:
        there = meant_by("", kind, member, 0)
    except ValueError as error:
        return str(error)
    if there.bit is None and (there.type, there.dims) == (member.type, member.dims):
        return ""
    is_bit = there.bit is not None and member.type is BOOL and isinstance(there.type, Elementary)
    if is_bit and there.type.is_integer:  # type: ignore[union-attr]
        return ""
    return f"{member.name} of {kind.name} is a {member.type.name}, and at {member.at}, a {there.type.name}"


def _quoted(text: str) -> str:
    text = text.strip()
    if text[:1] == "'" == text[-1:] and len(text) > 1:
        text = text[1:-1]
    return unquoted_or_raise(text)


def _cut(text: str, kind: Structure) -> str:
    return text[: kind.members[1].dims[0]]


def _array(values: DecoratedValue, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    """Return nested lists, None if all elements have the type's initial value."""
    flat: list[Any] = [None] * count_of(dims)
    something = False
    row = dims[0] if len(dims) == 1 else 0
    position = -1
    for tag, index, text, _, inner in values.inner:
        if tag != "Element":
            continue
        position += 1
        at = position if position < row and index == f"[{position}]" else _flat(index, dims)
        if at is None:
            how.say(f"no element {index}")
            continue
        if isinstance(kind, Elementary):
            value = None if text in _ZEROS and not how.keep else scalar(text, kind, how)
        else:
            structure = next((each for each in inner if each.tag == "Structure"), None)
            value = None if structure is None else _structure(structure, kind, how)
        flat[at] = value
        something = something or value is not None
    return nested(flat, kind, dims) if something else None


def _flat(index: str, dims: tuple[int, ...]) -> int | None:
    at = 0
    places = _INDEX.findall(index)
    if len(places) != len(dims):
        return None
    for place, length in zip(places, dims, strict=True):
        if int(place) >= length:
            return None
        at = at * length + int(place)
    return at


def _parameters(element: Element | None, kind: DataType) -> Any:
    """Return members given as attributes: `MessageParameters`, `AxisParameters`."""
    inner = None if element is None else next(element.iterchildren("*"), None)
    if inner is None or not isinstance(kind, Structure):
        return None
    found = {}
    for name, text in inner.items():
        member = kind.member(_ATTRIBUTES.get(name, name))
        if member is not None and isinstance(member.type, Elementary) and not member.dims:
            try:
                found[member.name] = value_of(TRUTH.get(text.lower(), text), member.type)
            except ValueTextError:
                continue
    return found or None


_ATTRIBUTES = {"ObjectType": "Class", "TargetObject": "Instance", "AttributeNumber": "Attribute"}
"""Attributes of MessageParameters with another member name."""
