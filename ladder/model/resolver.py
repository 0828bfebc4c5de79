"""Resolve addresses to places in memory, and check types and bounds.

| address | resolves to |
|---|---|
| `Run`, `Fill.ACC` | a place: a leaf |
| `Data[3]`, `Data[i,j+1]` | a place: an element, with known or computed indices |
| `Word.5`, `Word.[n]` | a place: a bit of an integer |
| `Local:2:I.Data.5` | a place: a bit of a digital card; bits 16 to 31 are in word 1 |
| `Local:3:I.Ch0Data` | a place: a word of an analog card |
| `Fill`, `Data`, `Recipe[2]` | a group: a structure or an array |
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache

from scanrack.io_images.amci3601.bits import (
    PROFILE_BITS,
    CommandLsw,
    CommandMsw,
    ConfigMsw,
    StatusLsw,
    StatusMsw,
)
from scanrack.io_images.cards import MemberPlace, member_of
from scanrack.io_images.image import WORDS
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords
from scanrack.io_images.site import Site, sites_of
from scanrack.io_images.tag_names import AmbiguousNameError, in_scope, normal

from .errors import LadderError
from .expressions import parse_address
from .operand_checks import is_string
from .operands import (
    Calculation,
    Constant,
    Group,
    Place,
    Resolved,
    StringConstant,
    as_number,
    constant,
    is_integer,
)
from .tags import HELD, STATUS_FLAGS, TRUTHS, Alias, Layout, SlotAlias, Tag, program_of
from .tree import (
    Address,
    BitStep,
    Characters,
    MemberStep,
    Number,
    Operand,
    Operation,
    SlashStep,
    Step,
    SubscriptStep,
    Unknown,
    WordStep,
    number,
)
from .types import DINT, INT, DataType, Elementary, Member, Structure, dims_text

_NAMES_LISTED = 12  # tags listed in a message


class AddressError(LadderError):
    """An address that can't be resolved, with its remedy."""

    def __init__(self, text: str, remedy: str, *sites: Site) -> None:
        self.remedy = remedy
        super().__init__(text, *sites)


def missing_in(error: ValueError) -> str:
    """Return the name of the undeclared tag in an error; "" for any other error."""
    return next((site.tag for site in sites_of(error)), "")


class AmbiguousTagError(AddressError):
    """A name that several programs declare."""


def _bits(word: int, bits: Iterable[object]) -> dict[str, tuple[int, int]]:
    """Return the word and bit number of each flag by name, except reserved ones."""
    return {
        bit.name: (word, bit.value.bit_length() - 1)  # type: ignore[attr-defined]
        for bit in bits
        if not bit.name.startswith("RESERVED")  # type: ignore[attr-defined]
    }


MEANINGS: Mapping[str, tuple[bool, Mapping[str, tuple[int, int]]]] = {
    "STATUS": (False, _bits(0, StatusMsw) | _bits(1, StatusLsw)),
    "COMMAND": (True, _bits(0, CommandMsw) | _bits(1, CommandLsw)),
    "CONFIG": (True, _bits(0, ConfigMsw)),
}
"""Bits of a 3601 by meaning: group -> (whether it is in the output image, name -> (word, bit))."""


def meanings_of(words: ModuleWords) -> Mapping[str, tuple[bool, Mapping[str, tuple[int, int]]]]:
    """Return a module's bits by meaning, with its own names, or a 3601's for groups that it lacks."""
    meanings = {
        group.upper(): (
            any(place.image == "O" for place in names.values()),
            {name.upper(): (place.word, place.bit) for name, place in names.items()},
        )
        for group, names in words.groups.items()
    }
    return {**MEANINGS, **meanings}


_PROFILE_BITS = {name.upper(): bit for name, bit in PROFILE_BITS.items()}

_WORD = re.compile(r"DATA(?P<data>\d+)|CH(?P<channel>\d+)DATA")
"""Name of a word in the AMCI profile or an analog card's profile; the generic profile has an array Data."""


@cache
def module_type(words: int, *, output: bool) -> Structure:
    """Return the type of an image of `words` words; its bytes are the same in all profiles."""
    name = "AM:1769_3601" if words == WORDS else f"AB:1769_MODULE_INT_{2 * words}Bytes"
    fault = () if output else (Member("Fault", DINT),)
    return Structure(f"{name}:{'O' if output else 'I'}:0", (*fault, Member("Data", INT, (words,))))


_WORD_BITS = 16


def _card_word_and_bit(step: BitStep, first: int = 0) -> tuple[Step, Step]:
    """Return the steps to the word and bit of `Local:2:I.Data.20`; a card's 32 terminals occupy two words."""
    bit = step.index
    if not isinstance(bit, Number) or not _WORD_BITS <= int(bit.value) < 2 * _WORD_BITS:
        return WordStep(first, "."), step
    return WordStep(first + 1, "."), BitStep(number(int(bit.value) - _WORD_BITS))


_LOCAL = re.compile(r"LOCAL:(\d+):([IO])")
_SLOT_FILE = re.compile(r"([IO]):(\d+)")


def is_image(name: str) -> bool:
    r"""Return whether a name needs no declaration: a slot's image, or a tag of a named program.

    >>> is_image("Local:1:I"), is_image("O:2"), is_image(r"\Main.Run"), is_image("Run")
    (True, True, True, False)
    """
    name = name.upper()
    return name.startswith("\\") or any(pattern.fullmatch(name) for pattern in (_LOCAL, _SLOT_FILE))


def slot_of_image(name: str) -> int | None:
    """Return the slot of an image such as `Local:1:I`; None for any other tag.

    >>> slot_of_image("Local:1:I"), slot_of_image("Local:1:C")
    (1, None)
    """
    local = _LOCAL.fullmatch(name.upper())
    return int(local[1]) if local else None


def _not_module_part_error(shown: Address, words: int, *, output: bool) -> AddressError:
    inputs = "" if output else ", ModuleOK, ConfigError, ConfigMode and Fault"
    parts = f"Data[0] to Data[{words - 1}], Data0 to Data{words - 1}{inputs}"
    return AddressError(f"{shown} is not part of a module", f"its parts are {parts}, and bits of words")


class Resolver:
    """Resolves addresses in a memory; tags of `program` have precedence over tags of the controller."""

    def __init__(self, layout: Layout, program: str = "") -> None:
        self._layout = layout
        self._program = program
        self._resolved: dict[Address, Place | Group] = {}
        self._open: list[Address] = []  # addresses that are being resolved, to detect circular aliases

    def operand(self, operand: Operand) -> Resolved:
        """Resolve an operand and everything in it, or raise an AddressError."""
        if isinstance(operand, Address):
            truth = TRUTHS.get(operand.name.upper()) if not operand.steps else None
            if truth is not None and self._layout.declaration(operand.name.upper(), self._program) is None:
                return constant(truth)
            return self.address(operand)
        if isinstance(operand, Number):
            return constant(operand.value)
        if isinstance(operand, Operation):
            resolved = tuple(map(self.operand, operand.operands))
            if not all(map(is_string, resolved)):
                resolved = tuple(map(as_number, resolved))
            return Calculation(operand.name, resolved)
        if isinstance(operand, Characters):
            return StringConstant(operand.value)
        assert isinstance(operand, Unknown)
        raise AddressError("? is not a value", "write the tag or the number")

    def address(self, address: Address) -> Place | Group:
        """Resolve an address, or raise an AddressError."""
        resolved = self._resolved.get(address)
        if resolved is None:
            if address in self._open:
                raise AddressError(f"{address} is an alias with itself as a subscript", "point it at a tag")
            self._open.append(address)
            try:
                resolved = self._resolved[address] = self._find(address, address, self._program, 0)
            finally:
                self._open.pop()
        return resolved

    def address_of(self, text: str) -> Address:
        """Return the address of a user's name (see `io_images.tag_names`), or raise a LadderError."""
        address = parse_address(normal(text))
        name = address.name.upper()
        if is_image(name) or self._layout.declaration(name, self._program) is not None:
            return address
        try:
            return Address(in_scope(address.name, self._layout.scoped_names()), address.steps)
        except AmbiguousNameError as error:
            raise AmbiguousTagError(str(error), "write one of them") from None

    def named(self, text: str) -> Place | Group:
        """Resolve a tag name that the user entered; see `address_of`."""
        return self.address(self.address_of(text))

    def full_name(self, text: str) -> str:
        """Return the declared spelling of a tag name that the user entered; see `address_of`."""
        address = self.address_of(text)
        resolved = self.address(address)
        declaration = self._layout.declaration(address.name.upper(), self._program)
        if not isinstance(declaration, Tag):
            return str(address if declaration is None else replace(address, name=declaration.name))
        members = resolved.path.removeprefix(declaration.name).split(".")[1:]
        return str(Address(declaration.name, tuple(self._spelled(address.steps, members))))

    def base_name(self, text: str) -> str:
        """Return the full name of a tag that the user entered, with aliases replaced by their tags."""
        self.named(text)  # circular aliases are an error
        address, program = self.address_of(text), self._program
        declaration = self._layout.declaration(address.name.upper(), program)
        while isinstance(declaration, Alias) and not declaration.type:
            target, program = declaration.target, program_of(declaration.name)
            address = Address(target.name, target.steps + address.steps)
            declaration = self._layout.declaration(address.name.upper(), program)
        return self.full_name(
            str(address if declaration is None else replace(address, name=declaration.name))
        )

    def _spelled(self, steps: Iterable[Step], members: Sequence[str]) -> Iterator[Step]:
        """Yield steps with members spelled as declared and elements in the program's notation."""
        names = {member.upper(): member for member in members}
        for step in steps:
            if isinstance(step, MemberStep):
                yield MemberStep(names.get(step.name.upper(), step.name))
            elif isinstance(step, SubscriptStep) and self._layout.files:
                yield WordStep(int(str(step.indices[0])), ":") if str(step.indices[0]).isdigit() else step
            else:
                yield step

    def hold(self) -> str:
        """Return the name of a new tag that stores a subscript during a call."""
        return self._layout.held().path

    def _find(self, address: Address, shown: Address, program: str, depth: int) -> Place | Group:
        """Resolve an address reached through `depth` aliases; `shown` is the address as written."""
        name = address.name.upper()
        declaration = self._layout.declaration(name, program)
        if isinstance(declaration, Tag):
            kind, dims = declaration.type, declaration.dims
            return self._walk(self._group(kind, declaration.name, dims, shown), address.steps)
        if isinstance(declaration, Alias):
            if depth > 20:
                raise AddressError(f"alias {declaration.name} leads back to itself", "point it at a tag")
            target = declaration.target
            scope = program_of(declaration.name)
            if declaration.type:
                module = self._find(target, shown, scope, depth + 1)
                return self._walk(_renamed_image(declaration, module), address.steps)
            return self._find(Address(target.name, target.steps + address.steps), shown, scope, depth + 1)
        if isinstance(declaration, SlotAlias):
            return self._by_meaning(declaration, address.steps, shown)
        if (name in STATUS_FLAGS or name.startswith(HELD.upper())) and not address.steps:
            return Place(self._layout.leaf(name), (), None, str(shown))
        return self._image(name, address, shown)

    def _group(self, kind: DataType, path: str, dims: tuple[int, ...], shown: Address) -> Group:
        """Return a whole structure or array, before any subscript."""
        return Group(kind, path, indices=(), dims=dims, layout=self._layout, text=str(shown))

    def _image(self, name: str, address: Address, shown: Address) -> Place | Group:
        """Resolve a part of a slot's image; raise an AddressError for an undeclared tag."""
        local, file = _LOCAL.fullmatch(name), _SLOT_FILE.fullmatch(name)
        if local:
            return self._local(int(local[1]), local[2] == "O", address.steps, shown)
        if file:
            steps = address.steps
            if not steps or not isinstance(steps[0], WordStep):
                steps = (WordStep(0, "."), *steps)
            return self._data(int(file[2]), file[1] == "O", steps, shown)
        raise self._undeclared_error(address.name)

    def _local(self, slot: int, output: bool, steps: tuple[Step, ...], shown: Address) -> Place | Group:
        """Resolve a part of a module's tag, by the names of any profile."""
        if not steps:
            return self._module(slot, output, shown)
        name = steps[0].name.upper() if isinstance(steps[0], MemberStep) else ""
        if name == "DATA":
            return self._data(slot, output, steps[1:], shown)
        words = self._layout.words(slot, output=output)
        numbered = _WORD.fullmatch(name)
        word = words if numbered is None else int(numbered["data"] or numbered["channel"])
        if word < words:
            return self._data(slot, output, (WordStep(word, "."), *steps[1:]), shown)
        if name in _PROFILE_BITS and not output and len(steps) == 1:
            leaf = self._layout.image(slot, output=False)
            return Place(leaf, (constant(0),), constant(_PROFILE_BITS[name]), str(shown))
        card = self._layout.modules.get(slot, PLAIN_WORDS).card
        member = member_of(card, "O" if output else "I", name)
        if member is not None:
            return self._member_of_card(slot, name, member, steps[1:], shown)
        if name == "FAULT" and not output:
            leaf = self._layout.fault(slot)
            return self._walk(self._group(leaf.type, leaf.path, (), shown), steps[1:])
        raise _not_module_part_error(shown, words, output=output)

    def _member_of_card(
        self, slot: int, name: str, member: MemberPlace, steps: tuple[Step, ...], shown: Address
    ) -> Place | Group:
        """Resolve a member of a card's tag; bits 16 to 31 of `ReadBack` are in the next word."""
        output = member.image == "O"
        if member.bit is not None:
            word_place = Place(
                self._layout.image(slot, output=output), (constant(member.word),), None, str(shown)
            )
            if steps:
                raise AddressError(f"nothing can follow the bit in {shown}", "end the address there")
            return replace(word_place, bit=constant(member.bit))
        if name == "READBACK" and len(steps) == 1 and isinstance(steps[0], BitStep):
            return self._data(slot, output, _card_word_and_bit(steps[0], member.word), shown)
        return self._data(slot, output, (WordStep(member.word, "."), *steps), shown)

    def _module(self, slot: int, output: bool, shown: Address) -> Group:
        """Return a whole image of a module; an input image also has the module's fault."""
        self._layout.image(slot, output=output)
        if not output:
            self._layout.fault(slot)
        path = f"Local:{slot}:{'O' if output else 'I'}"
        kind = module_type(self._layout.words(slot, output=output), output=output)
        return self._group(kind, path, (), shown)

    def _data(self, slot: int, output: bool, steps: tuple[Step, ...], shown: Address) -> Place | Group:
        if steps and isinstance(steps[0], BitStep):
            steps = (*_card_word_and_bit(steps[0]), *steps[1:])
        leaf = self._layout.image(slot, output=output)
        return self._walk(self._group(leaf.type, leaf.path, leaf.dims, shown), steps)

    def _by_meaning(self, alias: SlotAlias, steps: tuple[Step, ...], shown: Address) -> Place | Group:
        """Resolve a bit by group and name, such as `axis.status.MOVE_COMPLETE`."""
        members = (step.name.upper() for step in steps[:2] if isinstance(step, MemberStep))
        first, name, *_ = (*members, "", "")
        if first in ("I", "O"):
            return self._local(alias.slot, first == "O", steps[1:], shown)
        meanings = meanings_of(self._layout.modules.get(alias.slot, PLAIN_WORDS))
        if first not in meanings:
            listed = ", ".join(meaning.lower() for meaning in meanings)
            parts = f"parts of {alias.name} are {listed}, I and O"
            raise AddressError(f"{shown} is not part of a module", parts)
        output, bits = meanings[first]
        if len(steps) > 2 or name not in bits:
            close = difflib.get_close_matches(name, bits, n=1)
            hint = f"did you mean {close[0]}" if close else f"bits are {', '.join(bits)}"
            raise AddressError(f"{shown} is not a bit of {alias.name}.{first.lower()}", hint)
        word, bit = bits[name]
        leaf = self._layout.image(alias.slot, output=output)
        return Place(leaf, (constant(word),), constant(bit), str(shown))

    def _walk(self, group: Group, steps: tuple[Step, ...]) -> Place | Group:
        """Follow the steps from a group and return the result; raise an AddressError if a step is invalid."""
        for position, step in enumerate(steps):
            if isinstance(step, (SubscriptStep, WordStep)):
                group = self._subscript(group, step)
            elif isinstance(step, MemberStep):
                if alias_steps := _alias_steps(group, step.name):
                    return self._walk(group, (*alias_steps, *steps[position + 1 :]))
                group = self._member(group, step.name)
            else:
                if position != len(steps) - 1:
                    raise AddressError(f"nothing can follow the bit in {group.text}", "end the address there")
                return self._bit(group, step)
        return self._leaf(group)

    def _leaf(self, group: Group) -> Place | Group:
        """Return a single elementary value as a place, and any other group unchanged."""
        if group.dims or isinstance(group.type, Structure):
            return group
        return Place(self._layout.leaf(group.path), group.indices, None, group.text, group.array)

    def _subscript(self, group: Group, step: SubscriptStep | WordStep) -> Group:
        """Return an element of an array; raise an AddressError if the subscripts do not fit."""
        subscripts: tuple[Operand, ...] = (
            (number(step.index),) if isinstance(step, WordStep) else step.indices
        )
        if len(subscripts) != len(group.dims):
            shape = f"has {len(group.dims)} dimensions" if group.dims else "is not an array"
            text = f"{group.path} {shape}, but the address has {len(subscripts)} subscripts"
            raise AddressError(text, "write one per dimension")
        indices = tuple(self._index(subscript, group.path) for subscript in subscripts)
        for index, length in zip(indices, group.dims, strict=True):
            if isinstance(index, Constant) and not 0 <= index.value < length:
                slot = slot_of_image(group.path.rpartition(".")[0])
                remedy = f"must be 0 to {length - 1}"
                if slot is not None and slot not in self._layout.modules:
                    remedy += "; for more words, load the program with its rack file"
                raise AddressError(f"index {index.value} is outside {group.path}[{length}]", remedy)
        return replace(group, indices=group.indices + indices, dims=(), array=group.dims)

    def _index(self, operand: Operand, path: str) -> Resolved:
        """Return a subscript or bit number; raise an AddressError unless it is an integer."""
        resolved = self.operand(operand)
        if not is_integer(resolved):
            raise AddressError(
                f"subscript {operand} of {path} is not an integer", "use an integer tag or number"
            )
        return resolved

    def _member(self, group: Group, name: str) -> Group:
        """Return a member of a structure; raise an AddressError if it does not exist."""
        if group.dims:
            raise AddressError(f"{group.path} is an array", f"write {group.path}[index].{name}")
        if isinstance(group.type, Elementary):
            raise AddressError(f"{group.path} is {group.type.name} and has no member {name}", "leave it out")
        member = group.type.member(name)
        if member is None:
            names = ", ".join(member.name for member in group.type.members)
            raise AddressError(f"{group.type.name} has no member {name}", f"members are {names}")
        path = f"{group.path}.{member.name}"
        return replace(group, type=member.type, path=path, dims=member.dims, array=())

    def _bit(self, group: Group, step: BitStep | SlashStep) -> Place:
        """Return a bit of an integer; raise an AddressError if it does not exist."""
        word = self._leaf(group)
        if isinstance(word, Group) or not word.type.is_integer:
            kind = "an array" if group.dims else group.type.name
            raise AddressError(f"{group.path} is {kind} and has no bits", "use a BOOL or a bit of an integer")
        index = self._index(number(step.index) if isinstance(step, SlashStep) else step.index, group.path)
        bits = word.type.bits
        if isinstance(index, Constant) and not 0 <= index.value < bits:
            raise AddressError(f"{group.path} has no bit {index.value}", f"must be 0 to {bits - 1}")
        return replace(word, bit=index)

    def _undeclared_error(self, name: str) -> AddressError:
        """Return the error for an undeclared tag, with suggestions of similar tags."""
        names = list(self._layout.names(self._program))
        elsewhere = [
            candidate
            for candidate in self._layout.scoped_names()
            if candidate.upper().endswith(f".{name.upper()}")
        ]
        if elsewhere:
            return AddressError(
                f"the controller has no tag {name}", f"did you mean {' or '.join(elsewhere)}?"
            )
        close = difflib.get_close_matches(name, names, n=1)
        listed = ", ".join([*names[:_NAMES_LISTED], *["..."] * (len(names) > _NAMES_LISTED)]) or "none"
        hint = f"did you mean {close[0]}?" if close else f"tags are {listed}"
        return AddressError(f"no tag {name} ({hint})", "declare it", Site(tag=name))


def address_in(resolver: Resolver, name: str) -> str | None:
    """Return the address of an image word, image bit or fault from a user's name; otherwise None."""
    try:
        resolved = resolver.named(name)
    except LadderError:
        return None
    return resolved.address if isinstance(resolved, Place) else None


def _renamed_image(alias: Alias, module: Place | Group) -> Group:
    """Return a module's image with the names of a structure; raise an AddressError if the bytes differ."""
    if not isinstance(module, Group) or slot_of_image(module.path) is None:
        raise AddressError(f"{alias.target} is not a module's image", "bind Local:slot:I or Local:slot:O")
    assert isinstance(module.type, Structure)
    assert alias.type is not None
    members = [(member.name.upper(), member.type, member.dims) for member in alias.type.own]
    image = [(member.name.upper(), member.type, member.dims) for member in module.type.members]
    if members != image:
        needed = ", ".join(_declared(member) for member in module.type.members)
        remedy = f"declare {needed}, and other members AT parts of Data"
        raise AddressError(f"{alias.type.name} has other bytes than {alias.target}", remedy)
    return replace(module, type=alias.type)


def _declared(member: Member) -> str:
    return f"{member.name} : {member.type.name}{dims_text(member.dims)}"


def _alias_steps(group: Group, name: str) -> tuple[Step, ...]:
    """Return the steps to the target of a member with `at`; empty for other members."""
    member = group.type.member(name) if isinstance(group.type, Structure) and not group.dims else None
    if member is None or not member.at:
        return ()
    address = parse_address(member.at)
    return (MemberStep(address.name), *address.steps)
