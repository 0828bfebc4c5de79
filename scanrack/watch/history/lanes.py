"""Lanes of tags for the timing strip: values after each scan, as a few points that show every change.

    BOOL       [t, 0 or 1]                    at each edge
               [t, level, edges]              per stretch of scans, if there are many
    text       [t, text]                      at each change
    number     [t, least, greatest, last]     at each change, or per stretch of scans if there are many
    unknown    [t, None]                      the value is unknown from this time on

A piece of lanes has the times between which its points are valid.

Scans of a ladder program are repeated, so no pulse is missed. A Python program is not repeated. Its values
come from the trace if the rack file records them, otherwise from about 30 reads per second.
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
"""Maximum number of tags in a page's strip."""

MOST_POINTS = 400
"""Maximum number of points of a tag in a frame or answer."""

LIVE_SCANS = 1024
"""Maximum number of scans to repeat for a frame. Values before these scans are unknown."""

ANSWER_SCANS = 4096
"""Maximum number of scans in an answer. A page requests the others separately."""

MOST_KEPT = 4000
"""Minimum number of changes to keep for a Python value."""

Json = dict[str, Any]
Point = list[Any]
Series = tuple[list[int], dict[str, list[Any]]]
"""Times, ns, and the values of each tag at these times."""

UNKNOWN = object()


def points_of(times: Sequence[int], values: Sequence[Any], previous: Any = UNKNOWN) -> list[Point]:
    """Return the points of one tag.

    Args:
        values: values after the scans at `times`.
        previous: the value before the first scan; UNKNOWN = start with a point for the first value.
    """
    changes = _changes(values, previous)
    if len(changes) <= MOST_POINTS:
        return [_point(times[index], values[index]) for index in changes]
    changed_values = [values[index] for index in changes]
    if all(map(_is_number, changed_values)):
        return _stretches(times, values, changes[0], _envelope)
    if all(isinstance(value, bool) for value in changed_values):
        return _stretches(times, values, changes[0], _counted)
    unknown = [times[changes[0]], None]  # a text: only its last changes are shown
    return [unknown, *(_point(times[index], values[index]) for index in changes[1 - MOST_POINTS :])]


def _changes(values: Sequence[Any], previous: Any) -> list[int]:
    """Return the indexes of the values that differ from the value before them."""
    changes = []
    for index, value in enumerate(values):
        if previous is UNKNOWN or not same(value, previous) or type(value) is not type(previous):
            changes.append(index)
            previous = value
    return changes


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _point(time: int, value: Any) -> Point:
    if isinstance(value, bool):
        return [time, int(value)]
    return [time, value, value, value] if _is_number(value) else [time, value]


def _stretches(
    times: Sequence[int], values: Sequence[Any], first: int, summarize: Callable[[Sequence[Any]], Point]
) -> list[Point]:
    """Return a point for each of `MOST_POINTS` stretches of the values from index `first` on."""
    starts = [first + number * (len(values) - first) // MOST_POINTS for number in range(MOST_POINTS)]
    ends = [*starts[1:], len(values)]
    return [[times[start], *summarize(values[start:end])] for start, end in zip(starts, ends, strict=True)]


def _envelope(stretch: Sequence[float]) -> Point:
    return [min(stretch), max(stretch), stretch[-1]]


def _counted(stretch: Sequence[bool]) -> Point:
    edges = sum(earlier is not later for earlier, later in pairwise(stretch))
    return [int(stretch[-1]), *([edges] if edges else [])]


class ValueHistory:
    """Values of a Python program, by the scan in which they were read."""

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self._changes: dict[str, list[tuple[int, Any]]] = {}

    def clear(self) -> None:
        """Drop all values."""
        self._changes.clear()

    def take(self, scan: int, values: dict[str, Any]) -> None:
        """Add changed values."""
        for name, value in values.items():
            changes = self._changes.setdefault(name, [])
            changes.append((scan, value))
            if len(changes) > 2 * MOST_KEPT:
                del changes[:MOST_KEPT]

    def last_change(self, name: str, scan: int) -> tuple[int, Any] | None:
        """Return the scan of a value's last change up to a scan, and the old value; None without a change."""
        changes = [change for change in self._changes.get(name, []) if change[0] <= scan]
        return None if len(changes) < 2 else (changes[-1][0], changes[-2][1])

    def points(self, name: str, first: int, last: int) -> list[Point]:
        """Return the points of a value between two scans; the first point may be from an earlier read."""
        changes = self._changes.get(name, [])
        shown = [(scan, value) for scan, value in changes if first <= scan <= last]
        earlier_values = [value for scan, value in changes if scan < first]
        if earlier_values and (not shown or shown[0][0] > first):
            shown.insert(0, (first, earlier_values[-1]))
        return points_of([scan * self.period_ns for scan, _ in shown], [value for _, value in shown])


class TagLanes:
    """The points of tags for any scans."""

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
        self._latest_series: tuple[tuple[int, int, tuple[str, ...]], Series] | None = None  # by request

    def live(self, names: Iterable[str], all_names: Iterable[str], first: int, last: int) -> Json:
        """Return a piece of the latest scans, at most `LIVE_SCANS`.

        Args:
            all_names: tags of all pages, since pages that show the same scans share one repetition.
        """
        images, plain_names = self._split(names)
        if self._replica is None or self._replica.is_impure:
            return self._with_images(self._observed(plain_names, first, last), images)
        start = max(first, last - LIVE_SCANS + 1)
        distinct = tuple(dict.fromkeys(self._split(all_names)[1]))
        if not distinct:
            return self._with_images(self._observed((), start, last), images)
        piece = self._piece(plain_names, *self._repeated(distinct, start, last))
        return self._with_images(piece, images)

    def past(self, names: Sequence[str], first: int, last: int) -> tuple[Json, int | None]:
        """Return a piece of past scans, and the first scan of the next piece; None at the end."""
        end = min(last, first + ANSWER_SCANS - 1)
        following = end + 1 if end < last else None
        images, plain_names = self._split(names)
        return self._with_images(self._past(plain_names, first, end), images), following

    def _past(self, names: Sequence[str], first: int, end: int) -> Json:
        """Return a piece of past scans, repeated if possible.

        Otherwise its values are recorded, or were read at intervals if they are not recorded.
        """
        if not names:
            return self._observed((), first, end)
        if self._replica is not None and not self._replica.is_impure:
            return self._piece(names, *self._repeated(tuple(names), first, end))
        times, values = self._timeline.recorded(names, first, end)
        observed = self._observed([name for name in names if name not in values], first, end)
        if not values:
            return observed
        piece = self._piece(values, times, values)
        if not piece:
            return piece
        for name, points in observed["tags"].items():
            piece["tags"][name] = [point for point in points if point[0] < piece["to"]]
        return piece

    def _split(self, names: Iterable[str]) -> tuple[dict[str, Address], list[str]]:
        """Split names into words and bits of images, with their addresses, and other names."""
        addresses = {name: self._address(name) for name in names}
        images = {name: address for name, address in addresses.items() if address is not None}
        return images, [name for name in addresses if name not in images]

    def _with_images(self, piece: Json, images: Mapping[str, Address]) -> Json:
        """Return a piece with additional lanes of image words and bits, which every row contains."""
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
        """Return a piece with the given values; empty without times."""
        if not times:
            return {}
        tags = {name: points_of(times, values[name]) for name in names if name in values}
        return {"from": times[0], "to": times[-1] + self._period_ns, "tags": tags}

    def _observed(self, names: Iterable[str], first: int, last: int) -> Json:
        """Return a piece with values that were read at intervals."""
        begin = first * self._period_ns
        tags = {}
        for name in names:
            points = self._history.points(name, first, last)
            tags[name] = points if points and points[0][0] == begin else [[begin, None], *points]
        return {"from": begin, "to": (last + 1) * self._period_ns, "tags": tags}

    def _repeated(self, names: tuple[str, ...], first: int, last: int) -> Series:
        """Return the values after each scan; repeat the scans unless the last request was the same."""
        request = first, last, names
        latest = self._latest_series
        if latest is not None and latest[0] == request:
            times, values = latest[1]
            if times:  # otherwise the scans may have become available
                return times, values
        series = self._repeat(names, first, last)
        self._latest_series = request, series
        return series

    def _repeat(self, names: tuple[str, ...], first: int, last: int) -> Series:
        """Repeat scans; return their times, and the tags' values after each of them."""
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
