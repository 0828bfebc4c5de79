"""Runs a ladder program on the inputs of a recording, usually compiled and without a rack.

A rack is needed if tags were forced or set from outside, or if the program was edited, writes its inputs or
has routines in Python; see `replay.input_replay`.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from types import MappingProxyType
from typing import NamedTuple

from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.journal import RecordedPast
from scanrack.ladder.debug.replay import NO_FORCES, input_leaves
from scanrack.ladder.debug.stretch import PlainInputs, ScanInputs, Write
from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.state.snapshots import SavedValues, snapshot
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.phases import runs_logic
from scanrack.runtime.loop.scan import ScanFlag
from scanrack.traces.read.columns import Columns
from scanrack.traces.read.packed import CHUNK_SCANS, memory_blocks
from scanrack.traces.replay import PackedTrace

from ..record.edits_and_forces import is_edit
from ..record.link_losses import link_changes

Span = tuple[memoryview, slice]
"""An output image of the running program, and its place in the memory block of a recorded scan."""

NO_SNAPSHOTS: Mapping[int, str] = MappingProxyType({})

UNUSUAL = ScanFlag.TAGS_FROM_OUTSIDE | ScanFlag.OUTPUT_FORCES | ScanFlag.FAULT


class RungsRun(NamedTuple):
    """The result of a ladder program's run on recorded inputs."""

    row: int  # of the last scan
    met: bool  # whether the tag came on in that scan
    departs: int | None  # row of the first scan whose outputs differ from the recorded ones, or None
    notes: tuple[str, ...] = ()  # parts of the recording that were not repeated


def run_rungs(
    recording: PackedTrace,
    spec: RackSpec,
    debugger: Debugger,
    last: int,
    until: str | None = None,
    snapshots: Mapping[int, str] = NO_SNAPSHOTS,
) -> RungsRun:
    """Run a ladder program on recorded inputs up to a row, or until a tag turns on.

    Args:
        snapshots: see `follow`.
    """
    if can_follow(recording, debugger):
        return follow(recording, debugger, last, until, snapshots)
    from ..replay.input_replay import InputReplay  # most recordings need no orders
    from ..replay.replaying import edit_notes
    from ..replay.tag_orders import first_few

    replay, met = InputReplay(spec, recording.slots), False
    replay.attach(debugger)
    for _row in replay.play(recording, last):
        met = until is not None and bool(debugger.tags[until])
        if met:
            break
    departs = None if replay.departs is None else bisect_left(recording.numbers, replay.departs)
    notes = *edit_notes(recording.events), *replay.orders.notes, *first_few(replay.refused)
    return RungsRun(replay.row, met, departs, notes)


def can_follow(recording: PackedTrace, debugger: Debugger) -> bool:
    """Return whether a ladder program depends only on the inputs of a recording."""
    lowered = debugger.engine.lowered
    if debugger.interpreted or lowered.written_inputs or lowered.connections or recording.numbers[0]:
        return False
    if any(is_edit(event) or event.topic in ("/orders", "/forces") for event in recording.events):
        return False
    if not any(flag & UNUSUAL for flag in recording.distinct_flags):
        return True
    # a connection fault counts as set from outside before the next scan
    fault_scans = _link_faults(recording, _fault_tags(debugger)).keys()
    explained_scans = {*fault_scans, *(scan + 1 for scan in fault_scans)}
    return all(
        explained_scans.issuperset(columns.scan[(columns.flags & int(UNUSUAL)) != 0].tolist())
        for columns in recording.scans.chunks()
    )


def follow(
    recording: PackedTrace,
    debugger: Debugger,
    last: int,
    until: str | None = None,
    snapshots: Mapping[int, str] = NO_SNAPSHOTS,
) -> RungsRun:
    """Run a program on recorded inputs up to a row, or until a tag turns on. Requires `can_follow`.

    Args:
        snapshots: snapshots of the recording, by scan. The run begins at the latest one before the row if the
            program then continues as recorded; otherwise, it begins at the first scan.
    """
    inputs = _RecordedInputs(recording, debugger)
    if until is None and snapshots and inputs.are_of_every_scan():
        run = _from_snapshot(inputs, debugger, last, snapshots)
        if run is not None:
            return run
    return _run(inputs, debugger, first=0, last=last, until=until)


def _from_snapshot(
    inputs: _RecordedInputs, debugger: Debugger, last: int, snapshots: Mapping[int, str]
) -> RungsRun | None:
    """Run from the latest snapshot before a row. If that fails, reset the program and return None."""
    memory = debugger.engine.memory
    begin, saved = snapshot(memory), SavedValues(memory)
    run: RungsRun | None = None
    try:
        texts = {scan: text for scan, text in snapshots.items() if 0 < scan <= last}
        values = dict(zip(texts, saved.values_in([*texts.values()]), strict=True))
        past = RecordedPast({0: begin, **values}, inputs.between, inputs.plain, last)
        start = next(past.snapshots(last))
        debugger.go_to(past, start)
        run = _run(inputs, debugger, start, last)
    except (ArithmeticError, LookupError, TypeError, ValueError):
        pass  # no run of the program produces these values, so all scans are run below
    if run is None or run.departs is not None:
        debugger.start_again(begin)
        return None
    return run


def _run(
    inputs: _RecordedInputs, debugger: Debugger, first: int, last: int, until: str | None = None
) -> RungsRun:
    """Run rows `first` to `last`, or until a tag turns on.

    This notes the first row whose outputs differ from the recorded outputs.
    """
    memory, recording = debugger.engine.memory, inputs.recording
    outputs: list[Span] = [
        (memory.cells[leaf.ident].cell_contents.cast("B"), recording.span((int(leaf.slot or 0), "out")))
        for leaf in memory.layout.images
        if leaf.output
    ]
    departs, row = None, -1
    for row, _ in enumerate(debugger.follow(inputs.from_to(first, last)), first):
        if departs is None and inputs.runs and any(cell != inputs.block[span] for cell, span in outputs):
            departs = row
        if until is not None and debugger.tags[until]:
            return RungsRun(row, True, departs)
    return RungsRun(row, False, departs)


class _RecordedInputs:
    """The inputs of the scans: images, and changes in connection faults.

    Attributes:
        block: the memory of the scan that `from_to` yielded last.
        runs: whether the program ran in that scan.
    """

    def __init__(self, recording: PackedTrace, debugger: Debugger) -> None:
        leaves = input_leaves(debugger.engine.memory)
        self.recording = recording
        self._input_spans = [recording.span((int(leaf.slot or 0), "in")) for leaf in leaves]
        self._fault_writes = _link_faults(recording, _fault_tags(debugger))
        self.block, self.runs = b"", False

    def are_of_every_scan(self) -> bool:
        """Return whether the recording has every scan and the program ran in all of them."""
        numbers = self.recording.numbers
        return numbers[-1] == len(numbers) - 1 and all(map(runs_logic, self.recording.distinct_flags))

    def from_to(self, first: int, last: int) -> Iterator[ScanInputs]:
        """Yield the inputs of some rows; set `block` and `runs` with each."""
        for columns in self._columns(first, last):
            for block, inputs in zip(memory_blocks(columns), self._inputs_of(columns), strict=True):
                self.block, self.runs = block, inputs.images is not None
                yield inputs

    def between(self, first: int, last: int) -> Iterator[ScanInputs]:
        """Return the inputs of some rows."""
        return chain.from_iterable(map(self._inputs_of, self._columns(first, last)))

    def _columns(self, first: int, last: int) -> Iterator[Columns]:
        """Yield the columns of some rows, chunk by chunk."""
        for number in range(first // CHUNK_SCANS, last // CHUNK_SCANS + 1):
            start = CHUNK_SCANS * number
            yield self.recording.scans.chunk(number).rows(max(0, first - start), last + 1 - start)

    def plain(self, first: int, last: int) -> PlainInputs | None:
        """Return the inputs of some rows as arrays; None for the first scan or a connection fault.

        All rows must be in one chunk, whose length is a multiple of the distance between snapshots.
        """
        number = first // CHUNK_SCANS
        columns = self.recording.scans.chunk(number)
        rows = slice(first - CHUNK_SCANS * number, last + 1 - CHUNK_SCANS * number)
        if not first or rows.stop > CHUNK_SCANS or any(first <= scan <= last for scan in self._fault_writes):
            return None
        spans = [slice(span.start // 2, span.stop // 2) for span in self._input_spans]
        return PlainInputs(columns.time_ns[rows], tuple(columns.words[rows, span] for span in spans))

    def _inputs_of(self, columns: Columns) -> list[ScanInputs]:
        """Return the inputs of some scans; `images` is None where the program did not run."""
        spans, flags = self._input_spans, columns.flags.tolist()
        # most scans have the same flags
        modes = {flag: (runs_logic(flag), bool(flag & ScanFlag.FIRST_SCAN)) for flag in set(flags)}
        inputs_of_scans = []
        scans = zip(
            memory_blocks(columns), flags, columns.scan.tolist(), columns.time_ns.tolist(), strict=True
        )
        for block, flag, number, now_ns in scans:
            runs, is_first = modes[flag]
            images = [block[span] for span in spans] if runs else None
            writes = self._fault_writes.get(number, ())
            inputs_of_scans.append(
                ScanInputs(now_ns, is_first, images, writes, NO_FORCES if writes else None)
            )
        return inputs_of_scans


def _fault_tags(debugger: Debugger) -> list[Leaf]:
    """Return the tags that are connection faults, such as `axis.I.Fault`."""
    leaves = debugger.engine.lowered.layout.leaves.values()
    return [leaf for leaf in leaves if leaf.slot is not None and not leaf.is_image]


def _link_faults(recording: PackedTrace, leaves: Sequence[Leaf]) -> Mapping[int, tuple[Write, ...]]:
    """Return the connection faults that changed before each scan; -1 means that a module does not answer."""
    writes_by_scan: dict[int, tuple[Write, ...]] = {}
    for leaf in leaves:
        last_value = 0
        for change in link_changes(recording.events, int(leaf.slot or 0)):
            value = 0 if change.good else -1
            if value != last_value:
                writes_by_scan[change.scan] = (*writes_by_scan.get(change.scan, ()), (leaf, 0, value))
            last_value = value
    return writes_by_scan
