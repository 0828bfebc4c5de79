"""What reading a trace costs, beside the stock reader.

    python benchmarks/reading.py [--scans N] [--long N] [--smoke]

A million scans of 1 and of 4 slots, mid-move:

    arrays     read_columns: all scans as named arrays, CRCs checked
    slice      1,000 scans in the midst of it, by number, the file opened again
    one        one scan at random, in a trace that is open
    scans      iterating over Trace.scans(), an object per scan
    stock      iterating over the `mcap` library's reader, CRC validation on, nothing decoded

Then five million scans of 1 slot, each in a process of its own, imports included:

    query      open_trace, and a query for the scans beyond a position; at most 0.08 of stock, and 60 MiB
    stock      as above

Times are processor time, the best of some rounds. The positions that were read are compared with
those that were recorded, all of them.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from bars import Bars
from mcap.reader import make_reader
from recorder import PERIOD_NS, Rack, record, timed
from scanrack.traces.read.arrays import Selection, by_name, read_columns, scan_at
from scanrack.traces.read.reader import open_trace

MOST_QUERY, MOST_MIB = 0.08, 60
BEYOND = "slot1.in.position > 4000"

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


def alone(name: str, path: Path, scans: int) -> tuple[float, float]:
    """Return processor time, s, and memory, MiB, of a job in a process of its own."""
    words = [sys.executable, "-c", CHILD[name], str(path), str(scans), str(Path(__file__).parent)]
    said = subprocess.run(words, check=True, capture_output=True, text=True, encoding="utf-8").stdout
    seconds, mib = map(float, said.split())
    return seconds, mib


_END = """
import time
sys.path.append(sys.argv[3])
from bars import highest_mib
print(time.process_time(), highest_mib())
"""
CHILD = {
    "query": f"""
import sys
from scanrack import open_trace, query
with open_trace(sys.argv[1]) as trace:
    found = query(trace, {BEYOND!r})
# position 10 * n from scan n on, of 6 digits and again from 0; see Rack.move
assert found.occurrences[0].first == 401, found
assert found.occurrences[-1].last == int(sys.argv[2]) - 1, found
{_END}
""",
    "stock": f"""
import sys
from mcap.reader import make_reader
with open(sys.argv[1], "rb") as file:
    messages = make_reader(file, validate_crcs=True).iter_messages("/scan", log_time_order=False)
    assert sum(1 for _ in messages) == int(sys.argv[2])
{_END}
""",
}


def report_query(path: Path, scans: int, rounds: int, bars: Bars) -> None:
    """Measure a query of a long recording, beside the stock reader, in turns."""
    record(Rack(1), scans, path)
    runs = [(alone("query", path, scans), alone("stock", path, scans)) for _ in range(rounds)]
    ours, stock = (min(each[0] for each in side) for side in zip(*runs, strict=True))
    mib = max(run[0][1] for run in runs)
    ratio = ours / stock
    print(f"{scans:,} scans: a query {ours:.2f} s, the stock reader {stock:.2f} s")
    print(f"  ratio {ratio:.3f}, {bars.most('query / stock', ratio, MOST_QUERY)}")
    print(f"  memory {mib:.0f} MiB, {bars.most('MiB of a query', mib, MOST_MIB)}")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What reading a trace costs.")
    parser.add_argument("--scans", type=int, default=1_000_000)
    parser.add_argument("--long", type=int, default=5_000_000, help="scans that are queried")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    scans, rounds = (10_000, 1) if given.smoke else (given.scans, given.rounds)
    bars = Bars(count=not given.smoke)
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
        report_query(Path(folder) / "long.mcap", scans if given.smoke else given.long, rounds, bars)
    return bars.status()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
