"""Puts the bytes of TCP connections in order, drops repeated bytes, and buffers early bytes.

    segments   |1..8|      |17..24|9..16|   |9..16|
    bytes      |1..8|             |9..24|             the last one is a retransmission

Bytes that the capture missed or truncated form a gap. A gap is skipped when the other end acknowledges later
bytes, or when too many bytes are waiting after it.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from .segments import SYN, End, Segment

CONNECTIONS_MAX = 1024
"""Maximum number of connection directions followed; a new direction replaces the longest idle one."""

WAITING_MAX = 64
"""Maximum number of segments waiting in one direction."""

WAITING_BYTES_MAX = 1 << 20
_RING, _HALF = 1 << 32, 1 << 31


@dataclass(frozen=True, slots=True)
class Chunk:
    """Consecutive bytes in one direction of a connection."""

    at_ns: int  # time of the segment that completed them; after a gap, of their own segment
    source: End
    target: End
    data: bytes
    after_gap: bool  # whether bytes before them are missing, or the connection is new


@dataclass(slots=True)
class _Direction:
    """One direction of a connection."""

    next: int | None = None  # sequence number of the next byte; None before the first one
    waiting: dict[int, tuple[int, bytes]] = field(default_factory=dict)  # time and bytes by sequence number
    after_gap: bool = True  # whether the next chunk is after a gap, or the first one
    gap_counted: bool = False  # whether the gap before the next byte is counted
    passed_ns: int = 0  # time of the bytes before the next byte


class Streams:
    """Puts the bytes of many connections in order.

    Attributes:
        repeated: number of repeated bytes, so far.
        gaps: number of gaps, so far.
    """

    def __init__(self) -> None:
        self._directions: OrderedDict[tuple[End, End], _Direction] = OrderedDict()
        self.repeated = self.gaps = 0

    def chunks(self, segments: Iterable[Segment]) -> Iterator[Chunk]:
        """Yield the bytes of segments as soon as they are in order; at the end, the bytes after gaps."""
        latest_ns = 0
        for segment in segments:
            latest_ns = max(latest_ns, segment.at_ns)
            yield from self._add(segment, latest_ns)
        for key, direction in self._directions.items():
            while direction.waiting:
                self._skip_gap(direction)
                yield from self._take_chunks(key, direction)

    def _add(self, segment: Segment, at_ns: int) -> Iterator[Chunk]:
        """Add a segment; yield the bytes now in order, including the bytes that it acknowledges."""
        key = segment.source, segment.target
        direction = self._directions.setdefault(key, _Direction())
        self._directions.move_to_end(key)
        if len(self._directions) > CONNECTIONS_MAX:
            self._directions.popitem(last=False)
        first_byte = segment.sequence
        if segment.flags & SYN:  # a new connection; SYN itself takes one number
            first_byte = (first_byte + 1) % _RING
            self._directions[key] = direction = _Direction(first_byte)
        if not segment.data and not segment.cut:
            return
        if segment.acknowledged is not None:
            yield from self._acknowledge((segment.target, segment.source), segment.acknowledged)
        if direction.next is None:  # the capture began after the connection
            direction.next = first_byte
        if segment.data:
            self._store(direction, first_byte, at_ns, segment.data)
            yield from self._take_chunks(key, direction)
            while _is_full(direction):
                self._skip_gap(direction)
                yield from self._take_chunks(key, direction)

    def _acknowledge(self, key: tuple[End, End], expected: int) -> Iterator[Chunk]:
        """Yield the bytes waiting in a direction before `expected`, which the other end has received."""
        direction = self._directions.get(key)
        while direction and direction.next is not None and 0 < _ahead(expected, direction.next) < _HALF:
            if any(0 < _ahead(expected, first_byte) < _HALF for first_byte in direction.waiting):
                self._skip_gap(direction)
            else:
                self._note_gap(direction, expected)
            yield from self._take_chunks(key, direction)

    def _store(self, direction: _Direction, first: int, at_ns: int, data: bytes) -> None:
        """Store bytes that must wait, except bytes that were already yielded."""
        assert direction.next is not None
        ahead = _ahead(first, direction.next)
        if ahead >= _HALF:  # the data begin before the next byte
            old_bytes = min(_RING - ahead, len(data))
            self.repeated += old_bytes
            first, data = direction.next, data[old_bytes:]
        if len(data) > len(direction.waiting.get(first, (0, b""))[1]):
            direction.waiting[first] = at_ns, data

    def _take_chunks(self, key: tuple[End, End], direction: _Direction) -> Iterator[Chunk]:
        """Yield the waiting bytes that are now in order; bytes completed at the same time are one chunk."""
        data, next_sequence = bytearray(), direction.next or 0
        while direction.waiting:
            first_byte = _nearest(direction.waiting, next_sequence)
            ahead = _ahead(first_byte, next_sequence)
            if 0 < ahead < _HALF:
                break
            at_ns, waiting_data = direction.waiting.pop(first_byte)
            if data and at_ns > direction.passed_ns:  # later bytes are a chunk of their own
                yield self._chunk(key, direction, data)
                data = bytearray()
            old_bytes = (_RING - ahead) % _RING
            self.repeated += min(old_bytes, len(waiting_data))
            if old_bytes < len(waiting_data):
                direction.passed_ns = max(direction.passed_ns, at_ns)
                data += waiting_data[old_bytes:]
                next_sequence = direction.next = (next_sequence + len(waiting_data) - old_bytes) % _RING
        if data:
            yield self._chunk(key, direction, data)

    def _chunk(self, key: tuple[End, End], direction: _Direction, data: bytearray) -> Chunk:
        """Return bytes as a chunk; mark the direction's next chunk as having no gap before it."""
        after_gap, direction.after_gap, direction.gap_counted = direction.after_gap, False, False
        return Chunk(direction.passed_ns, *key, bytes(data), after_gap)

    def _skip_gap(self, direction: _Direction) -> None:
        """Skip the gap before the first waiting bytes."""
        self._note_gap(direction, _nearest(direction.waiting, direction.next or 0))

    def _note_gap(self, direction: _Direction, end: int) -> None:
        """Skip to a sequence number and record the missing bytes before it as a gap."""
        direction.next = end
        self.gaps += not direction.gap_counted
        direction.after_gap = direction.gap_counted = True


def _ahead(number: int, following: int) -> int:
    """Return how far a sequence number is ahead of another; `_HALF` or more means that it is behind."""
    return (number - following) % _RING


def _nearest(waiting: Iterable[int], following: int) -> int:
    """Return the first of the waiting sequence numbers; numbers before `following` count as earlier."""
    return min(waiting, key=lambda number: (number - following + _HALF) % _RING)


def _is_full(direction: _Direction) -> bool:
    """Return whether too many segments or bytes are waiting."""
    waiting_bytes = sum(len(data) for _, data in direction.waiting.values())
    return len(direction.waiting) > WAITING_MAX or waiting_bytes > WAITING_BYTES_MAX
