"""Declarations of tags, and the layout of a program's memory that follows from them.

Every elementary value is one leaf, or, if it lies in arrays, one element of a
leaf: `Recipe.Step.Time` of an array of structures is one list of all the times.
A leaf has a Python identifier, under which the compiled program reads and writes
it. The images of a slot are leaves, too, made when an address names them.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from .tree import Address
from .types import BOOL, DINT, INT, DataType, Elementary, count_of, leaves_of


@dataclass(frozen=True, slots=True)
class Tag:
    """A tag with memory of its own.

    Attributes:
        name: its name; case does not matter.
        type: its type.
        dims: length per dimension, none for a single value.
        initial: what it starts with: a value, a list per dimension, a dict of members; None = zero.
        comment: its comment.
    """

    name: str
    type: DataType
    dims: tuple[int, ...] = ()
    initial: object = None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Alias:
    """A second name of an address."""

    name: str
    target: Address
    comment: str = ""


@dataclass(frozen=True, slots=True)
class SlotAlias:
    """A name for the module in a slot, whose bits go by their meaning: `axis.status.MOVE_COMPLETE`."""

    name: str
    slot: int
    comment: str = ""


Declaration = Tag | Alias | SlotAlias


@dataclass(frozen=True, slots=True)
class Leaf:
    """An elementary value, or all elements of it that lie in arrays.

    Attributes:
        path: tag and members, without subscripts.
        type: its type.
        dims: dimensions of all arrays it lies in, the outermost first.
        ident: its identifier in the compiled program.
        slot: number of the slot, if it belongs to a module: its image or its fault; None if not.
        output: of a module: whether the program writes it.
    """

    path: str
    type: Elementary
    dims: tuple[int, ...]
    ident: str
    slot: int | None = None
    output: bool = False

    @property
    def size(self) -> int:
        """Number of elements."""
        return count_of(self.dims)

    @property
    def is_image(self) -> bool:
        """Whether it is the eight words of a slot's image, which are the rack's memory."""
        return self.slot is not None and bool(self.dims)


STATUS_FLAGS = {
    "S:FS": "first scan",
    "S:V": "overflow",
    "S:Z": "zero",
    "S:N": "negative",
    "S:C": "carry",
    "S:MINOR": "a minor fault has been recorded",
}
"""Bits that every program has, and what they tell."""

OVERRIDE = "~mcr"
"""Leaf of the override that MCR toggles."""


class Layout:
    """Where everything in a program's memory is.

    Attributes:
        declarations: by name in capitals.
        leaves: by path in capitals.

    Args:
        declarations: tags and aliases.
    """

    def __init__(self, declarations: Iterable[Declaration]) -> None:
        self.declarations: dict[str, Declaration] = {}
        self.leaves: dict[str, Leaf] = {}
        self._idents: set[str] = set()
        for name in (*STATUS_FLAGS, OVERRIDE):
            self._add(name, BOOL, ())
        for declaration in declarations:
            self.declarations[declaration.name.upper()] = declaration
            if isinstance(declaration, Tag):
                for path, kind, dims in leaves_of(declaration.type, declaration.dims):
                    self._add(f"{declaration.name}.{path}" if path else declaration.name, kind, dims)

    def leaf(self, path: str) -> Leaf:
        """Return the leaf of that path, in any case."""
        return self.leaves[path.upper()]

    def image(self, slot: int, *, output: bool) -> Leaf:
        """Return the leaf of a slot's image."""
        path = f"Local:{slot}:{'O' if output else 'I'}.Data"
        known = self.leaves.get(path.upper())
        if known is None:
            known = self._add(path, INT, (8,), slot=slot, output=output)
        return known

    def fault(self, slot: int) -> Leaf:
        """Return the leaf of a slot's connection fault, a DINT."""
        path = f"Local:{slot}:I.Fault"
        return self.leaves.get(path.upper()) or self._add(path, DINT, (), slot=slot)

    @property
    def images(self) -> tuple[Leaf, ...]:
        """The images that the program uses."""
        return tuple(leaf for leaf in self.leaves.values() if leaf.is_image)

    @property
    def faults(self) -> tuple[Leaf, ...]:
        """The connection faults that the program uses."""
        return tuple(leaf for leaf in self.leaves.values() if leaf.slot is not None and not leaf.is_image)

    def tags(self) -> Mapping[str, Tag]:
        """The tags with memory of their own, by name in capitals."""
        return {name: each for name, each in self.declarations.items() if isinstance(each, Tag)}

    def _add(
        self,
        path: str,
        kind: Elementary,
        dims: tuple[int, ...],
        *,
        slot: int | None = None,
        output: bool = False,
    ) -> Leaf:
        leaf = Leaf(path, kind, dims, self._ident(path), slot, output)
        self.leaves[path.upper()] = leaf
        return leaf

    def _ident(self, path: str) -> str:
        """Make a readable identifier that nothing else has."""
        wanted = re.sub(r"\W", "_", path, flags=re.ASCII).strip("_")
        if keyword.iskeyword(wanted) or wanted in RESERVED or wanted[:1].isdigit():
            wanted += "_"
        ident, number = wanted, 1
        while ident in self._idents:
            number += 1
            ident = f"{wanted}_{number}"
        self._idents.add(ident)
        return ident


RESERVED = frozenset(
    [
        "now",
        "given",
        "at",
        "float",
        "len",
        "abs",
        "min",
        "array",
        "region",
        "subscript",
        "outside",
        "negative",
        "jumped_back",
        "narrow",
        "integer",
        "cut",
        "divide",
        "modulo",
        "real_result",
        "real_divide",
        "real_modulo",
        "copy",
        "fill",
        "text",
        "set_text",
        "python",
        "answer",
        "real",
        "wrap",
        "power",
        "square_root",
        "integer_root",
        "truncated",
        "swapped",
        "distributed",
        "program",
        "scan",
    ]
)
"""Names that the compiled program uses itself; its temporaries start with two underscores."""
