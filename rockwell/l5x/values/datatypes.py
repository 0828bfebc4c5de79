"""Data types of a document by name.

For each name, the first match is used: elementary types, types that the document defines, its add-on
instructions, predefined types (`predefined`), and types inferred from decorated values.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from scanrack.io_images.text_limits import EXPORT_MIB, EXPORT_MIB_MOST
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.predefined.structures import PREDEFINED_TYPES
from scanrack.ladder.model.types import (
    BOOL,
    MAX_DIMENSIONS,
    TYPES,
    DataType,
    Elementary,
    Member,
    Structure,
    count_of,
)

from ..xml.elements import number_of
from ..xml.records import DataTypeRecord, Element, MemberRecord
from .layouts import Layouts
from .module_bits import with_bit_places
from .per_type import per_type

PATH_BYTES, VALUE_BYTES = 1400, 8
"""Measured memory, in bytes, for a path such as `Line.Speed`, and for each of its values."""

EIGHTS_SINCE = 27
"""First software revision with 8-byte values at multiples of 8 [1756-RM100F, chapter 5]."""

DEEPEST = 64
"""Maximum depth of nested types."""

NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
"""Names of members, parameters, programs and routines."""

_RENAMED: Mapping[str, str] = {
    **dict.fromkeys(("BIT", "BOOLEAN"), "BOOL"),
    **dict.fromkeys(("TIME", "LTIME", "DT", "LDT"), "LINT"),
    "TIMER_T": "TIMER",
    "TIME32": "DINT",
}
"""Other names of types. Durations and dates are integers in µs, or in ns if the name begins with an L."""


class _Counts(NamedTuple):
    """Number of paths to values and number of values; an array of 10 DINTs is one path with 10 values."""

    paths: int
    values: int


class UnknownTypeError(LadderError):
    """The document does not define a type."""


class Types:
    """All types by name; if the document has several types with the same name, the first is used."""

    def __init__(
        self, records: Iterable[DataTypeRecord], revision: str = "", memory_mib: int = EXPORT_MIB
    ) -> None:
        self._records: dict[str, DataTypeRecord] = {}
        for record in records:
            self._records.setdefault(record.name.upper(), record)
        major = number_of(revision.partition(".")[0])
        self._own = set(self._records)  # types with all members known, by name in capitals
        self.layouts = Layouts(major is None or major >= EIGHTS_SINCE, self._own)
        self._defined: dict[str, DataType] = {name.upper(): kind for name, kind in TYPES.items()}
        self._being_defined: list[str] = []  # a type after the types that contain it, by name in capitals
        self._shown: dict[str, DataType] = {}  # types that decorated values show, by name in capitals
        self.by_type: dict[tuple[str, int], tuple[DataType, Any]] = {}  # see `per_type`
        self._limit_mib = memory_mib
        self._bytes_left = memory_mib << 20  # for further tags
        self._depth = 0  # of decorated values
        self.apart: dict[str, list[str]] = {}  # integers with unknown bits, by module-defined type
        self.wrong: dict[str, str] = {}  # unusable types with the reason, by name in capitals
        # finds an add-on's structure by its name in capitals; set by the add-ons of the document
        self.add_on: Callable[[str], Structure | None] = lambda _name: None

    def find(self, name: str) -> DataType:
        """Return a type by name.

        Raises:
            UnknownTypeError: the type is undefined.
            LadderError: the type is unusable.
        """
        key = name.upper()
        defined = self._defined.get(key)
        if defined is not None:
            return defined
        if key in self.wrong:
            raise LadderError(self.wrong[key])
        if key in self._being_defined:
            raise LadderError(f"data type {name} contains itself")
        if len(self._being_defined) == DEEPEST:
            raise LadderError(f"data type {name} is nested in {DEEPEST} others")
        self._being_defined.append(key)
        try:
            kind = self._look_up(key, name)
        except UnknownTypeError:
            raise
        except LadderError as error:
            self.wrong[key] = str(error)
            raise
        finally:
            self._being_defined.pop()
        self._defined[key] = kind
        return kind

    def _look_up(self, key: str, name: str) -> DataType:
        """Return a type that is not yet defined, from the first source that has it; see `find`."""
        record = self._records.get(key)
        if record is not None:
            return self._structure(record)
        kind = self.add_on(key) or PREDEFINED_TYPES.get(key) or self._shown.get(key)
        if kind is None and key in _RENAMED:
            kind = TYPES[_RENAMED[key]]
        if kind is None:
            raise UnknownTypeError(f"no data type {name}")
        return kind

    def _structure(self, record: DataTypeRecord) -> Structure:
        """Return the structure of a data type; raise a LadderError if a member or the size is invalid."""
        structure = Structure(record.name, tuple(self._member(record, member) for member in record.members))
        for member in structure.members:
            _refuse_host(structure, member)
        self.refuse_size(structure)
        return structure

    def refuse_size(self, kind: Structure) -> None:
        """Raise a LadderError for a structure that is too large."""
        self._refuse(f"data type {kind.name}", self._bytes(kind, ()))

    def _refuse(self, subject: str, size: int) -> None:
        """Raise a LadderError if the size in bytes is above the limit."""
        if size > self._limit_mib << 20:
            mib = f"{-(-size >> 20):,} MiB" if size < EXPORT_MIB_MOST << 20 else "too much memory"
            raise LadderError(f"{subject} takes {mib}; {self._limit_mib:,} MiB are allowed (--memory)")

    def _bytes(self, kind: DataType, dims: tuple[int, ...]) -> int:
        """Return the approximate memory of a tag, in bytes."""
        count = self._count_values(kind)
        return count.paths * PATH_BYTES + count.values * count_of(dims) * VALUE_BYTES

    @per_type
    def _count_values(self, kind: DataType) -> _Counts:
        """Count the paths and the values of an element of a type."""
        if isinstance(kind, Elementary):
            return _Counts(1, 1)
        paths = values = 0
        for member in kind.own:
            counts = self._count_values(member.type)
            paths += counts.paths
            values += counts.values * count_of(member.dims)
        return _Counts(paths, values)

    @per_type
    def has_initials(self, kind: DataType) -> bool:
        """Return whether a type has initial values other than zero."""
        if isinstance(kind, Elementary):
            return False
        return any(member.initial is not None or self.has_initials(member.type) for member in kind.members)

    @per_type
    def has_locals(self, kind: DataType) -> bool:
        """Return whether a type contains add-on instances, whose local tags decorated data lacks."""
        if isinstance(kind, Elementary):
            return False
        is_add_on = kind.name.upper() in self.layouts.add_ons
        return is_add_on or any(self.has_locals(member.type) for member in kind.own)

    def take(self, kind: DataType, dims: tuple[int, ...]) -> None:
        """Add the memory of a tag to the total; raise a LadderError beyond the limit."""
        needed = self._bytes(kind, dims)
        self._refuse("it", needed)
        if needed > self._bytes_left:
            raise LadderError(
                f"the tags of the file take more than the {self._limit_mib:,} MiB that are allowed (--memory)"
            )
        self._bytes_left -= needed

    def _member(self, record: DataTypeRecord, member: MemberRecord) -> Member:
        """Return a member of a data type; a BIT is a bit of its target.

        Raise a LadderError if it is invalid.
        """
        place = f"{member.name} of data type {record.name}"
        if not NAME.fullmatch(member.name):
            raise LadderError(f"{place}: this is not a name")
        if len(member.dims) > MAX_DIMENSIONS:
            raise LadderError(f"{place} has dimensions {member.dims}")
        if member.wrong_dims:
            raise LadderError(f"{place}: {member.wrong_dims!r} are not dimensions")
        if member.type.upper() == "BIT" and member.target:
            return Member(member.name, BOOL, at=f"{member.target}.{member.bit}", hidden=member.hidden)
        try:
            kind = self.find(member.type)
        except UnknownTypeError:
            raise LadderError(f"{place} is a {member.type}, which the file does not define") from None
        self._refuse(place, self._bytes(kind, member.dims))
        return Member(member.name, kind, member.dims, hidden=member.hidden)

    def own(self, kind: Structure) -> Structure:
        """Register a type that was built from all of its members; return it."""
        self._own.add(kind.name.upper())
        return kind

    def define(self, name: str, kind: DataType) -> None:
        """Define a type, or replace it."""
        self._defined[name.upper()] = kind
        self.wrong.clear()  # types that failed because of this one are looked up again

    def show(self, data: Element) -> DataType | None:
        """Return the type inferred from a decorated value; None if no type can be inferred.

        Args:
            data: a `Structure`, `Array`, `DataValue` or one of their members.
        """
        kind = data.get("DataType", "")
        try:
            return self.find(kind)
        except LadderError:
            pass
        if data.tag not in ("Structure", "StructureMember") or self._depth == DEEPEST:
            return None
        self._depth += 1
        members: Iterable[Member] = list(filter(None, map(self._shown_member, data.iterchildren())))
        self._depth -= 1
        if ":" in kind:
            values = {child.get("Name", ""): child.get("Value", "") for child in data.iterchildren("*")}
            members, self.apart[kind] = with_bit_places(members, values)
        structure = _unique(kind or "unnamed", members)
        if self._bytes(structure, ()) > self._limit_mib << 20:
            return None
        if kind:
            self._shown[kind.upper()] = structure
            self._own.add(kind.upper())
        return structure

    def _shown_member(self, element: Any) -> Member | None:
        """Return the member that a decorated element shows; None if it can't be inferred."""
        name = element.get("Name")
        if not name or not isinstance(element.tag, str) or not NAME.fullmatch(name):
            return None
        if element.tag == "ArrayMember":
            return self._shown_array(element, name)
        kind = self.show(element)
        return Member(name, kind) if kind is not None else None

    def _shown_array(self, element: Any, name: str) -> Member | None:
        """Return the array member that an element shows; None without a type or valid, allowed lengths."""
        first = element.find("Element/Structure")
        kind = self.show(first if first is not None else element)
        lengths = tuple(filter(None, map(number_of, element.get("Dimensions", "").split(","))))
        if kind is None or not lengths or len(lengths) > MAX_DIMENSIONS or min(lengths) < 1:
            return None
        return Member(name, kind, lengths) if self._bytes(kind, lengths) <= self._limit_mib << 20 else None


def _refuse_host(kind: Structure, member: Member) -> None:
    """Raise a LadderError for a packed bit whose host is not an integer, or lacks the bit."""
    name, _, bit = member.at.partition(".")
    host = kind.member(name) if member.at else None
    if host is None:
        return
    is_integer = isinstance(host.type, Elementary) and host.type.is_integer and not host.dims
    if not is_integer or int(bit) >= host.type.bits:  # type: ignore[union-attr]
        raise LadderError(f"{member.name} of data type {kind.name} is at {member.at}, which is not a bit")


def _unique(name: str, members: Iterable[Member]) -> Structure:
    """Return a structure with the first member of each name."""
    by_name: dict[str, Member] = {}
    for member in members:
        by_name.setdefault(member.name.upper(), member)
    return Structure(name, tuple(by_name.values()))
