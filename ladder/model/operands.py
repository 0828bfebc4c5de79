"""Resolved operands: constants, places in memory, and calculations on them."""

from __future__ import annotations

from dataclasses import field
from functools import lru_cache

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.records import record

from .operators import BITWISE, FUNCTIONS, RELATIONS
from .tags import Layout, Leaf
from .types import BOOL, DINT, HIDDEN, LINT, LREAL, REAL, UDINT, ULINT, DataType, Elementary, leaves_of

SINGLE = 0
"""Width of a computation in REAL."""

DOUBLE = -1
"""Width of a computation in LREAL."""

FAULT = ":I.Fault"
"""End of a connection fault's address, after the slot; the fault is not a word of an image."""


@record
class Constant:
    """A number in double precision with its type: DINT, LINT if needed, or REAL (rounded on use)."""

    value: int | float
    type: Elementary


@record
class Place:
    """The place of one elementary value."""

    leaf: Leaf
    indices: tuple[Resolved, ...]  # one per dimension of the leaf
    bit: Resolved | None  # None for the whole value
    text: str  # the address as written
    array: tuple[int, ...] = ()  # dimensions of its array, none if it is not an element

    @property
    def type(self) -> Elementary:
        """Type of the value."""
        return self.leaf.type if self.bit is None else BOOL

    @property
    def path(self) -> str:
        """Tag and members, without subscripts."""
        return self.leaf.path

    @property
    def dims(self) -> tuple[int, ...]:
        """The remaining dimensions: none."""
        return ()

    @property
    def frame(self) -> str:
        """The add-on instruction that it is a part of, in capitals; "" in a program."""
        return self.leaf.frame

    @property
    def can_fault(self) -> bool:
        """Whether an index or bit is computed."""
        return self.fixed_index is None or not (self.bit is None or isinstance(self.bit, Constant))

    @property
    def fixed_index(self) -> int | None:
        """Flat index in the leaf; 0 for a single value, None if it is computed."""
        return fixed_index_in(self.leaf.dims, self.indices)

    @property
    def address(self) -> str | None:
        """Address of the word or bit of a slot's image or fault; None for a computed or any other place."""
        if self.leaf.slot is None or self.can_fault:
            return None
        word = f"Local:{self.leaf.slot}{FAULT}"
        if self.leaf.is_image:
            word = f"Local:{self.leaf.slot}:{'O' if self.leaf.output else 'I'}.Data[{self.fixed_index}]"
        return f"{word}.{int(self.bit.value)}" if isinstance(self.bit, Constant) else word


@record
class Group:
    """A structure, an array, or the rest of an array starting at an element."""

    type: DataType
    path: str  # tag and members, without subscripts
    indices: tuple[Resolved, ...]  # of the resolved dimensions
    dims: tuple[int, ...]  # the remaining dimensions
    layout: Layout
    text: str  # the address as written
    array: tuple[int, ...] = ()  # dimensions of its array, none if it is not an element

    @property
    def frame(self) -> str:
        """The add-on instruction that it is a part of, in capitals; "" in a program."""
        return self.layout.frame

    def member(self, path: str) -> Place:
        """Return an elementary member of a structure; it can be a bit of another member."""
        host, bit = self.type.packed.get(path, (path, None))  # type: ignore[union-attr]  # a structure
        leaf = self.layout.leaf(f"{self.path}.{host}")
        return Place(leaf, self.indices, None if bit is None else constant(bit), f"{self.text}.{path}")

    def find_member(self, name: str) -> Place | None:
        """Return an elementary member by its case-insensitive name; None if it does not exist."""
        member = None if self.dims or isinstance(self.type, Elementary) else self.type.member(name)
        if member is None or member.dims or not isinstance(member.type, Elementary):
            return None
        host, _, bit = member.at.partition(".")
        return self.member(host if host and not bit.isdecimal() else member.name)

    @property
    def length(self) -> Place:
        """LEN of a STRING. Messages show it under the string's name."""
        return Place(self.layout.leaf(f"{self.path}.LEN"), self.indices, None, self.text)


@dataclass(frozen=True, slots=True)
class Calculation:
    """An operator or function with resolved operands."""

    name: str
    operands: tuple[Resolved, ...]
    can_fault: bool = field(init=False, compare=False, repr=False)  # see the function `can_fault`

    def __post_init__(self) -> None:
        """Compute `can_fault` once, because a chain of operations would compute it again for each part."""
        object.__setattr__(self, "can_fault", any(map(can_fault, self.operands)))


@dataclass(frozen=True, slots=True)
class StringConstant:
    """A string constant."""

    value: str


Resolved = Constant | Place | Group | Calculation | StringConstant


def fixed_index_in(dims: tuple[int, ...], indices: tuple[Resolved, ...]) -> int | None:
    """Return the flat index of subscripts in the first dimensions, 0 for none; None if one is computed."""
    flat = 0
    for index, length in zip(indices, dims, strict=False):
        if not isinstance(index, Constant):
            return None
        flat = flat * length + int(index.value)
    return flat


def subscripts_of(dims: tuple[int, ...], index: int) -> tuple[Constant, ...]:
    """Return the subscripts of an element from its flat index.

    >>> [subscript.value for subscript in subscripts_of((2, 3), 4)]
    [1, 1]
    """
    subscripts: list[Constant] = []
    for length in reversed(dims):
        index, subscript = divmod(index, length)
        subscripts.insert(0, Constant(subscript, DINT))
    return tuple(subscripts)


MOST_CHARACTERS = 8
"""Maximum number of characters in a string constant used as a number: the bytes of a LINT."""


def as_number(resolved: Resolved) -> Resolved:
    """Return a string constant as its ASCII number, and any other operand unchanged.

    The first character is the most significant byte, as in the display style ASCII.

    >>> as_number(StringConstant("A")).value, as_number(StringConstant("AB")).value == 0x4142
    (65, True)
    """
    if not isinstance(resolved, StringConstant) or not 0 < len(resolved.value) <= MOST_CHARACTERS:
        return resolved
    codes = resolved.value.encode("latin-1", "replace")
    return constant(int.from_bytes(codes, "big", signed=len(codes) == MOST_CHARACTERS))


def leaves_in(resolved: Place | Group) -> list[Leaf]:
    """Return the leaves of a place or group, without hidden ones."""
    if isinstance(resolved, Place):
        return [resolved.leaf]
    return [resolved.layout.leaf(f"{resolved.path}{suffix}") for suffix in _leaf_suffixes(resolved.type)]


def first_leaf(resolved: Place | Group) -> Leaf:
    """Return the first leaf of a place or group."""
    if isinstance(resolved, Place):
        return resolved.leaf
    return resolved.layout.leaf(f"{resolved.path}{_leaf_suffixes(resolved.type)[0]}")


@lru_cache(maxsize=1024)
def _leaf_suffixes(kind: DataType) -> tuple[str, ...]:
    """Return the paths of a type's visible values, each with a dot before it."""
    return tuple(f".{path}" if path else "" for path, _, _ in leaves_of(kind) if HIDDEN not in path)


def constant(value: int | float) -> Constant:
    """Return a constant of a literal's type."""
    if isinstance(value, float):
        return Constant(value, REAL)
    return Constant(value, DINT if DINT.lowest <= value <= DINT.highest else LINT)


def is_integer(resolved: Resolved) -> bool:
    """Return whether the value is an integer."""
    if isinstance(resolved, (Constant, Place)):
        return resolved.type.is_integer
    if not isinstance(resolved, Calculation) or _is_real_function(resolved):
        return False
    return all(map(is_integer, resolved.operands))


def is_number(resolved: Resolved) -> bool:
    """Return whether the value is numeric."""
    if isinstance(resolved, (Constant, Place)):
        return not resolved.type.is_bool
    return isinstance(resolved, Calculation) and all(map(is_number, resolved.operands))


def is_truth(resolved: Resolved) -> bool:
    """Return whether this is a bit, a comparison, or a combination of them with AND, OR, XOR or NOT."""
    if isinstance(resolved, Place):
        return resolved.type.is_bool
    if not isinstance(resolved, Calculation):
        return False
    return resolved.name in RELATIONS or (resolved.name in BITWISE and any(map(is_truth, resolved.operands)))


def types_in(resolved: Resolved) -> set[Elementary]:
    """Return the types of all values in an operand, except subscripts."""
    if isinstance(resolved, (Constant, Place)):
        return {resolved.type}
    if isinstance(resolved, Calculation):
        types = {REAL} if _is_real_function(resolved) else set()
        return types.union(*map(types_in, resolved.operands))
    return set()


def _is_real_function(calculation: Calculation) -> bool:
    function = FUNCTIONS.get(calculation.name)
    return function is not None and function.whole is None


def can_fault(resolved: Resolved) -> bool:
    """Return whether reading the value can cause a subscript fault."""
    if isinstance(resolved, (Place, Group)):
        if any(not isinstance(index, Constant) for index in resolved.indices):
            return True
        return isinstance(resolved, Place) and resolved.can_fault
    return isinstance(resolved, Calculation) and resolved.can_fault


def width_of(*operands: Resolved) -> int:
    """Return the width for operands: DOUBLE, SINGLE, 128 with ULINT, 64 with LINT or UDINT, else 32."""
    types = set().union(*map(types_in, operands))
    if LREAL in types:
        return DOUBLE
    if REAL in types:
        return SINGLE
    if ULINT in types:
        return 2 * ULINT.bits
    return LINT.bits if LINT in types or UDINT in types else DINT.bits


def width_moved(source: Resolved, *kinds: Elementary) -> int:
    """Return the width of a computation whose result is stored in tags of these types."""
    return DOUBLE if LREAL in kinds else width_of(source)


def place_of(operand: Resolved) -> Place:
    """Return an operand as a Place; earlier checks ensure that it is one."""
    assert isinstance(operand, Place)
    return operand
