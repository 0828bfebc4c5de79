"""What reading a trace costs, beside the stock reader.

    python benchmarks/reading.py [--scans N] [--smoke]

A million scans of 1 and of 4 slots, mid-move:

    arrays     read_columns: all scans as named arrays, CRCs checked
    slice      1,000 scans in the midst of it, by number, the file opened again
    one        one scan at random, in a trace that is open
    scans      iterating over Trace.scans(), an object per scan
    stock      iterating over the `mcap` library's reader, CRC validation on, nothing decoded

Times are processor time, the best of some rounds. The positions that were read are compared with
those that were recorded, all of them.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from recorder import PERIOD_NS, Rack, record, timed
from scanrack.traces.read.arrays import Selection, by_name, read_columns, scan_at
from scanrack.traces.read.reader import open_trace

SLOTS = (1, 4)
SLICE = 1_000
AT_RANDOM = 50


def arrays(path: Path, slots: int, scans: int) -> None:
    with open_trace(path) as trace:
        columns = read_columns(trace)
        named = by_name(columns.words, trace.head.slots)
    check(columns.scan, columns.time_ns, named[f"slot{slots}"]["in"], np.arange(scans))


def check(numbers: np.ndarray, time_ns: np.ndarray, image: np.ndarray, wanted: np.ndarray) -> None:
    """Compare with what `Rack.move` does; AssertionError where it differs."""
    msw, lsw = np.divmod(wanted * 10, 1000)
    expected = (wanted, wanted * PERIOD_NS, msw & 0x7FFF, lsw)
    for found, right in zip(
        (numbers, time_ns, image["position_msw"], image["position_lsw"]), expected, strict=True
    ):
        if not np.array_equal(found, right):
            raise AssertionError("what was read is not what was recorded")


def a_slice(path: Path, slots: int, scans: int) -> None:
    first = scans // 2
    with open_trace(path) as trace:
        columns = read_columns(trace, Selection(first, first + SLICE - 1))
        named = by_name(columns.words, trace.head.slots)
    wanted = np.arange(first, first + SLICE)
    check(columns.scan, columns.time_ns, named[f"slot{slots}"]["in"], wanted)


def at_random(path: Path, scans: int) -> float:
    """Return the time of one scan."""
    numbers = random.Random(1).choices(range(scans), k=AT_RANDOM)

    def find() -> None:
        for number in numbers:
            if scan_at(trace, number).now_ns != number * PERIOD_NS:
                raise AssertionError(f"scan {number} is another one")

    with open_trace(path) as trace:
        find()  # where the chunks begin is found once
        return timed(find) / AT_RANDOM


def one_by_one(path: Path, slots: int, scans: int) -> None:
    with open_trace(path) as trace:
        count(sum(1 for _ in trace.scans()), scans)


def stock(path: Path, slots: int, scans: int) -> None:
    with path.open("rb") as file:
        messages = make_reader(file, validate_crcs=True).iter_messages("/scan", log_time_order=False)
        count(sum(1 for _ in messages), scans)


def count(found: int, scans: int) -> None:
    if found != scans:
        raise AssertionError(f"{found} scans read instead of {scans}")


JOBS: dict[str, Callable[[Path, int, int], None]] = {
    "arrays": arrays,
    "slice": a_slice,
    "scans": one_by_one,
    "stock": stock,
}


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What reading a trace costs.")
    parser.add_argument("--scans", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    scans, rounds = (10_000, 1) if given.smoke else (given.scans, given.rounds)
    print(f"{scans:,} scans\nslots  what      seconds   µs/scan    x arrays")
    with tempfile.TemporaryDirectory() as folder:
        for slots in SLOTS:
            path = Path(folder) / f"{slots}.mcap"
            record(Rack(slots), scans, path)
            took = {
                name: min(timed(job, path, slots, scans) for _ in range(rounds)) for name, job in JOBS.items()
            }
            took["one"] = at_random(path, scans)
            for name, seconds in took.items():
                each = seconds / {"slice": SLICE, "one": 1}.get(name, scans) * 1e6
                ratio = seconds / took["arrays"]
                print(f"{slots:5}  {name:8} {seconds:8.4f} {each:9.2f} {ratio:11.2f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
