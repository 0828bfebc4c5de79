"""Cross reference: the instructions that read or write a tag, with their rungs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field, replace
from functools import cached_property

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site

from ..model.operand_checks import WRITTEN
from ..model.operands import Calculation, Constant, Group, Place, Resolved, constant, first_leaf
from ..model.resolver import Resolver
from ..model.spec import Use
from ..model.tags import OWN, Leaf
from ..model.types import HIDDEN
from ..state.lowered import ADD_ON, AddOnCall, Call, LoweredProgram, LoweredRoutine, LoweredStep

BOTH_WAYS = frozenset(
    {
        Use.STORAGE,
        Use.TIMER,
        Use.COUNTER,
        Use.BLOCK,
        Use.CONTROL,
        Use.SLC_TIMER,
        Use.SLC_COUNTER,
        Use.SLC_CONTROL,
        Use.MESSAGE,
        Use.ARRAY,
        Use.PID,
        Use.ALARM_DIGITAL,
        Use.ALARM_ANALOG,
        Use.MOTION,
        Use.AXIS,
        Use.COORDINATE_SYSTEM,
    }
)
"""Uses that both read and write their operand."""

TARGETS = WRITTEN | BOTH_WAYS | {Use.RESETTABLE, Use.SLC_RESETTABLE}
"""Uses that write their operand."""

STRETCHES = frozenset({Use.SOURCE, Use.DESTINATION, Use.TABLE, Use.ARRAY})
"""Uses whose operand can extend beyond its first element."""


@dataclass(frozen=True, slots=True)
class Mention:
    """An operand of an instruction."""

    site: Site
    where: Place | Group  # the resolved operand
    text: str  # the address as written
    reads: bool
    writes: bool
    stretch: bool = False  # whether it may extend beyond the named element
    step: LoweredStep | None = field(default=None, compare=False, repr=False)  # the instruction
    instance: str = ""  # the instance, if it is in an add-on instruction

    @property
    def way(self) -> str:
        """The access as text: `reads`, `writes` or `reads, writes`."""
        return ", ".join(word for word, is_so in (("reads", self.reads), ("writes", self.writes)) if is_so)

    def __str__(self) -> str:
        site = self.site
        return f"{site.routine}, {site.place}: {site.instruction} {self.way} {self.text}"


class CrossReference:
    """All mentions of tags in a program."""

    def __init__(self, lowered: LoweredProgram) -> None:
        self._lowered = lowered
        self._resolver = Resolver(lowered.layout)

    @cached_property
    def mentions(self) -> tuple[Mention, ...]:
        """All mentions; mentions in add-on instructions are listed once per instance."""
        return tuple(_without_duplicates(_mentions(self._lowered, lambda _operand: True)))

    def of(self, tag: str) -> tuple[Mention, ...]:
        """Return the mentions of an address, its parts and its containers; may raise a LadderError."""
        operand = self._resolver.named(tag)
        mentions = _mentions(self._lowered, lambda passed: overlap(operand, passed, stretch=True))
        return tuple(
            mention
            for mention in _without_duplicates(mentions)
            if overlap(operand, mention.where, stretch=mention.stretch)
        )

    def writers(self, leaf: Leaf, index: int, mask: int | None) -> tuple[Mention, ...]:
        """Return the mentions, including in add-on instructions, that may write a value or a bit of it."""
        path = leaf.path.upper()

        def matches(operand: Place | Group) -> bool:
            return _one_contains_other(path, operand.path)

        def written(mention: Mention) -> bool:
            """Return whether a mention's operand contains the value, or may contain it."""
            where = mention.where
            if isinstance(where, Group):
                return f"{path}.".startswith(f"{where.path.upper()}.")
            fixed, bit = where.fixed_index, where.bit
            includes_bit = mask is None or not isinstance(bit, Constant) or bool(mask >> int(bit.value) & 1)
            return where.leaf is leaf and (fixed in (None, index) or mention.stretch) and includes_bit

        return tuple(
            mention for mention in _mentions(self._lowered, matches) if mention.writes and written(mention)
        )

    def __iter__(self) -> Iterator[Mention]:
        return iter(self.mentions)


def cross_reference(lowered: LoweredProgram) -> CrossReference:
    """Return the cross reference of a built program (`Program.build`)."""
    return CrossReference(lowered)


def overlap(a: Place | Group, b: Place | Group, *, stretch: bool = False) -> bool:
    """Return whether two operands may share memory; with `stretch`, `b` extends beyond the named element."""
    if not _one_contains_other(a.path, b.path) or not (
        stretch or all(map(_may_be_equal, a.indices, b.indices))
    ):
        return False
    return not isinstance(a, Place) or not isinstance(b, Place) or _may_be_equal(a.bit, b.bit)


def _one_contains_other(a: str, b: str) -> bool:
    """Return whether two paths are equal, or one contains the other."""
    a, b = f"{a}.".upper(), f"{b}.".upper()
    return a.startswith(b) or b.startswith(a)


def _may_be_equal(a: Resolved | None, b: Resolved | None) -> bool:
    """Return whether two subscripts or bit numbers may be equal, that is, are not different constants."""
    return not isinstance(a, Constant) or not isinstance(b, Constant) or a.value == b.value


def _mentions(lowered: LoweredProgram, matches: Callable[[Place | Group], bool]) -> Iterator[Mention]:
    """Yield mentions; inside an add-on instruction, only if its arguments include a match."""
    visited: set[object] = set()
    for routine in lowered.routines.values():
        if not routine.frame:
            yield from _routine_mentions(lowered, routine, lambda operand: operand, matches, visited)


def _routine_mentions(
    lowered: LoweredProgram,
    routine: LoweredRoutine,
    placed: Callable[[Place | Group], Place | Group],
    matches: Callable[[Place | Group], bool],
    visited: set[object],
    instance: str = "",
) -> Iterator[Mention]:
    """Yield the mentions of a routine and of the add-on instructions that it calls."""
    for line in routine.lines:
        for step in line.all_steps:
            for mention in mentions_of(lowered.sites[step.site], step):
                where = placed(mention.where)
                yield replace(mention, where=where, text=where.text, instance=instance)
            for call in step.operands:
                if isinstance(call, AddOnCall):
                    yield from _call_mentions(lowered, call, placed, matches, visited)


def _call_mentions(
    lowered: LoweredProgram,
    call: AddOnCall,
    placed: Callable[[Place | Group], Place | Group],
    matches: Callable[[Place | Group], bool],
    visited: set[object],
) -> Iterator[Mention]:
    """Yield the mentions inside an add-on call, with its arguments instead of the parameters.

    Nothing is yielded if no argument matches, or if an equal call was visited.
    """
    handed = {name: placed(operand) for name, operand in call.handed.items()}
    handed[OWN] = placed(call.instance)
    call_key = (call.name, *((name, argument.text) for name, argument in handed.items()))
    if call_key in visited or not any(map(matches, handed.values())):
        return
    visited.add(call_key)
    for key in call.routines:
        routine, instance = lowered.routines[key], handed[OWN].text
        yield from _routine_mentions(
            lowered, routine, lambda operand: placed_in(lowered, handed, operand), matches, visited, instance
        )


def placed_in(
    lowered: LoweredProgram, handed: Mapping[str, Place | Group], operand: Place | Group
) -> Place | Group:
    """Return an add-on's operand as an operand of the program; `handed` has arguments by `Leaf.root`."""
    leaf = first_leaf(operand)
    if not leaf.root:
        return operand
    base = handed[leaf.root]
    suffix, shown = operand.path[len(leaf.root) :], operand.text[len(leaf.root) :]
    if leaf.root == OWN:
        suffix, shown = f".{operand.path}", f".{operand.text}"
    path, text = base.path + suffix, base.text + shown
    inner = tuple(_placed_index(lowered, handed, index) for index in operand.indices)
    missing = (constant(0),) * (0 if leaf.outer else len(base.dims))  # the first element represents an array
    indices = base.indices + missing + inner
    array = operand.array or base.array
    if isinstance(operand, Group):
        return replace(operand, path=path, indices=indices, layout=lowered.layout, text=text, array=array)
    bit = operand.bit if operand.bit is not None or not isinstance(base, Place) else base.bit
    return Place(lowered.layout.leaf(path), indices, bit, text, array)


def _placed_index(lowered: LoweredProgram, handed: Mapping[str, Place | Group], index: Resolved) -> Resolved:
    """Return a subscript of an add-on's operand as a subscript of the program."""
    if isinstance(index, Calculation):
        return Calculation(
            index.name, tuple(_placed_index(lowered, handed, operand) for operand in index.operands)
        )
    return placed_in(lowered, handed, index) if isinstance(index, (Place, Group)) else index


def _without_duplicates(mentions: Iterable[Mention]) -> Iterator[Mention]:
    """Yield mentions; outside of rungs, skip mentions with a repeated text."""
    texts: set[str] = set()
    for mention in mentions:
        if mention.site.unit == "rung" or str(mention) not in texts:
            texts.add(str(mention))
            yield mention


def mentions_of(site: Site, step: LoweredStep) -> Iterator[Mention]:
    """Yield the operands of an instruction, and the places that their subscripts read."""
    for operand, uses in _operands(step):
        reads = not uses & TARGETS or bool(uses & BOTH_WAYS)
        writes = bool(uses & TARGETS)
        for place, in_subscript in _places_in(operand):
            if isinstance(place, Place) and HIDDEN in place.leaf.path:
                continue
            stretch = not STRETCHES.isdisjoint(step.spec.operands)
            yield Mention(
                site, place, place.text, reads or in_subscript, writes and not in_subscript, stretch, step
            )


def _operands(step: LoweredStep) -> Iterable[tuple[Resolved, frozenset[Use]]]:
    """Return the operands of an instruction with their uses; operands of a call are read or written."""
    if step.name == ADD_ON:
        call: AddOnCall = step.operands[0]
        return [(call.instance, frozenset({Use.TIMER}))]
    if step.name == "JSR":
        jump: Call = step.operands[0]
        into = [(operand, frozenset({Use.NUMBER})) for operand in jump.inputs]
        return [*into, *((operand, frozenset({Use.TARGET})) for operand in jump.returns)]
    if step.name in ("SBR", "RET"):
        use = Use.TARGET if step.name == "SBR" else Use.NUMBER
        return [(operand, frozenset({use})) for operand in step.operands]
    return [
        (operand, frozenset({use}))
        for operand, use in zip(step.operands, step.uses, strict=False)
        if not isinstance(operand, (str, Call))
    ]


def _places_in(operand: Resolved) -> Iterator[tuple[Place | Group, bool]]:
    """Yield each place in an operand, and whether the place is in a subscript."""
    if isinstance(operand, Calculation):
        for part in operand.operands:
            yield from _places_in(part)
    elif isinstance(operand, (Place, Group)):
        yield operand, False
        inner = [*operand.indices]
        if isinstance(operand, Place) and operand.bit is not None:
            inner.append(operand.bit)
        for part in inner:
            for place, _ in _places_in(part):
                yield place, True
