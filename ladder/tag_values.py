r"""Tags by pattern, and the expressions that read them: for a recorder.

An expression is Python over the variables of the compiled program, the cells of its memory.

| pattern | means |
|---|---|
| `Run`, `fill.acc` | a tag, a member; case does not matter |
| `Fill` | all members of a structure, less the hidden ones |
| `\Main.*`, `S?` | all that match |
| `Recipe[3].T`, `Recipe[3]` | an element |
| an alias | its target; a bit: its word |
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import product

from .errors import LadderError
from .expressions import parse_address
from .operands import Constant, Group, Place
from .resolver import Resolver
from .tags import Alias, Layout, Leaf
from .tree import Address, BitStep
from .types import DataType, Elementary, count_of

TEXT = "TEXT"


@dataclass(frozen=True, slots=True)
class TagValue:
    """A value, or the elements of an array, of a program.

    Attributes:
        name: its full name.
        type: name of its elementary type, such as DINT; TEXT for a STRING.
        length: elements of an array; 0 for a single value.
        source: the expression that reads it: `*name` for an array, length and data for a TEXT.
    """

    name: str
    type: str
    length: int
    source: str


def tag_values(layout: Layout, patterns: Sequence[str]) -> list[TagValue]:
    """Return what patterns mean, each value once, in the order of the patterns.

    Raises:
        LadderError: a pattern that matches nothing; the closest tag.
    """
    found: dict[str, TagValue] = {}
    known = list(_all_values(layout))
    for pattern in patterns:
        matches = _matching(layout, known, pattern)
        found.update((each.name, each) for each in matches if each.name not in found)
    return list(found.values())


def _matching(layout: Layout, known: Sequence[TagValue], pattern: str) -> list[TagValue]:
    matches = [each for each in known if matches_part(pattern, each.name, fold=True)]
    if matches:
        return matches
    try:
        return _at_address(layout, known, parse_address(pattern))
    except LadderError as error:
        close = get_close_matches(pattern.upper(), [each.name.upper() for each in known], 1)
        names = {each.name.upper(): each.name for each in known}
        hint = f"; did you mean {names[close[0]]}?" if close else ""
        raise LadderError(f"no tag matches {pattern!r}{hint}") from error


def matches_part(pattern: str, name: str, *, fold: bool = False) -> bool:
    """Return whether a pattern matches a name, or what stands before a dot or a subscript in it.

    >>> matches_part("Fill", "Fill.ACC"), matches_part("Fi", "Fill.ACC"), matches_part("*.acc", "Fill.ACC")
    (True, False, False)

    Args:
        pattern: a name, with `*` and `?`; brackets are subscripts.
        name: the name.
        fold: case does not matter.
    """
    text = "".join({"*": ".*", "?": "."}.get(each, re.escape(each)) for each in pattern)
    return re.match(rf"{text}(?:[.\[]|$)", name, re.IGNORECASE if fold else 0) is not None


def _all_values(layout: Layout) -> Iterator[TagValue]:
    for tag in layout.tags().values():
        yield from _values(layout, tag.name, tag.type, tag.dims)


def _values(layout: Layout, path: str, kind: DataType, dims: tuple[int, ...]) -> Iterator[TagValue]:
    """Yield the values below a path."""
    if isinstance(kind, Elementary):
        leaf = layout.leaf(path)
        yield _value(layout, path, leaf, 0, leaf.size if leaf.dims else 0)
    elif kind.is_string:
        for at, indices in enumerate(product(*map(range, dims))):
            subscript = f"[{','.join(map(str, indices))}]" if dims else ""
            yield _text(layout, path, f"{path}{subscript}", at)
    else:
        for member in kind.own:
            yield from _values(layout, f"{path}.{member.name}", member.type, dims + member.dims)


def _at_address(layout: Layout, known: Sequence[TagValue], address: Address) -> list[TagValue]:
    """Return the values at an address."""
    declaration = layout.declarations.get(address.name.upper())
    if isinstance(declaration, Alias) and not declaration.type:
        target = declaration.target
        return _matching(layout, known, str(Address(target.name, (*target.steps, *address.steps))))
    if address.steps and isinstance(address.steps[-1], BitStep):
        return _matching(layout, known, str(Address(address.name, address.steps[:-1])))
    where = Resolver(layout).address(address)
    if not isinstance(where, Place | Group):
        raise LadderError(f"{address} is no tag")
    if isinstance(where, Place):
        if where.leaf.is_image or where.fixed_index is None:
            raise LadderError(f"{address} is no tag of its own")
        name = str(address) if where.bit is None else _element_name(where.leaf, where.fixed_index)
        return [_value(layout, name, where.leaf, where.fixed_index, 0)]
    return list(_members(layout, where, str(address)))


def _element_name(leaf: Leaf, at: int) -> str:
    """Return the name of the word in which a packed bit lies."""
    return f"{leaf.path}[{at}]" if leaf.dims else leaf.path


def _members(layout: Layout, group: Group, name: str) -> Iterator[TagValue]:
    """Yield the values in an element of an array of structures."""
    if not all(isinstance(index, Constant) for index in group.indices):
        raise LadderError(f"{name} has a computed subscript")
    prefix = f"{group.path.upper()}."
    for path, leaf in layout.leaves.items():
        rest = leaf.path[len(prefix) :]
        if not path.startswith(prefix) or "~" in rest:
            continue
        at, inner = 0, leaf.dims[len(group.indices) :]
        for index, length in zip(group.indices, leaf.dims, strict=False):
            assert isinstance(index, Constant)
            at = at * length + int(index.value)
        count = count_of(inner)
        yield _value(layout, f"{name}.{rest}", leaf, at * count, count if inner else 0)


def _value(layout: Layout, name: str, leaf: Leaf, start: int, length: int) -> TagValue:
    return TagValue(name, leaf.type.name, length, _source(layout, leaf, start, length))


def _text(layout: Layout, path: str, name: str, at: int) -> TagValue:
    """Return a STRING: its length and its characters."""
    data = layout.leaf(f"{path}.DATA")
    room = data.dims[-1]
    characters = _source(layout, data, at * room, room).removeprefix("*")
    return TagValue(name, TEXT, 0, f"{_source(layout, layout.leaf(f'{path}.LEN'), at, 0)}, {characters}")


def _source(layout: Layout, leaf: Leaf, start: int, length: int) -> str:
    """Return the expression that reads one value (length 0) or several of a leaf."""
    spot = layout.spot(leaf)
    if spot is None:
        if not leaf.dims:
            return leaf.ident
        if not length:
            return f"{leaf.ident}[{start}]"
        return f"*{leaf.ident}" if length == leaf.size else f"*{leaf.ident}[{start}:{start + length}]"
    places = [spot.at(start + number) for number in range(length or 1)]
    if not length:
        return f"{spot.ident}[{places[0]}]"
    step = places[1] - places[0] if length > 1 else 1
    if places == list(range(places[0], places[0] + step * length, step)):
        return f"*{spot.ident}[{places[0]}:{places[-1] + 1}:{step}]"
    return f"*({', '.join(f'{spot.ident}[{place}]' for place in places)})"
