"""What pages get of a running session, its past, a branch and the opened recording is what was recorded.

The recording is read by the stock MCAP reader. Broken on purpose: a window that is known up to the scan that
was asked for, a level that goes on where rows were lost, points of too many edges left out: a test turns red.

What a page knows of lanes, put together as `web/lanes.js` does; a recording read by the stock reader.
"""

from __future__ import annotations

import json
import random
import shutil
import struct
import tempfile
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from itertools import pairwise
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

import pytest
from live_sessions import FEEDER, LiveSession
from mcap.reader import make_reader
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.jobs.record.order_repeater import orders_of
from scanrack.traces import open_trace
from scanrack.watch.monitors.monitor import Monitor, SessionFacts
from scanrack.watch.monitors.page import Page
from scanrack.watch.monitors.questions import handle_message as ask
from scanrack.watch.monitors.session_monitor import SessionMonitor, Setup
from scanrack.watch.monitors.stretched import SessionProgram
from scanrack.watch.recorded_session import OpenedRecording, TracePlace

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


pytestmark = pytest.mark.slow

SCANS = 1500
SEEDS = range(2)


@pytest.fixture
def rack(tmp_path):
    """The feeder with recorded tags."""
    shutil.copy(FEEDER.with_name("feeder.rung"), tmp_path)
    rack = tmp_path / "feeder.toml"
    rack.write_text(f"tags = {list(TAGS)}\n{FEEDER.read_text(encoding='utf-8')}", encoding="utf-8")
    return rack


def orders(dice, scans):
    """Presses, forces and writes at random; the external input changes in every scan for a while."""
    kinds: list[Callable[[], dict[str, object]]] = [
        lambda: {
            "do": "press",
            "slot": 1,
            "name": dice.choice(["estop", "home"]),
            "on": dice.choice([True, False, None]),
        },
        lambda: {"do": "force", "tag": "Local:1:I.Data[0].7", "value": dice.choice([0, 1])},
        lambda: {"do": "force", "tag": "OutGo", "value": dice.choice([0, 1])},
        lambda: {"do": "write", "tag": "Strokes.ACC", "value": dice.randrange(9)},
        lambda: {"do": "unforce", "tag": "all"},
        lambda: {"do": "incident", "slot": 1, "kind": "power-cycle"},
    ]
    begin = dice.randrange(scans // 2)
    pulses = [
        (begin + place, {"do": "press", "slot": 1, "name": "external", "on": not place % 2})
        for place in range(900)
    ]
    return sorted(
        [*pulses, *((dice.randrange(scans), dice.choice(kinds)()) for _ in range(20))],
        key=lambda each: each[0],
    )


class Watching:
    """Pages that look at a session while it runs; a listener behind the tap. Each answer is kept."""

    def __init__(self, rack, trace, dice, rows):
        self.rack, self.dice, self.answers, self.pieces = rack, dice, [], []
        self.session = LiveSession(orders(dice, SCANS), trace, rack, rows=rows)
        ring, machines = self.session.ring, tuple(self.session.machines)
        about = SessionFacts("0", "feeder", str(rack), "rack", False, False, str(trace), True)
        setup = Setup(ring.shape, about, "", "", 0, machines, str(trace), self.programs())
        self.monitor: Monitor = SessionMonitor(setup, ring, Pipe()[0])
        self.page, self.asking = Page(), Page()
        for each in (self.page, self.asking):
            self.monitor.join(each)
        assert self.ask(self.page, "lanes", tags=list(TAGS))["unknown"] == []

    def programs(self):
        return (SessionProgram(0, str(self.rack.parent), "feeder.toml", "feeder.rung"),)

    def play(self, scans):
        self.session.run.cpu.add_listener(self)
        self.session.play(scans)
        self.tick()
        self.monitor.subject.timeline.close()

    def branch(self, trace):
        """Go on as a branch does: another session in the same ring."""
        told = {"trace": str(trace), "record": None, "programs": self.programs()}
        ring = self.session.ring
        self.session = LiveSession(orders(self.dice, SCANS), trace, self.rack, ring=ring)
        self.session.tap.send({"branch": {**told, "rows": ring.written, "snapshots": ring.snapshots.end}})
        self.tick()
        assert self.ask(self.page, "lanes", tags=list(TAGS))["unknown"] == []
        self.answers, self.pieces = [], []

    def event(self, scan, now_ns, topic, fields):
        pass

    def close(self):
        pass

    def scan(self, scan, now_ns, flags):
        if self.dice.random() < 0.01:
            self.tick()
        if self.dice.random() < 0.01 and self.monitor.latest is not None:
            self.look(int(self.monitor.latest["scan"]))

    def tick(self):
        self.monitor.tick()
        frame = self.monitor.frame(self.page)
        self.pieces += [frame.get("strip"), frame.get("lanes")]

    def look(self, newest):
        """Ask for a window that may reach behind the newest scan, and look at a scan of the past."""
        first = self.dice.randrange(newest + 1)
        last = first + self.dice.randrange(2500)
        strip = self.ask(self.asking, "window", **{"from": first, "to": last})["strip"]
        lanes = self.ask(self.asking, "steps", **{"from": first, "to": last}, tags=list(TAGS))["lanes"]
        ends = range(min(last, newest) + 1, last + 2)  # the recording may be ahead of the rows
        self.answers += [(first, ends, strip), (first, ends, lanes)]
        self.shown(self.dice.randrange(newest + 1))

    def shown(self, scan):
        if self.monitor.subject.timeline.row(scan) is None:
            return  # lost, and not written yet
        assert self.ask(self.asking, "look", scan=scan)["scan"] == scan
        self.asking.last = {}
        events = self.ask(self.asking, "events", to=scan)["events"]
        self.answers.append((scan, self.monitor.frame(self.asking), events))

    def ask(self, page, do, **fields):
        page.outbox.clear()
        ask(self.monitor, page, {"id": 1, "do": do, **fields})
        (answer,) = [each["answer"] for each in page.outbox if "answer" in each]
        assert "refused" not in answer, answer
        return answer


def compare(watching, recorded, *, whole):
    """Compare all answers and pieces with the recording; `whole`: no rows were lost."""
    assert watching.answers
    lanes = Lanes()
    for piece in watching.pieces:
        lanes.take(piece, recorded)
    for name in recorded.lanes:
        known = lanes.known(name, recorded)
        if whole and name != "1.position":
            begins = min(known) if name in TAGS else 0  # a tag's lane begins when it is chosen
            assert known == set(range(begins, len(recorded))), name
    for first, last, answer in watching.answers:
        if isinstance(last, dict):
            compare_frame(first, last, answer, recorded)
            continue
        own = Lanes()
        own.take(answer, recorded)
        assert not answer or answer["from"] >= first * PERIOD_NS
        if whole and "bits" in answer:
            assert answer["from"] == first * PERIOD_NS
            assert answer["to"] // PERIOD_NS in last


def compare_frame(scan, frame, events, recorded):
    """Compare the picture of a past scan."""
    assert (frame["scan"], frame["t"], frame["state"]) == (scan, scan * PERIOD_NS, "past")
    assert frame["words"]["1"] == [*recorded.inputs[scan], *recorded.outputs[scan]]
    machine = frame["machine"]["1"]
    assert (machine["position"], machine["shaft"]) == (recorded.lanes["1.position"][scan], None)
    for name, value in frame.get("tags", {}).items():
        assert value == recorded.lanes[name][scan], (scan, name)
    told = [(each["scan"], each["t"]) for each in events]
    assert told == [each for each in recorded.events if each[0] <= scan][-len(told) or len(recorded.events) :]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_session_its_past_and_a_branch_show_what_was_recorded(rack, tmp_path, seed):
    watching = Watching(rack, tmp_path / "one.mcap", random.Random(seed), None)
    watching.play(SCANS)
    compare(watching, Recorded(tmp_path / "one.mcap"), whole=True)
    watching.branch(tmp_path / "two.mcap")
    watching.play(SCANS)
    compare(watching, Recorded(tmp_path / "two.mcap"), whole=True)


def test_a_monitor_that_loses_rows_shows_none_that_it_does_not_know(rack, tmp_path):
    watching = Watching(rack, tmp_path / "one.mcap", random.Random(7), 32)
    watching.play(SCANS)
    assert watching.monitor.state(past=False)["missed"] > 100
    compare(watching, Recorded(tmp_path / "one.mcap"), whole=False)


def test_an_opened_recording_shows_what_was_recorded(rack, tmp_path):
    dice, path = random.Random(7), tmp_path / "one.mcap"
    LiveSession(orders(dice, SCANS), path, rack).play(SCANS)
    watching = Watching.__new__(Watching)
    watching.dice, watching.answers, watching.pieces = dice, [], []
    with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
        recording = OpenedRecording(trace, TracePlace(path, None, ""), Path(folder), trust=False)
        watching.monitor, watching.asking = recording.monitor(lambda *_, **_given: None), Page()
        watching.monitor.join(watching.asking)
        while watching.monitor.tick():
            pass
        assert len(orders_of(trace.events())) > 900
        for _ in range(20):
            watching.look(SCANS - 1)
    compare(watching, Recorded(path), whole=False)
    for first, last, answer in watching.answers:
        if not isinstance(last, dict) and "bits" in answer:
            assert (answer["from"], answer["to"]) == (first * PERIOD_NS, last[0] * PERIOD_NS)
