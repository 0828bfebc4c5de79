"""What recording a scan costs, beside the least it could cost.

    python benchmarks/recorder.py [--scans N] [--smoke]

For 1, 4 and 16 slots, all of them mid-move (position words change in every scan):

    recorder   ScanRecorder.scan, per scan, closing the file included
    floor      joining the same payloads, compressing and writing them by the MiB: no records,
               no indexes, no checksums

The loop that moves the positions is timed alone and taken off both; times are processor time,
the best of some rounds. The trace is read back with the stock reader, its CRC validation on,
and compared scan by scan.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time

import zstandard
from mcap.reader import make_reader
from scanrack.traces.layout import SLOT_BYTES, SlotInfo
from scanrack.traces.recorder import CHUNK_BYTES_MAX, ScanRecorder
from scanrack.traces.schema import CDR_PREFIX, SCAN_HEAD

PERIOD_NS = 2_000_000
SLOTS = (1, 4, 16)

Tell = Callable[[int, int, int], None]


class Rack:
    """A memory block with a 3601 mid-move in every slot."""

    def __init__(self, slots: int) -> None:
        self.slots = [SlotInfo(number, "amci3601", "4.1") for number in range(1, slots + 1)]
        self.memory = bytearray(SLOT_BYTES * slots)
        words = memoryview(self.memory).cast("h")
        for place in range(0, len(words), 16):
            words[place] = 0x0002  # relative move
            words[place + 8] = 0x4001  # MODULE_OK, MOVING_CW
        self._words = words
        self._positions = [(place + 10, place + 11) for place in range(0, len(words), 16)]

    def move(self, scan: int) -> None:
        """Let every axis be where 5000 steps/s take it."""
        msw, lsw = divmod(scan * 10, 1000)
        words = self._words
        for at_msw, at_lsw in self._positions:
            words[at_msw] = msw & 0x7FFF
            words[at_lsw] = lsw

    def run(self, scans: int, tell: Tell) -> None:
        """Move and tell, scan by scan."""
        for scan in range(scans):
            self.move(scan)
            tell(scan, scan * PERIOD_NS, 1)


def timed(action: Callable[[], object]) -> float:
    """Return the processor time that an action takes: a busy machine falsifies it less than a wall clock."""
    start = process_time()
    action()
    return process_time() - start


def record(rack: Rack, scans: int, path: Path) -> None:
    recorder = ScanRecorder(path, rack.memory, rack.slots, scan_period_ns=PERIOD_NS)
    rack.run(scans, recorder.scan)
    recorder.close()


def join_and_compress(rack: Rack, scans: int, path: Path) -> None:
    """Write the payloads and nothing else."""
    size = SCAN_HEAD.size + len(rack.memory)
    batch = CHUNK_BYTES_MAX // size
    pending: list[bytes] = []
    pack, memory, keep = SCAN_HEAD.pack, rack.memory, pending.append
    with path.open("wb", buffering=0) as file:

        def tell(scan: int, now_ns: int, flags: int) -> None:
            keep(pack(CDR_PREFIX, scan, flags) + memory)
            if len(pending) == batch:
                flush()

        def flush() -> None:
            file.write(zstandard.compress(b"".join(pending)))
            pending.clear()

        rack.run(scans, tell)
        flush()


def check(rack: Rack, scans: int, path: Path) -> None:
    """Compare the trace with what was to be recorded; AssertionError for the first scan that differs."""
    with path.open("rb") as file:
        messages = make_reader(file, validate_crcs=True).iter_messages("/scan", log_time_order=False)
        count = 0
        for count, (_, _, message) in enumerate(messages, start=1):
            scan = count - 1
            rack.move(scan)
            wanted = SCAN_HEAD.pack(CDR_PREFIX, scan, 1) + rack.memory
            if (message.sequence, message.log_time, message.data) != (scan, scan * PERIOD_NS, wanted):
                raise AssertionError(f"scan {scan} was not recorded as it was")
    if count != scans:
        raise AssertionError(f"{count} scans recorded instead of {scans}")


def measure(slots: int, scans: int, rounds: int, directory: Path) -> str:
    """Return a line of the table: the best of some rounds, taken in turns."""
    rack = Rack(slots)
    trace, floor = directory / "run.mcap", directory / "floor.zst"
    actions: tuple[Callable[[], object], ...] = (
        lambda: rack.run(scans, lambda scan, now_ns, flags: None),
        lambda: record(rack, scans, trace),
        lambda: join_and_compress(rack, scans, floor),
    )
    turns = [[timed(action) for action in actions] for _ in range(rounds)]
    bare, recorder, least = (min(times) / scans * 1e6 for times in zip(*turns, strict=True))
    check(rack, scans, trace)
    size, least_size = (path.stat().st_size / scans for path in (trace, floor))
    mine, least = recorder - bare, least - bare
    ratio = f"{mine / least:7.1f}" if least > 0 else "      -"
    return f"{slots:5} {mine:11.2f} {least:11.2f} {ratio} {size:12.1f} {least_size:12.1f}"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What recording a scan costs.")
    parser.add_argument("--scans", type=int, default=200_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    scans, rounds = (2_000, 1) if given.smoke else (given.scans, given.rounds)
    print("slots recorder µs    floor µs   ratio  bytes/scan  floor bytes")
    with tempfile.TemporaryDirectory() as directory:
        for slots in SLOTS:
            print(measure(slots, scans, rounds, Path(directory)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
