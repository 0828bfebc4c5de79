"""Adds missing members that rungs name to structures, and infers their types.

The members are added at the end of a user-defined or module structure. COP and SIZE use the longer structure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from scanrack.ladder.lowering.type_inference import Guesses
from scanrack.ladder.model.predefined.structures import PREDEFINED_TYPES
from scanrack.ladder.model.spec import Spec
from scanrack.ladder.model.tags import Declaration, Tag
from scanrack.ladder.model.tree import Address, MemberStep, Step, SubscriptStep
from scanrack.ladder.model.types import DataType, Member, Structure

from .assembly import Parts
from .report import Report


def widen(parts: Parts, specs: Mapping[str, Spec], report: Report) -> None:
    """Add the members that programs name to the types of their tags, and report them."""
    widening = _Widening(parts)
    guesses = Guesses(widening.use_of, parts.type_of, parts.operands_of, specs)
    guesses.read_all(parts.program_routines())
    for key, guess in guesses.found.items():
        members = widening.added[key] = tuple(guess.root.own_members(guess.name))
        for member in members:
            report.declare(f"{guess.name}.{member.name}", member.type, member.dims)
    if not widening.added:
        return
    parts.declarations = widening.widened_declarations(parts.declarations)
    for part in parts.programs.values():
        part.declarations = widening.widened_declarations(part.declarations)
    for key, definition in parts.add_ons.items():
        parameters = tuple(
            replace(parameter, type=widening.widened_type(parameter.type))
            for parameter in definition.parameters
        )
        if parameters != definition.parameters:
            parts.add_ons[key] = replace(definition, parameters=parameters)


class _Widening:
    """Finds structures that lack a member, and replaces them."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._widened: dict[int, tuple[Structure, Structure]] = {}  # by id of the type, which is kept alive
        self.added: dict[str, tuple[Member, ...]] = {}  # by type in capitals

    def use_of(self, program: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
        """Return the structure that lacks a member of an address, and the remaining steps; otherwise None."""
        address = self._parts.without_aliases(program, address)
        tag = self._parts.declaration(program, address.name)
        kind: DataType | None = tag.type if isinstance(tag, Tag) else None
        for index, step in enumerate(address.steps):
            if isinstance(step, SubscriptStep):
                continue
            if not isinstance(step, MemberStep) or not isinstance(kind, Structure):
                return None
            member = kind.member(step.name)
            if member is None:
                return None if self._is_fixed(kind) else (kind.name, address.steps[index:])
            kind = member.type
        return None

    def _is_fixed(self, kind: Structure) -> bool:
        """Return whether all members of a structure are known."""
        return kind.is_string or kind.name in PREDEFINED_TYPES or kind.name.upper() in self._parts.add_ons

    def widened_declarations(self, declarations: list[Declaration]) -> list[Declaration]:
        """Return declarations with the widened types."""
        return [
            replace(declaration, type=self.widened_type(declaration.type))
            if isinstance(declaration, Tag)
            else declaration
            for declaration in declarations
        ]

    def widened_type(self, kind: DataType) -> DataType:
        """Return a type with its missing members added."""
        if not isinstance(kind, Structure):
            return kind
        if id(kind) not in self._widened:
            members = tuple(replace(member, type=self.widened_type(member.type)) for member in kind.members)
            wider = members + self.added.get(kind.name.upper(), ())
            self._widened[id(kind)] = kind, kind if wider == kind.members else replace(kind, members=wider)
        return self._widened[id(kind)][1]
