"""Undefined types: of modules, or missing in a partial export.

They get the members that rungs name, with types inferred from their use (`type_inference`). An axis has
hundreds of members, depending on kind and revision: used members that `AXIS_TYPES` lacks are added to its
type in the same way.

A call shows the type of its arguments: after `Guard(G1,Door:I,Door:I.Ch0)` Door:I has the type of the first
InOut, and a member Ch0 of the type of the second.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

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

Argument = tuple[str, Address, TagRecord]
"""An argument: the program or add-on of the call, the address, the InOut."""

AXES = AXIS_TYPES["AXIS_CIP_DRIVE"]
_DEEPEST = 64  # maximum depth of types that depend on each other


class UnknownTypes:
    """Finds and infers the undefined types of a document."""

    def __init__(self, document: L5xDocument, types: Types) -> None:
        self._types = types
        self._members = {
            record.name.upper(): {member.name.upper(): member.type for member in record.members}
            for record in document.data_types
        }
        names = Names(document)
        self._tags, self._add_ons = names.tags, names.add_ons
        self._record, self._without_aliases = names.record, names.without_aliases
        self._arguments = {add_on.name.upper(): tuple(arguments_of(add_on)) for add_on in document.add_ons}
        self._passed: dict[str, str] = {}
        self.names = dict(self._missing(document))
        self._with_axes = frozenset(self._naming_axis_members(document))

    def __bool__(self) -> bool:
        """Whether any type is undefined."""
        return bool(self.names or self._with_axes)

    def _missing(self, document: L5xDocument) -> Iterator[tuple[str, str]]:
        """Yield undefined types: name in capitals, name."""
        for data_type in document.data_types:
            for member in data_type.members:
                if self._is_unknown(member.type):
                    yield member.type.upper(), member.type
        for record in self._records():
            if self._is_unknown(record.type) and not self._shows(record):
                yield record.type.upper(), record.type

    def _naming_axis_members(self, document: L5xDocument) -> Iterator[tuple[str, str]]:
        """Yield owner and name, in capitals, of routines that name axis members that `AXIS_TYPES` lacks."""
        records = list(self._records())
        axes = {record.name.upper() for record in records if record.type.upper() in AXIS_TYPES}
        axes |= {
            record.name.upper() for record in records if record.target.rpartition(".")[2].upper() in axes
        }
        for owner, routine in document.routines() if axes else ():
            members = _members_named(routine)
            if any(name.upper() in axes and AXES.member(member) is None for name, member in members):
                yield owner.upper(), routine.name.upper()

    def _records(self) -> Iterator[TagRecord]:
        """Yield all tags and parameters."""
        for scope in (*self._tags.values(), *self._add_ons.values()):
            yield from scope.values()

    def _is_unknown(self, name: str) -> bool:
        key = name.upper()
        if not key or key in self._members or key in self._add_ons:
            return False
        try:
            self._types.find(name)
        except LadderError as error:
            return isinstance(error, UnknownTypeError)
        return False

    def _shows(self, record: TagRecord) -> bool:
        try:
            type_of(record, self._types)
        except LadderError:
            return False
        return True

    def define(self, routines: Owned, specs: Mapping[str, Spec]) -> Mapping[str, DataType]:
        """Define undefined types from their use; return them by name, axes with only the added members."""
        owned = list(routines)
        arguments = [argument for owner, routine in owned for argument in self._arguments_in(owner, routine)]
        self._passed = dict(self._undeclared(arguments))
        guesses = Guesses(self._use_of, self._known, lambda _name: (), specs)
        guesses.read_all(
            (owner, routine)
            for owner, routine in owned
            if self.names or (owner.upper(), routine.name.upper()) in self._with_axes
        )
        parts = self._parts_passed(arguments)
        settled: dict[str, DataType] = {}
        for key in self.names:
            self._settle(key, guesses, parts, settled)
        return {name: settled[key] for key, name in self.names.items()} | self._extend_axes(guesses)

    def _undeclared(self, passed: Iterable[Argument]) -> Iterator[tuple[str, str]]:
        """Yield arguments without a declared tag: name in capitals and type of the parameter."""
        for owner, address, inout in passed:
            if not address.steps and not inout.dims and self._record(owner, address.name) is None:
                yield address.name.upper(), inout.type

    def _parts_passed(self, passed: Iterable[Argument]) -> dict[str, list[Argument]]:
        """Return the arguments that are members of undefined types, by type in capitals."""
        parts: dict[str, list[Argument]] = {}
        for argument in passed:
            use = self._use_of(argument[0], argument[1])
            if use is not None and use[1]:
                parts.setdefault(use[0].upper(), []).append(argument)
        return parts

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

    def _settle(
        self,
        key: str,
        guesses: Guesses,
        parts: dict[str, list[Argument]],
        settled: dict[str, DataType],
        depth: int = 0,
    ) -> None:
        """Define a type, after the types of the InOuts to which its members are passed."""
        for owner, address, inout in parts.pop(key, ()):
            inner_type = inout.type.upper()
            if (
                inner_type in self.names
                and inner_type not in settled
                and inner_type != key
                and depth < _DEEPEST
            ):
                self._settle(inner_type, guesses, parts, settled, depth + 1)
            if inner_type in settled or inner_type not in self.names:
                guesses.argument(owner, address, self._types.find(inout.type), inout.dims)
        if key in settled:
            return
        guess = guesses.found.get(key)
        name = self.names[key]
        unknown = Structure(name, (Member("unknown", DINT, hidden=True),))
        settled[key] = guess.type(name) if guess else unknown
        self._types.define(name, settled[key])

    def _arguments_in(self, owner: str, routine: Routine) -> Iterator[Argument]:
        """Yield the arguments of add-on calls in a routine."""
        for instruction in all_instructions([routine]):
            for inout, operand in zip(
                self._arguments.get(instruction.name.upper(), ()), instruction.operands[1:], strict=False
            ):
                if inout.usage == "InOut" and isinstance(operand, Address):
                    yield owner, operand, inout

    def _use_of(self, owner: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
        """Return the undefined type to which an address leads, and the remaining steps, or None."""
        address = self._without_aliases(owner, address)
        record = self._record(owner, address.name)
        kind = record.type if record is not None else self._passed.get(address.name.upper(), "")
        steps = list(address.steps)
        while kind:
            if isinstance(next(iter(steps), None), SubscriptStep):
                steps.pop(0)
            first_step = next(iter(steps), None)
            member_name = first_step.name if isinstance(first_step, MemberStep) else ""
            beyond = kind.upper() in AXIS_TYPES and bool(member_name) and AXES.member(member_name) is None
            if kind.upper() in self.names or beyond:
                return kind, tuple(steps)
            if not member_name:
                return None
            del steps[0]
            kind = self._member_type(kind, member_name)
        return None

    def _member_type(self, kind: str, name: str) -> str:
        members = self._members.get(kind.upper())
        if members is not None:
            return members.get(name.upper(), "")
        parameter = self._add_ons.get(kind.upper(), {}).get(name.upper())
        return parameter.type if parameter is not None else ""

    def _known(self, owner: str, address: Address) -> DataType | None:
        record = self._record(owner, address.name)
        if record is None or any(isinstance(step, MemberStep) for step in address.steps):
            return None
        try:
            return self._types.find(record.type)
        except LadderError:
            return None


def _members_named(routine: RoutineRecord) -> Iterator[tuple[str, str]]:
    """Yield the tags, each with a member, that the texts of a routine name."""
    for text in (*(rung.text for rung in routine.rungs), *(text for text, _ in routine.lines)):
        yield from _MEMBER.findall(text)
        yield from _ATTRIBUTE.findall(text)
