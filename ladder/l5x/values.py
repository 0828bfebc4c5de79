"""Decorated data and L5K text to initial values, in the form that `Tag.initial` has.

Decorated data name their values and are preferred:

    <Structure DataType="Recipe">
      <DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5"/>
      <ArrayMember Name="Steps" DataType="DINT" Dimensions="2"><Element Index="[0]" Value="7"/>...
      <StructureMember Name="Delay" DataType="TIMER"><DataValueMember Name="PRE" .../>...

L5K text, `[1.50000000e+000,[7,0],[0,5000,0]]`, has the values of all members in the order of their memory.
Zeros are left out where zero is what a tag starts with. What does not fit is cut to the bits of its type.
"""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Callable, Sequence
from typing import Any

from ..arithmetic import real, wrap
from ..quoting import unquoted
from ..types import DataType, Elementary, Member, Structure, count_of
from .datatypes import has_initials
from .records import Data, number_of

_RADIX = re.compile(r"(16|8|2)#([0-9A-Fa-f_]+)")
_DATE = re.compile(
    r"L?DT#(\d{4})-(\d\d)-(\d\d)-(\d\d):(\d\d):(\d\d)(?:\.([\d_]+))?"
    r"(?:Z|\(UTC([+-])(\d\d):(\d\d)\))?",
    re.IGNORECASE,
)
_DURATION = re.compile(
    r"(LT|T|T32|LTIME|TIME|TIME32)#([+-]?)((?:_?\d{1,19}(?:\.\d{1,9})?(?:d|h|ms|m|us|ns|s))+)", re.IGNORECASE
)
_PART = re.compile(r"(\d+)(?:\.(\d+))?([a-z]+)")
_NANOSECONDS = {
    "d": 86_400_000_000_000,
    "h": 3_600_000_000_000,
    "m": 60_000_000_000,
    "s": 1_000_000_000,
    "ms": 1_000_000,
    "us": 1000,
    "ns": 1,
}
_INDEX = re.compile(r"\d{1,9}")
_DEEPEST = 64
"""Levels of brackets in L5K text."""


class ValueTextError(ValueError):
    """A value that can't be read; the text."""


def initial_of(data: Sequence[Data], kind: DataType, dims: tuple[int, ...]) -> Any:
    """Return what a tag starts with, None for what its type starts with.

    Args:
        data: its `Data` elements.
        kind: its type.
        dims: its dimensions.

    Raises:
        ValueTextError: a value can't be read.
    """
    found = {each.get("Format", ""): each for each in data}
    keep = has_initials(kind)
    decorated = found.get("Decorated")
    inner = None if decorated is None else next(decorated.iterchildren("*"), None)
    if inner is not None:
        return _decorated(inner, kind, dims, keep)
    if "String" in found and isinstance(kind, Structure) and kind.is_string:
        return _cut(_quoted(found["String"]), kind) or None
    if "Message" in found or "Alarm" in found:
        return _parameters(found.get("Message", found.get("Alarm")), kind)
    if "L5K" in found:
        return _l5k("".join(found["L5K"].itertext()), kind, dims, keep)
    if any(each.get("Format") is None and (each.text or "").strip("0 \r\n\t") for each in data):
        raise ValueTextError("its values are bytes only, which are not read")
    return None


# --- decorated


def _decorated(element: Data, kind: DataType, dims: tuple[int, ...], keep: bool) -> Any:
    if dims:
        return _array(element, kind, dims, keep)
    if isinstance(kind, Elementary):
        return _scalar(element.get("Value"), kind, keep)
    return _structure(element, kind, keep)


def _scalar(text: str | None, kind: Elementary, keep: bool) -> Any:
    if text is None:
        return None
    value = value_of(text, kind)
    return value if value or keep else None


def _structure(element: Data, kind: Structure, keep: bool) -> Any:
    if kind.is_string and not _has_elements(element):
        return _string(element, kind)
    found = {}
    for each in element.iterchildren("*"):
        member = kind.member(each.get("Name", ""))
        if member is None:
            continue
        value = _decorated(each, member.type, member.dims, keep)
        if value is not None:
            found[member.name] = value
    return found or None


def _string(element: Data, kind: Structure) -> str | None:
    data = next((each for each in element.iterchildren("*") if each.get("Name") == "DATA"), None)
    return None if data is None else _cut(_quoted(data), kind) or None


def _has_elements(element: Data) -> bool:
    """Whether the characters of a string are listed one by one."""
    return element.find("ArrayMember/Element") is not None


def _quoted(element: Data) -> str:
    text = (element.text or "").strip()
    if text[:1] == "'" == text[-1:] and len(text) > 1:
        text = text[1:-1]
    try:
        return unquoted(text)
    except ValueError as error:
        raise ValueTextError(str(error)) from None


def _cut(text: str, kind: Structure) -> str:
    return text[: kind.members[1].dims[0]]


def _array(element: Data, kind: DataType, dims: tuple[int, ...], keep: bool) -> Any:
    """Return nested lists, None if all elements are what the type starts with."""
    total = count_of(dims)
    values: list[Any] = [None] * total
    something = False
    for each in element.iterchildren("Element"):
        at = _flat(each.get("Index", ""), dims)
        if at is None:
            continue
        inner = each.find("Structure")
        if inner is not None and isinstance(kind, Structure):
            values[at] = _structure(inner, kind, keep)
        elif isinstance(kind, Elementary):
            values[at] = _scalar(each.get("Value"), kind, keep)
        something = something or values[at] is not None
    return _nested(values, kind, dims) if something else None


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


def _nested(values: list[Any], kind: DataType, dims: tuple[int, ...]) -> Any:
    """Return flat values as a list per dimension; missing ones are zeros."""
    blank: Callable[[], Any] = {}.copy
    if isinstance(kind, Elementary):
        zero = kind.zero

        def blank() -> Any:
            return zero
    elif kind.is_string:
        blank = str
    flat = [blank() if each is None else each for each in values]
    for length in reversed(dims[1:]):
        flat = [flat[start : start + length] for start in range(0, len(flat), length)]
    return flat


def _parameters(element: Data | None, kind: DataType) -> Any:
    """Return members that are attributes: those of `MessageParameters` and `AlarmDigitalParameters`."""
    inner = None if element is None else next(element.iterchildren("*"), None)
    if inner is None or not isinstance(kind, Structure):
        return None
    found = {}
    for name, text in inner.items():
        member = kind.member(_ATTRIBUTES.get(name, name))
        if member is not None and isinstance(member.type, Elementary) and not member.dims:
            try:
                found[member.name] = value_of(_TRUTH.get(text.lower(), text), member.type)
            except ValueTextError:
                continue
    return found or None


_ATTRIBUTES = {"ObjectType": "Class", "TargetObject": "Instance", "AttributeNumber": "Attribute"}
"""Attributes of MessageParameters that have another name as members."""

_TRUTH = {"true": "1", "false": "0"}


# --- one value


def value_of(text: str, kind: Elementary) -> bool | int | float:
    """Return a value of a type, from any radix.

    Raises:
        ValueTextError: it is none.
    """
    if kind.is_real or kind.is_double:
        value = _real_of(text)
        return real(value) if kind.is_real else value
    try:
        number = int(text)
    except ValueError:
        number = _integer_of(text.strip())
    if kind.is_bool:
        return bool(number & 1)
    if kind.lowest <= number <= kind.highest:
        return number
    return wrap(number, kind.wraps)


def _integer_of(text: str) -> int:
    radix = _RADIX.fullmatch(text)
    if radix:
        try:
            return int(radix[2].replace("_", ""), int(radix[1]))
        except ValueError:
            raise ValueTextError(f"{text!r} has digits that are not of radix {radix[1]}") from None
    if text[:1] == "'" == text[-1:] and len(text) > 1:
        return int.from_bytes(unquoted_or_raise(text[1:-1]).encode("latin-1", "replace"), "big")
    date = _DATE.fullmatch(text)
    if date:
        return _date_of(date)
    duration = _DURATION.fullmatch(text)
    if duration:
        return _duration_of(duration)
    if text.lower() in _TRUTH:
        return int(_TRUTH[text.lower()])
    value = _real_of(text)
    if math.isfinite(value):
        return round(value)
    raise ValueTextError(f"{text!r} is not a whole number")


def unquoted_or_raise(text: str) -> str:
    """Return the characters of a literal.

    Raises:
        ValueTextError: an escape is none.
    """
    try:
        return unquoted(text)
    except ValueError as error:
        raise ValueTextError(str(error)) from None


def _date_of(date: re.Match[str]) -> int:
    """Return the µs of a DT#, the ns of an LDT#, since 1970."""
    try:
        moment = datetime.datetime(*(int(each) for each in date.groups()[:6]))  # type: ignore[arg-type]
    except ValueError:
        raise ValueTextError(f"{date.group()!r} is not a date") from None
    seconds = round((moment - datetime.datetime(1970, 1, 1)).total_seconds())
    if date[8]:
        ahead = int(date[9]) * 3600 + int(date[10]) * 60
        seconds -= ahead if date[8] == "+" else -ahead
    digits = 9 if date.group()[0] in "Ll" else 6
    fraction = (date[7] or "").replace("_", "").ljust(digits, "0")[:digits]
    return seconds * int(10**digits) + int(fraction)


def _duration_of(duration: re.Match[str]) -> int:
    """Return the µs of a T# or T32#, the ns of an LT#."""
    total = 0
    for whole, fraction, unit in _PART.findall(duration[3].lower()):
        unit_ns = _NANOSECONDS[unit]
        total += int(whole) * unit_ns + int(fraction.ljust(9, "0")) * unit_ns // 10**9
    units = total if duration[1][0] in "Ll" else total // 1000
    return -units if duration[2] == "-" else units


def _real_of(text: str) -> float:
    text = text.strip()
    try:
        return float(text)
    except ValueError:
        pass
    plain = text.upper().lstrip("+-")
    if plain.startswith(("1.$", "1.#INF")):
        return -math.inf if text.startswith("-") else math.inf
    if plain.startswith("1.#"):
        return math.nan
    if _RADIX.fullmatch(text):
        return float(_integer_of(text))
    raise ValueTextError(f"{text!r} is not a number")


# --- L5K text

_TOKEN = re.compile(
    r"\s*(?:(?P<mark>[\[\],])|(?P<string>'(?:[^'$]|\$.)*')|(?P<value>[^\[\],'\s]+))", re.DOTALL
)


def _l5k(text: str, kind: DataType, dims: tuple[int, ...], keep: bool) -> Any:
    text = text.strip()
    if not text:
        return None
    return _l5k_value(_l5k_tree(text), kind, dims, keep)


def _l5k_tree(text: str) -> Any:
    """Return L5K text as nested lists of texts."""
    outer: list[Any] = []
    open_lists = [outer]
    at = 0
    while at < len(text):
        found = _TOKEN.match(text, at)
        if found is None:
            if not text[at:].strip():
                break
            raise ValueTextError(f"{text[at : at + 20]!r} is not L5K data")
        at = found.end()
        mark = found["mark"]
        if mark == "[":
            if len(open_lists) > _DEEPEST:
                raise ValueTextError(f"L5K data are more than {_DEEPEST} levels deep")
            open_lists[-1].append([])
            open_lists.append(open_lists[-1][-1])
        elif mark == "]":
            if len(open_lists) == 1:
                raise ValueTextError("L5K data close a bracket that is not open")
            open_lists.pop()
        elif mark is None:
            open_lists[-1].append(found["string"] or found["value"])
    if len(open_lists) != 1 or len(outer) != 1:
        raise ValueTextError("L5K data are not one value")
    return outer[0]


def _l5k_value(tree: Any, kind: DataType, dims: tuple[int, ...], keep: bool) -> Any:
    if dims:
        return _l5k_array(tree, kind, dims, keep)
    if isinstance(kind, Elementary):
        return _scalar(tree, kind, keep) if isinstance(tree, str) else None
    if kind.is_string:
        return _l5k_string(tree, kind)
    return _l5k_structure(tree, kind, keep) if isinstance(tree, list) else None


def _l5k_array(tree: Any, kind: DataType, dims: tuple[int, ...], keep: bool) -> Any:
    flat: list[Any] = [tree]
    for _ in dims:
        flat = [each for part in flat if isinstance(part, list) for each in part]
    if len(flat) > count_of(dims):
        return None
    values = [_l5k_value(each, kind, (), keep) for each in flat]
    if all(each is None for each in values):
        return None
    return _nested(values + [None] * (count_of(dims) - len(values)), kind, dims)


def _l5k_string(tree: Any, kind: Structure) -> str | None:
    if not (isinstance(tree, list) and len(tree) == 2 and all(isinstance(each, str) for each in tree)):
        return None
    length, text = tree
    characters, most = unquoted_or_raise(text.strip("'")), number_of(length)
    return characters[:most] or None if most is not None else None


def _l5k_structure(tree: Sequence[Any], kind: Structure, keep: bool) -> Any:
    """Return members in the order of their memory; status bits of predefined types share a first word."""
    bits = [each for each in kind.own if each.bit is not None]
    words = [each for each in kind.own if each.bit is None]
    packed = any(each.type.name == "BOOL" and not each.dims for each in words)
    if len(tree) != len(words) + bool(bits) or packed:
        return None  # another version of the type: its members are not in this order
    found: dict[str, Any] = {}
    if bits:
        word = _scalar(tree[0], _DINT, keep=True) if isinstance(tree[0], str) else 0
        found.update((each.name, True) for each in bits if int(word) >> _bit(each) & 1)
    for member, part in zip(words, tree[bool(bits) :], strict=True):
        value = _l5k_value(part, member.type, member.dims, keep)
        if value is not None:
            found[member.name] = value
    return found or None


_DINT = Elementary("DINT", 32, "i")


def _bit(member: Member) -> int:
    return member.bit or 0
