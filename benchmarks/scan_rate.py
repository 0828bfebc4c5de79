"""Scans per second with simulated 3601s in mid-move, with and without recording, beside a floor.

The floor moves the same bytes and does nothing else: per scan and module it
takes one input image from a buffer into the rack's memory and compares the
output image with the one before; with recording it also joins, compresses and
writes the bytes of the scans, without the records and indexes of a trace. What
is measured beside it is the whole scan: input latch, forces, logic, output
latch, listeners, housekeeping, the modules' motion, and a complete MCAP file.

Scans in mid-move go by rows (docs/decisions/0012); the making of the rows counts.

    python benchmarks/scan_rate.py            a table
    python benchmarks/scan_rate.py --smoke    a short run that only checks
    python benchmarks/scan_rate.py --memory   10 million scans; memory has to stay flat
"""

from __future__ import annotations

import argparse
import resource
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import zstandard
from scanrack.io_images.amci3601 import Configuration, Direction, Idle, InputBit, Manual
from scanrack.io_images.image import WORDS, Image
from scanrack.io_images.thousands import join_reported
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.runtime.modules.amci3601 import Amci3601
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.reader import open_trace
from scanrack.traces.write.recorder import ScanRecorder

PERIOD_NS = 2_000_000
MODULES = (1, 4, 16)
CHUNK_SCANS = 4096
ROUNDS = 3

CONFIGURE = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT, step_and_direction=True, starting_speed=1000
).to_image()
MOVE = Manual(Direction.CW, 5000, 20, 10).to_image()
SCRIPT = (CONFIGURE, Idle().to_image(), MOVE)
MOVE_STARTS_NS = 2 * PERIOD_NS


def logic(scan) -> None:
    """Bring every module into a manual move in the first three scans, then leave it alone."""
    if scan.number < len(SCRIPT):
        for slot in scan.slot.values():
            slot.outputs.load(SCRIPT[scan.number])


def position_at(now_ns: int) -> int:
    """Return the position by chapter 2: 0.2 s and 600 steps of ramp, then 5 steps per ms."""
    return 600 + (now_ns - MOVE_STARTS_NS - 200_000_000) * 5 // 1_000_000


def rack_of(modules: int) -> Rack:
    """Return a rack with so many 3601s."""
    return Rack(Card(number, Amci3601(), "amci3601", "4.1") for number in range(1, modules + 1))


def measure_scans(modules: int, scans: int, trace: Path | None) -> float:
    """Return the seconds that `scans` scans took; check where they led and what was recorded."""
    rack = rack_of(modules)
    listeners = []
    if trace is not None:
        slots = [SlotInfo(number, "amci3601", "4.1") for number in rack.slots]
        listeners.append(ScanRecorder(trace, rack.memory, slots, scan_period_ns=PERIOD_NS))
    cpu = Cpu(rack, logic, PERIOD_NS, listeners=listeners)
    start = time.perf_counter()
    cpu.run(scans)
    cpu.close()
    took = time.perf_counter() - start
    for slot in rack.slots.values():
        check(join_reported(slot.inputs[2], slot.inputs[3]), position_at((scans - 1) * PERIOD_NS), "position")
    if trace is not None:
        with open_trace(trace) as recording:
            check(sum(1 for _ in recording.scans()), scans, "scans in the trace")
    return took


def measure_floor(modules: int, scans: int, trace: Path | None) -> float:
    """Return the seconds that moving and recording the same bytes took."""
    memory = bytearray(4 * WORDS * modules)
    view = memoryview(memory)
    outputs = bytes(2 * WORDS)
    latch = [
        (view[place : place + 2 * WORDS], view[place + 2 * WORDS : place + 4 * WORDS])
        for place in range(0, len(memory), 4 * WORDS)
    ]
    source = Image(range(8))
    record = floor_recorder(trace, memory) if trace is not None else None
    start = time.perf_counter()
    for scan in range(scans):
        source.words[3] = scan & 0x3FF  # a position that moves, for the compressor's sake
        for out, into in latch:
            into[:] = source.raw
            if out.tobytes() != outputs:
                raise AssertionError
        if record is not None:
            record(scan)
    if record is not None:
        record(-1)
    return time.perf_counter() - start


def floor_recorder(trace: Path, memory: bytearray) -> Callable[[int], None]:
    """Return what joins, compresses and writes the bytes of each scan, and ends the file at scan -1."""
    file = trace.open("wb", buffering=0)
    compressor = zstandard.ZstdCompressor(level=1)
    head = struct.Struct("<III")
    scans: list[bytes] = []

    def record(scan: int) -> None:
        if scan >= 0:
            scans.append(head.pack(0x100, scan, 1) + memory)
        if scan < 0 or len(scans) == CHUNK_SCANS:
            file.write(compressor.compress(b"".join(scans)))
            scans.clear()
        if scan < 0:
            file.close()

    return record


def check(found: object, expected: object, what: str) -> None:
    """Stop the benchmark if it measured something wrong."""
    if found != expected:
        raise SystemExit(f"{what} is {found}, should be {expected}")


def table(scans: int, rounds: int) -> None:
    """Print the rates, best of `rounds`, and the ratio to the floor of the same run."""
    print(f"{'modules':>7} {'recording':>9} {'scans/s':>9} {'us/scan':>8} {'floor us':>8} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as folder:
        for modules in MODULES:
            count = max(scans // modules, 1_000)
            for trace in (None, Path(folder) / "trace.mcap"):
                took = min(measure_scans(modules, count, trace) for _ in range(rounds)) / count
                plain = trace and trace.with_suffix(".bin")  # a recording replaces no file of another kind
                floor = min(measure_floor(modules, count, plain) for _ in range(rounds)) / count
                recording = "no" if trace is None else "yes"
                print(
                    f"{modules:>7} {recording:>9} {1 / took:>9,.0f} {took * 1e6:>8.2f} "
                    f"{floor * 1e6:>8.2f} {took / floor:>6.1f}"
                )


def memory(scans: int) -> None:
    """Print the memory after every tenth of a long recorded run; fail if it grows by over 8 MiB."""
    with tempfile.TemporaryDirectory() as folder:
        rack = rack_of(1)
        slots = [SlotInfo(1, "amci3601", "4.1")]
        recorder = ScanRecorder(Path(folder) / "trace.mcap", rack.memory, slots, scan_period_ns=PERIOD_NS)
        cpu = Cpu(rack, logic, PERIOD_NS, listeners=[recorder])
        seen = []
        for _ in range(10):
            cpu.run(scans // 10)
            seen.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
            print(f"{cpu.scan:>12,} scans  {seen[-1]:>7.1f} MiB")
        cpu.close()
        if seen[-1] - seen[0] > 8:
            raise SystemExit(f"memory grew by {seen[-1] - seen[0]:.1f} MiB")


def main(arguments: Sequence[str]) -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    parser.add_argument("--memory", action="store_true", help="10 million scans; memory has to stay flat")
    parser.add_argument("--scans", type=int, default=300_000, help="with one module (default: %(default)s)")
    given = parser.parse_args(arguments)
    if given.memory:
        memory(10_000_000)
    else:
        table(4_000 if given.smoke else given.scans, 1 if given.smoke else ROUNDS)


if __name__ == "__main__":
    main(sys.argv[1:])
