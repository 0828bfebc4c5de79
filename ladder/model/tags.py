"""Declarations of tags, and the resulting layout of a program's memory.

Every elementary value is one leaf, or an element of a leaf if it is in arrays. For example,
`Recipe.Step.Time` of an array of structures is one list of all times. A leaf has a Python identifier in the
compiled program. The images of a slot are also leaves. They are created when an address first refers to them.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.enip.listing import ExternalAccess
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords
from scanrack.io_images.records import record

from .expressions import parse_address
from .operators import CALLED
from .stretches import Spot, spot_of, stretch_of
from .tree import Address
from .types import BOOL, DINT, HIDDEN, INT, DataType, Elementary, Member, Structure, count_of, leaves_of


@dataclass(frozen=True, slots=True)
class Tag:
    """A tag with its own memory; tag names are case-insensitive."""

    name: str
    type: DataType
    dims: tuple[int, ...] = ()  # length per dimension, none for a single value
    initial: object = None  # a value, a list per dimension, a dict of members; None = zero
    comment: str = ""
    access: ExternalAccess = ExternalAccess.READ_WRITE  # of clients, such as HMIs


@dataclass(frozen=True, slots=True)
class Alias:
    """A second name for an address."""

    name: str
    target: Address
    comment: str = ""
    type: Structure | None = None  # structure that names the parts of a module's image; None keeps its own


@dataclass(frozen=True, slots=True)
class SlotAlias:
    """A name for the module in a slot, with named bits: `axis.status.MOVE_COMPLETE`."""

    name: str
    slot: int
    comment: str = ""


Declaration = Tag | Alias | SlotAlias


@record
class Leaf:
    """An elementary value, or all values with the same path in arrays."""

    path: str  # tag and members, without subscripts
    type: Elementary
    dims: tuple[int, ...]  # dimensions of all arrays around it, the outermost first
    ident: str  # its identifier in the compiled program
    slot: int | None = None  # slot of a module's image or fault, else None
    output: bool = False  # for a module: whether the program writes it
    frame: str = ""  # the add-on instruction whose instances contain it, in capitals; "" for tags
    root: str = ""  # in an add-on instruction the start of its path: `OWN`, or an InOut in capitals
    outer: int = 0  # in an add-on instruction the number of the InOut's own dimensions

    @property
    def size(self) -> int:
        """Number of elements."""
        return count_of(self.dims)

    @property
    def inner(self) -> int:
        """Number of the leaf's elements in each element of its root."""
        return count_of(self.dims[self.outer :])

    @property
    def rest(self) -> str:
        """The leaf's path after its root, with a dot."""
        return f".{self.path}" if self.root == OWN else self.path[len(self.root) :]

    @property
    def is_image(self) -> bool:
        """Whether it is a slot's image, which consists of words in the rack's memory."""
        return self.slot is not None and bool(self.dims)

    @property
    def is_input(self) -> bool:
        """Whether a module sets it, such as an input image or a connection fault."""
        return self.slot is not None and not self.output


STATUS_FLAGS = {
    "S:FS": "first scan",
    "S:V": "overflow",
    "S:Z": "zero",
    "S:N": "negative",
    "S:C": "carry",
    "S:MINOR": "a minor fault has been recorded",
}
"""Status bits that every program has, with their meanings."""

TRUTHS = {"TRUE": 1, "FALSE": 0}
"""Constants by name; a tag of the same name takes precedence."""

Presets = Mapping[tuple[str, int], int | float]
"""Initial values given in rungs, by leaf path and flat index."""

OVERRIDE = "~mcr"
"""Leaf with the state of the MCR zone."""

IGNORES_ARRAY_FAULTS = "~GSV.CONTROLLER..IGNOREARRAYFAULTSDURINGPOSTSCAN"
"""Leaf, in capitals, of the attribute that ignores array faults in postscan."""

HELD = "~held"
"""Prefix of leaves that store a subscript during a call."""


OWN = "~"
"""Root of an instance's members in the routines of its add-on instruction."""

OPEN = 1 << 31
"""Length of an InOut that is an array of any length."""


def scoped(program: str, name: str) -> str:
    r"""Return the full name of a program's tag or routine; without a program, the name itself.

    >>> print(scoped("Main", "Run"), scoped("", "Run"))
    \Main.Run Run
    """
    return rf"\{program}.{name}" if program else name


def program_of(name: str) -> str:
    r"""Return the program in a full name; "" for the controller.

    >>> program_of(r"\Main.Run"), program_of("Run")
    ('Main', '')
    """
    return name[1 : name.index(".")] if name.startswith("\\") else ""


def tag_in(path: str) -> str:
    r"""Return the full name of the tag in a path.

    >>> tag_in("Recipe.Step.Time"), tag_in(r"\Main.Recipe.Step.Time")
    ('Recipe', '\\Main.Recipe')
    """
    start = path.find(".") + 1 if path.startswith("\\") else 0
    end = path.find(".", start)
    return path if end < 0 else path[:end]


class SparseTag(NamedTuple):
    """A structure tag with few values in use."""

    ident: str  # variable of the bytes with all other values
    variables: Mapping[str, Leaf]  # the values in use, by path in capitals


class Layout:
    """The memory layout of a program.

    Args:
        declarations: tags and aliases, under their full names.
        files: whether the tags are data files of an SLC, with elements like N7:0.
        modules: the words of known modules by slot; any other slot has a module of eight words.
    """

    frame = ""
    """The add-on instruction that is laid out, in capitals; "" for a program."""

    def __init__(
        self,
        declarations: Iterable[Declaration],
        *,
        files: bool = False,
        modules: Mapping[int, ModuleWords] = MappingProxyType({}),
    ) -> None:
        self.files, self.modules = files, modules
        self.declarations: dict[str, Declaration] = {}  # by full name in capitals, see `scoped`
        self._leaves: dict[str, Leaf] = {}  # by path in capitals, without those of `_folded`
        self._ordered = False
        self._folded: dict[str, Tag] = {}  # tags with leaves that are not created yet, by name in capitals
        self._separate: dict[str, list[str]] = {}  # created leaves of such tags, in capitals
        self.boxed: dict[str, str] = {}  # identifiers of lists and bytes, by tag in capitals
        self.rests: dict[str, SparseTag] = {}  # by tag in capitals, see `fold_rest`
        self.in_bytes: set[str] = set()  # tags in bytes, or such roots of an add-on, in capitals
        self._spots: dict[str, Spot | None] = {}
        self._single: list[Leaf] = []  # leaves with their own variable, valid for `_single_size`
        self._single_size = (0, 0, 0)
        self._idents: set[str] = set()
        self._held = 0
        for name in (*STATUS_FLAGS, OVERRIDE):
            self._add(name, BOOL, ())
        for declaration in declarations:
            self.declarations[declaration.name.upper()] = declaration
            if isinstance(declaration, Tag):
                self._folded[declaration.name.upper()] = declaration

    @property
    def leaves(self) -> Mapping[str, Leaf]:
        """All leaves by path in capitals: status flags, leaves of the tags in order, then all others.

        Reading it creates missing leaves of tags.
        """
        if not self._ordered:
            self._ordered = True
            self._unfold(*list(self._folded))
            flags = {name: self._leaves[name] for name in (*STATUS_FLAGS, OVERRIDE.upper())}
            tags = {path.upper(): self._leaves[path.upper()] for path in self._paths()}
            self._leaves = flags | tags | self._leaves
        return self._leaves

    def _paths(self) -> Iterator[str]:
        for tag in self.tags().values():
            for path, _, _ in leaves_of(tag.type, tag.dims):
                yield f"{tag.name}.{path}" if path else tag.name

    def _unfold(self, *names: str) -> None:
        """Create all leaves of tags, by names in capitals."""
        for name in names:
            tag = self._folded.pop(name, None)
            if tag is not None:
                self._separate.pop(name, None)
                for member_path, row in _rows(tag.type).items():
                    self._row_leaf(tag, f"{name}.{member_path}" if member_path else name, row)

    def _row_leaf(self, tag: Tag, name: str, row: _Row) -> Leaf:
        """Return the leaf `name` (a path in capitals) for a row of a tag's type; create it if necessary."""
        leaf = self._leaves.get(name)
        if leaf is not None:
            return leaf
        if not row.path:
            return self._add(tag.name, row.type, tag.dims)
        path = f"{tag.name}.{row.path}"
        ident = f"{_head(tag.name)}_{row.end}"
        if not row.end or ident in RESERVED or ident in self._idents:
            ident = self._ident(path)
        self._idents.add(ident)
        leaf = self._leaves[name] = Leaf(path, row.type, tag.dims + row.dims, ident)
        return leaf

    def _request(self, name: str) -> Leaf | None:
        """Create and return the leaf with a path in capitals; None if no tag has a leaf with this path."""
        head = tag_in(name)
        tag = self._folded.get(head)
        row = None if tag is None else _rows(tag.type).get(name[len(head) + 1 :])
        if tag is None or row is None:
            return None
        if row.path:
            self._separate.setdefault(head, []).append(name)
        else:
            del self._folded[head]
        return self._row_leaf(tag, name, row)

    def request_below(self, path: str) -> None:
        """Create all leaves in a part of a tag."""
        name = path.upper()
        head = tag_in(name)
        tag = self._folded.get(head)
        if tag is not None:
            start = f"{name}."[len(head) + 1 :]
            for member_path in _rows(tag.type):
                if member_path.startswith(start) and f"{head}.{member_path}" not in self._leaves:
                    self._request(f"{head}.{member_path}")

    def leaves_ending_in(self, member: str) -> list[Leaf]:
        """Return the leaves whose paths end in a member, in the order of their tags."""
        end = f".{member.upper()}"
        return [
            self.leaf(f"{name}.{member_path}")
            for name, tag in self.tags().items()
            for member_path in _rows(tag.type)
            if f".{member_path}".endswith(end)
        ]

    @property
    def unused(self) -> Iterator[Tag]:
        """Yield the tags without a requested leaf."""
        return (tag for name, tag in self._folded.items() if name not in self._separate)

    def declaration(self, name: str, program: str = "") -> Declaration | None:
        """Return a declaration by name in capitals, first from the program, then the controller, or None."""
        scoped_tag = self.declarations.get(scoped(program, name).upper()) if program else None
        return scoped_tag or self.declarations.get(name)

    def names(self, program: str = "") -> Iterator[str]:
        """Yield the names visible in a program: its tags without their prefix, then the controller's tags."""
        prefix = scoped(program, "")
        for declaration in self.declarations.values():
            if program and declaration.name.upper().startswith(prefix.upper()):
                yield declaration.name[len(prefix) :]
        for declaration in self.declarations.values():
            if not program_of(declaration.name):
                yield declaration.name

    def scoped_names(self) -> Iterator[str]:
        """Yield the full names of the programs' tags."""
        yield from (
            declaration.name for declaration in self.declarations.values() if program_of(declaration.name)
        )

    def declare(self, tag: Tag) -> None:
        """Add a tag after all other tags in the layout."""
        self.declarations[tag.name.upper()] = self._folded[tag.name.upper()] = tag
        self._ordered = False

    def hidden(self, path: str, kind: Elementary) -> Leaf:
        """Add and return a hidden leaf, which has no address."""
        return self._add(path, kind, ())

    def leaf(self, path: str) -> Leaf:
        """Return a leaf by its path in any case."""
        leaf = self.find(path)
        if leaf is None:
            raise KeyError(path)
        return leaf

    def find(self, path: str) -> Leaf | None:
        """Return a leaf by its case-insensitive path; None if it does not exist.

        A leaf of a tag is created when it is requested for the first time.
        """
        name = path.upper()
        leaf = self._leaves.get(name)
        if leaf is None and self._folded:
            leaf = self._request(name)
        return leaf

    def words(self, slot: int, *, output: bool) -> int:
        """Return the number of words of a slot's image."""
        return len(self.modules.get(slot, PLAIN_WORDS).named("O" if output else "I"))

    def image(self, slot: int, *, output: bool) -> Leaf:
        """Return the leaf of a slot's image."""
        path = f"Local:{slot}:{'O' if output else 'I'}.Data"
        leaf = self.find(path)
        if leaf is None:
            dims = (self.words(slot, output=output),)
            leaf = self._add(path, INT, dims, slot=slot, output=output)
        return leaf

    def fault(self, slot: int) -> Leaf:
        """Return the leaf of a slot's connection fault, a DINT."""
        path = f"Local:{slot}:I.Fault"
        return self.find(path) or self._add(path, DINT, (), slot=slot)

    def held(self) -> Leaf:
        """Return a new leaf that stores a subscript during a call."""
        self._held += 1
        return self._add(f"{HELD}{self._held}", DINT, ())

    # --- lists

    def box(self, leaf: Leaf) -> None:
        """Lay out a leaf's tag as a stretch of a list, unless it already is a list."""
        name = leaf.path if leaf.slot is not None else tag_in(leaf.path)
        tag = self.declarations.get(name.upper())
        plain = isinstance(tag, Tag) and isinstance(tag.type, Elementary) and bool(tag.dims)
        if name.upper() not in self.boxed and not leaf.is_image and not plain:
            self.boxed[name.upper()] = self._ident(name)
            self._spots.clear()

    def make_bytes(self, names: Iterable[str]) -> None:
        """Lay out tags, named in capitals, as bytes."""
        for name in names:
            self.in_bytes.add(name)
            if name not in self.boxed:
                self.boxed[name] = self._ident(self.declarations[name].name)
        self._spots.clear()

    def fold_rest(self, name: str) -> None:
        """Lay out a tag, named in capitals, as bytes; leaves that were requested remain variables.

        A large structure with few members in use then needs few variables.
        """
        tag, separate = self._folded[name], self._separate[name]
        if len(separate) < len(_rows(tag.type)):
            self.rests[name] = SparseTag(
                self._ident(f"{tag.name}.rest"),
                {separate_name: self._leaves[separate_name] for separate_name in separate},
            )
            self._spots.clear()

    @property
    def partly_used(self) -> list[Tag]:
        """The structures with requested leaves that are neither lists nor bytes."""
        return [self._folded[name] for name in self._separate if name not in self.boxed]

    def spot(self, leaf: Leaf) -> Spot | None:
        """Return the place of a leaf in a list or in bytes; None if it has its own variable."""
        if not self.boxed and not self.rests:
            return None
        name = leaf.path.upper()
        if name in self._spots:
            return self._spots[name]
        return self._find_spot(leaf, name)

    def _find_spot(self, leaf: Leaf, name: str) -> Spot | None:
        """Return the place of a leaf, given its path in capitals, and cache it; None for a variable."""
        head = tag_in(name)
        if leaf.slot is not None and name in self.boxed:
            spot = spot_of(leaf.type, (), "", self.boxed[name])
        elif head in self.boxed and isinstance(self.declarations.get(head), Tag):
            spot = self._boxed_spot(head, name)
        elif head in self.rests and name not in self.rests[head].variables:
            spot = self.rest_spot(leaf)
        else:
            spot = None
        self._spots[name] = spot
        return spot

    def rest_spot(self, leaf: Leaf) -> Spot:
        """Return the place of a leaf in the bytes of a sparse tag, even if the leaf is a variable."""
        head = tag_in(leaf.path)
        tag = self.declarations[head.upper()]
        assert isinstance(tag, Tag)
        member_path = leaf.path[len(head) + 1 :]
        return spot_of(tag.type, tag.dims, member_path, self.rests[head.upper()].ident, in_bytes=True)

    def byte_spot(self, path: str) -> Spot | None:
        """Return the place of a structure in bytes by path; None if it is not in bytes."""
        name = path.upper()
        spot = self._spots.get(name)
        if spot is None and tag_in(name) in self.in_bytes:
            spot = self._spots[name] = self._boxed_spot(tag_in(name), name)
        return spot

    def _boxed_spot(self, head: str, name: str) -> Spot:
        tag = self.declarations[head]
        assert isinstance(tag, Tag)
        member_path = name[len(head) + 1 :]
        return spot_of(tag.type, tag.dims, member_path, self.boxed[head], in_bytes=head in self.in_bytes)

    @property
    def size(self) -> tuple[int, int, int]:
        """Numbers of lists, sparse tags and leaves. If a number has grown, an older memory is incomplete."""
        return len(self.boxed), len(self.rests), len(self._leaves)

    @property
    def single(self) -> list[Leaf]:
        """The leaves with their own variable."""
        boxed, rests = self.boxed, self.rests
        self._unfold(*[name for name in self._folded if name not in boxed and name not in rests])
        if not boxed and not rests:
            return list(self.leaves.values())
        if self._single_size != self.size:
            self._single_size = self.size
            self._single = [leaf for name, leaf in self._leaves.items() if self._is_single(name)]
        return self._single

    def _is_single(self, name: str) -> bool:
        head = tag_in(name)
        if head in self.rests:
            return name in self.rests[head].variables
        return not (name in self.boxed or head in self.boxed)

    @property
    def lists(self) -> Iterator[tuple[str, list[Any]]]:
        """The lists of tags, by identifier, with their initial values."""
        for name, ident in self.boxed.items():
            tag = self.declarations.get(name)
            if name in self.in_bytes:
                continue
            if isinstance(tag, Tag):
                yield ident, stretch_of(tag.type).zeros * count_of(tag.dims)
            else:
                yield ident, [self.leaf(name).type.zero]

    @property
    def byte_tags(self) -> Iterator[tuple[str, DataType, int]]:
        """Identifier, type and number of elements of each tag and sparse tag in bytes."""
        named = [(name, ident) for name, ident in self.boxed.items() if name in self.in_bytes]
        named += [(name, remainder.ident) for name, remainder in self.rests.items()]
        for name, ident in named:
            tag = self.declarations.get(name)
            if isinstance(tag, Tag):
                yield ident, tag.type, count_of(tag.dims)

    @property
    def idents(self) -> list[str]:
        """The variables of the compiled program: single leaves, then lists and bytes."""
        return [
            *(leaf.ident for leaf in self.single),
            *self.boxed.values(),
            *(remainder.ident for remainder in self.rests.values()),
        ]

    @property
    def images(self) -> tuple[Leaf, ...]:
        """The images in use."""
        return tuple(leaf for leaf in self._leaves.values() if leaf.is_image)

    @property
    def faults(self) -> tuple[Leaf, ...]:
        """The connection faults in use."""
        return tuple(leaf for leaf in self._leaves.values() if leaf.slot is not None and not leaf.is_image)

    def tags(self) -> Mapping[str, Tag]:
        """The tags by name in capitals."""
        return {
            name: declaration
            for name, declaration in self.declarations.items()
            if isinstance(declaration, Tag)
        }

    def _add(
        self,
        path: str,
        kind: Elementary,
        dims: tuple[int, ...],
        *,
        slot: int | None = None,
        output: bool = False,
    ) -> Leaf:
        """Create a leaf with a path, and return it."""
        leaf = self._leaf(path, kind, dims, slot, output)
        self._leaves[path.upper()] = leaf
        return leaf

    def _leaf(
        self, path: str, kind: Elementary, dims: tuple[int, ...], slot: int | None, output: bool
    ) -> Leaf:
        return Leaf(path, kind, dims, self._ident(path), slot=slot, output=output)

    def _ident(self, path: str) -> str:
        """Return a new identifier for a path, with a number at the end if it is taken."""
        stem = _identifier(path)
        ident, number = stem, 1
        while ident in self._idents:
            number += 1
            ident = f"{stem}_{number}"
        self._idents.add(ident)
        return ident


def _identifier(path: str) -> str:
    """Return a variable's name for a path."""
    stem = path.replace(".", "_")
    if not stem.isidentifier() or stem[0] == "_" or stem[-1] == "_" or not stem.isascii():
        stem = re.sub(r"\W", "_", path, flags=re.ASCII).strip("_") or "tag"
    if keyword.iskeyword(stem) or stem in RESERVED:
        stem += "_"
    return f"tag_{stem}" if stem[0].isdigit() or stem.startswith(_FUNCTIONS) else stem


_FUNCTIONS = ("addon_", "jsr_", "string_", "put_text_")
"""Prefixes of function names in the compiled program."""


class _Row(NamedTuple):
    """An elementary value of a type."""

    path: str
    end: str  # the end of its identifier, "" if that must be derived from its path
    type: Elementary
    dims: tuple[int, ...]


@lru_cache(maxsize=1024)
def _rows(kind: DataType) -> Mapping[str, _Row]:
    """Return the elementary values of a type by path in capitals."""
    return {
        path.upper(): _Row(path, path.replace(".", "_") if _ENDING.fullmatch(path) else "", leaf, dims)
        for path, leaf, dims in leaves_of(kind)
    }


@lru_cache(maxsize=1024)
def _head(name: str) -> str:
    """Return the prefix of the identifiers of a structure's values."""
    head = _identifier(name)
    return f"tag_{head}" if f"{head}_".startswith(_FUNCTIONS) else head


_ENDING = re.compile(r"[\w.]*[A-Za-z0-9]", re.ASCII)


class FrameLayout(Layout):
    """The layout of an add-on instruction's routines, shared by all instances.

    Members of the instance are in the list `frame`, starting at `base`. An InOut is a list, an offset and the
    number of elements from there to the end of its array; a bit of an integer also has a mask.

    Attributes:
        own: type of an instance.
        inouts: variables of the InOuts, by name in capitals.

    Args:
        program: the program's layout, for status flags.
    """

    def __init__(self, frame: str, own: Structure, inouts: Iterable[Tag], program: Layout) -> None:
        self.frame, self.own, self._program = frame.upper(), own, program
        handed = tuple(inouts)
        self.inouts = {tag.name.upper(): f"of_{tag.name}" for tag in handed}
        super().__init__((*(_declared(member) for member in own.members), *handed))

    def leaf(self, path: str) -> Leaf:
        """Return a leaf by its path in any case; status flags and stored subscripts belong to the program."""
        return self._program.leaf(path) if path.upper().startswith(("S:", HIDDEN)) else super().leaf(path)

    def _row_leaf(self, tag: Tag, name: str, row: _Row) -> Leaf:
        known = self._leaves.get(name)
        path = f"{tag.name}.{row.path}" if row.path else tag.name
        return known or self._add(path, row.type, tag.dims + row.dims)

    def held(self) -> Leaf:
        """Return a new leaf that stores a subscript during a call."""
        return self._program.held()

    def make_bytes(self, names: Iterable[str]) -> None:
        """Lay out roots as bytes; see `Leaf.root`."""
        self.in_bytes.update(names)
        self._spots.clear()

    def spot(self, leaf: Leaf) -> Spot | None:
        """Return the place of a leaf in a list or in bytes."""
        return self._spot(leaf.path.upper()) if leaf.frame else self._program.spot(leaf)

    def byte_spot(self, path: str) -> Spot | None:
        """Return the place of a structure in bytes by path; None if it is not in bytes."""
        name = path.upper()
        return self._spot(name) if self.root_of(name) in self.in_bytes else None

    def root_of(self, path: str) -> str:
        """Return `Leaf.root` of a path in capitals."""
        head = path.partition(".")[0]
        return head if head in self.inouts else OWN

    def _spot(self, name: str) -> Spot:
        """Return the place of a path in capitals: in the instance, or in the argument of an InOut."""
        spot = self._spots.get(name)
        if spot is None:
            root = self.root_of(name)
            in_bytes = root in self.in_bytes
            if root == OWN:
                spot = spot_of(self.own, (), name, FRAME, BASE, in_bytes=in_bytes)
            else:
                tag, ident = self.declarations[root], self.inouts[root]
                assert isinstance(tag, Tag)
                member_path = name[len(root) + 1 :]
                spot = spot_of(tag.type, tag.dims, member_path, ident, f"{ident}_at", in_bytes=in_bytes)
            self._spots[name] = spot
        return spot

    def _leaf(
        self, path: str, kind: Elementary, dims: tuple[int, ...], slot: int | None, output: bool
    ) -> Leaf:
        """Return a new leaf of the instance or an InOut.

        It has no identifier, because it has no variable.
        """
        head = path.partition(".")[0].upper()
        if head not in self.inouts:
            return Leaf(path, kind, dims, ident="", slot=slot, output=output, frame=self.frame, root=OWN)
        tag = self.declarations[head]
        assert isinstance(tag, Tag)
        return Leaf(
            path,
            kind,
            dims,
            ident="",
            slot=slot,
            output=output,
            frame=self.frame,
            root=head,
            outer=len(tag.dims),
        )


def _declared(member: Member) -> Declaration:
    if member.at:
        return Alias(member.name, parse_address(member.at))
    return Tag(member.name, member.type, member.dims)


FRAME, BASE = "frame", "base"
"""Variables of a compiled add-on instruction: the list of its instance, and the offset in the list."""

_WORDS = f"""
now given at program scan rung_done LadderFault fault mask site stretch region types faults {FRAME} {BASE}
float len abs min max array bytes broken converted
subscript outside negative negative_control jumped_back called returned narrow integer cut divide modulo
real_result real_divide real_modulo double_result double_divide double_modulo
copy copy_row fill move_down shift_bits store_bytes first_of
text set_text text_in set_text_in chars set_chars read_string store_string
python answer interpret fetched passed received
"""

RESERVED = frozenset((*_WORDS.split(), *CALLED))
"""Identifiers of the compiled program; its temporaries start with two underscores."""
