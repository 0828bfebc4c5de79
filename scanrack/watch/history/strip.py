"""Makes the timing strip of rows: bits by their edges, positions as an envelope.

    rows      0 0 0 1 0 0 0 0 1 1 1        edges  (t3, 1) (t4, 0) (t8, 1)

So a pulse of one scan is visible, however many scans a frame has.

A piece of the strip has the times between which it is valid:

    bit        [t, level]                     at each edge
    bit        [t, level, edges]              per stretch of scans, if there are many edges
    position   [t, least, greatest, last]     per stretch of scans
    unknown    [t, None]                      from this time: rows were lost, or there is no position
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.addresses import Address
from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import BitPlace, ModuleWords, Quantity
from scanrack.runtime.live.ring import Rows
from scanrack.traces.read.number_formats import NumberFormats

MOST_EDGES = 400
"""Largest number of edges of one signal in a piece; more are combined into stretches."""

EVERY_BIT = np.uint16(0xFFFF)

CONFIGURES = np.uint16(0x8000)
"""Bit of an image's first word that makes all its words configure [chapter 3, Configuration Mode]."""

Json = dict[str, Any]
Point = list[Any]
Numbers = np.ndarray[Any, np.dtype[np.int64]]
Words = np.ndarray[Any, np.dtype[np.uint16]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]


class PositionPlace(NamedTuple):
    """The place of a position in the memory."""

    slot: int
    quantity: Quantity
    inputs: slice  # the words of its input image


@dataclass(frozen=True, slots=True)
class Signals:
    """The named bits of a rack, by word of its memory.

    Attributes:
        bits: word of the memory -> bit of the word -> name, such as `1.MOVE_COMPLETE`.
        positions: places of positions, by name.
        modes: word of a module with two modes -> the word of its image whose sign bit means configuration.
    """

    bits: Mapping[int, Mapping[int, str]]
    positions: Mapping[str, PositionPlace]
    modes: Mapping[int, int]


def values_at(rows: Rows, layout: MemoryLayout, address: Address) -> NDArray[Any]:
    """Return an image word in each row as an array, or a bit of it as an array of bool."""
    column = layout.places[address.slot].columns(address.image).start + address.word
    words: NDArray[Any] = rows["words"][:, column]
    return words if address.bit is None else (words >> address.bit & 1).astype(bool)


def signals_of(slots: Mapping[int, ModuleWords]) -> Signals:
    """Return the signals of a rack.

    Args:
        slots: words of the rack's modules, in memory order.
    """
    bits: dict[int, dict[int, str]] = {}
    places = memory_layout(slots.items()).places
    for slot, words in slots.items():
        for name, place in _shown_bits(words):
            word = places[slot].columns(place.image).start + place.word
            bits.setdefault(word, {})[place.bit] = f"{slot}.{name}"
    positions = {}
    modes: dict[int, int] = {}
    for slot, words in slots.items():
        position = words.quantity("position")
        if position is not None:
            positions[f"{slot}.position"] = PositionPlace(slot, position, places[slot].columns("I"))
        for image in ("O", "I") if words.modes is not None else ():
            columns = places[slot].columns(image)
            mode = columns.start + (words.modes.word(image) if words.modes else 0)
            modes |= dict.fromkeys(range(columns.start, columns.stop), mode)
    return Signals(bits, positions, modes)


def _shown_bits(words: ModuleWords) -> list[tuple[str, BitPlace]]:
    """Return the bits of a module; if both images have a bit, such as MODE_CONFIG, use the input's."""
    named_bits = [(name, place) for names in words.groups.values() for name, place in names.items()]
    inputs = {name for name, place in named_bits if place.image == "I"}
    return [(name, place) for name, place in named_bits if place.image == "I" or name not in inputs]


def piece_of(
    rows: Rows,
    before: Rows,
    signals: Signals,
    period_ns: int,
    most: int = 1,
    *,
    formats: NumberFormats | None = None,
) -> Json:
    """Return the strip of rows: its valid times `from` and `to`, ns, `bits` and `positions`.

    Args:
        rows: rows in scan order; there may be gaps.
        before: the row before them; if it is empty, the first row begins every signal.
        most: largest number of points of a position, not counting gaps.
        formats: number formats of modules whose configuration selects them.

    Returns:
        The piece; empty if there are no rows. A bit without a point keeps its level.
    """
    if not len(rows):
        return {}
    begins = _begins(rows, before)
    times = rows["now_ns"]
    gaps = [[int(times[place - 1]) + period_ns, None] for place in np.flatnonzero(begins) if place]
    parts = {
        "bits": _edges(rows, before, begins, signals),
        "positions": _positions(rows, begins, signals, most, formats or NumberFormats()),
    }
    if gaps:
        parts = {
            part: {name: sorted([*points, *gaps], key=_time) for name, points in by_name.items()}
            for part, by_name in parts.items()
        }
    return {"from": int(times[0]), "to": int(times[-1]) + period_ns, **parts}


def _time(point: Point) -> int:
    now_ns: int = point[0]
    return now_ns


def _begins(rows: Rows, before: Rows) -> Flags:
    """Return for each row whether its predecessor is missing."""
    scans = rows["scan"].astype(np.int64)
    first = before["scan"][-1:].astype(np.int64) if len(before) else scans[:1] + 1
    begins: Flags = np.diff(scans, prepend=first) != 1
    return begins


def _edges(rows: Rows, before: Rows, begins: Flags, signals: Signals) -> dict[str, list[Point]]:
    """Return the edges of all bits, and their levels after gaps."""
    times = rows["now_ns"]
    edges: dict[str, list[Point]] = {}
    for word, names in signals.bits.items():
        column = _column(rows, word, signals)
        previous = column[:1] if begins[0] else _column(before[-1:], word, signals)
        changed_bits = column ^ np.concatenate([previous, column[:-1]])
        changed_bits[begins] = EVERY_BIT
        places = np.flatnonzero(changed_bits)
        if not len(places):
            continue
        for bit, name in names.items():
            edge_places = places[(changed_bits[places] >> bit & 1).astype(bool)]
            if len(edge_places) > MOST_EDGES:
                edges[name] = _counted(times, (column >> bit & 1).astype(np.int64), begins)
            elif len(edge_places):
                levels = (column[edge_places] >> bit & 1).tolist()
                edges[name] = [
                    [moment, level] for moment, level in zip(times[edge_places].tolist(), levels, strict=True)
                ]
    return edges


def _column(rows: Rows, word: int, signals: Signals) -> Words:
    """Return a word in each row, without bits that have another meaning in configuration mode."""
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
    """Return the points of positions, steps; None where the words mirror a configuration."""
    words, times = rows["words"], rows["now_ns"]
    positions = {}
    scans = rows["scan"].astype(np.int64)
    for name, (slot, quantity, inputs) in signals.positions.items():
        is_position = words[:, signals.modes[inputs.start]] >= 0  # bit 15 means that these words are a mirror
        values = formats.values(slot, quantity, scans, words[:, inputs]).astype(np.int64)
        points = _envelope(times, values, begins | np.diff(is_position, prepend=is_position[:1]), most)
        known_flags = is_position[np.searchsorted(times, [point[0] for point in points])].tolist()
        positions[name] = [
            point if is_known else [point[0], None]
            for point, is_known in zip(points, known_flags, strict=True)
        ]
    return positions


def _counted(times: Numbers, levels: Numbers, begins: Flags) -> list[Point]:
    """Return `[t, level, edges]` of about `MOST_EDGES` stretches; `[t, level]` without edges."""
    starts, ends = _stretches(begins, MOST_EDGES)
    edges = np.diff(levels, prepend=levels[:1]) != 0
    edges[starts] = False
    columns = times[starts], levels[ends - 1], np.add.reduceat(edges.astype(np.int64), starts)
    return [
        [moment, level, *([many] if many else [])]
        for moment, level, many in zip(*(column.tolist() for column in columns), strict=True)
    ]


def _envelope(times: Numbers, values: Numbers, begins: Flags, most: int) -> list[Point]:
    """Return `[t, least, greatest, last]` of about `most` stretches."""
    starts, ends = _stretches(begins, most)
    least, greatest = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    envelope: list[Point] = np.stack((times[starts], least, greatest, values[ends - 1]), axis=1).tolist()
    return envelope


def _stretches(begins: Flags, most: int) -> tuple[Numbers, Numbers]:
    """Return the starts and ends of about `most` stretches; none contains a gap."""
    even = np.linspace(0, len(begins), min(most, len(begins)), endpoint=False).astype(np.int64)
    starts = np.union1d(even, np.flatnonzero(begins))
    return starts, np.append(starts[1:], len(begins))
