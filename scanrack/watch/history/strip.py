"""The timing strip of rows, which shows the edges of bits and the envelopes of positions.

    rows      0 0 0 1 0 0 0 0 1 1 1        edges  (t3, 1) (t4, 0) (t8, 1)

A one-scan pulse is visible no matter how many scans a frame has.

A piece of the strip has the times between which its points are valid:

    bit        [t, level]                     at each edge
    bit        [t, level, edges]              per stretch of scans, if there are many edges
    position   [t, least, greatest, last]     per stretch of scans
    unknown    [t, None]                      from this time on, rows were lost or there is no position
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.addresses import Address
from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import BitPlace, ModuleWords, Quantity
from scanrack.runtime.live.ring import Rows
from scanrack.traces.read.number_formats import NumberFormats

MOST_EDGES = 400
"""Maximum number of edges of a signal in a piece. More edges are combined into stretches."""

EVERY_BIT = np.uint16(0xFFFF)

CONFIGURES = np.uint16(0x8000)
"""Bit of an image's first word that selects configuration mode [chapter 3, Configuration Mode]."""

Json = dict[str, Any]
Point = list[Any]
Numbers = np.ndarray[Any, np.dtype[np.int64]]
Words = np.ndarray[Any, np.dtype[np.uint16]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]


class PositionPlace(NamedTuple):
    """The location of a position in the rack's memory."""

    slot: int
    quantity: Quantity
    inputs: slice  # the words of the module's input image


@dataclass(frozen=True, slots=True)
class Signals:
    """The named bits of a rack, by word of its memory.

    Attributes:
        bits: word of the memory -> bit of the word -> name, such as `1.MOVE_COMPLETE`.
        positions: locations of positions, by name.
        modes: word of a module that has a configuration mode -> the word of its image whose sign bit is the
            mode.
    """

    bits: Mapping[int, Mapping[int, str]]
    positions: Mapping[str, PositionPlace]
    modes: Mapping[int, int]


def values_at(rows: Rows, layout: MemoryLayout, address: Address) -> NDArray[Any]:
    """Return an image word of each row as an array, or a bit of it as an array of bool."""
    column = layout.places[address.slot].columns(address.image).start + address.word
    words: NDArray[Any] = rows["words"][:, column]
    return words if address.bit is None else (words >> address.bit & 1).astype(bool)


def signals_of(slots: Mapping[int, ModuleWords]) -> Signals:
    """Return the signals of a rack.

    Args:
        slots: words of the rack's modules, in memory order.
    """
    bits: dict[int, dict[int, str]] = {}
    images = memory_layout(slots.items()).places
    for slot, words in slots.items():
        for name, bit_place in _shown_bits(words):
            word = images[slot].columns(bit_place.image).start + bit_place.word
            bits.setdefault(word, {})[bit_place.bit] = f"{slot}.{name}"
    positions = {}
    modes: dict[int, int] = {}
    for slot, words in slots.items():
        position = words.quantity("position")
        if position is not None:
            positions[f"{slot}.position"] = PositionPlace(slot, position, images[slot].columns("I"))
        if words.modes is not None:
            for image in ("O", "I"):
                columns = images[slot].columns(image)
                mode = columns.start + words.modes.word(image)
                modes |= dict.fromkeys(range(columns.start, columns.stop), mode)
    return Signals(bits, positions, modes)


def _shown_bits(words: ModuleWords) -> list[tuple[str, BitPlace]]:
    """Return a module's bits; if both images have a bit, such as MODE_CONFIG, use the input bit."""
    named_bits = [(name, place) for names in words.groups.values() for name, place in names.items()]
    inputs = {name for name, place in named_bits if place.image == "I"}
    return [(name, place) for name, place in named_bits if place.image == "I" or name not in inputs]


def piece_of(
    rows: Rows,
    previous: Rows,
    signals: Signals,
    period_ns: int,
    most: int = 1,
    *,
    formats: NumberFormats | None = None,
) -> Json:
    """Return a piece of the strip: its times `from` and `to`, ns, `bits` and `positions`.

    Args:
        rows: rows in scan order; there may be gaps.
        previous: the row before them; if empty, every signal starts with the first row.
        most: maximum number of points per position, not counting gaps.
        formats: number formats of modules whose configuration selects them.

    Returns:
        The piece; empty without rows. A bit without a point keeps its level.
    """
    if not len(rows):
        return {}
    begins = _begins(rows, previous)
    times = rows["now_ns"]
    bits = _edges(rows, previous, begins, signals)
    positions = _positions(rows, begins, signals, most, formats or NumberFormats())
    gaps = [[int(times[index - 1]) + period_ns, None] for index in np.flatnonzero(begins) if index]
    for lanes in (bits, positions) if gaps else ():
        for points in lanes.values():
            points += gaps
            points.sort(key=itemgetter(0))
    return {"from": int(times[0]), "to": int(times[-1]) + period_ns, "bits": bits, "positions": positions}


def _begins(rows: Rows, previous: Rows) -> Flags:
    """Return for each row whether its predecessor is missing."""
    scans = rows["scan"].astype(np.int64)
    predecessor = previous["scan"][-1:].astype(np.int64) if len(previous) else scans[:1] + 1
    begins: Flags = np.diff(scans, prepend=predecessor) != 1
    return begins


def _edges(rows: Rows, previous: Rows, begins: Flags, signals: Signals) -> dict[str, list[Point]]:
    """Return the edges of all bits, and their levels after gaps."""
    times = rows["now_ns"]
    edges: dict[str, list[Point]] = {}
    for word, names in signals.bits.items():
        column = _column(rows, word, signals)
        first = column[:1] if begins[0] else _column(previous[-1:], word, signals)
        changed_bits = column ^ np.concatenate([first, column[:-1]])
        changed_bits[begins] = EVERY_BIT
        changed_rows = np.flatnonzero(changed_bits)
        if not len(changed_rows):
            continue
        for bit, name in names.items():
            edge_rows = changed_rows[(changed_bits[changed_rows] >> bit & 1).astype(bool)]
            if len(edge_rows) > MOST_EDGES:
                edges[name] = _counted(times, (column >> bit & 1).astype(np.int64), begins)
            elif len(edge_rows):
                levels = (column[edge_rows] >> bit & 1).tolist()
                edges[name] = list(map(list, zip(times[edge_rows].tolist(), levels, strict=True)))
    return edges


def _column(rows: Rows, word: int, signals: Signals) -> Words:
    """Return a word from each row, without bits that have a different meaning in configuration mode."""
    words = rows["words"].view(np.uint16)
    column = words[:, word]
    mode = signals.modes.get(word)
    if mode is None:
        return column
    mask = CONFIGURES if word == mode else np.uint16(0)
    return np.where(words[:, mode] & CONFIGURES, column & mask, column)


def _positions(
    rows: Rows, begins: Flags, signals: Signals, most: int, formats: NumberFormats
) -> dict[str, list[Point]]:
    """Return the points of positions, in steps; None while the words mirror a configuration."""
    words, times = rows["words"], rows["now_ns"]
    positions = {}
    scans = rows["scan"].astype(np.int64)
    for name, (slot, quantity, inputs) in signals.positions.items():
        is_position = words[:, signals.modes[inputs.start]] >= 0  # bit 15 = the words mirror a configuration
        values = formats.values(slot, quantity, scans, words[:, inputs]).astype(np.int64)
        points = _envelope(times, values, begins | np.diff(is_position, prepend=is_position[:1]), most)
        is_known = is_position[np.searchsorted(times, [point[0] for point in points])].tolist()
        positions[name] = [
            point if known else [point[0], None] for point, known in zip(points, is_known, strict=True)
        ]
    return positions


def _counted(times: Numbers, levels: Numbers, begins: Flags) -> list[Point]:
    """Return `[t, level, edges]` of about `MOST_EDGES` stretches; `[t, level]` if without edges."""
    starts, ends = _stretches(begins, MOST_EDGES)
    edges = np.diff(levels, prepend=levels[:1]) != 0
    edges[starts] = False
    columns = times[starts], levels[ends - 1], np.add.reduceat(edges.astype(np.int64), starts)
    return [
        [moment, level, edge_count] if edge_count else [moment, level]
        for moment, level, edge_count in zip(*(column.tolist() for column in columns), strict=True)
    ]


def _envelope(times: Numbers, values: Numbers, begins: Flags, most: int) -> list[Point]:
    """Return `[t, least, greatest, last]` of about `most` stretches."""
    starts, ends = _stretches(begins, most)
    least, greatest = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    envelope: list[Point] = np.stack((times[starts], least, greatest, values[ends - 1]), axis=1).tolist()
    return envelope


def _stretches(begins: Flags, most: int) -> tuple[Numbers, Numbers]:
    """Return the starts and ends of about `most` stretches without gaps."""
    even = np.linspace(0, len(begins), min(most, len(begins)), endpoint=False).astype(np.int64)
    starts = np.union1d(even, np.flatnonzero(begins))
    return starts, np.append(starts[1:], len(begins))
