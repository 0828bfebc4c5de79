"""Tags by name and number, and the bytes that a path refers to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from typing import NamedTuple

from scanrack.io_images.enip.codes import (
    BAD_SEGMENT,
    BEYOND,
    GENERAL,
    NO_PRIVILEGE,
    TYPE_CODES,
    UNKNOWN_OBJECT,
    CipRefusedError,
)
from scanrack.io_images.enip.listing import (
    BOOL,
    DWORD,
    ExternalAccess,
    Kind,
    ListedAlias,
    ListedTag,
    Listing,
    Part,
    PlainKind,
    StructuredKind,
)
from scanrack.io_images.enip.paths import PROGRAM, Instance, PathStep, steps_of

from .templates import Templates

READ_WRITE, READ_ONLY = 0, 2
"""Values of External Access in a listing."""

PROGRAM_CODE = 0x1068
"""Type code of a program in the controller's listing."""


@dataclass(frozen=True, slots=True)
class Symbol:
    """A tag with its numbers, or an alias with the numbers of its target."""

    number: int  # in its scope, from 1
    index: int  # in the listing
    tag: ListedTag  # an alias has its own name here
    target: tuple[PathStep, ...] = ()  # steps to the target of an alias


@dataclass(frozen=True, slots=True)
class Target:
    """Bytes of a tag that a path refers to."""

    symbol: Symbol
    kind: Kind
    offset: int
    count: int  # elements from there to the end of the array
    bit: int | None  # in the byte at `offset`
    name: str  # without subscripts: `Recipe.Steps.Time`

    @property
    def tag(self) -> ListedTag:
        """The tag."""
        return self.symbol.tag


class Writable:
    """Tags that clients may write, as patterns: `Run`, `Recipe.*`, `Local:1:O.Data`, `Program:Main.*`.

    A pattern matches a name and everything below it. Clients may write a whole structure if they may write
    all its members.
    """

    def __init__(self, patterns: Sequence[str]) -> None:
        texts = [_pattern(pattern) for pattern in patterns]
        self._expression = re.compile(
            "|".join(rf"(?:{text})(?:\.|$)" for text in texts) or r"(?!)", re.IGNORECASE
        )

    def matches(self, name: str) -> bool:
        """Return whether a pattern matches a name without subscripts, or one of its parents."""
        return self._expression.match(name) is not None

    def __call__(self, name: str, kind: Kind) -> bool:
        """Return whether clients may write all bytes under a name without subscripts."""
        if self.matches(name):
            return True
        members = _visible_members(kind)
        return bool(members) and all(self(f"{name}.{member.name}", member.kind) for member in members)

    def any_of(self, name: str, kind: Kind) -> bool:
        """Return whether clients may write any byte under a name."""
        if self(name, kind):
            return True
        return any(self.any_of(f"{name}.{member.name}", member.kind) for member in _visible_members(kind))


def _visible_members(kind: Kind) -> list[Part]:
    return [] if isinstance(kind, PlainKind) else [member for member in kind.parts if not member.hidden]


def _pattern(text: str) -> str:
    if text.startswith("\\"):
        text = PROGRAM + text[1:]
    return "".join({"*": ".*", "?": "."}.get(character, re.escape(character)) for character in text)


class Row(NamedTuple):
    """A line of a listing."""

    number: int
    name: str
    type_code: int
    element_size: int  # bytes
    dims: tuple[int, ...]
    access: int  # READ_WRITE or READ_ONLY


class Database:
    """The tags of a rack.

    Args:
        writable: patterns of names that clients may write.
    """

    def __init__(self, listing: Listing, writable: Sequence[str] = ()) -> None:
        self.listing, self.templates, self.writable = listing, Templates(), Writable(writable)
        self._programs = {name.upper(): name for name in listing.programs}
        # "" is the controller; names of programs and tags are keys in capitals
        self.scopes: dict[str, list[Symbol]] = {"": [], **{name: [] for name in self._programs}}
        self._by_name: dict[tuple[str, str], Symbol] = {}  # by scope and tag
        self._rows: dict[str, list[Row]] = {}  # by scope, from the first request on
        for index, tag in enumerate(listing.tags):
            if tag.access is not ExternalAccess.NONE:
                self._add(index, tag, ())
        for alias in listing.aliases:
            self._add_alias(alias)

    def _add(self, index: int, tag: ListedTag, target: tuple[PathStep, ...]) -> None:
        """Add a tag or an alias to its scope; in the controller, programs have the first numbers."""
        scope = self.scopes[tag.program.upper()]
        program_count = 0 if tag.program else len(self._programs)
        scope.append(Symbol(len(scope) + program_count + 1, index, tag, target))
        self._by_name[tag.program.upper(), tag.name.upper()] = scope[-1]
        self.templates.code_of(tag.kind)  # numbers its structures in the order of the tags

    def _add_alias(self, alias: ListedAlias) -> None:
        """Add an alias, unless clients can't see its tag."""
        try:
            steps = tuple(steps_of(alias.target))
            symbol, steps_below = self._resolve_symbol(steps)
            kind, dims = _Walk(symbol, steps_below).end()
        except (CipRefusedError, ValueError):
            return
        tag = ListedTag(alias.name, alias.program, kind, dims, symbol.tag.access, alias.comment)
        self._add(symbol.index, tag, steps)

    def rows(self, scope: str) -> list[Row]:
        """Return the lines of a scope, programs first; refuse an unknown scope."""
        key = scope.upper()
        if key not in self.scopes:
            raise CipRefusedError(UNKNOWN_OBJECT)
        if key not in self._rows:
            programs = [] if key else list(self._programs.values())
            rows = [
                Row(number, f"{PROGRAM}{name}", PROGRAM_CODE, 0, (), READ_WRITE)
                for number, name in enumerate(programs, 1)
            ]
            self._rows[key] = [*rows, *map(self._row, self.scopes[key])]
        return self._rows[key]

    def _row(self, symbol: Symbol) -> Row:
        """Return the line of a tag; it is READ_WRITE if clients may write any byte of the tag."""
        tag = symbol.tag
        code, dims = self.templates.code_of(tag.kind), tag.dims
        if tag.is_bits:
            code, dims = TYPE_CODES["DWORD"], (tag.count,)
        target = self.resolve(symbol.target) if symbol.target else None
        name = tag.path if target is None else target.name
        writes = tag.access is ExternalAccess.READ_WRITE and self.writable.any_of(name, tag.kind)
        access = READ_WRITE if writes else READ_ONLY
        type_code = code | len(dims) << 13
        return Row(symbol.number, tag.name, type_code, element_size=tag.element, dims=dims, access=access)

    def refuse_write(self, target: Target) -> None:
        """Refuse a write to a target that clients may not write."""
        if not self.may_write(target.tag, target.name, target.kind):
            raise CipRefusedError(NO_PRIVILEGE)

    def may_write(self, tag: ListedTag, name: str, kind: Kind) -> bool:
        """Return whether the rack lists a name as writable and the tag's external access allows writing."""
        return tag.access is ExternalAccess.READ_WRITE and self.writable(name, kind)

    def resolve(self, steps: Sequence[PathStep]) -> Target:
        """Return the target of a path; refuse a path whose target does not exist."""
        symbol, steps_below = self._resolve_symbol(steps)
        return _Walk(symbol, steps_below).target()

    def _resolve_symbol(self, steps: Sequence[PathStep]) -> tuple[Symbol, list[PathStep]]:
        """Return the tag at the start of a path, with aliases resolved, and the steps below the tag."""
        scope, steps_left = "", list(steps)
        first_step = steps_left[0] if steps_left else ""
        if isinstance(first_step, str) and first_step.lower().startswith(PROGRAM.lower()):
            scope = first_step[len(PROGRAM) :].upper()
            del steps_left[0]
        if not steps_left or isinstance(steps_left[0], int):
            raise CipRefusedError(BAD_SEGMENT)
        symbol = self._symbol(scope, steps_left.pop(0))
        return self._resolve_symbol((*symbol.target, *steps_left)) if symbol.target else (symbol, steps_left)

    def _symbol(self, scope: str, step: PathStep) -> Symbol:
        """Return the tag or alias with a name or an instance number in a scope; refuse an unknown one."""
        if isinstance(step, Instance):
            symbols = self.scopes.get(scope, [])
            index = step.number - 1 - (0 if scope else len(self._programs))
            symbol = symbols[index] if 0 <= index < len(symbols) else None
        else:
            symbol = self._by_name.get((scope, str(step).upper()))
        if symbol is None:
            raise CipRefusedError(BAD_SEGMENT)
        return symbol


def _flat_index(indices: Sequence[int], lengths: Sequence[int]) -> int:
    """Return the position of an array element in memory; refuse an index beyond its dimension."""
    flat = 0
    for index, length in zip(indices, lengths, strict=True):
        if index >= length:
            raise CipRefusedError(GENERAL, BEYOND)
        flat = flat * length + index
    return flat


class _Walk:
    """Follows the steps of a path into a tag."""

    def __init__(self, symbol: Symbol, steps: list[PathStep]) -> None:
        tag = symbol.tag
        self._symbol, self._steps = symbol, steps
        # where the walk is now
        self._kind, self._dims, self._offset = tag.kind, tag.dims, 0
        self._bit: int | None = None
        self._name = tag.path

    def end(self) -> tuple[Kind, tuple[int, ...]]:
        """Return the type and the dimensions at the end of the path."""
        self.target()
        return self._kind, self._dims

    def target(self) -> Target:
        """Return the bytes at the end of the path; refuse a step that does not exist."""
        while True:
            count, is_single = self._subscripts()
            if not self._steps:
                return Target(self._symbol, self._kind, self._offset, count, self._bit, self._name)
            if not is_single:
                raise CipRefusedError(BAD_SEGMENT)
            step = self._steps.pop(0)
            if not isinstance(step, str):
                raise CipRefusedError(BAD_SEGMENT)
            self._enter(step)

    def _subscripts(self) -> tuple[int, bool]:
        """Apply subscripts; return the number of elements to the array's end, and whether one is selected."""
        indices: list[int] = []
        while self._steps and isinstance(self._steps[0], int):
            indices.append(self._steps.pop(0))  # type: ignore[arg-type]
        if self._kind == BOOL and self._dims:
            self._kind, self._dims = DWORD, (-(-prod(self._dims) // 32),)
        element_count = prod(self._dims)
        if not indices:
            return element_count, not self._dims
        if not self._dims or len(indices) not in (1, len(self._dims)):
            raise CipRefusedError(UNKNOWN_OBJECT)
        flat = _flat_index(indices, self._dims if len(indices) > 1 else (element_count,))
        self._offset += flat * self._kind.size
        self._dims = ()
        return element_count - flat, True

    def _enter(self, name: str) -> None:
        """Enter a member, or a bit of an integer."""
        if isinstance(self._kind, StructuredKind):
            member = self._kind.by_name.get(name.upper())
            if member is None:
                raise CipRefusedError(BAD_SEGMENT)
            self._kind, self._dims, self._bit = member.kind, member.dims, member.bit
            self._offset += member.offset
            self._name += f".{member.name}"
        elif name.isascii() and name.isdigit() and self._bit is None and int(name[:4]) < self._kind.bits:
            self._kind, self._bit = BOOL, int(name[:4]) % 8
            self._offset += int(name[:4]) // 8
        else:
            raise CipRefusedError(BAD_SEGMENT)
