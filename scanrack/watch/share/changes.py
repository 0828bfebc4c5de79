"""The values of a trace as lists of changes, collected in a single pass over its scans.

    scan       100  101  102  103  104
    value        7    7    9    9    7      list: scans 100 102 104, values 7 9 7

A browser finds the value in a scan by bisection. A page stores scans as differences, see `packed`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.memory_layout import MemoryLayout
from scanrack.runtime.live.ring import Rows

from ..history.catalog import shown_value
from ..history.timeline import Timeline

ROWS_AT_ONCE = 4096
"""Number of scans whose recorded values are read at once."""


class Difference(NamedTuple):
    """The first scan in which two traces differ."""

    scan: int
    keys: Sequence[str]  # keys of the lists that differ in this scan


class ChangeLists:
    """Lists of changes; a key has a part of a frame and names, one per line, such as `tags`, `0`, `Start`."""

    def __init__(self) -> None:
        self._lists: dict[str, tuple[list[int], list[Any]]] = {}

    def note(self, key: str, scan: int, value: Any) -> None:
        """Add the value in a scan if it has changed; scans must come in order."""
        scans, values = self.list_of(key)
        if not values or values[-1] != value:
            scans.append(scan)
            values.append(value)

    def list_of(self, key: str) -> tuple[list[int], list[Any]]:
        """Return a list, created if necessary: its change scans, and the value from each of them on."""
        return self._lists.setdefault(key, ([], []))

    def set_list(self, key: str, scans: list[int], values: list[Any]) -> None:
        """Set the list of a key."""
        self._lists[key] = scans, values

    def value_in(self, key: str, scan: int) -> Any:
        """Return the value of a list in a scan; None before its first change."""
        scans, values = self._lists[key]
        index = bisect_right(scans, scan) - 1
        return None if index < 0 else values[index]

    def first_difference(self, other: ChangeLists, parts: Collection[str], scans: range) -> Difference | None:
        """Return the first scan in which common lists differ, and their keys; None without a difference.

        Args:
            parts: parts of a frame whose lists are compared.
            scans: the scans that both traces have.
        """
        keys = [key for key in self._lists.keys() & other._lists.keys() if key.partition("\n")[0] in parts]
        unequal_scans = {key: self._first_unequal(other, key, scans) for key in keys}
        first = min((scan for scan in unequal_scans.values() if scan is not None), default=None)
        if first is None:
            return None
        return Difference(first, sorted(key for key, scan in unequal_scans.items() if scan == first))

    def _first_unequal(self, other: ChangeLists, key: str, scans: range) -> int | None:
        """Return the first of the scans in which the values of a list differ; None without a difference."""
        if self._lists[key] == other._lists[key]:
            return None
        own_changes, _ = self._lists[key]
        other_changes, _ = other._lists[key]
        changes = {scans.start, *own_changes, *other_changes}.intersection(scans)
        for scan in sorted(changes):
            if self.value_in(key, scan) != other.value_in(key, scan):
                return scan
        return None

    def packed(self, first: int) -> dict[str, dict[str, Any]]:
        """Return the lists for a page: their values, and their scans as differences from `first` on.

        Integers are also stored as differences (`columns` has a list per array element), so counters take
        almost no space.
        """
        return {
            key: {"steps": _steps(scans, first), **_packed(values)}
            for key, (scans, values) in self._lists.items()
        }

    def last_changes(self, part: str, scan: int) -> dict[str, int]:
        """Return, by name, the scan in which each list in a part last changed, up to a scan; -1 if none."""
        latest = {}
        for key, (scans, _) in self._lists.items():
            if key.startswith(f"{part}\n"):
                changes = [change for change in scans[1:] if change <= scan]
                latest[key.split("\n")[-1]] = changes[-1] if changes else -1
        return latest


def _steps(scans: Sequence[int], first: int) -> list[int]:
    steps: list[int] = np.diff(np.asarray(scans, np.int64), prepend=first).tolist()
    return steps


def _packed(values: list[Any]) -> dict[str, Any]:
    """Return values for a page: differences of integers, or of each column of equal lists, if possible."""
    if all(map(_is_small, values)):
        return {"differences": _differences(values)}
    if all(isinstance(value, list) and len(value) == len(values[0]) for value in values):
        columns = [list(column) for column in zip(*values, strict=True)]
        if columns and all(_is_small(number) for column in columns for number in column):
            return {"columns": list(map(_differences, columns))}
    return {"values": values}


def _is_small(value: object) -> bool:
    """Return whether a value is an integer whose differences a browser can add exactly."""
    return type(value) is int and abs(value) < 1 << 52


def _differences(values: Sequence[int]) -> list[int]:
    return [value - previous for value, previous in zip(values, [0, *values], strict=False)]


def take_words(lists: ChangeLists, rows: Rows, layout: MemoryLayout) -> None:
    """Collect the words of the images, inputs before outputs as in frames."""
    words, scans = rows["words"], rows["scan"]
    for slot, image_places in layout.places.items():
        images = [words[:, image_places.columns(image)] for image in ("I", "O")]
        for index, values in enumerate(np.concatenate(images, axis=1).T):
            changes = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1]]))
            lists.set_list(f"words\n{slot}\n{index}", scans[changes].tolist(), values[changes].tolist())


def take_recorded(
    lists: ChangeLists, number: int, timeline: Timeline, names: Iterable[str], scans: Sequence[int]
) -> None:
    """Collect the recorded values of a Python program."""
    tag_names = list(names)
    for begin in range(0, len(scans), ROWS_AT_ONCE):
        piece = scans[begin : begin + ROWS_AT_ONCE]
        _, values = timeline.recorded(tag_names, piece[0], piece[-1])
        for name in tag_names:
            column = values.get(name) or _array_values(name, values)
            for scan, value in zip(piece, column, strict=False):
                lists.note(f"tags\n{number}\n{name}", scan, shown_value(value))


def _array_values(name: str, values: Mapping[str, list[Any]]) -> list[Any]:
    """Return the values of an array from the values of its elements."""
    elements = [column for key, column in values.items() if key.startswith(f"{name}[")]
    return list(map(list, zip(*elements, strict=True)))
