"""What a page knows of lanes, put together as `web/lanes.js` does; a recording read by the stock reader."""

from __future__ import annotations

import json
import struct
from bisect import bisect_left, bisect_right
from itertools import pairwise
from typing import Any

from mcap.reader import make_reader
from scanrack.io_images.amci3601 import WORDS_3601

PERIOD_NS = 2_000_000
TAGS = ("Strokes.ACC", "Axis.State", "OutGo", "Trouble")
ROW = struct.Struct("<4xII16hii??")
"""A scan of the feeder in CDR: header, scan, flags, eight outputs, eight inputs, the tags."""


class Recorded:
    """A recording of the feeder, as the stock reader reads it."""

    def __init__(self, path):
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            rows = [ROW.unpack(message.data) for _, _, message in reader.iter_messages("/scan")]
            others = [
                found for found in reader.iter_messages(log_time_order=False) if found[1].topic != "/scan"
            ]
        assert [row[0] for row in rows] == list(range(len(rows)))
        self.outputs = [row[2:10] for row in rows]
        self.inputs = [row[10:18] for row in rows]
        self.events = [(json.loads(message.data)["scan"], message.log_time) for _, _, message in others]
        self.lanes: dict[str, list[Any]] = dict(
            zip(TAGS, map(list, zip(*(row[18:] for row in rows), strict=True)), strict=True)
        )
        for names in WORDS_3601.groups.values():
            for name, at in names.items():
                self.lanes[f"1.{name}"] = [self._bit(name, at, scan) for scan in range(len(rows))]
        self.lanes["1.position"] = [self._position(scan) for scan in range(len(rows))]

    def __len__(self):
        return len(self.inputs)

    def _bit(self, name, at, scan):
        """A bit, without those that mean something else in a configuration; of two of a name the status."""
        words = (self.inputs if at.image == "I" or name == "MODE_CONFIG" else self.outputs)[scan]
        if words[0] < 0:
            return int(name == "MODE_CONFIG")
        return words[at.word] >> at.bit & 1

    def _position(self, scan):
        words = self.inputs[scan]
        return None if words[0] < 0 else words[2] * 1000 + words[3]


class Lanes:
    """The pieces of a page, and whether each says what the recording has."""

    def __init__(self):
        self.points = {}

    def take(self, piece, recorded):
        """Check a piece, and put it in the place of what was known of its time."""
        if not piece:
            return
        begin, end = piece["from"], piece["to"]
        given = {**piece.get("bits", {}), **piece.get("positions", {}), **piece.get("tags", {})}
        for name in {*self.points, *given} if "bits" in piece else given:
            check(name, given.get(name, []), end, recorded)
            self._put(name, begin, end, given.get(name, []))

    def _put(self, name, begin, end, items):
        known = self.points.setdefault(name, [])
        times = [point[0] for point in known]
        later, at = known[bisect_left(times, end) :], bisect_right(times, end) - 1
        if not later or later[0][0] != end:
            later.insert(0, [end, *known[at][1:]] if at >= 0 else [end, None])
        self.points[name] = known[: bisect_left(times, begin)] + items + later

    def known(self, name, recorded):
        """Return the scans of which a value is known, after checking each with the recording."""
        found: set[int] = set()
        points = self.points.get(name, [])
        for point, following in pairwise(points):
            first, last = point[0] // PERIOD_NS, following[0] // PERIOD_NS
            if point[1] is None:
                continue
            found.update(range(first, last))
            if len(point) == 2:
                assert {recorded.lanes[name][scan] for scan in range(first, last)} <= {point[1]}, (
                    name,
                    point,
                )
        assert not points or points[-1][1] is None, "nothing is known behind the last piece"
        return found


def check(name, points, end, recorded):
    """Compare the stretches of a piece with the recording."""
    for point, following in pairwise([*points, [end]]):
        values = recorded.lanes[name][point[0] // PERIOD_NS : following[0] // PERIOD_NS]
        last = values[-1]
        if len(point) == 4:
            expected: list[Any] = [min(values), max(values), last]
        elif len(point) == 3:
            expected = [last, sum(one != other for one, other in pairwise(values))]
        elif point[1] is None:
            continue
        else:
            assert set(values) == {point[1]}, (name, point)
            continue
        assert point[1:] == expected, (name, point)
