"""Makes lanes of tags for the timing strip: the value after each scan, in few points that show every change.

    BOOL       [t, 0 or 1]                    at each edge
               [t, level, edges]              per stretch of scans, if there are many
    text       [t, text]                      at each change
    number     [t, least, greatest, last]     at each change, or per stretch of scans if there are many
    unknown    [t, None]                      the value is unknown from then on

A piece of lanes has the times between which it is valid.

Scans of a ladder program are repeated, so no pulse is missed. A Python program is not repeated: its values
come from the recording if the rack file records them, or else from about 30 reads per second.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

from scanrack.io_images.addresses import Address
from scanrack.io_images.memory_layout import NO_MEMORY, MemoryLayout
from scanrack.ladder.state.memory import same

from .catalog import shown_value, value_of
from .program_replica import ProgramReplica
from .strip import values_at
from .timeline import Timeline

MOST_LANES = 16
"""Largest number of tags in a page's strip."""

MOST_POINTS = 400
"""Largest number of points of one tag in a frame or answer."""

LIVE_SCANS = 1024
"""Largest number of scans repeated for a frame; values before them are unknown."""

ANSWER_SCANS = 4096
"""Largest number of scans in an answer; a page requests the rest separately."""

MOST_KEPT = 4000
"""Largest number of kept changes of one Python value."""

Json = dict[str, Any]
Point = list[Any]
Series = tuple[list[int], dict[str, list[Any]]]
"""Times, ns, and the values of each tag at these times."""

UNKNOWN = object()


def points_of(times: Sequence[int], values: Sequence[Any], before: Any = UNKNOWN) -> list[Point]:
    """Return the points of one tag.

    Args:
        values: values after the scans at `times`.
        before: the value before the first scan; UNKNOWN = begin with a point for the first value.
    """
    changes = _changes(values, before)
    if len(changes) <= MOST_POINTS:
        return [_point(times[place], values[place]) for place in changes]
    if all(_is_number(values[place]) for place in changes):
        return _stretches(times, values, changes, lambda some: [min(some), max(some), some[-1]])
    if all(isinstance(values[place], bool) for place in changes):
        return _stretches(times, values, changes, _counted)
    unknown = [times[changes[0]], None]
    return [unknown, *(_point(times[place], values[place]) for place in changes[1 - MOST_POINTS :])]


def _changes(values: Sequence[Any], before: Any) -> list[int]:
    changes = []
    for place, value in enumerate(values):
        if before is UNKNOWN or not same(value, before) or type(value) is not type(before):
            changes.append(place)
            before = value
    return changes


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _point(time: int, value: Any) -> Point:
    if isinstance(value, bool):
        return [time, int(value)]
    return [time, value, value, value] if _is_number(value) else [time, value]


def _stretches(
    times: Sequence[int],
    values: Sequence[Any],
    changes: Sequence[int],
    summarize: Callable[[Sequence[Any]], Point],
) -> list[Point]:
    starts = [changes[0] + place * (len(values) - changes[0]) // MOST_POINTS for place in range(MOST_POINTS)]
    ends = [*starts[1:], len(values)]
    return [[times[start], *summarize(values[start:end])] for start, end in zip(starts, ends, strict=True)]


def _counted(stretch: Sequence[bool]) -> Point:
    edges = sum(earlier is not later for earlier, later in pairwise(stretch))
    return [int(stretch[-1]), *([edges] if edges else [])]


class ValueHistory:
    """Values of a Python program, by the scans in which they were read."""

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self._changes: dict[str, list[tuple[int, Any]]] = {}

    def clear(self) -> None:
        """Drop all values."""
        self._changes.clear()

    def take(self, scan: int, values: dict[str, Any]) -> None:
        """Record changed values."""
        for name, value in values.items():
            changes = self._changes.setdefault(name, [])
            changes.append((scan, value))
            if len(changes) > 2 * MOST_KEPT:
                del changes[:MOST_KEPT]

    def last_change(self, name: str, scan: int) -> tuple[int, Any] | None:
        """Return the scan of a value's last change up to a scan, and the old value; None if there is none."""
        changes = [change for change in self._changes.get(name, []) if change[0] <= scan]
        return None if len(changes) < 2 else (changes[-1][0], changes[-2][1])

    def points(self, name: str, first: int, last: int) -> list[Point]:
        """Return the points of a value between two scans; the first point may be from an earlier read."""
        changes = self._changes.get(name, [])
        before = [change for change in changes if change[0] < first][-1:]
        within = [change for change in changes if first <= change[0] <= last]
        starts = [(first, value) for _, value in before if not within or within[0][0] > first]
        shown = [*starts, *within]
        return points_of([scan * self.period_ns for scan, _ in shown], [value for _, value in shown])


class TagLanes:
    """Returns points of tags for any scans."""

    def __init__(
        self,
        timeline: Timeline,
        replica: ProgramReplica | None,
        history: ValueHistory,
        address: Callable[[str], Address | None] = lambda _name: None,
        layout: MemoryLayout = NO_MEMORY,
    ) -> None:
        self._timeline, self._replica, self._history = timeline, replica, history
        self._address, self._layout = address, layout
        self._period_ns = history.period_ns
        self._known: tuple[tuple[int, int, tuple[str, ...]], Series] | None = None

    def live(self, names: Iterable[str], all_names: Iterable[str], first: int, last: int) -> Json:
        """Return a piece of the latest scans; if there are too many, only of the last ones.

        Args:
            all_names: tags of all pages, so that pages with the same scans share one repetition.
        """
        images, plain_names = self._parted(names)
        if self._replica is None or self._replica.is_impure:
            return self._with_images(self._observed(plain_names, first, last), images)
        start = max(first, last - LIVE_SCANS + 1)
        distinct = tuple(dict.fromkeys(self._parted(all_names)[1]))
        piece = (
            self._piece(plain_names, *self._repeated(distinct, start, last))
            if distinct
            else self._observed((), start, last)
        )
        return self._with_images(piece, images)

    def past(self, names: Sequence[str], first: int, last: int) -> tuple[Json, int | None]:
        """Return a piece of past scans, and the scan of the next piece; None at the end."""
        end = min(last, first + ANSWER_SCANS - 1)
        following = end + 1 if end < last else None
        images, plain_names = self._parted(names)
        return self._with_images(self._past(plain_names, first, end), images), following

    def _past(self, names: Sequence[str], first: int, end: int) -> Json:
        if not names:
            return self._observed((), first, end)
        if self._replica is not None and not self._replica.is_impure:
            return self._piece(names, *self._repeated(tuple(names), first, end))
        times, values = self._timeline.recorded(names, first, end)
        observed = self._observed([name for name in names if name not in values], first, end)
        if not values:
            return observed
        piece = self._piece(values, times, values)
        for name, points in observed["tags"].items() if piece else ():
            piece["tags"][name] = [point for point in points if point[0] < piece["to"]]
        return piece

    def _parted(self, names: Iterable[str]) -> tuple[dict[str, Address], list[str]]:
        """Split names into words and bits of images, and all others."""
        addresses = {name: self._address(name) for name in names}
        images = {name: address for name, address in addresses.items() if address is not None}
        return images, [name for name in addresses if name not in images]

    def _with_images(self, piece: Json, images: Mapping[str, Address]) -> Json:
        """Return a piece with words and bits of images added; every row has these."""
        if not piece or not images:
            return piece
        first, last = piece["from"] // self._period_ns, piece["to"] // self._period_ns - 1
        rows = self._timeline.between(first, last)
        times = rows["now_ns"].tolist()
        unknown = [] if times and times[0] == piece["from"] else [[piece["from"], None]]
        lanes = {
            name: unknown + points_of(times, values_at(rows, self._layout, address).tolist())
            for name, address in images.items()
        }
        return {**piece, "tags": piece["tags"] | lanes}

    def _piece(self, names: Iterable[str], times: list[int], values: Mapping[str, list[Any]]) -> Json:
        """Return the piece for scans with the given values; an empty piece without scans."""
        if not times:
            return {}
        tags = {name: points_of(times, values[name]) for name in names if name in values}
        return {"from": times[0], "to": times[-1] + self._period_ns, "tags": tags}

    def _observed(self, names: Iterable[str], first: int, last: int) -> Json:
        """Return the piece for scans with values that were read at intervals."""
        begin = first * self._period_ns
        tags = {}
        for name in names:
            points = self._history.points(name, first, last)
            tags[name] = points if points and points[0][0] == begin else [[begin, None], *points]
        return {"from": begin, "to": (last + 1) * self._period_ns, "tags": tags}

    def _repeated(self, names: tuple[str, ...], first: int, last: int) -> Series:
        """Repeat scans and return the values after each."""
        wish = first, last, names
        if self._known is None or self._known[0] != wish or not self._known[1][0]:
            self._known = wish, self._repeat(names, first, last)
        return self._known[1]

    def _repeat(self, names: tuple[str, ...], first: int, last: int) -> Series:
        replica = self._replica
        times: list[int] = []
        values: dict[str, list[Any]] = {name: [] for name in names}
        if replica is None or first > last:
            return times, values
        tags = replica.engine.tags
        for now_ns in replica.walk(first, last):
            times.append(now_ns)
            for name, column in values.items():
                column.append(shown_value(value_of(tags, name)))
        return times, values
