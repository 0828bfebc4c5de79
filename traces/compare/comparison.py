"""Two traces compared."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ..format.layout import SlotInfo
from ..read.arrays import column_chunks
from ..read.columns import Columns
from ..read.reader import Trace
from .alignment import SAME_CLOCK, Clock
from .before import rules_in
from .blocks import BLOCK_SCANS, blocks_by_number, blocks_by_time
from .bytime import tolerantly
from .differing import Extent, First
from .exactly import exactly
from .fields import all_fields
from .findings import Findings
from .reading import Progress, read_parts
from .sequenced import Difference, differing_sequences
from .streaming import Stream, keyed_by_number, keyed_by_time
from .tagged import CommonTags
from .tolerance import EXACT, Tolerance


@dataclass(frozen=True, slots=True)
class Comparison:
    """The result of comparing two traces.

    Attributes:
        first: the first scan that differs; None if none does.
        extents: how much differs in each bit, value and word, by the first scan in which it does.
        scans_a: how many scans the first trace has.
        scans_b: how many the second has.
        only_a: how many scans of the first have nothing in the second to be compared with.
        only_b: the same the other way round.
        differing: in how many scans anything differs.
        slots_only_a: numbers of slots that only the first trace has.
        slots_only_b: those that only the second has.
        heads: entries of the metadata that differ: name, in the first trace, in the second.
        tolerance: what was allowed to differ.
        aligned: whether their clocks were brought together.
        sequences: sequences of the programs that wait otherwise: name, first step that differs in either.
    """

    first: First | None
    extents: tuple[Extent, ...]
    scans_a: int
    scans_b: int
    only_a: int
    only_b: int
    differing: int
    slots_only_a: tuple[int, ...]
    slots_only_b: tuple[int, ...]
    heads: tuple[tuple[str, str, str], ...]
    tolerance: Tolerance
    aligned: bool = False
    sequences: tuple[Difference, ...] = ()

    @property
    def same(self) -> bool:
        """Whether both show the same: every scan, in the slots of both, and no more of them in one.

        Metadata and sequences may differ: the same images from another program are the same images.
        Traces whose clocks were brought together need not begin and end together.
        """
        if self.first is not None or self.slots_only_a or self.slots_only_b:
            return False
        if self.aligned:
            return self.only_a < self.scans_a
        return not (self.only_a or self.only_b)


def compare(
    one: Trace,
    other: Trace,
    tolerance: Tolerance = EXACT,
    *,
    clock: Clock = SAME_CLOCK,
    progress: Progress = lambda scans: None,
) -> Comparison:
    """Compare two traces.

    Without a tolerance scans are paired by number and every bit and their times count; with one
    they are paired by time, see `bytime.tolerantly`. Both are read block by block, so memory stays
    flat however long they are; a block holds the scans within the tolerance as well.

    Args:
        one: the first trace.
        other: the second.
        tolerance: what may differ.
        clock: turns times of the second trace into times of the first, see `align`; another than
            that of both makes it a comparison by time.
        progress: called at each chunk with the scans of the first trace read so far.

    Raises:
        TraceError: one of the files is damaged beyond what can be left out.
    """
    tags = CommonTags(one, other)
    found = compare_parts(
        (one.head.slots, tags.rows(read_parts(one, progress), 0)),
        (other.head.slots, tags.rows(column_chunks(other, tags=True), 1)),
        tolerance,
        clock=clock,
        heads=_heads(one, other) + _tags_of_one(tags),
        tags=tags,
    )
    exact = tolerance.exact and clock == SAME_CLOCK
    found = replace(found, sequences=differing_sequences(one, other, exact=exact))
    if found.first is None:
        return found
    slots = {detail.slot for detail in found.first.details}
    first = found.first
    rules = (
        rules_in(one, first.scan, first.time_ns, slots),
        rules_in(other, first.scan_b, first.time_b_ns, slots),
    )
    return replace(found, first=replace(first, rules_a=rules[0], rules_b=rules[1]))


def compare_columns(
    one: tuple[Sequence[SlotInfo], Columns],
    other: tuple[Sequence[SlotInfo], Columns],
    tolerance: Tolerance = EXACT,
    *,
    clock: Clock = SAME_CLOCK,
    only: frozenset[tuple[int | None, str]] | None = None,
) -> Comparison:
    """Compare scans that are in memory, see `compare_parts`."""
    return compare_parts((one[0], [one[1]]), (other[0], [other[1]]), tolerance, clock=clock, only=only)


def compare_parts(
    one: tuple[Sequence[SlotInfo], Iterable[Columns]],
    other: tuple[Sequence[SlotInfo], Iterable[Columns]],
    tolerance: Tolerance = EXACT,
    *,
    clock: Clock = SAME_CLOCK,
    heads: tuple[tuple[str, str, str], ...] = (),
    only: frozenset[tuple[int | None, str]] | None = None,
    tags: CommonTags | None = None,
    block_scans: int = BLOCK_SCANS,
) -> Comparison:
    """Compare scans that come part by part, see `compare`.

    Args:
        one: slots and scans of the first trace.
        other: those of the second.
        tolerance: what may differ.
        clock: turns times of the second into times of the first.
        heads: metadata that differ, for the result.
        only: which images are compared: slot and direction; all if left out. (None, "cpu") stands
            for flags and times.
        tags: the recorded tags of the scans; None = they have none.
        block_scans: how many scans are compared at once, 1 or more. The result does not depend on it.

    Raises:
        ValueError: time goes back from one scan of a trace to the next, and they are paired by time.
    """
    numbers = [{slot.number for slot in slots} for slots, _ in (one, other)]
    both = numbers[0] & numbers[1]
    common = [slot for slot in one[0] if slot.number in both]
    fields = [field for field in all_fields(common) if only is None or (field.slot, field.direction) in only]
    fields += [] if tags is None else tags.fields()
    row = None if tags is None else tags.dtype
    by_number = tolerance.exact and clock == SAME_CLOCK
    keyed = (
        [keyed_by_number(parts) for _, parts in (one, other)]
        if by_number
        else [keyed_by_time(one[1], SAME_CLOCK), keyed_by_time(other[1], clock)]
    )
    a, b = Stream(one[0], both, keyed[0], row), Stream(other[0], both, keyed[1], row)
    found = Findings(common)
    if by_number:
        for numbered in blocks_by_number(a, b, block_scans):
            paired = len(numbered.pairs.a), len(numbered.pairs.b)
            found.add(numbered.one, numbered.other, exactly(fields, numbered), paired)
    else:
        for timed in blocks_by_time(a, b, tolerance.time_ns, block_scans):
            set_against = len(timed.there.rows), len(timed.back.rows)
            found.add(timed.one, timed.other, tolerantly(fields, timed, tolerance), set_against)
    return Comparison(
        first=found.first,
        extents=found.extents,
        scans_a=a.scans,
        scans_b=b.scans,
        only_a=a.scans - found.compared[0],
        only_b=b.scans - found.compared[1],
        differing=found.differing,
        slots_only_a=tuple(sorted(numbers[0] - numbers[1])),
        slots_only_b=tuple(sorted(numbers[1] - numbers[0])),
        heads=heads,
        tolerance=tolerance,
        aligned=clock != SAME_CLOCK,
    )


def _tags_of_one(tags: CommonTags) -> tuple[tuple[str, str, str], ...]:
    """Return the tags that only one trace has, as an entry of what differs beside the scans."""
    a, b = (", ".join(names) for names in tags.only)
    return (("tags of one trace only", a, b),) if a or b else ()


def _heads(one: Trace, other: Trace) -> tuple[tuple[str, str, str], ...]:
    a, b = one.head.metadata, other.head.metadata
    names = dict.fromkeys([*a, *b])
    return tuple((name, a.get(name, ""), b.get(name, "")) for name in names if a.get(name) != b.get(name))
