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

READ_SCANS = 2
"""Number of scans before the last one whose reads also show the program's dependencies."""

_INT16 = -(2**15), 2**15 - 1


class ProgramTrials:
    """Tries different inputs on a Python program.

    Args:
        row: row of the scan after which the inputs change.
        terminal: names terminals; inputs without a name are status words of modules.
        scans: maximum number of scans in a try, up to 255.
    """

    def __init__(
        self, recording: PackedTrace, row: int, spec: RackSpec, load: Load, terminal: Terminal, scans: int
    ) -> None:
        self._recording, self._row, self._spec, self._load = recording, row, spec, load
        self._terminal, self._scans = terminal, scans
        self._replay: InputReplay  # of the present run

    def of(
        self, text: str, watched: Watched, requested: Value | None, name: Callable[[Bits], str]
    ) -> Remedies:
        """Return the smallest sets of inputs that change a value of the program to the requested value.

        Args:
            watched: makes the reader of the value.
            requested: the requested value; None for the opposite value of a bit.
            name: returns the name of an input.

        Raises:
            ValueError: the value is not a bit and none is requested, or the program ends before that scan.
        """
        with fresh(self._load) as logic:
            reads, read = Reads(), watched(logic)
            rows = self._rows(logic, reads)
            if all(row != self._row for row in rows):
                raise ValueError(f"{text} can't be tried: the program ends before this scan")
            value = read()
            if requested is None and not isinstance(value, bool):
                raise ValueError(f"{text} is {value!r}: give the value that it should have")
            target = (not value) if requested is None else requested

            def attempt(changes: Sequence[InputChange]) -> int | None:
                if not can_copy():
                    return self._try_from_start(changes, watched, target)
                scans = in_copy(lambda: str(self._scans_with(changes, rows, read, target) or ""))
                return int(scans) if scans else None

            search = Search(text, target, attempt)
            terminals, reported = self._candidates(reads.masks, target, name)
            result = search.among(terminals)
            return result if result.found or not reported else search.among([*terminals, *reported])

    def _scans_with(
        self, changes: Sequence[InputChange], rows: Iterator[int], read: Callable[[], Any], target: Value
    ) -> int | None:
        """Run more scans with changed inputs; return the number of scans to reach the value, or None."""
        past = Past(self._recording, self._row)
        for slot in {change.cell.slot for change in changes}:
            self._replay.replace_inputs(slot, _image(past, slot, changes))
        return next((row - self._row for row in rows if read() == target), None)

    def _try_from_start(self, changes: Sequence[InputChange], watched: Watched, target: Value) -> int | None:
        """Do the same as `_scans_with`, but with a reloaded program that runs from the start."""
        present = self._replay
        try:
            with fresh(self._load) as logic:
                read, rows = watched(logic), self._rows(logic, Reads())
                is_reached = any(row == self._row for row in rows)
                return self._scans_with(changes, rows, read, target) if is_reached else None
        finally:
            self._replay = present

    def _rows(self, logic: ScanLogic, reads: Reads) -> Iterator[int]:
        """Start a replay of a program, kept in `_replay`; yield the row after each scan.

        The reads of the last scans up to the row of the question are noted.
        """

        def call(program: ScanLogic, scan: LogicScan) -> None:
            reads.on = replay.row >= self._row - READ_SCANS
            try:
                program(scan)
            finally:
                reads.on = False

        recording = _extended(self._recording, self._row, self._scans)
        self._replay = replay = InputReplay(self._spec, recording.slots, call=call, edited=self._load.edited)
        reads.watch(replay.view.slot)
        replay.attach(logic)
        return replay.play(recording, 1 << 62)  # to the end of the recording

    def block(self) -> bytes:
        """Return the rack's current memory block in this run."""
        return self._replay.block()

    def _candidates(
        self, masks: Mapping[tuple[int, int], int], target: Value, name: Callable[[Bits], str]
    ) -> tuple[list[Candidate], list[Candidate]]:
        """Return the inputs in the first `MOST_CANDIDATES` words that the program has read.

        Returns:
            Terminals, and status bits and words of modules.
        """
        constants = [*_constants(self._load)] + ([] if isinstance(target, bool) else [float(target)])
        past = Past(self._recording, self._row)
        terminals: list[Candidate] = []
        reported: list[Candidate] = []
        for bits in read_bits(list(masks.items())[:MOST_CANDIDATES]):
            bit_number, value = bits.address.bit, past.words(bits.slot, "in", self._row)[bits.word]
            terminal = self._terminal(bits.slot, bits.word, bit_number)
            source = terminal or f"slot {bits.slot}, as the module reports it"
            input_name = name(bits)
            if bit_number is None:
                candidate = number(bits, input_name, source, value, limits=_INT16, compared=constants)
            else:
                candidate = bit(bits, input_name, source, bool(value & bits.mask))
            (terminals if terminal else reported).append(candidate)
        return terminals, reported


def _extended(recording: PackedTrace, row: int, scans: int) -> PackedTrace:
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
