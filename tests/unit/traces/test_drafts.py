"""A chunk that is not finished is in the file as a draft, and the finished trace does not show it."""

from __future__ import annotations

import errno
import io
import random
import signal
import sys
from bisect import bisect_left
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import forked
import pytest
from scanrack.runtime.loop import pace
from scanrack.traces import Attachment, Scan, ScanRecorder, SlotInfo, Trace, open_trace
from scanrack.traces.files.locking import could_lock
from scanrack.traces.read.reader import open_records
from scanrack.traces.repair import repair
from scanrack.traces.write.line import LineRecorder, UnitColumns
from scanrack.traces.write.output import TraceFile, open_trace_file

SLOTS = [SlotInfo(1, "amci3601", "4.1")]
SCANS = 120


class Disk(io.BytesIO):
    """A file in memory that takes few bytes at a time and shows what a process killed after each call leaves.

    Args:
        most: bytes of a write at most.
        room: bytes that it holds at most.
    """

    def __init__(self, most: int = 1 << 30, room: int = 1 << 30) -> None:
        super().__init__()
        self.left: list[bytes] = []
        self._most, self._room = most, room

    def write(self, data: object) -> int:
        part = memoryview(data)[: self._most]  # type: ignore[arg-type]
        if self.tell() + len(part) > self._room:
            raise OSError(errno.ENOSPC, "No space left on device")
        count = super().write(part)
        self.left.append(self.getvalue())
        return count

    def truncate(self, size: int | None = None) -> int:
        count = super().truncate(size)
        self.left.append(self.getvalue())
        return count

    def close(self) -> None:
        self.content = self.getvalue()


def recorder_of(disk: Disk, memory: bytearray) -> ScanRecorder:
    file = TraceFile(disk, "run.mcap", drafts=True)
    return ScanRecorder(file, memory, SLOTS, scan_period_ns=2_000_000, chunk_scans=50)


def record(disk: Disk, *, every: int = 0, scans: int = SCANS, attach: int = -1) -> Iterator[int]:
    """Record noise, with events, and a draft every so many scans; yield each recorded scan's number."""
    memory, noise = bytearray(32), random.Random(5)
    recorder = recorder_of(disk, memory)
    for scan in range(scans):
        if scan == attach:
            recorder.attach(scan, [Attachment("more.py", b"x = 1\n" * 20)])
        memory[:] = noise.randbytes(32)
        if every and scan % every == 0:
            recorder.draft_soon()
        if scan % 7 == 0:
            recorder.event(scan, scan * 2_000_000, "/events", {"scan": scan, "slot": 1})
        recorder.scan(scan, scan * 2_000_000, 1)
        yield scan
    recorder.close()


def scans_in(content: bytes) -> list[int]:
    trace = Trace(io.BytesIO(content), len(content))
    return [each.scan for each in trace if isinstance(each, Scan)]


@pytest.mark.parametrize("every", [1, 10, 33, 70])
@pytest.mark.parametrize("attach", [-1, 61])
def test_the_finished_trace_does_not_depend_on_drafts(every: int, attach: int) -> None:
    plain, drafted = Disk(), Disk(most=300)
    assert list(record(plain, attach=attach)) == list(record(drafted, every=every, attach=attach))
    assert drafted.content == plain.content


def test_a_process_that_is_killed_after_any_call_leaves_every_scan_up_to_the_last_draft() -> None:
    disk, sure = Disk(most=300), 0
    looked = 0
    for scan in record(disk, every=10):
        for content in disk.left[1:]:
            if sure:
                assert scans_in(content)[: sure + 1] == list(range(sure + 1)), scan
                looked += 1
        if disk.left and scan % 10 == 0:
            sure = scan
            assert scans_in(disk.getvalue())[-1] == scan
        disk.left.clear()
    assert looked > 40


def test_a_repair_makes_of_it_what_would_have_been(tmp_path: Path) -> None:
    drafted, path = Disk(), tmp_path / "run.mcap"
    for scan in record(drafted, every=10):
        if scan in (20, 80, 100):
            path.write_bytes(drafted.getvalue())
            assert repair(path).scans == scan + 1
            ended = Disk()
            list(record(ended, scans=scan + 1))
            assert path.read_bytes() == ended.content
            assert repair(path).notes == []


def test_a_disk_without_room_for_drafts_has_none() -> None:
    plain = Disk()
    list(record(plain))
    disk = Disk(room=len(plain.content) + 100)  # none for the gap before a draft
    list(record(disk, every=10))
    assert disk.content == plain.content


def test_attachments_leave_the_draft_there() -> None:
    disk = Disk()
    for scan in record(disk, every=10, attach=65):
        if scan == 65:
            assert scans_in(disk.getvalue())[-1] >= 60


def test_a_recording_under_way_is_read_to_its_last_chunk(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = ScanRecorder(path, bytearray(32), SLOTS, scan_period_ns=1, chunk_scans=50)
    for scan in range(70):
        recorder.draft_soon()
        recorder.scan(scan, scan, 0)
    with open_trace(path) as trace, open_trace(path) as another:
        assert len(list(trace.scans())) == len(list(another.scans())) == 50
        assert any("it is being recorded" in note for note in trace.notes)
    other = tmp_path / "killed.mcap"
    other.write_bytes(path.read_bytes())
    with open_trace(other) as trace:
        assert len(list(trace.scans())) == 70
    recorder.close()


def test_who_follows_a_recording_gets_its_chunks(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = ScanRecorder(path, bytearray(32), SLOTS, scan_period_ns=1, chunk_scans=50)
    recorder.scan(0, 0, 0)
    with open_trace(path) as trace:
        for scan in range(1, 170):
            recorder.draft_soon()
            recorder.scan(scan, scan, 0)
            assert trace.follow() is ((scan + 1) % 50 == 0)
            assert len(list(trace.scans())) == (scan + 1) // 50 * 50
        recorder.close()
        assert trace.follow()
        assert (len(list(trace.scans())), trace.notes) == (170, [])


def test_the_line_of_units_has_drafts_too(tmp_path: Path) -> None:
    path = tmp_path / "line.mcap"
    recorder = LineRecorder(path, [UnitColumns(1, ["position"])], {})
    recorder.received(5, b"abc")
    recorder.draft()
    other = tmp_path / "killed.mcap"
    other.write_bytes(path.read_bytes())
    recorder.close()
    with open_records(other) as records:
        assert len(records.sections) == 1
    assert repair(other).messages == 1
    assert other.read_bytes() == path.read_bytes()


def test_a_device_has_no_drafts() -> None:
    recorder = ScanRecorder("/dev/null", bytearray(32), SLOTS, scan_period_ns=1)
    recorder.draft_soon()
    recorder.scan(0, 0, 0)
    recorder.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no shared locks")
def test_those_who_look_whether_a_file_is_recorded_do_not_see_one_another(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    open_trace_file(path, 0).close()
    with path.open("rb") as one, path.open("rb") as other:
        assert could_lock(one.fileno(), shared=True)
        assert could_lock(other.fileno(), shared=True)


class Time:
    """A clock that only sleeping and looking move."""

    def __init__(self) -> None:
        self.now_ns = 0

    def monotonic_ns(self) -> int:
        self.now_ns += 10_000
        return self.now_ns

    def sleep(self, seconds: float) -> None:
        self.now_ns += round(seconds * 1e9)


@pytest.mark.parametrize("period_ns", [100_000, 2_000_000, 30_000_000])
@pytest.mark.parametrize("pacer", [pace.RealTime(), pace.AdjustablePace(0.5), pace.AdjustablePace(None)])
def test_the_beat_comes_in_time(
    monkeypatch: pytest.MonkeyPatch, pacer: pace.RealTime, period_ns: int
) -> None:
    clock, beats, scans = Time(), [], []
    monkeypatch.setattr(pace, "time", clock)
    pacer.beat = lambda: beats.append(clock.now_ns)
    pacer._beat_ns = 0
    pacer.begin(period_ns)
    while clock.now_ns < 2_000_000_000:
        pacer.wait()
        scans.append(clock.now_ns)  # a scan that takes no time, and its record
    recorded = [scans[bisect_left(scans, beat)] for beat in beats]
    gaps = [later - earlier for earlier, later in pairwise(recorded)]
    assert max(gaps) <= pace.BEAT_NS
    assert len(beats) - 2 <= 2_000_000_000 / (
        pace.BEAT_NS - 4 * period_ns if period_ns < 20_000_000 else period_ns
    )


KILLED = """
import os, signal

def logic(scan):
    if scan.number == 300:
        {}
"""


@pytest.mark.slow
@pytest.mark.parametrize("end", ["os.kill(os.getpid(), signal.SIGKILL)", "os._exit(0)"])
def test_a_session_in_real_time_that_ends_at_once_leaves_its_scans(tmp_path: Path, end: str) -> None:
    (tmp_path / "line.py").write_text(KILLED.format(end), encoding="utf-8")
    (tmp_path / "line.toml").write_text(
        'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    words = [sys.executable, "-m", "scanrack", "run", "line.toml", "--realtime", "-q"]
    done = forked.run(words, cwd=tmp_path, check=False, timeout=120)
    assert done.returncode in (-signal.SIGKILL, 0)
    with open_trace(tmp_path / "line.mcap") as trace:
        assert len(list(trace.scans())) > 1  # how many, depends on the machine: those up to 0.1 s before
        assert any("ended from outside, or by os._exit" in note for note in trace.notes)
    assert repair(tmp_path / "line.mcap").needed
