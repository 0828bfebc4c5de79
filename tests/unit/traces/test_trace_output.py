"""The file behind a recorder: refusals, full disks, and what is left of a trace then."""

from __future__ import annotations

import errno
import io
import os
import random
from itertools import pairwise
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from scanrack.traces import Attachment, ScanRecorder, SlotInfo, open_trace
from scanrack.traces.format.records import MAGIC
from scanrack.traces.read.finding import UNDER_WAY, find_records
from scanrack.traces.write.output import SUMMARY_ROOM, DiskReserve, TraceFile, TraceFull, open_trace_file

SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "amci3601", "2.0")]
SCANS = 250
CHUNK_SCANS = 40
PROGRAM = Attachment("logic.py", bytes(range(256)) * 12)


class Disk:
    """A disk of so many bytes, with one trace and its reserve on it.

    `thief`: somebody else takes the room of the reserve the moment it is given back.
    """

    def __init__(self, capacity: int, *, reserve: int, thief: bool = False, code: int = errno.ENOSPC) -> None:
        self.capacity = capacity
        self.size = reserve  # of the reserve: this object is the file and the room
        self.content = bytearray()
        self.thief = thief
        self.code = code
        self.closed = False
        self.released = False

    @property
    def free(self) -> int:
        return self.capacity - len(self.content) - self.size

    def write(self, data: memoryview, /) -> int:
        taken = min(len(data), self.free)
        if taken <= 0:
            raise OSError(self.code, os.strerror(self.code))
        self.content += data[:taken]
        return taken

    def seek(self, place: int, /) -> int:
        raise NotImplementedError("only drafts seek")

    def truncate(self, size: int, /) -> int:
        del self.content[size:]
        return size

    def close(self) -> None:
        self.closed = True

    def grow(self, size: int) -> None:
        if size > self.free:
            raise OSError(self.code, os.strerror(self.code))
        self.size += size

    def release(self) -> None:
        if self.thief:
            self.capacity -= self.size
        self.size = 0
        self.released = True


def record(file: TraceFile, scans: int = SCANS) -> tuple[list[int], TraceFull | None]:
    """Record until all is done or the disk is full; return the scans accepted, and what was raised."""
    memory = bytearray(64)
    noise = random.Random(1)
    accepted: list[int] = []
    full: TraceFull | None = None
    recorder = None
    try:
        recorder = ScanRecorder(
            file, memory, SLOTS, scan_period_ns=2_000_000, program=PROGRAM, chunk_scans=CHUNK_SCANS
        )
        for scan in range(scans):
            memory[:] = noise.randbytes(64)  # nothing to compress: chunks of full size
            if scan % 50 == 0:
                recorder.event(scan, scan * 2_000_000, "/cpu", {"mode": f"mode {scan}"})
            accepted.append(scan)
            recorder.scan(scan, scan * 2_000_000, 1)
    except TraceFull as error:
        full = error
    try:
        if recorder is not None:
            recorder.close()
    except TraceFull as error:
        full = error
    return accepted, full


def stock_scans(content: bytes) -> list[int]:
    """Read the scan numbers with the stock reader, its CRC validation on."""
    reader = make_reader(io.BytesIO(content), validate_crcs=True)
    summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    scans = [message.sequence for _, _, message in reader.iter_messages("/scan", log_time_order=False)]
    assert next(iter(reader.iter_attachments())).data == PROGRAM.data
    return scans


def undisturbed() -> bytes:
    disk = Disk(10**9, reserve=0)
    record(TraceFile(disk, "whole"))
    return bytes(disk.content)


def test_a_file_that_gets_shorter_while_it_is_read_ends_with_its_last_whole_record() -> None:
    """The recorder takes an unfinished chunk back behind the reader's look at the size."""
    content = undisturbed()
    spans, _ = find_records(io.BytesIO(content), len(content))
    found, notes = find_records(io.BytesIO(content[: spans[4].offset]), len(content), drafts=False)
    assert (found, notes) == (spans[:4], [UNDER_WAY])


def failure_points(content: bytes) -> list[int]:
    """Return sizes of disks at which each record is met: just before, at and after its end, and within."""
    spans, _ = find_records(io.BytesIO(content), len(content))
    ends = [span.offset for span in spans] + [len(content) - len(MAGIC), len(content)]
    near = {end + step for end in ends for step in (-1, 0, 1)}
    within = {(end + after) // 2 for end, after in pairwise(ends)}
    return sorted(near | within | {1})


RESERVE = 40_000
UNDISTURBED = undisturbed()
WHOLE = len(UNDISTURBED)
FAILURE_POINTS = failure_points(UNDISTURBED)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "points"),
    [(errno.ENOSPC, FAILURE_POINTS), (errno.EDQUOT, FAILURE_POINTS[::7])],
    ids=["disk", "quota"],
)
def test_a_full_disk_leaves_a_complete_trace_wherever_it_happens(code: int, points: list[int]) -> None:
    outcomes = set()
    for room in points:
        disk = Disk(room + RESERVE, reserve=RESERVE, code=code)
        accepted, full = record(TraceFile(disk, "full", disk))
        assert stock_scans(bytes(disk.content)) == accepted, room
        assert full is None or full.complete, room
        assert disk.closed
        outcomes.add((full is not None, 0 < len(accepted) < SCANS, len(accepted) == SCANS))
    # seen: full in the head, full during the run, full in the summary only or not at all
    assert outcomes == {(True, False, False), (True, True, False), (False, False, True)}


def test_a_full_disk_is_told_with_the_scan_that_filled_it() -> None:
    disk = Disk(RESERVE + WHOLE // 2, reserve=RESERVE)
    accepted, full = record(TraceFile(disk, "run.mcap", disk))
    assert str(full) == f"run.mcap: the disk is full; the trace is complete and ends at scan {accepted[-1]}"


def test_nothing_is_taken_after_the_disk_was_full() -> None:
    disk = Disk(RESERVE + WHOLE // 2, reserve=RESERVE)
    file = TraceFile(disk, "run.mcap", disk)
    memory = bytearray(64)
    recorder = ScanRecorder(file, memory, SLOTS, scan_period_ns=2_000_000, program=PROGRAM, chunk_scans=40)
    noise = random.Random(1)
    last = None
    for scan in range(1000):
        memory[:] = noise.randbytes(64)
        try:
            recorder.scan(scan, scan, 0)
        except TraceFull:
            last = scan if last is None else last
    with pytest.raises(TraceFull):
        recorder.event(1000, 1000, "/cpu", {"mode": "run"})
    recorder.close()
    assert last is not None
    assert stock_scans(bytes(disk.content)) == list(range(last + 1))


def test_a_disk_that_is_full_within_the_head_is_refused_and_leaves_a_whole_file() -> None:
    head = next(
        span.offset for span in find_records(io.BytesIO(UNDISTURBED), WHOLE)[0] if span.opcode == Opcode.CHUNK
    )
    for room in range(8, head, 101):
        disk = Disk(room + RESERVE, reserve=RESERVE)
        with pytest.raises(TraceFull, match="the trace is complete and ends before the first scan") as full:
            ScanRecorder(
                TraceFile(disk, "run", disk), bytearray(64), SLOTS, scan_period_ns=1, program=PROGRAM
            )
        assert full.value.complete
        assert disk.closed
        assert stock_scans(bytes(disk.content)) == []


def test_what_was_cut_back_is_closed_without_a_further_complaint() -> None:
    disk = Disk(RESERVE + WHOLE // 2, reserve=RESERVE, thief=True)
    recorder = ScanRecorder(
        TraceFile(disk, "run", disk), bytearray(64), SLOTS, scan_period_ns=1, program=PROGRAM, chunk_scans=1
    )
    with pytest.raises(TraceFull, match="cut back"):  # noqa: PT012 - some scan
        for scan in range(SCANS):
            recorder.scan(scan, scan, 0)
    size = len(disk.content)
    recorder.close()
    assert disk.closed
    assert len(disk.content) == size


@pytest.mark.slow
def test_where_the_reserve_does_not_help_the_file_ends_with_its_last_whole_record(tmp_path: Path) -> None:
    for room in FAILURE_POINTS:
        disk = Disk(room + RESERVE, reserve=RESERVE, thief=True)
        accepted, full = record(TraceFile(disk, "run.mcap", disk))
        if full is None:
            assert stock_scans(bytes(disk.content)) == accepted
            continue
        assert not full.complete
        assert f"cut back to its last whole record, at byte {len(disk.content):,}" in str(full)
        path = tmp_path / "left.mcap"
        path.write_bytes(disk.content)
        if len(disk.content) > 12_000:  # past the head: what is left reads as a trace, in whole chunks
            with open_trace(path) as trace:
                scans = [scan.scan for scan in trace.scans()]
                assert trace.notes[:1] == [
                    f"it has no end: the last whole record ends at byte {len(disk.content):,} "
                    f"of {len(disk.content):,}"
                ]
            assert scans == accepted[: len(scans)]
            assert len(accepted) - len(scans) <= CHUNK_SCANS + 1


def test_without_a_reserve_the_file_ends_with_its_last_whole_record() -> None:
    disk = Disk(WHOLE // 2, reserve=0)
    _, full = record(TraceFile(disk, "run.mcap"))
    assert full is not None
    assert not full.complete


def test_another_failure_of_the_disk_is_told_as_it_is() -> None:
    disk = Disk(RESERVE + WHOLE // 2, reserve=RESERVE, code=errno.EIO)
    _, full = record(TraceFile(disk, "run.mcap", disk))
    assert full is not None
    assert not full.complete
    assert str(full).startswith(f"run.mcap: {os.strerror(errno.EIO)}; it was cut back")


def test_a_file_that_takes_nothing_is_not_waited_for() -> None:
    class Deaf(Disk):
        def write(self, data: memoryview, /) -> int:
            return 0

    _, full = record(TraceFile(Deaf(10**6, reserve=0), "deaf"))
    assert full is not None
    assert "accepts no more bytes" in str(full)


@pytest.mark.parametrize("room", [1_000, 20_000, 300_000, 460_000])
def test_the_reserve_that_a_recorder_asks_for_is_enough(monkeypatch: pytest.MonkeyPatch, room: int) -> None:
    disks: list[Disk] = []

    def on_a_small_disk(path: Path, reserve_bytes: int, keeping: object) -> TraceFile:
        assert keeping is None
        disks.append(Disk(room + reserve_bytes, reserve=reserve_bytes))
        return TraceFile(disks[0], str(path), disks[0])

    monkeypatch.setattr("scanrack.traces.write.recorder.open_trace_file", on_a_small_disk)
    memory = bytearray(64)
    noise = random.Random(1)
    accepted: list[int] = []
    with pytest.raises(TraceFull) as full:  # noqa: PT012 - which of them raises is the disk's affair
        recorder = ScanRecorder("run.mcap", memory, SLOTS, scan_period_ns=2_000_000, program=PROGRAM)
        for scan in range(10_000):  # chunks of full size: 4096 scans of 107 bytes that do not compress
            memory[:] = noise.randbytes(64)
            accepted.append(scan)
            recorder.scan(scan, scan, 0)
    assert full.value.complete
    if accepted:
        recorder.close()
    assert stock_scans(bytes(disks[0].content)) == accepted


def test_a_device_has_no_reserve() -> None:
    file = open_trace_file(Path("/dev/null"), 1000)
    assert file._room is None
    file.close()


def test_the_reserve_grows_with_the_summary() -> None:
    disk = Disk(10**9, reserve=SUMMARY_ROOM)
    file = TraceFile(disk, "long", disk)
    for _ in range(1000):
        file.write(b"x" * 10)
    assert 1000 * 256 <= disk.size <= 1000 * 256 + SUMMARY_ROOM


def test_a_reserve_that_can_grow_no_more_ends_the_trace_in_good_time() -> None:
    disk = Disk(4 * SUMMARY_ROOM, reserve=SUMMARY_ROOM)
    file = TraceFile(disk, "long", disk)
    writes = 0
    while not file.full:
        file.write(b"x" * 10)
        writes += 1
    assert not disk.released  # the room for the summary is still held
    assert disk.size >= (writes - 1) * 256


def test_a_reserve_is_really_allocated_and_given_back(tmp_path: Path) -> None:
    reserve = DiskReserve(tmp_path)
    reserve.grow(300_000)
    held = os.fstat(reserve._file.fileno())
    assert reserve.size == 300_000
    assert held.st_blocks * 512 >= 300_000
    assert list(tmp_path.iterdir()) == []
    reserve.release()
    assert reserve.size == 0
    assert reserve._file.closed


@pytest.mark.parametrize(
    ("target", "why"),
    [
        ("missing/run.mcap", "no directory"),
        (".", "it is a directory"),
        ("taken/run.mcap", "no directory"),
    ],
    ids=["no directory", "a directory", "a file for a directory"],
)
def test_a_path_that_cannot_be_written_is_refused_before_any_scan(
    tmp_path: Path, target: str, why: str
) -> None:
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    with pytest.raises(OSError, match=why) as refusal:
        ScanRecorder(tmp_path / target, bytearray(64), SLOTS, scan_period_ns=2_000_000)
    assert str(tmp_path) in str(refusal.value)
    assert [entry.name for entry in tmp_path.iterdir()] == ["taken"]


@pytest.mark.skipif(getattr(os, "geteuid", int)() == 0, reason="root, and Windows, may write everywhere")
def test_no_permission_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OSError, match="Permission denied"):
            open_trace_file(tmp_path / "run.mcap", 1000)
    finally:
        tmp_path.chmod(0o700)


def test_no_permission_is_refused_as_root_would_see_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    monkeypatch.setattr("os.open", refuse)
    with pytest.raises(OSError, match=r"run\.mcap: Permission denied"):
        open_trace_file(tmp_path / "run.mcap", 1000)


def test_a_disk_without_room_for_the_reserve_is_refused_and_an_old_trace_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_room(self: DiskReserve, size: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(DiskReserve, "grow", no_room)
    path = tmp_path / "run.mcap"
    path.write_bytes(MAGIC + b"the old one")
    with pytest.raises(OSError, match="No space left on device; its end needs 1,000 bytes"):
        open_trace_file(path, 1000)
    assert path.read_bytes() == MAGIC + b"the old one"


def test_a_device_that_is_always_full_is_refused_before_any_scan() -> None:
    with pytest.raises(TraceFull, match="/dev/full: No space left on device"):
        ScanRecorder("/dev/full", bytearray(64), SLOTS, scan_period_ns=2_000_000)
