"""Reads the scans of a recording one by one, and creates a rack with its slots."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from scanrack.io_images.module_words import ModuleWords
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.module import Module
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.packed import CHUNK_SCANS
from scanrack.traces.replay import PackedTrace

from .building import round_trip_ms


class RecordedScan(NamedTuple):
    """A recorded scan."""

    number: int
    now_ns: int
    flags: int
    memory: bytes  # the rack's memory block after the scan


as_scan: Callable[[Any], RecordedScan] = partial(tuple.__new__, RecordedScan)
"""Converts a tuple to a scan; faster than `RecordedScan._make`."""


def recorded_scans(recording: PackedTrace, row: int, last: int) -> Iterator[RecordedScan]:
    """Yield the scans of a recording from row `row` to row `last`, inclusive."""
    while row <= last:
        columns = recording.scans.chunk(row // CHUNK_SCANS)
        start = row % CHUNK_SCANS
        count = min(len(columns.scan), last + 1 - row + start)
        if start >= count:
            return
        words, size = columns.words[start:count].tobytes(), 2 * columns.words.shape[1]
        blocks = (words[offset : offset + size] for offset in range(0, len(words), size))
        heads = (column[start:count].tolist() for column in (columns.scan, columns.time_ns, columns.flags))
        yield from map(as_scan, zip(*heads, blocks, strict=True))
        row += count - start


def recorded_words(slots: Iterable[SlotInfo], spec: RackSpec | None) -> dict[int, ModuleWords]:
    """Return the words of recorded slots by number, with the rack's names if its words are equal."""
    rack_words = {slot.number: slot.words for slot in (spec.slot if spec else ())}
    return {
        slot.number: rack_words[slot.number] if rack_words.get(slot.number) == slot.words else slot.words
        for slot in slots
    }


def recorded_rack(slots: Iterable[SlotInfo], spec: RackSpec, modules: Mapping[int, Module]) -> Rack:
    """Return a rack with the modules of a recording."""
    slots = tuple(slots)
    words = recorded_words(slots, spec)
    trips = {slot.number: round_trip_ms(spec, slot) for slot in spec.slot}
    return Rack(
        Card(
            slot.number,
            modules[slot.number],
            catalog=slot.module,
            firmware=slot.firmware,
            words=words[slot.number],
            round_trip_ms=trips.get(slot.number, 0),
        )
        for slot in slots
    )
