"""The bytes of TCP connections in order: retransmitted ones once, early ones after those before them.

    segments   |1..8|      |17..24|9..16|   |9..16|
    bytes      |1..8|             |9..24|             the last one is a retransmission

Bytes that never come, since the capture missed them, are a gap: what waits behind it is passed on with a note
when too much waits.
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

    at_ns: int  # time of the segment that completed them
    source: End
    target: End
    data: bytes
    after_gap: bool  # bytes before them are missing, or the connection is a new one


@dataclass(slots=True)
class _Direction:
    next: int | None = None  # sequence number of the next byte
    waiting: dict[int, bytes] = field(default_factory=dict)
    fresh: bool = True


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
        """Yield the bytes of segments, as soon as they are in order; at the end those behind gaps."""
        latest_ns = 0
        for segment in segments:
            latest_ns = max(latest_ns, segment.at_ns)
            yield from self._add(segment, latest_ns)
        for key, direction in self._directions.items():
            while direction.waiting:
                self._skip_gap(direction)
                yield from self._taken(key, direction, latest_ns)

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
        if not segment.data:
            return
        if direction.next is None:  # the capture began later
            direction.next = first
        self._keep(direction, first, segment.data)
        yield from self._taken(key, direction, at_ns)
        while _too_much(direction):
            self._skip_gap(direction)
            yield from self._taken(key, direction, at_ns)

    def _keep(self, direction: _Direction, first: int, data: bytes) -> None:
        assert direction.next is not None
        ahead = (first - direction.next) % _RING
        if ahead >= _HALF:  # it begins before the next byte
            old = min(_RING - ahead, len(data))
            self.repeated += old
            first, data = direction.next, data[old:]
        if len(data) > len(direction.waiting.get(first, b"")):
            direction.waiting[first] = data

    def _taken(self, key: tuple[End, End], direction: _Direction, at_ns: int) -> Iterator[Chunk]:
        """Yield what is next, if it has come."""
        data, following = bytearray(), direction.next or 0
        while direction.waiting:
            first = _nearest(direction.waiting, following)
            ahead = (first - following) % _RING
            if 0 < ahead < _HALF:
                break
            held = direction.waiting.pop(first)
            old = (_RING - ahead) % _RING
            self.repeated += min(old, len(held))
            data += held[old:]
            following = (following + len(held[old:])) % _RING
        if data:
            direction.next = following
            yield Chunk(at_ns, *key, bytes(data), direction.fresh)
            direction.fresh = False

    def _skip_gap(self, direction: _Direction) -> None:
        after = direction.next or 0
        direction.next = _nearest(direction.waiting, after)
        direction.fresh = True
        self.gaps += 1


def _nearest(waiting: Iterable[int], following: int) -> int:
    """Return the number that comes first, seen from the next one: what is old comes before what is new."""
    return min(waiting, key=lambda each: (each - following + _HALF) % _RING)


def _too_much(direction: _Direction) -> bool:
    waiting = direction.waiting
    return len(waiting) > WAITING_MAX or sum(map(len, waiting.values())) > WAITING_BYTES_MAX
