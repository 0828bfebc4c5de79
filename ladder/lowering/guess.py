"""The evidence for the type of an undeclared tag, as a tree of its members; see `type_inference`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from itertools import zip_longest

from scanrack.io_images.dataclass import dataclass

from ..model.predefined.motion_types import is_axis
from ..model.tags import Declaration, Tag
from ..model.tree import Address, BitStep, MemberStep, Number, SubscriptStep
from ..model.types import BOOL, DINT, INT, LINT, REAL, STRING, DataType, Member, Structure

COMPUTED = 100
"""Number of elements assumed for an array with a computed subscript."""

COMPUTED_EACH = 16
"""Number of elements assumed per dimension for a multi-dimensional array with computed subscripts."""

MOST = 20_000
"""Maximum number of elements inferred from a constant subscript."""


@dataclass(slots=True)
class Guess:
    """The evidence for the type of a tag or member."""

    name: str
    structures: tuple[Structure, ...] = ()  # candidates for its type
    members: dict[str, Guess] = field(default_factory=dict)  # by name in capitals
    lengths: list[int] = field(default_factory=list)  # of its dimensions, from subscripts
    votes: list[DataType] = field(default_factory=list)  # types that its uses require
    weak: list[DataType] = field(default_factory=list)  # types that its uses suggest
    bit: int = -1  # the highest accessed bit, -1 without one
    copied: int = 0  # length of a copy of it, elements; 0 without a copy
    number: DataType = DINT  # type of a number without other evidence
    single: bool = False  # whether a use reads or writes it as a single value
    twin: Guess | None = None  # the guess with the evidence of both, see `same_as`
    _cached_type: DataType | None = None

    @property
    def root(self) -> Guess:
        """The guess that collects the evidence: this guess, or the last of its twins."""
        guess = self
        while guess.twin is not None:
            guess = guess.twin
        return guess

    def same_as(self, other: Guess) -> None:
        """Note that both tags have the same type, such as a queue and a value loaded into it.

        This guess receives the evidence of the other guess. Members of the same name are joined in the same
        way.
        """
        own_root, other_root = self.root, other.root
        todo = [(own_root, other_root)]
        while todo:
            kept, absorbed = todo.pop()
            if kept is absorbed:
                continue
            absorbed.twin = kept
            kept.bit = max(kept.bit, absorbed.bit)
            for kinds, added in ((kept.votes, absorbed.votes), (kept.weak, absorbed.weak)):
                for kind in added:
                    add_kind(kinds, kind)
            for name, member in absorbed.members.items():
                if name in kept.members:
                    member_guess = kept.members[name]
                    member_guess.lengths = _longer_lengths(member_guess.lengths, member.lengths)
                    todo.append((member_guess.root, member.root))
                else:
                    kept.members[name] = member

    @property
    def is_bare(self) -> bool:
        """Whether copies and subscripts are the only evidence for the type."""
        root = self.root
        return not root.members and root.bit < 0 and not root.votes and root.weak in ([], [DINT])

    def member(self, name: str) -> Guess:
        """Return a member, created if new."""
        root = self.root
        return root.members.setdefault(name.upper(), Guess(name, root.structures, number=root.number))

    def subscripts(self, step: SubscriptStep) -> None:
        """Note subscripts."""
        while len(self.lengths) < len(step.indices):
            self.lengths.append(0)
        for dimension, index in enumerate(step.indices):
            length = COMPUTED if len(step.indices) == 1 else COMPUTED_EACH
            if isinstance(index, Number) and isinstance(index.value, int):
                length = min(max(index.value, 0), MOST - 1) + 1
            self.lengths[dimension] = max(self.lengths[dimension], length)

    @property
    def dims(self) -> tuple[int, ...]:
        """Dimensions from its subscripts, or from a copy if it is never used as a single value."""
        lengths = self.lengths
        if self.copied and (lengths or not self.single):
            lengths = [max([self.copied, *lengths[:1]]), *lengths[1:]]
        return tuple(max(1, length) for length in lengths[:3])

    def type(self, path: str) -> DataType:
        """Return the guessed type; `path` is the name of a new structure, if one is needed."""
        root = self.root
        if root._cached_type is None:
            root._cached_type = root._infer_type(path)
        return root._cached_type

    def _infer_type(self, path: str) -> DataType:
        """Return the type for the strongest evidence.

        The order is a structure that a use requires, members, bits, votes, weak votes.
        """
        if self.needed is not None:
            return self._with_members(self.needed, path)
        if self.members:
            return self._structure_type(path)
        if self.bit >= 0:
            return LINT if self.bit > 31 else self.number
        for votes in (self.votes, self.weak):
            for kind in (BOOL, REAL, LINT, DINT):
                if kind in votes:
                    return self.number if votes is self.weak and kind is DINT else kind
            if votes:
                return votes[0]
        return self.number

    @property
    def asks_for_structure(self) -> bool:
        """Whether a use of the tag or of a member requires a structure."""
        root = self.root
        asks = root.needed is not None or root.weak == [STRING]
        return asks or any(member.asks_for_structure for member in root.members.values())

    @property
    def needed(self) -> DataType | None:
        """The structure that a use requires; None if no use does."""
        return next((vote for vote in self.root.votes if isinstance(vote, Structure)), None)

    def _with_members(self, needed: DataType, path: str) -> DataType:
        """Return an axis type with the undocumented members in use; return any other type unchanged."""
        if not isinstance(needed, Structure) or not is_axis(needed):
            return needed
        added = tuple(member for member in self.own_members(path) if needed.member(member.name) is None)
        return replace(needed, members=needed.members + added) if added else needed

    def fits(self, member: Member | None) -> bool:
        """Return whether its uses match a member of a type."""
        if member is None or bool(member.dims) != bool(self.dims):
            return False
        return BOOL not in self.root.votes or member.type is BOOL

    def _structure_type(self, path: str) -> Structure:
        """Return the first candidate with all members in use, or a new structure named `path`."""
        is_module_tag = ":" in self.name
        candidates = () if is_module_tag else self.structures
        for structure in candidates:
            if all(guess.fits(structure.member(guess.name)) for guess in self.members.values()):
                return structure
        return Structure(path, tuple(self.own_members(path)))

    def own_members(self, path: str) -> Iterator[Member]:
        """Yield the members in use, with their types; `path` is the name of their structure."""
        for member in self.members.values():
            yield Member(member.name, member.type(f"{path}_{member.name}"), member.dims)


def add_kind(kinds: list[DataType], kind: DataType) -> None:
    """Add a type only once, because a tag can have thousands of uses."""
    if all(known is not kind for known in kinds):
        kinds.append(kind)


def _longer_lengths(a: list[int], b: list[int]) -> list[int]:
    return [max(pair) for pair in zip_longest(a, b, fillvalue=0)]


def type_at(declaration: Declaration | None, address: Address) -> DataType | None:
    """Return the type of an address in a tag; None for a bit or a missing member or tag."""
    if not isinstance(declaration, Tag):
        return None
    kind: DataType = declaration.type
    for step in address.steps:
        if isinstance(step, MemberStep):
            member = kind.member(step.name) if isinstance(kind, Structure) else None
            if member is None:
                return None
            kind = member.type
        elif isinstance(step, BitStep):
            return None
        elif not isinstance(step, SubscriptStep):
            return INT
    return kind
