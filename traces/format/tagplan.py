r"""The tags that a trace records in addition to images: their fields, bytes and schema.

A row of tags follows the memory block in the payload of a scan. The block is a multiple of eight bytes and
the widest fields come first, so that no field needs padding, whatever alignment a decoder uses:

    byte  0            4     8      12                  12 + block
          00 01 00 00  scan  flags  outputs, inputs ... tags

The schema has everything that a reader needs; the full name of each tag is a comment:

    Tags0123456789ab tags
    ====...
    MSG: scanrack/Tags0123456789ab
    int32 fill_acc  # Fill.ACC
    Names01234567 main_step  # \Main.Step
    ====...
    MSG: scanrack/Names01234567
    uint16 IDLE=0
    uint16 FILL=1
    uint16 value
"""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from keyword import kwlist
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.tag_names import element_of, without_ranges

from .named_words import split_schema

if TYPE_CHECKING:
    import numpy as np

VALUES_MAX = 10_000
"""Maximum number of values in a row; each element of an array counts."""

ROW_BYTES_MAX = 64 * 1024

CHEAP_VALUES = 1_000
"""Maximum number of values in a row without a warning about their cost."""

VALUE_NS = 20
"""Approximate cost of a value per scan, ns: 14 with a thousand values, 21 with ten thousand."""

FIELD = "tags"
"""Name of the field in /scan, and prefix of its signals' names."""

LAST_CODE = 0xFFFF
"""Code of the 65,535th and all later texts."""


class Format(NamedTuple):
    """The storage format of a value."""

    ros: str  # its type in ros2msg
    letter: str  # its letter in the `struct` module
    size: int


FORMATS: Mapping[str, Format] = {
    "LINT": Format("int64", "q", 8),
    "ULINT": Format("uint64", "Q", 8),
    "LREAL": Format("float64", "d", 8),
    "DINT": Format("int32", "i", 4),
    "UDINT": Format("uint32", "I", 4),
    "REAL": Format("float32", "f", 4),
    "INT": Format("int16", "h", 2),
    "UINT": Format("uint16", "H", 2),
    "ENUM": Format("", "H", 2),  # its own message
    "TEXT": Format("uint16", "H", 2),
    "SINT": Format("int8", "b", 1),
    "USINT": Format("uint8", "B", 1),
    "BOOL": Format("bool", "?", 1),
}
"""Formats by type of tag, widest first."""

_TYPES = {tag_format.ros: name for name, tag_format in FORMATS.items() if name != "TEXT"}
_HASH_DIGITS = 12
_NAMES_DIGITS = 8
_FIELD = re.compile(
    r"(?P<type>\w+?)(?:\[(?P<length>[1-9]\d*)\])? (?P<field>[a-z][a-z0-9_]*)"
    r"  # (?P<name>.+?)(?P<text>, text)?"
)


@dataclass(frozen=True, slots=True)
class Tag:
    """A recorded tag."""

    name: str  # its full name: `Fill.ACC`, `\Main.Step`, `line.step`; for an array, see `io_images.tag_names`
    type: str  # a key of `FORMATS`
    length: int = 0  # elements of an array; 0 for a single value
    names: tuple[str, ...] = ()  # for an ENUM: names of the codes 0, 1, 2 ...

    @property
    def count(self) -> int:
        """Number of the tag's values."""
        return self.length or 1

    @property
    def size(self) -> int:
        """Size of the tag's values in a row, bytes."""
        return self.count * FORMATS[self.type].size

    @property
    def addresses(self) -> tuple[str, ...]:
        """The program's name for each of the tag's values."""
        if not self.length:
            return (self.name,)
        return tuple(element_of(self.name, index) for index in range(self.length))


@dataclass(frozen=True, slots=True)
class TagField:
    """A field of the row."""

    tag: Tag
    name: str
    constants: tuple[str, ...] = ()  # for an ENUM: names of its codes in the schema

    @property
    def letters(self) -> str:
        """The field's format in the `struct` module."""
        return f"{self.tag.length or ''}{FORMATS[self.tag.type].letter}"

    def columns(self, rows: np.ndarray[Any, Any]) -> Iterator[tuple[str, Any]]:
        """Yield the program's name for each value, and the value's column in the given rows."""
        values = rows[self.name]
        for index, address in enumerate(self.tag.addresses):
            yield address, values[:, index] if self.tag.length else values

    @property
    def enum_message(self) -> str:
        """Name of the message type of an ENUM."""
        return f"Names{_hash(_constant_lines(self.constants), _NAMES_DIGITS)}"

    @property
    def line(self) -> str:
        """The field's line in the schema."""
        kind = FORMATS[self.tag.type].ros or self.enum_message
        length = f"[{self.tag.length}]" if self.tag.length else ""
        mark = ", text" if self.tag.type == "TEXT" else ""
        return f"{kind}{length} {self.name}  # {self.tag.name}{mark}"


@dataclass(frozen=True)
class TagPlan:
    """All fields of a row, in the order of their bytes."""

    fields: tuple[TagField, ...]

    @property
    def letters(self) -> str:
        """The row's format in the `struct` module, without the byte order."""
        return "".join(field.letters for field in self.fields)

    @cached_property
    def dtype(self) -> np.dtype[np.void]:
        """The row as a numpy type; its fields have the schema's names."""
        import numpy as np  # readers need it, a recorder does not

        layout: list[Any] = []
        for field in self.fields:
            kind = f"<{FORMATS[field.tag.type].letter}"
            layout.append((field.name, kind, (field.tag.length,)) if field.tag.length else (field.name, kind))
        return np.dtype(layout)

    @property
    def size(self) -> int:
        """Size of a row, bytes."""
        return sum(field.tag.size for field in self.fields)

    @property
    def values(self) -> int:
        """Number of values in a row; each element of an array counts."""
        return sum(field.tag.count for field in self.fields)

    @property
    def cost(self) -> str | None:
        """The cost of recording the row, as text; None if it is low."""
        if self.values <= CHEAP_VALUES:
            return None
        about = round(self.values * VALUE_NS / 1000)
        return (
            f"{self.values:,} values of tags are recorded in every scan: about {about} µs, "
            f"and {self.size:,} bytes before compression"
        )

    @property
    def has_texts(self) -> bool:
        """Whether any tag is a text."""
        return any(field.tag.type == "TEXT" for field in self.fields)

    @property
    def message(self) -> str:
        """Name of the row's message."""
        return f"Tags{_hash([field.line for field in self.fields], _HASH_DIGITS)}"

    def messages(self) -> Iterator[tuple[str, list[str]]]:
        """Yield the messages of the schema, each with its name and lines."""
        yield self.message, [field.line for field in self.fields]
        enums = {field.enum_message: field.constants for field in self.fields if field.constants}
        for name, constants in enums.items():
            yield name, [*_constant_lines(constants), "uint16 value"]

    def to_json(self) -> str:
        """Return the table that is attached to a trace as tags.json."""
        rows = [
            {"name": tag.name, "field": f"{FIELD}.{field.name}", "type": tag.type}
            | ({"length": tag.length} if tag.length else {})
            | ({"elements": tag.addresses} if ".." in tag.name else {})
            | ({"names": tag.names} if tag.names else {})
            for field in self.fields
            for tag in [field.tag]
        ]
        return json.dumps({"tags": rows}, ensure_ascii=False, separators=(",", ":")) + "\n"


class TagSource(Protocol):
    """The recorder's source of a scan's tags.

    Attributes:
        take: returns the rack's current memory block, followed by the row of tags.
        pending: messages for the last row, each a topic and fields. The recorder writes and clears them.
    """

    @property
    def plan(self) -> TagPlan: ...  # noqa: D102 - see the class
    @property
    def take(self) -> Callable[[], bytes]: ...  # noqa: D102
    @property
    def pending(self) -> list[tuple[str, Mapping[str, str | int]]]: ...  # noqa: D102


def plan_of(tags: Sequence[Tag]) -> TagPlan:
    r"""Return the plan of tags: the widest first, tags of equal width in the given order.

    >>> plan = plan_of([Tag("Run", "BOOL"), Tag(r"\Main.Step", "ENUM", 0, ("idle", "fill"))])
    >>> [(field.name, field.constants) for field in plan.fields], plan.letters
    ([('main_step', ('IDLE', 'FILL')), ('run', ())], 'H?')

    Raises:
        ValueError: no tags are given, a tag is given twice, or a row would have too many values or bytes.
    """
    if not tags:
        raise ValueError("no tag to record")
    names = [tag.name for tag in tags]
    if len(set(names)) < len(names):
        duplicate = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"tag {duplicate} is given twice")
    values, size = sum(tag.count for tag in tags), sum(tag.size for tag in tags)
    if values > VALUES_MAX or size > ROW_BYTES_MAX:
        raise ValueError(
            f"the tags have {values:,} values in {size:,} bytes; must be at most {VALUES_MAX:,} values "
            f"and {ROW_BYTES_MAX:,} bytes per scan: select fewer tags"
        )
    used_names = set(kwlist)  # readers in Python turn fields into attributes
    fields = [TagField(tag, field_name(tag.name, used_names), _constants(tag.names)) for tag in tags]
    return TagPlan(tuple(sorted(fields, key=lambda field: -FORMATS[field.tag.type].size)))


def read_plan(schema: str) -> TagPlan | None:
    """Return the plan in the schema of /scan; None if the schema has no tags.

    Raises:
        ValueError: the schema has invalid tags.
    """
    head, bodies = split_schema(schema)
    row = next((line.split(" ")[0] for line in head if line.endswith(f" {FIELD}")), None)
    if row is None:
        return None
    if row not in bodies:
        raise ValueError(f"no message {row}")
    return TagPlan(tuple(_read_field(line, bodies) for line in bodies[row]))


def _read_field(line: str, bodies: Mapping[str, Sequence[str]]) -> TagField:
    """Return the tag in a line of the row's message; raise ValueError if the line is not a tag."""
    match = _FIELD.fullmatch(line)
    if match is None:
        raise ValueError(f"{line!r} is not a tag")
    kind, length, name = match["type"], int(match["length"] or 0), match["name"]
    if match["text"] and kind == FORMATS["TEXT"].ros:
        return TagField(Tag(name, "TEXT", length), match["field"])
    if kind in _TYPES:
        return TagField(Tag(name, _TYPES[kind], length), match["field"])
    if kind not in bodies:
        raise ValueError(f"{line!r} has an unknown type")
    # the last line of an enum's message is its value, see `TagPlan.messages`
    constants = tuple(constant.split(" ")[1].partition("=")[0] for constant in bodies[kind][:-1])
    return TagField(Tag(name, "ENUM", length, constants), match["field"], constants)


def field_name(name: str, used_names: set[str]) -> str:
    r"""Return a new name that ROS 2 allows, `[a-z][a-z0-9]*(_[a-z0-9]+)*`, and add it to `used_names`.

    >>> used_names = set()
    >>> [field_name(name, used_names) for name in (r"\Main.Step", "Fill.ACC", "MaxSpeed", "max_speed")]
    ['main_step', 'fill_acc', 'max_speed', 'max_speed_2']
    >>> [field_name(name, used_names) for name in ("Recipe[3].T", "_x", "7up", "Größe", "\u6b65")]
    ['recipe_3_t', 'x', 't_7up', 'grosse', 'tag']
    """
    text = unicodedata.normalize("NFKD", without_ranges(name).removeprefix("Program:").replace("ß", "ss"))
    text = text.encode("ascii", "ignore").decode()
    text = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", text)
    stem = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_") or "tag"
    stem = f"t_{stem}" if stem[0].isdigit() else stem
    candidate, number = stem, 1
    while candidate in used_names:
        number += 1
        candidate = f"{stem}_{number}"
    used_names.add(candidate)
    return candidate


def _constants(names: Sequence[str]) -> tuple[str, ...]:
    used_names: set[str] = set()
    return tuple(field_name(name, used_names).upper() for name in names)


def _constant_lines(constants: Sequence[str]) -> list[str]:
    return [f"uint16 {name}={code}" for code, name in enumerate(constants)]


def _hash(lines: Sequence[str], digits: int) -> str:
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:digits]
