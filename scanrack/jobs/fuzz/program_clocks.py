"""Finds the values of a ladder program that follow the time.

Inputs, memory and time determine a scan. `clocks_of` returns the clocks of a program in which only timers
read the time. A timer is *even* if it can count while nothing else changes. That is so if other instructions
only read its bits, copy its count, or compare the count with constants.

    XIC(Run)TON(Cycle,1400,0)      the count changes in every scan, the bits when it is done
    GRT(Cycle.ACC,700)OTE(Late)    changes between a count of 700 and one of 701
    XIC(Lost)MOV(Cycle.ACC,Since)  has run if Since is the count
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from scanrack.ladder.debug.crossref import Mention, cross_reference
from scanrack.ladder.instructions import blocks, compare, move, timing
from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.model.types import DINT
from scanrack.ladder.state.lowered import ADD_ON, LoweredProgram, LoweredStep

from .last_program import remember_last

_FAMILIES = (
    "addons arrays bits blocks compare compute control decimal files move sequencers shifts statements "
    "timing trigonometry"
)

EVEN = frozenset(_FAMILIES.split(" "))
"""Families of instructions that depend only on their operands and count time in milliseconds."""

TIMERS = frozenset(
    block.name for block in (timing.TON, timing.TOF, timing.RTO, blocks.TONR, blocks.TOFR, blocks.RTOR)
)

MEMBERS = ("ACC", "~last_ns", "PRE", "TT")

COMPARISONS = tuple(
    comparison.run
    for comparison in (compare.EQU, compare.NEQ, compare.GRT, compare.GEQ, compare.LES, compare.LEQ)
)


@dataclass(frozen=True, slots=True)
class EvenTimer:
    """The members and uses of an even timer.

    Attributes:
        last: virtual time of its last count, ns.
        constants: constants with which the count is compared.
        copies: tags that only a MOV of the count writes.
    """

    count: Leaf
    last: Leaf
    preset: Leaf
    counting: Leaf
    constants: frozenset[int] = frozenset()
    copies: tuple[Leaf, ...] = ()


@dataclass(frozen=True, slots=True)
class ProgramClocks:
    """The clocks of a program.

    Attributes:
        scanned: time of the latest scan of a controller with tasks, ns; None without tasks.
    """

    timers: tuple[EvenTimer, ...]
    scanned: Leaf | None


@remember_last
def clocks_of(lowered: LoweredProgram) -> ProgramClocks | None:
    """Return the clocks of a program; None if it reads the time in another way, or calls Python."""
    schedule = lowered.schedule
    if lowered.functions or lowered.opening or lowered.closing or not all(map(_is_even, _steps(lowered))):
        return None
    if schedule is not None and schedule.called:
        return None  # a periodic or event task
    mentions = cross_reference(lowered).mentions
    timers = tuple(_even_timers(mentions))
    return ProgramClocks(timers, None if schedule is None else schedule.previous_scan)


def _steps(lowered: LoweredProgram) -> Iterator[LoweredStep]:
    return (
        step for routine in lowered.routines.values() for line in routine.lines for step in line.all_steps
    )


def _is_even(step: LoweredStep) -> bool:
    family = getattr(step.spec.run, "__module__", "").rpartition(".instructions.")[2]
    return step.name == ADD_ON or family in EVEN


@dataclass(slots=True)
class _Uses:
    """How a program uses the count of a timer."""

    constants: set[int] = field(default_factory=set)
    copies: list[Leaf] = field(default_factory=list)
    even: bool = True


def _even_timers(mentions: Sequence[Mention]) -> Iterator[EvenTimer]:
    """Yield the even timers that are not in arrays, including those in add-on instruction instances."""
    writes_by_path: dict[str, int] = defaultdict(int)
    for mention in mentions:
        writes_by_path[_path(mention)] += mention.writes
    timers = {_path(timer): timer.where for timer in mentions if _is_single_timer(timer)}
    uses = _uses_of(timers, mentions)
    for path, group in timers.items():
        use = uses[path]
        if use.even and all(_is_written_once(leaf, writes_by_path) for leaf in use.copies):
            assert isinstance(group, Group)
            count, last, preset, counting = (group.member(name).leaf for name in MEMBERS)
            yield EvenTimer(count, last, preset, counting, frozenset(use.constants), tuple(use.copies))


def _uses_of(timers: Iterable[str], mentions: Iterable[Mention]) -> dict[str, _Uses]:
    """Return how a program uses the counts of its timers, by path."""
    uses = {path: _Uses() for path in timers}
    by_step: dict[tuple[int, str], list[Mention]] = defaultdict(list)
    for mention in mentions:
        by_step[id(mention.step), mention.instance].append(mention)
    for together in by_step.values():
        for mention in together:
            _note_use(mention, together, uses)
    return uses


def _path(mention: Mention) -> str:
    return mention.where.path.upper()


def _is_single_timer(mention: Mention) -> bool:
    """Return whether a timer instruction names a timer that is not an array element."""
    where = mention.where
    named = mention.step is not None and mention.step.name in TIMERS
    return named and isinstance(where, Group) and not where.indices


def _is_written_once(leaf: Leaf, written: dict[str, int]) -> bool:
    """Return whether only one instruction writes a tag, by itself or as part of a structure."""
    path = leaf.path.upper()
    return sum(count for name, count in written.items() if path == name or path.startswith(f"{name}.")) == 1


def _note_use(mention: Mention, together: list[Mention], uses: dict[str, _Uses]) -> None:
    """Record a mention of timers.

    Args:
        together: all mentions of its instruction.
    """
    path, step = _path(mention), mention.step
    assert step is not None
    if isinstance(mention.where, Group):
        if step.name in (*TIMERS, timing.RES.name, ADD_ON):
            return
        for timer, use in uses.items():
            use.even = use.even and not (timer == path or timer.startswith(f"{path}."))
    elif path.endswith(".ACC") and (timer_uses := uses.get(path.removesuffix(".ACC"))) is not None:
        _note_count(mention.where, step, together, timer_uses)


def _note_count(place: Place, step: LoweredStep, together: list[Mention], use: _Uses) -> None:
    """Record a mention of a timer's count."""
    constants = [operand.value for operand in step.operands if isinstance(operand, Constant)]
    is_simple = place.bit is None and all(map(_is_plain, step.operands))
    if is_simple and step.spec.run in COMPARISONS and list(map(type, constants)) == [int]:
        use.constants.add(int(constants[0]))
    elif is_simple and step.spec.run is move.MOV.run and len(together) == 2 and _is_copy(together[1]):
        use.copies.append(together[1].where.leaf)  # type: ignore[union-attr]  # a place, see `_is_copy`
    else:
        use.even = False


def _is_plain(operand: object) -> bool:
    """Return whether an operand is a constant, or a tag without a computed subscript."""
    return isinstance(operand, Constant) or (isinstance(operand, Place) and not operand.can_fault)


def _is_copy(target: Mention) -> bool:
    where = target.where
    single = isinstance(where, Place) and not where.indices and where.bit is None
    return single and target.writes and not target.reads and where.leaf.type is DINT  # type: ignore[union-attr]
