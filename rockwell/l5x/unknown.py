"""Infers types that a document does not define: module types, or types missing in a partial export.

These types get the members that rungs name, with types inferred from their use (`type_inference`). An axis
has hundreds of members, depending on kind and revision. Members in use that `AXIS_TYPES` lacks are added to
its type in the same way.

A call shows the types of its arguments: after `Guard(G1,Door:I,Door:I.Ch0)`, Door:I has the type of the first
InOut, and its member Ch0 the type of the second InOut.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from scanrack.ladder.lowering.type_inference import Guesses
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.predefined.motion_types import AXIS_TYPES
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.spec import Spec
from scanrack.ladder.model.tree import Address, MemberStep, Step, SubscriptStep
from scanrack.ladder.model.types import DINT, DataType, Member, Structure

from .addons import arguments_of
from .names import Names
from .scopes import type_of
from .uses import all_instructions
from .values.datatypes import Types, UnknownTypeError
from .xml.records import L5xDocument, RoutineRecord, TagRecord

_MEMBER = re.compile(r"([A-Za-z_]\w*)\.([A-Za-z_]\w*)", re.ASCII)
_ATTRIBUTE = re.compile(r"[GS]SV\(\s*Axis\s*,\s*(\w+)\s*,\s*(\w+)\s*,", re.ASCII | re.IGNORECASE)

Owned = Iterable[tuple[str, Routine]]
"""Routines, each with its program or add-on."""


class Argument(NamedTuple):
    """An argument of an add-on call that is passed to an InOut."""

    owner: str  # the program or add-on of the call
    address: Address
    inout: TagRecord


AXES = AXIS_TYPES["AXIS_CIP_DRIVE"]
"""An axis type; all axis types have the same members."""

_DEEPEST = 64  # maximum depth of types that depend on each other


class UnknownTypes:
    """Finds and infers the undefined types of a document."""

    def __init__(self, document: L5xDocument, types: Types) -> None:
        self._types = types
        self._members = {  # type names by member, by data type; both names in capitals
            record.name.upper(): {member.name.upper(): member.type for member in record.members}
            for record in document.data_types
        }
        names = Names(document)
        self._tags, self._add_ons = names.tags, names.add_ons
        self._record, self._without_aliases = names.record, names.without_aliases
        self._arguments = {add_on.name.upper(): tuple(arguments_of(add_on)) for add_on in document.add_ons}
        self._types_of_undeclared: dict[str, str] = {}  # by tag in capitals
        self.names = dict(self._missing(document))  # undefined types, by name in capitals
        self._routines_with_axes = frozenset(self._naming_axis_members(document))

    def __bool__(self) -> bool:
        """Return whether any type is undefined, or an axis lacks members."""
        return bool(self.names or self._routines_with_axes)

    def _missing(self, document: L5xDocument) -> Iterator[tuple[str, str]]:
        """Yield undefined types: name in capitals, name."""
        for data_type in document.data_types:
            for member in data_type.members:
                if self._is_unknown(member.type):
                    yield member.type.upper(), member.type
        for record in self._records():
            if self._is_unknown(record.type) and not self._shows_type(record):
                yield record.type.upper(), record.type

    def _axis_names(self) -> set[str]:
        """Return the names of axis tags and of their aliases, in capitals."""
        records = list(self._records())
        axes = {record.name.upper() for record in records if record.type.upper() in AXIS_TYPES}
        aliases = [record for record in records if record.target.rpartition(".")[2].upper() in axes]
        axes.update(alias.name.upper() for alias in aliases)
        return axes

    def _naming_axis_members(self, document: L5xDocument) -> Iterator[tuple[str, str]]:
        """Yield owner and name, in capitals, of routines that name axis members that `AXIS_TYPES` lacks."""
        axes = self._axis_names()
        for owner, routine in document.routines() if axes else ():
            members = _members_named(routine)
            if any(name.upper() in axes and AXES.member(member) is None for name, member in members):
                yield owner.upper(), routine.name.upper()

    def _records(self) -> Iterator[TagRecord]:
        """Yield all tags and parameters."""
        for scope in (*self._tags.values(), *self._add_ons.values()):
            yield from scope.values()

    def _is_unknown(self, name: str) -> bool:
        """Return whether no type has this name; return False for "" and for the name of an unusable type."""
        key = name.upper()
        if not key or key in self._members or key in self._add_ons:
            return False
        try:
            self._types.find(name)
        except LadderError as error:
            return isinstance(error, UnknownTypeError)
        return False

    def _shows_type(self, record: TagRecord) -> bool:
        """Return whether a tag's type is defined, or can be inferred from the tag's decorated values."""
        try:
            type_of(record, self._types)
        except LadderError:
            return False
        return True

    def define(self, routines: Owned, specs: Mapping[str, Spec]) -> Mapping[str, DataType]:
        """Define undefined types from their use; return them by name, axes with only the added members."""
        routines = list(routines)
        arguments: list[Argument] = []
        for owner, routine in routines:
            arguments += self._arguments_in(owner, routine)
        self._types_of_undeclared = dict(self._undeclared(arguments))
        guesses = Guesses(missing=self._use_of, known=self._type_of, of_call=lambda _name: (), specs=specs)
        if self.names:
            guesses.read_all(routines)
        else:  # only the members of axes are unknown
            guesses.read_all(
                (owner, routine)
                for owner, routine in routines
                if (owner.upper(), routine.name.upper()) in self._routines_with_axes
            )
        member_arguments = self._member_arguments(arguments)
        defined: dict[str, DataType] = {}
        for key in self.names:
            self._define(key, guesses, member_arguments, defined)
        return {name: defined[key] for key, name in self.names.items()} | self._extend_axes(guesses)

    def _undeclared(self, arguments: Iterable[Argument]) -> Iterator[tuple[str, str]]:
        """Yield the name (in capitals) and the InOut's type for each argument that is an undeclared tag."""
        for owner, address, inout in arguments:
            if not address.steps and not inout.dims and self._record(owner, address.name) is None:
                yield address.name.upper(), inout.type

    def _member_arguments(self, arguments: Iterable[Argument]) -> dict[str, list[Argument]]:
        """Return the arguments that are members of undefined types, by type in capitals."""
        by_type: dict[str, list[Argument]] = {}
        for argument in arguments:
            kind, steps = self._use_of(argument.owner, argument.address) or ("", ())
            if steps:
                by_type.setdefault(kind.upper(), []).append(argument)
        return by_type

    def _extend_axes(self, guesses: Guesses) -> dict[str, DataType]:
        """Add the members in use to the types of axes; return the added members by type."""
        extended: dict[str, DataType] = {}
        for name, axis in AXIS_TYPES.items():
            guess = guesses.found.get(name)
            added = guess.type(name) if guess else None
            if isinstance(added, Structure):
                extended[name] = added
                self._types.define(name, replace(axis, members=axis.members + added.members))
        return extended

    def _define(
        self,
        key: str,
        guesses: Guesses,
        member_arguments: dict[str, list[Argument]],
        defined: dict[str, DataType],
        depth: int = 0,
    ) -> None:
        """Define a type, after the types of the InOuts to which its members are passed.

        Args:
            key: the name of the type, in capitals.
            member_arguments: the arguments not handled yet, see `_member_arguments`.
            defined: the types defined so far, by name in capitals.
        """
        for owner, address, inout in member_arguments.pop(key, ()):
            inout_type = inout.type.upper()
            is_undefined = inout_type in self.names and inout_type not in defined
            if is_undefined and inout_type != key and depth < _DEEPEST:
                self._define(inout_type, guesses, member_arguments, defined, depth + 1)
            if inout_type in defined or inout_type not in self.names:
                guesses.argument(owner, address, self._types.find(inout.type), inout.dims)
        if key in defined:
            return
        guess = guesses.found.get(key)
        name = self.names[key]
        unknown = Structure(name, (Member("unknown", DINT, hidden=True),))
        defined[key] = guess.type(name) if guess else unknown
        self._types.define(name, defined[key])

    def _arguments_in(self, owner: str, routine: Routine) -> Iterator[Argument]:
        """Yield the arguments of InOuts in the add-on calls of a routine."""
        for instruction in all_instructions([routine]):
            parameters = self._arguments.get(instruction.name.upper(), ())
            for parameter, operand in zip(parameters, instruction.operands[1:], strict=False):
                if parameter.usage == "InOut" and isinstance(operand, Address):
                    yield Argument(owner, operand, parameter)

    def _use_of(self, owner: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
        """Return the undefined type in an address, and the steps after it; None if all types are defined.

        An axis counts as undefined if the next step is a member that `AXIS_TYPES` lacks.
        """
        address = self._without_aliases(owner, address)
        record = self._record(owner, address.name)
        kind = self._types_of_undeclared.get(address.name.upper(), "") if record is None else record.type
        steps = list(address.steps)
        while kind:
            if steps and isinstance(steps[0], SubscriptStep):
                del steps[0]
            member = steps[0].name if steps and isinstance(steps[0], MemberStep) else ""
            is_new_axis_member = kind.upper() in AXIS_TYPES and bool(member) and AXES.member(member) is None
            if kind.upper() in self.names or is_new_axis_member:
                return kind, tuple(steps)
            if not member:
                return None
            del steps[0]
            kind = self._member_type(kind, member)
        return None

    def _member_type(self, kind: str, name: str) -> str:
        """Return the name of a member's type; "" if it is unknown."""
        members = self._members.get(kind.upper())
        if members is not None:
            return members.get(name.upper(), "")
        parameter = self._add_ons.get(kind.upper(), {}).get(name.upper())
        return parameter.type if parameter is not None else ""

    def _type_of(self, owner: str, address: Address) -> DataType | None:
        """Return the type of a tag or of an array's element; None for members and undefined types."""
        record = self._record(owner, address.name)
        if record is None or any(isinstance(step, MemberStep) for step in address.steps):
            return None
        try:
            return self._types.find(record.type)
        except LadderError:
            return None


def _members_named(routine: RoutineRecord) -> Iterator[tuple[str, str]]:
    """Yield the names before and after each dot in a routine, and each GSV's and SSV's axis and attribute."""
    for text in (*(rung.text for rung in routine.rungs), *(text for text, _ in routine.lines)):
        yield from _MEMBER.findall(text)
        yield from _ATTRIBUTE.findall(text)
