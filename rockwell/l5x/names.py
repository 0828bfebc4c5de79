"""Looks up the tags of a document by name, before they are declared: records, aliases, types."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from scanrack.ladder.lowering.guess import type_at
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_address
from scanrack.ladder.model.tags import Declaration, Tag
from scanrack.ladder.model.tree import Address
from scanrack.ladder.model.types import DataType

from .assembly import owner_of
from .values.datatypes import Types
from .xml.records import L5xDocument, TagRecord


class Names:
    """The tags of programs, add-ons and the controller, each scope by name in capitals."""

    def __init__(self, document: L5xDocument) -> None:
        self.tags = {"": _by_name(document.tags)}  # "" for the controller
        for program in document.programs:
            self.tags[program.name.upper()] = _by_name(program.tags)
        self.add_ons = {
            add_on.name.upper(): _by_name((*add_on.parameters, *add_on.locals)) for add_on in document.add_ons
        }

    def record(self, owner: str, name: str) -> TagRecord | None:
        """Return the tag with a name in the scope of a program or add-on; None if it is undeclared."""
        add_on = self.add_ons.get(owner.upper())
        if add_on is not None and name.upper() in add_on:
            return add_on[name.upper()]
        if name.startswith("\\"):
            owner, name = owner_of(name)
            return self.tags.get(owner.upper(), {}).get(name.upper())
        return self.tags.get(owner.upper(), {}).get(name.upper()) or self.tags[""].get(name.upper())

    def without_aliases(self, owner: str, address: Address) -> Address:
        """Resolve the aliases in an address as far as possible."""
        for _ in range(20):
            record = self.record(owner, address.name)
            if record is None or not record.target:
                break
            try:
                target = parse_address(record.target)
            except LadderError:
                break
            address = Address(target.name, target.steps + address.steps)
        return address

    def type_of(
        self, owner: str, address: Address, types: Types, module_tags: Mapping[str, Declaration]
    ) -> DataType | None:
        """Return the type of an address; None if it is unknown."""
        address = self.without_aliases(owner, address)
        record = self.record(owner, address.name)
        tag = module_tags.get(address.name.upper())
        if record is not None:
            try:
                tag = Tag(record.name, types.find(record.type), record.dims)
            except LadderError:
                return None
        return type_at(tag, address)


def _by_name(records: Iterable[TagRecord]) -> dict[str, TagRecord]:
    return {record.name.upper(): record for record in records}
