"""The bytes of TCP connections in order: retransmitted ones once, early ones after those before them.

    segments   |1..8|      |17..24|9..16|   |9..16|
    bytes      |1..8|             |9..24|             the last one is a retransmission

Bytes that never come, since the capture missed or cut them, are a gap. The other end says so: its next data
acknowledges them. Else what waits after the gap is passed on when too much waits.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from .segments import SYN, End, Segment

CONNECTIONS_MAX = 1024
"""Directions of connections that are followed at once; the longest silent one is forgotten for a new one."""

WAITING_MAX = 64
WAITING_BYTES_MAX = 1 << 20
_RING, _HALF = 1 << 32, 1 << 31


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes of one direction of a connection."""

    at_ns: int  # time of the segment that completed them; after a gap of their own
    source: End
    target: End
    data: bytes
    after_gap: bool  # bytes before them are missing, or the connection is a new one


@dataclass(slots=True)
class _Direction:
    next: int | None = None  # sequence number of the next byte
    waiting: dict[int, tuple[int, bytes]] = field(default_factory=dict)  # time and bytes by sequence number
    fresh: bool = True
    lacking: bool = False  # the bytes before the next one are missing
    passed_ns: int = 0  # time of the bytes before the next one


class Streams:
    """Puts the bytes of connections in order.

    Attributes:
        repeated: bytes that came again, so far.
        gaps: places so far at which bytes are missing.
    """

    def __init__(self) -> None:
        self._directions: OrderedDict[tuple[End, End], _Direction] = OrderedDict()
        self.repeated = self.gaps = 0

    def chunks(self, segments: Iterable[Segment]) -> Iterator[Chunk]:
        """Yield the bytes of segments, as soon as they are in order; at the end those after gaps."""
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
        first = segment.sequence
        if segment.flags & SYN:
            first = (first + 1) % _RING
            self._directions[key] = direction = _Direction(first)
        if not segment.data and not segment.cut:
            return
        if segment.acknowledged is not None:
            yield from self._acknowledge((segment.target, segment.source), segment.acknowledged)
        if direction.next is None:  # the capture began later
            direction.next = first
        if segment.data:
            self._keep(direction, first, at_ns, segment.data)
            yield from self._taken(key, direction)
            while _too_much(direction):
                self._skip_gap(direction)
                yield from self._taken(key, direction)

    def _acknowledge(self, key: tuple[End, End], expected: int) -> Iterator[Chunk]:
        """Yield what waits in a direction before a byte up to which the other end has all."""
        direction = self._directions.get(key)
        while direction and direction.next is not None and 0 < _ahead(expected, direction.next) < _HALF:
            if any(_ahead(expected, first) < _HALF for first in direction.waiting if first != expected):
                self._skip_gap(direction)
            else:
                self._miss(direction, expected)
            yield from self._taken(key, direction)

    def _keep(self, direction: _Direction, first: int, at_ns: int, data: bytes) -> None:
        assert direction.next is not None
        ahead = _ahead(first, direction.next)
        if ahead >= _HALF:  # it begins before the next byte
            old = min(_RING - ahead, len(data))
            self.repeated += old
            first, data = direction.next, data[old:]
        if len(data) > len(direction.waiting.get(first, (0, b""))[1]):
            direction.waiting[first] = at_ns, data

    def _taken(self, key: tuple[End, End], direction: _Direction) -> Iterator[Chunk]:
        """Yield what is next, if it has come: one chunk for all that comes to be in order at a time."""
        data, following = bytearray(), direction.next or 0
        while direction.waiting:
            first = _nearest(direction.waiting, following)
            ahead = _ahead(first, following)
            if 0 < ahead < _HALF:
                break
            at_ns, held = direction.waiting.pop(first)
            if data and at_ns > direction.passed_ns:  # what came later is a chunk of its own
                yield self._chunk(key, direction, data)
                data = bytearray()
            old = (_RING - ahead) % _RING
            self.repeated += min(old, len(held))
            if old < len(held):
                direction.passed_ns = max(direction.passed_ns, at_ns)
                data += held[old:]
                following = direction.next = (following + len(held) - old) % _RING
        if data:
            yield self._chunk(key, direction, data)

    def _chunk(self, key: tuple[End, End], direction: _Direction, data: bytearray) -> Chunk:
        fresh, direction.fresh, direction.lacking = direction.fresh, False, False
        return Chunk(direction.passed_ns, *key, bytes(data), fresh)

    def _skip_gap(self, direction: _Direction) -> None:
        self._miss(direction, _nearest(direction.waiting, direction.next or 0))

    def _miss(self, direction: _Direction, until: int) -> None:
        """Note that the bytes before a sequence number are missing."""
        direction.next = until
        self.gaps += not direction.lacking
        direction.fresh = direction.lacking = True


def _ahead(number: int, following: int) -> int:
    """Return how far a sequence number is ahead of the next one; half of the ring and more is behind."""
    return (number - following) % _RING


def _nearest(waiting: Iterable[int], following: int) -> int:
    """Return the number that comes first, seen from the next one: what is old comes before what is new."""
    return min(waiting, key=lambda each: (each - following + _HALF) % _RING)


def _too_much(direction: _Direction) -> bool:
    waiting = direction.waiting
    return len(waiting) > WAITING_MAX or sum(len(data) for _, data in waiting.values()) > WAITING_BYTES_MAX
