"""Scans that listeners receive by rows, many at once, are those that they receive one by one.

The oracle is the scan by its phases: the same recording byte for byte, with tags, texts and snapshots. How
many scans come at once, and where a listener ends them, is drawn. Actions come from the logic, in
the middle of a block.
"""

from __future__ import annotations

import random
import struct
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from ahead3601 import Rig, played
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack import load_rack, run
from scanrack.jobs.run.result import RunCounters
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.runtime.loop import ahead, listeners, scans_ahead
from scanrack.traces import ScanRecorder, SlotInfo
from scanrack.traces.format.tagplan import Tag, TagPlan, plan_of
from scanrack.traces.write import snapshots
from scanrack.traces.write.snapshots import SnapshotLog
from steps3601 import Wait
from stories3601 import THEMES
from stories_ahead import stories

pytestmark = pytest.mark.slow

PLAN = plan_of([Tag("Count", "DINT"), Tag("Text", "TEXT")])
EXAMPLES = Path(__file__).parents[2] / "examples"
RACKS = sorted(EXAMPLES.glob("*/*.toml"))


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(scans_ahead, "LEAST_ROWS", 1)
    monkeypatch.setattr(snapshots, "WORTH_SCANS", 1)
    for name, value in (("SHORTEST_WAIT", 1), ("LONGEST_WAIT", 2), ("FEWEST_ROWS", 40)):
        monkeypatch.setattr(ahead.Patience, name, value)


class RowDiary:
    """A listener that notes everything, and takes scans at once as chance has it.

    Attributes:
        told: events, and scans with their images.
        at_once: most scans that it has received in one call.
    """

    def __init__(self, rig: Rig, chance: random.Random) -> None:
        self.told: list[object] = []
        self.at_once = 0
        self._rig, self._chance = rig, chance

    def event(self, scan, now_ns, topic, fields) -> None:
        self.told.append((scan, now_ns, topic, dict(fields)))

    def scan(self, scan, now_ns, flags) -> None:
        self.told.append((scan, now_ns, flags, bytes(self._rig.rack.memory)))

    def look(self) -> bool:
        return self._chance.random() < 0.02

    def begin_rows(self, scan) -> int:
        return self._chance.choice([0, 1, 2, 7, 50, 3000])

    def rows(self, scans, times, flags, images) -> None:
        assert bytes(self._rig.rack.memory) == images[-1] or self._rig.cpu.scan > scans[-1]
        self.at_once = max(self.at_once, len(scans))
        for scan, now_ns, image in zip(scans, times, images, strict=True):
            self.told.append((scan, now_ns, flags, image))

    def close(self) -> None:
        pass


@dataclass
class Tags:
    """Two tags of a rig: how often its logic was called, in units, and a text that changes now and then."""

    rig: Rig
    every: int
    plan: TagPlan = PLAN
    pending: list = field(default_factory=list)
    told: int = -1

    def take(self) -> bytes:
        count = len(self.rig.fresh) // self.every
        if count // 5 != self.told:
            self.told = count // 5
            self.pending.append(("/texts", {"tag": "Text", "code": self.told, "text": f"text {self.told}"}))
        return bytes(self.rig.rack.memory) + struct.pack("<iH", count, self.told)


def with_recorder(path: Path, seed: int, tags: bool):
    """Return what makes a diary and a recorder, with tags and snapshots of the logic's calls if wanted."""

    def make(rig: Rig):
        slots = [SlotInfo(slot.number, slot.catalog, slot.firmware) for slot in rig.rack.slots.values()]
        recorder = ScanRecorder(
            path,
            rig.rack.memory,
            slots,
            scan_period_ns=rig.made_of.period_ns,
            chunk_scans=61,
            tags=Tags(rig, 1 + seed % 40) if tags else None,
            snapshots=SnapshotLog(lambda: str(len(rig.fresh))),
        )
        rig.row_diary = RowDiary(rig, random.Random(seed))
        return [rig.row_diary, recorder]

    return make


def assert_rows_are_scans(script: Rig, folder: Path, seed: int, *, tags: bool) -> RowDiary:
    """Run a script by phases and by rows, and compare."""
    rigs = []
    for name, by_rows in (("slow", False), ("fast", True)):
        make = with_recorder(folder / f"{name}.mcap", seed, tags)
        rig = Rig(script.made_of, ahead=by_rows, actions=script.actions, made=make)
        rig.cpu.run(script.cpu.scan)
        rig.cpu.close()
        rigs.append(rig)
    slow, fast = rigs
    assert fast.row_diary.told == slow.row_diary.told
    assert fast.fresh == slow.fresh
    assert fast.seen == slow.seen
    assert (folder / "fast.mcap").read_bytes() == (folder / "slow.mcap").read_bytes()
    assert not slow.row_diary.at_once
    return fast.row_diary


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("tags", [False, True], ids=["images", "tags"])
def test_rows_are_what_single_scans_are(tmp_path, theme, tags):
    @settings(max_examples=max(1, settings().max_examples // 6))
    @given(story=stories(theme), seed=st.integers(0, 1000))
    def lockstep(story, seed):
        world, steps = story
        assert_rows_are_scans(played(world, [*steps, Wait(2_000)]), tmp_path, seed, tags=tags)

    lockstep()


@pytest.mark.parametrize("rack", RACKS, ids=lambda path: path.stem)
def test_examples_record_the_same_bytes(tmp_path, monkeypatch, rack):
    """The listeners of `scanrack run`: hints, counters, sequences, tags, snapshots, the recorder."""
    run(rack, scans=1_500, trace=tmp_path / "fast.mcap")
    monkeypatch.setattr(listeners.Listeners, "begin_rows", lambda self, scan: 0)
    run(rack, scans=1_500, trace=tmp_path / "slow.mcap")
    assert (tmp_path / "fast.mcap").read_bytes() == (tmp_path / "slow.mcap").read_bytes()


@pytest.mark.parametrize("name", ["feeder/feeder", "sequences/stations", "three_stations/line"])
def test_listeners_of_a_run_take_rows(tmp_path, name):
    """Otherwise the test above compares nothing."""
    with ExitStack() as ports:
        job = load_rack(EXAMPLES / f"{name}.toml")
        job_run = JobRun(job, ports, RunOptions(trace=tmp_path / "one.mcap", listeners=[RunCounters()]))
        assert job_run.cpu._listeners.begin_rows(0)
        job_run.cpu.close()
