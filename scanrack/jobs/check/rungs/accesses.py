"""Variables of a ladder program, and the instructions that read and write them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from scanrack.io_images.site import Site
from scanrack.ladder.debug.crossref import Mention, mentions_of
from scanrack.ladder.model.operands import Constant, Place, first_leaf
from scanrack.ladder.model.spec import Use
from scanrack.ladder.model.tags import OWN, Leaf, Tag, program_of, tag_in
from scanrack.ladder.model.types import Elementary
from scanrack.ladder.state.lowered import ADD_ON, AddOnCall, LoweredProgram, LoweredStep

from ...load.program import EXPORT_SUFFIXES
from ..facts import Access, FileLine, Role, Touch, Variable
from ..logic import TRUE, Bit, Condition, leaves, needed
from .number_ranges import BY_PEOPLE, written_value
from .operands import is_zero, part_of, uses_of
from .view import LadderView
from .walk import Point

FIRST_SCAN = "S:FS"

OPEN = (".py", *EXPORT_SUFFIXES)
"""Suffixes of programs with tags that can be read and written from outside."""

BIT_USES = {"OTE": Touch.COIL, "OTL": Touch.LATCH, "OTU": Touch.UNLATCH}
ASSIGNMENTS = (":=", "[:=]")


class Variables:
    """The variables of a program.

    Attributes:
        by_key: tags, and the terminals and add-on members for which `key` was called.
    """

    def __init__(self, view: LadderView) -> None:
        self._view = view
        self.by_key: dict[str, Variable] = {name: self._tag(tag) for name, tag in view.tags.items()}

    def _tag(self, tag: Tag) -> Variable:
        """Return the variable of a tag.

        Tags that may be used from outside the program count as visible to people.
        """
        role = Role.PLAIN if isinstance(tag.type, Elementary) else Role.BLOCK
        is_open = self._view.path.suffix in OPEN  # Python or an operator panel may use any tag
        shown = is_open or self._view.is_recorded(tag.name) or BY_PEOPLE.search(tag.name) is not None
        place, is_set = self._view.declaration(tag.name), tag.initial is not None
        return Variable(tag.name, place, role, tag.type.name, set=is_set, shown=shown)

    def key(self, mention: Mention) -> str:
        """Return the key of an operand's variable; "" for add-on members that the caller may write."""
        leaf = first_leaf(mention.where)
        if leaf.frame:
            return self._member_key(leaf)
        if leaf.slot is None:
            return tag_in(leaf.path).upper()
        key = leaf.path.upper()
        if key not in self.by_key:
            role = Role.OUTPUT if leaf.output else Role.INPUT
            place = FileLine(str(self._view.path), 1)
            self.by_key[key] = Variable(leaf.path, place, role, leaf.type.name, set=True)
        return key

    def _member_key(self, leaf: Leaf) -> str:
        """Return the key of a bit in an add-on instruction's instance; "" if the caller may write it."""
        key = f"{leaf.frame}.{leaf.path}".upper()
        if leaf.root != OWN or leaf.path.upper() in self._view.written_members:
            return ""
        if key not in self.by_key:
            place, kind = self._view.declaration(leaf.path), leaf.type.name
            self.by_key[key] = Variable(leaf.path, place, Role.PLAIN, kind, set=True, shown=True)
        return key


def accesses_of(point: Point, view: LadderView, variables: Variables) -> Iterator[Access]:
    """Yield the accesses of an instruction to variables."""
    lowered, step, unit = view.lowered, point.step, point.routine.name
    needs = needed(point.condition)
    owner = view.owners.get(program_of(unit).upper(), "")
    once = in_first_scan(needs)
    steady = all(map(_is_steady, (*leaves(point.condition), *leaves(point.value))))
    mentions = list(mentions_of(lowered.sites[step.site], step))
    if step.name == ADD_ON:
        mentions += list(_reference_arguments(lowered, step.operands[0], mentions[0].site))
    for mention in mentions:
        key = variables.key(mention)
        if key:
            use, part = use_of(point, mention), part_of(mention.where, _start(key, mention))
            yield Access(
                *(key, part, use, point.place, unit, needs, owner, once),
                default=not point.is_rung and use is Touch.COIL,
                steady=steady,
                parameter=step.name == "SBR",
                zero=mention.writes and gives_zero(step),
                text=mention.text,
            )


def gives_zero(step: LoweredStep) -> bool:
    """Whether an instruction writes only 0."""
    return step.name == "RES" or is_zero(written_value(step))


def _start(key: str, mention: Mention) -> str:
    """Return the path at which the part of a variable begins."""
    leaf = first_leaf(mention.where)
    return leaf.path if leaf.slot is not None or leaf.frame else key


def in_first_scan(bits: Iterable[Bit]) -> bool:
    """Whether one of the bits is the first-scan bit and must be on."""
    return any(bit.on and bit.name.startswith(FIRST_SCAN) for bit in bits)


def _is_steady(part: Condition) -> bool:
    """Whether a part of a condition is true in every scan except the first."""
    return part == TRUE or (isinstance(part, Bit) and not part.on and part.name.startswith(FIRST_SCAN))


def _reference_arguments(lowered: LoweredProgram, call: AddOnCall, site: Site) -> Iterator[Mention]:
    """Yield the arguments passed to an add-on instruction by reference, which it may read and write."""
    frame = lowered.frames.get(call.name)
    for name, operand in call.handed.items():
        writes = frame is None or name in frame.written
        yield Mention(site, operand, operand.text, True, writes, stretch=True)


def touch_of(mention: Mention) -> Touch:
    """Return whether an operand is read, written or both."""
    if mention.reads and mention.writes:
        return Touch.BOTH
    return Touch.WRITE if mention.writes else Touch.READ


def use_of(point: Point, mention: Mention) -> Touch:
    """Return how an instruction uses an operand."""
    touch = touch_of(mention)
    if touch is not Touch.WRITE:
        return touch
    step = point.step
    if step.name in BIT_USES:
        return BIT_USES[step.name]
    if step.name in ASSIGNMENTS and isinstance(mention.where, Place) and mention.where.type.is_bool:
        return _assigned(point)
    is_coil = any(operand is mention.where and use is Use.COIL for use, operand in uses_of(step))
    return Touch.COIL if is_coil else Touch.WRITE


def _assigned(point: Point) -> Touch:
    """Return how an assignment uses the bit that it writes."""
    value = point.step.operands[1]
    if point.condition == TRUE:
        return Touch.COIL
    if not isinstance(value, Constant):
        return Touch.WRITE
    return Touch.LATCH if value.value else Touch.UNLATCH
