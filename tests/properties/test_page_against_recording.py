"""What pages get of a running session, its past, a branch and the opened recording is what was recorded.

The recording is read by the stock MCAP reader. Broken on purpose: a window that is known up to the scan that
was asked for, a level that goes on where rows were lost, points of too many edges left out: a test turns red.
"""

import random
import shutil
import tempfile
from collections.abc import Callable
from multiprocessing import Pipe
from pathlib import Path

import pytest
from live_sessions import FEEDER, LiveSession
from page_model import PERIOD_NS, TAGS, Lanes, Recorded
from scanrack.jobs.record.order_repeater import orders_of
from scanrack.traces import open_trace
from scanrack.watch.monitors.monitor import Monitor, SessionFacts
from scanrack.watch.monitors.page import Page
from scanrack.watch.monitors.questions import ask
from scanrack.watch.monitors.session_monitor import SessionMonitor, Setup
from scanrack.watch.monitors.stretched import SessionProgram
from scanrack.watch.recorded_session import OpenedRecording, TracePlace

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
        self.session.tap.tell({"branch": {**told, "rows": ring.written, "snapshots": ring.snapshots.end}})
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
