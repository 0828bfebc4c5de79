"""Finds inputs that would change a value of a Python program.

    recorded inputs ... scan 741 | copy 1: scans 742 to 751 with start on
                                 | copy 2: ... with guard off

A Python program can't be copied, but its process can: each try is a fork of the process at that scan. On a
system without fork, each try runs the program from the start.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from scanrack.ladder.debug.remedies import (
    MOST_CANDIDATES,
    Candidate,
    InputChange,
    Remedies,
    Search,
    bit,
    number,
)
from scanrack.ladder.state.memory import Value
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.scan import LogicScan, ScanLogic
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.replay import PackedTrace

from ..replay.input_replay import InputReplay
from .bits import Bits, read_bits
from .copies import can_copy, in_copy
from .past import ALL_BITS, Past
from .source.input_reads import Reads
from .traced_run import Load, Watched, fresh

Terminal = Callable[[int, int, int | None], str | None]
"""Names the terminal at slot, word and bit (None: the whole word); returns None if it is not a terminal."""

LAST = 2
"""Number of scans before the one in question whose reads also show what the program depends on."""

_INT16 = -(2**15), 2**15 - 1


class ProgramTrials:
    """Tries other inputs on a Python program.

    Args:
        row: the scan of the question.
        terminal: distinguishes terminals from what modules report.
        scans: maximum scans of a try, up to 255.
    """

    def __init__(
        self, recording: PackedTrace, row: int, spec: RackSpec, load: Load, terminal: Terminal, scans: int
    ) -> None:
        self._recording, self._row, self._spec, self._load = recording, row, spec, load
        self._terminal, self._scans = terminal, scans
        self._watched: Watched
        self._target: Value = False
        self._replay: InputReplay

    def of(
        self, text: str, watched: Watched, requested: Value | None, name: Callable[[Bits], str]
    ) -> Remedies:
        """Return the smallest sets of inputs after which a value of the program is as requested.

        Args:
            watched: reads the value.
            requested: the requested value; None for the opposite value of a bit.
            name: returns the name of an input.

        Raises:
            ValueError: the value is not a bit and none is requested, or the program ends before that scan.
        """
        self._watched = watched
        with fresh(self._load) as logic:
            reads, read = Reads(), watched(logic)
            rows = self._rows(logic, reads)
            if all(row != self._row for row in rows):
                raise ValueError(f"the program ends before the scan in question: {text} can't be tried")
            value = read()
            if requested is None and not isinstance(value, bool):
                raise ValueError(f"{text} is {value!r}: give the value that it should have")
            self._target = (not value) if requested is None else requested

            def attempt(changes: Sequence[InputChange]) -> int | None:
                if not can_copy():
                    return self._try_from_start(changes)
                scans = in_copy(lambda: str(self._scans_with(changes, rows, read) or ""))
                return int(scans) if scans else None

            search = Search(text, self._target, attempt)
            terminals, reported = self._candidates(reads.masks, self._target, name)
            result = search.among(terminals)
            return result if result.found or not reported else search.among([*terminals, *reported])

    def _scans_with(
        self, changes: Sequence[InputChange], rows: Iterator[int], read: Callable[[], Any]
    ) -> int | None:
        """Run the scans after the one in question with changed inputs, until the value is as requested.

        Returns:
            Their number; None if it never is.
        """
        past = Past(self._recording, self._row)
        for slot in {change.cell.slot for change in changes}:
            self._replay.hold(slot, _image(past, slot, changes))
        return next((row - self._row for row in rows if read() == self._target), None)

    def _try_from_start(self, changes: Sequence[InputChange]) -> int | None:
        """Do as `_scans_with`, with a program that runs from the start."""
        present = self._replay
        try:
            with fresh(self._load) as logic:
                read, rows = self._watched(logic), self._rows(logic, Reads())
                is_there = any(row == self._row for row in rows)
                return self._scans_with(changes, rows, read) if is_there else None
        finally:
            self._replay = present

    def _rows(self, logic: ScanLogic, reads: Reads) -> Iterator[int]:
        """Run a program, and yield the row of each scan after it; note what it reads in the last ones."""

        def call(program: ScanLogic, scan: LogicScan) -> None:
            reads.on = replay.row >= self._row - LAST
            try:
                program(scan)
            finally:
                reads.on = False

        recording = _longer(self._recording, self._row, self._scans)
        self._replay = replay = InputReplay(self._spec, recording.slots, call=call, edited=self._load.edited)
        reads.watch(replay.view.slot)
        replay.attach(logic)
        return replay.play(recording, 1 << 62)

    def block(self) -> bytes:
        """Return the rack's present memory block in this run."""
        return self._replay.block()

    def _candidates(
        self, masks: Mapping[tuple[int, int], int], wish: Value, name: Callable[[Bits], str]
    ) -> tuple[list[Candidate], list[Candidate]]:
        """Return the inputs that the program has read: first terminals, then what modules report."""
        constants = [*_constants(self._load)] + ([] if isinstance(wish, bool) else [float(wish)])
        past = Past(self._recording, self._row)
        own: list[Candidate] = []
        reported: list[Candidate] = []
        for bits in read_bits(list(masks.items())[:MOST_CANDIDATES]):
            bit_number, value = bits.address.bit, past.words(bits.slot, "in", self._row)[bits.word]
            place = self._terminal(bits.slot, bits.word, bit_number)
            source = place or f"slot {bits.slot}, as the module reports it"
            named = name(bits)
            if bit_number is None:
                candidate = number(bits, named, source, value, _INT16, constants)
            else:
                candidate = bit(bits, named, source, bool(value & bits.mask))
            (own if place else reported).append(candidate)
        return own, reported


def _longer(recording: PackedTrace, row: int, scans: int) -> PackedTrace:
    """Return a recording up to a scan, with that scan repeated several times."""
    columns = recording.columns.rows(0, row + 1)
    last = columns.rows(row, row + 1)
    period_ns = int(columns.time_ns[-1] - columns.time_ns[-2]) if row else 1_000_000
    columns_after = [
        last._replace(scan=last.scan + count, time_ns=last.time_ns + count * period_ns)
        for count in range(1, scans + 1)
    ]
    events = tuple(event for event in recording.events if event.scan <= recording.numbers[row])
    return PackedTrace(
        recording.slots, PackedScans.of(recording.layout.words, [columns, *columns_after]), events
    )


def _image(past: Past, slot: int, changes: Sequence[InputChange]) -> bytes:
    """Return an input image with some inputs changed."""
    words = [word & ALL_BITS for word in past.words(slot, "in", past.row)]
    for change in changes:
        bits: Bits = change.cell
        if bits.slot == slot and bits.address.bit is None:
            words[bits.word] = int(change.value) & ALL_BITS
        elif bits.slot == slot:
            words[bits.word] = words[bits.word] | bits.mask if change.value else words[bits.word] & ~bits.mask
    return b"".join(word.to_bytes(2, "little") for word in words)


def _constants(load: Load) -> Iterator[float]:
    """Yield the numbers that the program's file uses in comparisons."""
    for node in ast.walk(ast.parse(load.program.read_bytes())):
        for child in ast.walk(node) if isinstance(node, ast.Compare) else ():
            value = child.value if isinstance(child, ast.Constant) else None
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                yield value
