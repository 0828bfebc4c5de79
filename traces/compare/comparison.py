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
from .fields import EXACT, TIME, Field, Tolerance, all_fields
from .findings import Extent, Findings, First, rules_in
from .stream import Stream, keyed_by_number, keyed_by_time
from .tagged import CommonTags

Difference = tuple[str, str, str]
"""A name, and the values of the first and the second trace as text."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """The result of comparing two traces."""

    first: First | None  # the first scan that differs; None if no scan differs
    extents: tuple[Extent, ...]  # of each differing bit, value and word, in order of the first scan
    scans_a: int  # number of scans in the first trace
    scans_b: int  # number of scans in the second trace
    only_a: int  # number of scans of the first trace without a counterpart in the second
    only_b: int  # number of scans of the second trace without a counterpart in the first
    differing: int  # number of scans with a difference
    slots_only_a: tuple[int, ...]  # numbers of slots that only the first trace has
    slots_only_b: tuple[int, ...]  # numbers of slots that only the second trace has
    heads: tuple[Difference, ...]  # metadata that differ
    tolerance: Tolerance  # the allowed differences
    aligned: bool = False  # whether their clocks were aligned
    sequences: tuple[Difference, ...] = ()  # the first differing step of each differing sequence

    @property
    def same(self) -> bool:
        """Whether both traces have the same slots and equal scans, and neither has extra scans.

        Metadata and sequences may differ, since images can be equal even if the programs are not.
        Traces with aligned clocks may begin and end at different times.
        """
        if self.first is not None or self.slots_only_a or self.slots_only_b:
            return False
        if self.aligned:
            return self.only_a < self.scans_a
        return not (self.only_a or self.only_b)


def compare(
    a: Trace,
    b: Trace,
    tolerance: Tolerance = EXACT,
    *,
    clock: TimeMap = SAME_CLOCK,
    progress: Callable[[int], None] = lambda scans: None,
) -> Comparison:
    """Compare two traces.

    Without a tolerance, scans are paired by number, and all bits and times are compared. With a tolerance,
    scans are paired by time, see `differing`. Both traces are read block by block, so memory use does not
    depend on their length; a block also has the scans within the tolerance.

    Args:
        clock: converts times of the second trace to times of the first, see `align`; with any clock but
            `SAME_CLOCK`, scans are paired by time.
        progress: called for each chunk with its number of scans in the first trace.
    """

    def read_parts() -> Iterator[Columns]:
        for columns in column_chunks(a, tags=True):
            progress(len(columns.scan))
            yield columns

    tags = CommonTags(a, b)
    comparison = compare_parts(
        (a.head.slots, tags.rows(read_parts(), 0)),
        (b.head.slots, tags.rows(column_chunks(b, tags=True), 1)),
        tolerance,
        clock=clock,
        tags=tags,
        formats=NumberFormats.of(a),
    )
    by_number = tolerance.exact and clock == SAME_CLOCK
    heads, sequences = _heads(a, b, tags), tuple(differing_sequences(a, b, exact=by_number))
    first = comparison.first
    if first is not None:
        slots = {detail.slot for detail in first.details}
        first = replace(
            first,
            rules_a=rules_in(a, first.scan, first.time_ns, slots),
            rules_b=rules_in(b, first.scan_b, first.time_b_ns, slots),
        )
    return replace(comparison, first=first, heads=heads, sequences=sequences)


def compare_parts(
    a: tuple[Sequence[SlotInfo], Iterable[Columns]],
    b: tuple[Sequence[SlotInfo], Iterable[Columns]],
    tolerance: Tolerance = EXACT,
    *,
    clock: TimeMap = SAME_CLOCK,
    only: frozenset[tuple[int | None, str]] | None = None,
    tags: CommonTags | None = None,
    formats: NumberFormats | None = None,
    block_scans: int = BLOCK_SCANS,
) -> Comparison:
    """Compare traces that are read in parts, see `compare`.

    Args:
        a: slots and scans of the first trace.
        b: slots and scans of the second trace.
        only: slots and directions of the images to compare; None = all. (None, "cpu") means the flags and
            times.
        tags: the recorded tags of the scans; None if they have none.
        formats: number formats of modules whose configuration selects them.
        block_scans: maximum number of scans to compare at once, 1 or more. The result does not depend on it.

    Raises:
        ValueError: scans are paired by time, and a scan has an earlier time than the scan before it.
    """
    (slots_a, parts_a), (slots_b, parts_b) = a, b
    numbers_a, numbers_b = ({slot.number for slot in slots} for slots in (slots_a, slots_b))
    common_numbers = numbers_a & numbers_b
    common_slots = [slot for slot in slots_a if slot.number in common_numbers]
    by_number = tolerance.exact and clock == SAME_CLOCK
    fields = _fields_to_compare(common_slots, formats, only)
    if not by_number:
        fields = [field for field in fields if field is not TIME]
    tag_row = None
    if tags is not None:
        fields, tag_row = [*fields, *tags.fields()], tags.dtype
    keyed_a = keyed_by_number(parts_a) if by_number else keyed_by_time(parts_a, SAME_CLOCK)
    keyed_b = keyed_by_number(parts_b) if by_number else keyed_by_time(parts_b, clock)
    stream_a = Stream(slots_a, common_numbers, keyed_a, tag_row)
    stream_b = Stream(slots_b, common_numbers, keyed_b, tag_row)
    if by_number:
        blocks, counts = blocks_by_number(stream_a, stream_b, block_scans), None
    else:
        blocks, counts = blocks_by_time(stream_a, stream_b, tolerance.time_ns, block_scans), tolerance.counts
    findings, compared_a, compared_b = Findings(common_slots), 0, 0
    for block in blocks:
        findings.add(block.side_a, block.side_b, differing(fields, block, counts))
        compared_a += block.windows_a.scans
        compared_b += block.windows_b.scans
    return Comparison(
        first=findings.first,
        extents=findings.extents,
        scans_a=stream_a.scans,
        scans_b=stream_b.scans,
        only_a=stream_a.scans - compared_a,
        only_b=stream_b.scans - compared_b,
        differing=findings.differing,
        slots_only_a=tuple(sorted(numbers_a - numbers_b)),
        slots_only_b=tuple(sorted(numbers_b - numbers_a)),
        heads=(),  # `compare` adds them
        tolerance=tolerance,
        aligned=clock != SAME_CLOCK,
    )


def _fields_to_compare(
    slots: Sequence[SlotInfo], formats: NumberFormats | None, only: frozenset[tuple[int | None, str]] | None
) -> list[Field]:
    """Return the fields of images, flags and times; `only` is the argument of `compare_parts`."""
    fields = all_fields(slots, formats)
    return fields if only is None else [field for field in fields if (field.slot, field.direction) in only]


def _heads(a: Trace, b: Trace, tags: CommonTags) -> tuple[Difference, ...]:
    """Return the metadata that differs, and the tags that only one trace has."""
    metadata_a, metadata_b = a.head.metadata, b.head.metadata
    names = dict.fromkeys([*metadata_a, *metadata_b])
    heads = [
        (name, metadata_a.get(name, ""), metadata_b.get(name, ""))
        for name in names
        if metadata_a.get(name) != metadata_b.get(name)
    ]
    if tags.only_a or tags.only_b:
        heads.append(("tags of one trace only", ", ".join(tags.only_a), ", ".join(tags.only_b)))
    return tuple(heads)


def differing_sequences(a: Trace, b: Trace, *, exact: bool) -> Iterator[Difference]:
    """Yield the first differing step of each sequence whose waits differ in the two traces.

    Line numbers are ignored, because an added comment changes the line numbers below it. Both traces are read
    in parallel, so memory use does not depend on the number of steps.

    Args:
        exact: whether a wait must also begin in the same scan.
    """
    waiting_steps: dict[str, tuple[deque[Step], deque[Step]]] = {}  # steps not paired yet, by sequence
    first_differing: dict[str, tuple[Step, Step]] = {}
    for steps in zip_longest(_steps(a), _steps(b)):
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
        if name in first_differing:
            step_a, step_b = first_differing[name]
            yield name, _wait_text(step_a), _wait_text(step_b)
        elif any(queues):
            step_text_a, step_text_b = (_wait_text(queue[0] if queue else None) for queue in queues)
            yield name, step_text_a, step_text_b


def _steps(trace: Trace) -> Iterator[Step]:
    if SEQUENCES.name in trace.head.channels:
        yield from (step_of(event) for event in trace.events() if event.topic == SEQUENCES.name)


def _wait_text(step: Step | None) -> str:
    return "no further step" if step is None else f"{step.wait or OVER} from scan {step.scan} on"
