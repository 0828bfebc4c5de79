"""Compares two traces."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest

from scanrack.io_images.dataclass import dataclass

from ..format.layout import SlotInfo
from ..format.topics import SEQUENCES
from ..read.arrays import column_chunks
from ..read.columns import Columns
from ..read.number_formats import NumberFormats
from ..read.reader import Trace
from ..read.sequence_steps import OVER, Step, step_of
from .alignment import SAME_CLOCK, TimeMap
from .blocks import BLOCK_SCANS, blocks_by_number, blocks_by_time
from .differing import differing
from .fields import EXACT, TIME, Tolerance, all_fields
from .findings import Extent, Findings, First, rules_in
from .stream import Stream, keyed_by_number, keyed_by_time
from .tagged import CommonTags

Difference = tuple[str, str, str]
"""Name of a sequence, and its first differing step in either trace."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """The result of comparing two traces."""

    first: First | None  # the first scan that differs; None if none does
    extents: tuple[Extent, ...]  # of each bit, value and word, by the first scan in which it differs
    scans_a: int  # number of scans in the first trace
    scans_b: int  # number of scans in the second
    only_a: int  # number of scans of the first trace without a counterpart in the second
    only_b: int  # number of scans of the second without a counterpart in the first
    differing: int  # number of scans in which anything differs
    slots_only_a: tuple[int, ...]  # numbers of slots that only the first trace has
    slots_only_b: tuple[int, ...]  # numbers of slots that only the second has
    heads: tuple[tuple[str, str, str], ...]  # metadata that differ: name, value in the first, in the second
    tolerance: Tolerance  # the allowed differences
    aligned: bool = False  # whether their clocks were aligned
    sequences: tuple[Difference, ...] = ()  # name, and the first differing step in either trace

    @property
    def same(self) -> bool:
        """Whether both show the same scans in the same slots, and neither has more.

        Metadata and sequences may differ: equal images count as equal even from different programs.
        Traces with aligned clocks need not begin and end together.
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
    clock: TimeMap = SAME_CLOCK,
    progress: Callable[[int], None] = lambda scans: None,
) -> Comparison:
    """Compare two traces.

    Without a tolerance, scans are paired by number, and all bits and times count; with one,
    they are paired by time, see `differing`. Both are read block by block, so memory stays
    flat however long they are; a block holds the scans within the tolerance as well.

    Args:
        clock: converts times of the second trace to times of the first, see `align`; any other than
            `SAME_CLOCK` makes it a comparison by time.
        progress: called at each chunk with the number of further scans of the first trace read.
    """

    def read_parts() -> Iterator[Columns]:
        for columns in column_chunks(one, tags=True):
            progress(len(columns.scan))
            yield columns

    tags = CommonTags(one, other)
    comparison = compare_parts(
        (one.head.slots, tags.rows(read_parts(), 0)),
        (other.head.slots, tags.rows(column_chunks(other, tags=True), 1)),
        tolerance,
        clock=clock,
        tags=tags,
        formats=NumberFormats.of(one),
    )
    is_exact = tolerance.exact and clock == SAME_CLOCK
    heads, sequences = _heads(one, other, tags), tuple(differing_sequences(one, other, exact=is_exact))
    first = comparison.first
    if first is not None:
        slots = {detail.slot for detail in first.details}
        first = replace(
            first,
            rules_a=rules_in(one, first.scan, first.time_ns, slots),
            rules_b=rules_in(other, first.scan_b, first.time_b_ns, slots),
        )
    return replace(comparison, first=first, heads=heads, sequences=sequences)


def compare_parts(
    one: tuple[Sequence[SlotInfo], Iterable[Columns]],
    other: tuple[Sequence[SlotInfo], Iterable[Columns]],
    tolerance: Tolerance = EXACT,
    *,
    clock: TimeMap = SAME_CLOCK,
    only: frozenset[tuple[int | None, str]] | None = None,
    tags: CommonTags | None = None,
    formats: NumberFormats | None = None,
    block_scans: int = BLOCK_SCANS,
) -> Comparison:
    """Compare scans that are given part by part, see `compare`.

    Args:
        one: slots, and scans, of the first trace.
        other: slots, and scans, of the second trace.
        only: the images to compare, by slot and direction; by default all. (None, "cpu") stands
            for flags and times.
        tags: the recorded tags of the scans; None if they have none.
        formats: number formats of modules whose configuration selects them.
        block_scans: maximum scans compared at once, 1 or more. The result does not depend on it.

    Raises:
        ValueError: scans are paired by time, and time goes back from one scan of a trace to the next.
    """
    slot_numbers = [{slot.number for slot in slots} for slots, _ in (one, other)]
    both_numbers = slot_numbers[0] & slot_numbers[1]
    common_slots = [slot for slot in one[0] if slot.number in both_numbers]
    by_number = tolerance.exact and clock == SAME_CLOCK
    fields = [
        field
        for field in all_fields(common_slots, formats)
        if (only is None or (field.slot, field.direction) in only) and (by_number or field is not TIME)
    ]
    row = None
    if tags is not None:
        fields, row = [*fields, *tags.fields()], tags.dtype
    if by_number:
        stream_a, stream_b = (
            Stream(slots, both_numbers, keyed_by_number(parts), row) for slots, parts in (one, other)
        )
        blocks, counts = blocks_by_number(stream_a, stream_b, block_scans), None
    else:
        stream_a = Stream(one[0], both_numbers, keyed_by_time(one[1], SAME_CLOCK), row)
        stream_b = Stream(other[0], both_numbers, keyed_by_time(other[1], clock), row)
        blocks, counts = blocks_by_time(stream_a, stream_b, tolerance.time_ns, block_scans), tolerance.counts
    findings, compared_scans = Findings(common_slots), (0, 0)
    for block in blocks:
        findings.add(block.one, block.other, differing(fields, block, counts))
        compared_scans = compared_scans[0] + block.there.scans, compared_scans[1] + block.back.scans
    return Comparison(
        first=findings.first,
        extents=findings.extents,
        scans_a=stream_a.scans,
        scans_b=stream_b.scans,
        only_a=stream_a.scans - compared_scans[0],
        only_b=stream_b.scans - compared_scans[1],
        differing=findings.differing,
        slots_only_a=tuple(sorted(slot_numbers[0] - slot_numbers[1])),
        slots_only_b=tuple(sorted(slot_numbers[1] - slot_numbers[0])),
        heads=(),
        tolerance=tolerance,
        aligned=clock != SAME_CLOCK,
    )


def _heads(one: Trace, other: Trace, tags: CommonTags) -> tuple[tuple[str, str, str], ...]:
    """Return the entries of the metadata that differ, and the tags that only one trace has."""
    metadata_a, metadata_b = one.head.metadata, other.head.metadata
    names = dict.fromkeys([*metadata_a, *metadata_b])
    heads = [
        (name, metadata_a.get(name, ""), metadata_b.get(name, ""))
        for name in names
        if metadata_a.get(name) != metadata_b.get(name)
    ]
    if any(tags.only):
        heads.append(("tags of one trace only", ", ".join(tags.only[0]), ", ".join(tags.only[1])))
    return tuple(heads)


def differing_sequences(one: Trace, other: Trace, *, exact: bool) -> Iterator[Difference]:
    """Yield the first difference of each sequence whose waits differ in the two traces.

    Line numbers do not count, because a comment above moves them all. Both traces are read side by side, so
    memory use is constant, however many steps their sequences have.

    Args:
        exact: whether the scans of waits are compared, too.
    """
    waiting_steps: dict[str, tuple[deque[Step], deque[Step]]] = {}
    first_differing: dict[str, tuple[Step, Step]] = {}
    for steps in zip_longest(_steps(one), _steps(other)):
        for side, step in enumerate(steps):
            if step is None or step.sequence in first_differing:
                continue
            queues = waiting_steps.setdefault(step.sequence, (deque(), deque()))
            queues[side].append(step)
            if all(queues):
                step_a, step_b = (queue.popleft() for queue in queues)
                if step_a.wait != step_b.wait or (exact and step_a.scan != step_b.scan):
                    first_differing[step.sequence] = step_a, step_b
    for name, queues in waiting_steps.items():
        first_step, second_step = first_differing.get(name) or map(_next_in, queues)
        if first_step is not None or second_step is not None:
            yield name, _wait(first_step), _wait(second_step)


def _steps(trace: Trace) -> Iterator[Step]:
    if SEQUENCES.name in trace.head.channels:
        yield from (step_of(event) for event in trace.events() if event.topic == SEQUENCES.name)


def _next_in(queue: deque[Step]) -> Step | None:
    return queue[0] if queue else None


def _wait(step: Step | None) -> str:
    return "nothing more" if step is None else f"{step.wait or OVER} from scan {step.scan} on"
