"""Finds the values of a ladder program that change with time.

Inputs, memory and time determine a scan. `clocks_of` returns the clocks of a program in which only timers
read the time. A timer is *even* if it can count while nothing else changes. This requires that other
instructions only read its bits, copy its count, or compare the count with constants.

    XIC(Run)TON(Cycle,1400,0)      the count changes in every scan, the bits when it is done
    GRT(Cycle.ACC,700)OTE(Late)    changes between counts of 700 and 701
    XIC(Lost)MOV(Cycle.ACC,Since)  has run if Since equals the count
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
"""Families of instructions that depend only on their operands and on time in milliseconds."""

TIMERS = frozenset(
    block.name for block in (timing.TON, timing.TOF, timing.RTO, blocks.TONR, blocks.TOFR, blocks.RTOR)
)

MEMBERS = ("ACC", "~last_ns", "PRE", "TT")
"""Members of a timer, in the order of the first fields of `EvenTimer`."""

COMPARISONS = tuple(
    comparison.run
    for comparison in (compare.EQU, compare.NEQ, compare.GRT, compare.GEQ, compare.LES, compare.LEQ)
)


@dataclass(frozen=True, slots=True)
class EvenTimer:
    """The members and uses of an even timer.

    Attributes:
        count: accumulated value, ms.
        last: virtual time of the last count, ns.
        preset: preset value, ms.
        counting: the timing bit.
        constants: constants to which the count is compared.
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
        timers: the even timers.
        scanned: time of the latest scan of a controller with tasks, ns; None without tasks.
    """

    timers: tuple[EvenTimer, ...]
    scanned: Leaf | None


@remember_last
def clocks_of(lowered: LoweredProgram) -> ProgramClocks | None:
    """Return the clocks of a program; None if it also reads the time by other means, or calls Python."""
    schedule = lowered.schedule
    if lowered.functions or lowered.opening or lowered.closing or not all(map(_is_even, _steps(lowered))):
        return None
    if schedule is not None and schedule.called:
        return None  # a periodic or event task
    timers = tuple(_even_timers(cross_reference(lowered).mentions))
    return ProgramClocks(timers, None if schedule is None else schedule.previous_scan)


def _steps(lowered: LoweredProgram) -> Iterator[LoweredStep]:
    return (
        step for routine in lowered.routines.values() for line in routine.lines for step in line.all_steps
    )


def _is_even(step: LoweredStep) -> bool:
    """Return whether an instruction belongs to an even family."""
    family = getattr(step.spec.run, "__module__", "").rpartition(".instructions.")[2]
    return step.name == ADD_ON or family in EVEN


@dataclass(slots=True)
class _Uses:
    """The uses of a timer's count in a program; see `EvenTimer`."""

    constants: set[int] = field(default_factory=set)
    copies: list[Leaf] = field(default_factory=list)
    even: bool = True


def _even_timers(mentions: Sequence[Mention]) -> Iterator[EvenTimer]:
    """Yield the even timers outside arrays, including timers in instances of add-on instructions."""
    writes_by_path: dict[str, int] = defaultdict(int)
    for mention in mentions:
        writes_by_path[_path(mention)] += mention.writes
    timers = {_path(timer): timer.where for timer in mentions if _is_single_timer(timer)}
    uses_by_path = _uses_of(timers, mentions)
    for path, group in timers.items():
        uses = uses_by_path[path]
        if uses.even and all(_is_written_once(leaf, writes_by_path) for leaf in uses.copies):
            assert isinstance(group, Group)
            count, last, preset, counting = (group.member(name).leaf for name in MEMBERS)
            yield EvenTimer(count, last, preset, counting, frozenset(uses.constants), tuple(uses.copies))


def _uses_of(timers: Iterable[str], mentions: Iterable[Mention]) -> dict[str, _Uses]:
    """Return the uses of the timers' counts, by path of the timer."""
    uses = {path: _Uses() for path in timers}
    mentions_by_step: dict[tuple[int, str], list[Mention]] = defaultdict(list)
    for mention in mentions:
        mentions_by_step[id(mention.step), mention.instance].append(mention)
    for step_mentions in mentions_by_step.values():
        for mention in step_mentions:
            _note_use(mention, step_mentions, uses)
    return uses


def _path(mention: Mention) -> str:
    return mention.where.path.upper()


def _is_single_timer(mention: Mention) -> bool:
    """Return whether a timer instruction names a timer that is not an array element."""
    operand = mention.where
    is_timer = mention.step is not None and mention.step.name in TIMERS
    return is_timer and isinstance(operand, Group) and not operand.indices


def _is_written_once(leaf: Leaf, writes_by_path: dict[str, int]) -> bool:
    """Return whether only one instruction writes a tag, by itself or as part of a structure."""
    return sum(count for path, count in writes_by_path.items() if _is_within(leaf.path.upper(), path)) == 1


def _is_within(path: str, outer_path: str) -> bool:
    """Return whether a path is the outer path or one of its members."""
    return path == outer_path or path.startswith(f"{outer_path}.")


def _note_use(mention: Mention, step_mentions: list[Mention], uses: dict[str, _Uses]) -> None:
    """Add a mention of a timer, or of a structure with timers, to the uses.

    Args:
        step_mentions: all mentions of the same instruction.
    """
    path, step = _path(mention), mention.step
    assert step is not None
    if isinstance(mention.where, Group):
        if step.name in (*TIMERS, timing.RES.name, ADD_ON):
            return
        for timer_path, timer_uses in uses.items():
            timer_uses.even = timer_uses.even and not _is_within(timer_path, path)
    elif path.endswith(".ACC") and path.removesuffix(".ACC") in uses:
        _note_count(mention.where, step, step_mentions, uses[path.removesuffix(".ACC")])


def _note_count(count: Place, step: LoweredStep, step_mentions: list[Mention], uses: _Uses) -> None:
    """Add a mention of a timer's count to its uses."""
    constants = [operand.value for operand in step.operands if isinstance(operand, Constant)]
    is_simple = count.bit is None and all(map(_is_plain, step.operands))
    if is_simple and step.spec.run in COMPARISONS and list(map(type, constants)) == [int]:
        uses.constants.add(int(constants[0]))
    elif (
        is_simple
        and step.spec.run is move.MOV.run
        and len(step_mentions) == 2
        and _is_copy_target(step_mentions[1])
    ):
        uses.copies.append(step_mentions[1].where.leaf)  # type: ignore[union-attr]  # see `_is_copy_target`
    else:
        uses.even = False


def _is_plain(operand: object) -> bool:
    """Return whether an operand is a constant, or a tag without a computed subscript."""
    return isinstance(operand, Constant) or (isinstance(operand, Place) and not operand.can_fault)


def _is_copy_target(mention: Mention) -> bool:
    """Return whether a mention writes a whole DINT that is not an array element."""
    operand = mention.where
    if not isinstance(operand, Place) or operand.indices or operand.bit is not None:
        return False
    return mention.writes and not mention.reads and operand.leaf.type is DINT
