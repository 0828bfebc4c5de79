"""Recordings that are killed at random moments: what is lost, and whether every file opens.

    python benchmarks/kills.py [--kills N] [--smoke]

A child process records as fast as it can and notes in shared memory how many scans it has handed to
the recorder; kill -9 meets it within the first fifth of a second. Then the trace is opened as it is,
compared scan by scan with what was recorded, repaired, and read by the stock reader with CRC
validation. `lost` counts the scans that were given to the recorder and are not in the file: never more than
the open chunk holds.
"""

from __future__ import annotations

import argparse
import mmap
import os
import random
import signal
import sys
import tempfile
from pathlib import Path
from struct import Struct
from time import sleep

import numpy as np
from mcap.reader import make_reader
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.arrays import by_name, read_columns
from scanrack.traces.read.reader import open_trace
from scanrack.traces.repair import repair
from scanrack.traces.write.recorder import ScanRecorder

SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "amci3601", "4.1")]
CHUNK_SCANS = 1_000
LATEST_S = 0.2
COUNT = Struct("<Q")


def record_for_ever(path: Path, told: mmap.mmap) -> None:
    """Record a position that counts up, an event now and then."""
    memory = bytearray(64)
    words = memoryview(memory).cast("h")
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, chunk_scans=CHUNK_SCANS)
    scan = 0
    while True:
        words[10], words[11] = divmod(scan, 1000)
        if scan % 777 == 0:
            recorder.event(scan, scan * 2_000_000, "/stimuli", {"name": "HOME"})
        recorder.scan(scan, scan * 2_000_000, 1)
        scan += 1
        COUNT.pack_into(told, 0, scan)


def kill_one(path: Path, after_s: float) -> int:
    """Let a child record, and kill it; return how many scans it has recorded."""
    told = mmap.mmap(-1, COUNT.size)
    child = os.fork()
    if child == 0:
        record_for_ever(path, told)
    while COUNT.unpack(told[:])[0] == 0:
        sleep(0.0005)
    sleep(after_s)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    handed_over: int = COUNT.unpack(told[:])[0]
    return handed_over


def check(path: Path) -> int:
    """Return how many scans a trace has; AssertionError if they are not those that were recorded."""
    with open_trace(path) as trace:
        columns = read_columns(trace)
        image = by_name(columns.words, trace.head.slots)["slot1"]["in"]
        wanted = np.arange(len(columns.scan))
        expected = (wanted, *np.divmod(wanted, 1000))
        for found, right in zip(
            (columns.scan, image["position_msw"], image["position_lsw"]), expected, strict=True
        ):
            if not np.array_equal(found, right):
                raise AssertionError(f"{path}: what is in it is not what was recorded")
        if any(event.scan % 777 for event in trace.events()):
            raise AssertionError(f"{path}: an event that was not recorded")
    return len(columns.scan)


def check_repaired(path: Path, scans: int) -> None:
    """Repair a trace and read it with the stock reader."""
    if not repair(path).needed or check(path) != scans:
        raise AssertionError(f"{path}: the repair lost scans")
    with path.open("rb") as file:
        found = sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages("/scan"))
    if found != scans:
        raise AssertionError(f"{path}: the stock reader finds {found} scans instead of {scans}")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Recordings that are killed at random moments.")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--smoke", action="store_true", help="a few kills only")
    given = parser.parse_args(arguments)
    kills = 4 if given.smoke else given.kills
    moments = random.Random(1)
    lost, kept = [], []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(kills):
            path = Path(folder) / f"{number}.mcap"
            handed_over = kill_one(path, moments.uniform(0, LATEST_S))
            scans = check(path)
            check_repaired(path, scans)
            kept.append(scans)
            lost.append(max(0, handed_over - scans))
            if lost[-1] > CHUNK_SCANS:
                raise AssertionError(f"{path}: {lost[-1]} scans lost, a chunk holds {CHUNK_SCANS}")
    print(f"{kills} kills, every file opened; {min(kept):,} to {max(kept):,} scans kept, all as recorded")
    print(f"scans lost: {min(lost):,} to {max(lost):,} of an open chunk of {CHUNK_SCANS:,}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
