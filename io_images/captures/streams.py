"""Puts the bytes of TCP connections in order: retransmitted bytes occur once, and early bytes wait.

    segments   |1..8|      |17..24|9..16|   |9..16|
    bytes      |1..8|             |9..24|             the last one is a retransmission

Bytes that the capture missed or cut are a gap, which the other end reveals: its next segment
acknowledges them. Otherwise the bytes after a gap are passed on when too many are waiting.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from .segments import SYN, End, Segment

CONNECTIONS_MAX = 1024
"""Maximum directions of connections followed at once; a new one replaces the one silent the longest."""

WAITING_MAX = 64
WAITING_BYTES_MAX = 1 << 20
_RING, _HALF = 1 << 32, 1 << 31


@dataclass(frozen=True, slots=True)
class Chunk:
    """Successive bytes in one direction of a connection."""

    at_ns: int  # time of the segment that completed them; after a gap, of their own segment
    source: End
    target: End
    data: bytes
    after_gap: bool  # whether bytes before them are missing, or the connection is new


@dataclass(slots=True)
class _Direction:
    next: int | None = None  # sequence number of the next byte
    waiting: dict[int, tuple[int, bytes]] = field(default_factory=dict)  # time and bytes by sequence number
    fresh: bool = True
    lacking: bool = False  # whether the bytes before the next one are missing
    passed_ns: int = 0  # time of the bytes before the next one


class Streams:
    """Puts the bytes of many connections in order.

    Attributes:
        repeated: number of repeated bytes so far.
        gaps: number of places so far with missing bytes.
    """

    def __init__(self) -> None:
        self._directions: OrderedDict[tuple[End, End], _Direction] = OrderedDict()
        self.repeated = self.gaps = 0

    def chunks(self, segments: Iterable[Segment]) -> Iterator[Chunk]:
        """Yield the bytes of segments as soon as they are in order; at the end, yield bytes after gaps."""
        latest_ns = 0
        for segment in segments:
            latest_ns = max(latest_ns, segment.at_ns)
            yield from self._add(segment, latest_ns)
        for key, direction in self._directions.items():
            while direction.waiting:
                self._skip_gap(direction)
                yield from self._taken(key, direction)

    def _add(self, segment: Segment, at_ns: int) -> Iterator[Chunk]:
        key = segment.source, segment.target
        direction = self._directions.setdefault(key, _Direction())
        self._directions.move_to_end(key)
        if len(self._directions) > CONNECTIONS_MAX:
            self._directions.popitem(last=False)
        first_byte = segment.sequence
        if segment.flags & SYN:
            first_byte = (first_byte + 1) % _RING
            self._directions[key] = direction = _Direction(first_byte)
        if not segment.data and not segment.cut:
            return
        if segment.acknowledged is not None:
            yield from self._acknowledge((segment.target, segment.source), segment.acknowledged)
        if direction.next is None:  # the capture began after the connection
            direction.next = first_byte
        if segment.data:
            self._keep(direction, first_byte, at_ns, segment.data)
            yield from self._taken(key, direction)
            while _too_much(direction):
                self._skip_gap(direction)
                yield from self._taken(key, direction)

    def _acknowledge(self, key: tuple[End, End], expected: int) -> Iterator[Chunk]:
        """Yield the waiting bytes in a direction up to `expected`, which the other end has acknowledged."""
        direction = self._directions.get(key)
        while direction and direction.next is not None and 0 < _ahead(expected, direction.next) < _HALF:
            if any(
                _ahead(expected, first_byte) < _HALF
                for first_byte in direction.waiting
                if first_byte != expected
            ):
                self._skip_gap(direction)
            else:
                self._miss(direction, expected)
            yield from self._taken(key, direction)

    def _keep(self, direction: _Direction, first: int, at_ns: int, data: bytes) -> None:
        assert direction.next is not None
        ahead = _ahead(first, direction.next)
        if ahead >= _HALF:  # the data begin before the next byte
            old_bytes = min(_RING - ahead, len(data))
            self.repeated += old_bytes
            first, data = direction.next, data[old_bytes:]
        if len(data) > len(direction.waiting.get(first, (0, b""))[1]):
            direction.waiting[first] = at_ns, data

    def _taken(self, key: tuple[End, End], direction: _Direction) -> Iterator[Chunk]:
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
        is_fresh, direction.fresh, direction.lacking = direction.fresh, False, False
        return Chunk(direction.passed_ns, *key, bytes(data), is_fresh)

    def _skip_gap(self, direction: _Direction) -> None:
        self._miss(direction, _nearest(direction.waiting, direction.next or 0))

    def _miss(self, direction: _Direction, until: int) -> None:
        """Note that the bytes before a sequence number are missing."""
        direction.next = until
        self.gaps += not direction.lacking
        direction.fresh = direction.lacking = True


def _ahead(number: int, following: int) -> int:
    """Return how far a sequence number is ahead of the next one; half of the ring or more means behind."""
    return (number - following) % _RING


def _nearest(waiting: Iterable[int], following: int) -> int:
    """Return the first of the waiting sequence numbers; numbers before `following` come before later ones."""
    return min(waiting, key=lambda number: (number - following + _HALF) % _RING)


def _too_much(direction: _Direction) -> bool:
    waiting_chunks = direction.waiting
    return (
        len(waiting_chunks) > WAITING_MAX
        or sum(len(data) for _, data in waiting_chunks.values()) > WAITING_BYTES_MAX
    )
