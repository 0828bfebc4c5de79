"""What recording a scan costs, beside other writers and the least it could cost.

    python benchmarks/recorder.py [--scans N] [--smoke]

For 1, 4 and 16 slots, all of them mid-move (position words change in every scan):

    floor      joining the same payloads, compressing and writing them by the MiB: no records,
               no indexes, no checksums
    recorder   ScanRecorder.scan, per scan, closing the file included
    Rust       the writer of foxglove-sdk, if that is installed: pip install foxglove-sdk
    stock      the `mcap` library's writer, one add_message per scan
    busy       the recorder with a draft every 0.1 s of scans of 20 µs, as a session at speed max has it
    paced      the same with scans of 2 ms, as in real time: a draft every 50 scans

The loop that moves the positions is timed alone and taken off all of them; times are processor time,
the best of some rounds taken in turns, so what counts on a busy machine is the ratio. All compress with
zstd, level 1, in one thread. Each trace is read back with the stock reader, its CRC validation on, and
compared scan by scan.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from math import inf
from pathlib import Path
from time import process_time

import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from scanrack.io_images.image import WORDS
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.format.schema import (
    CDR_PREFIX,
    MESSAGE_ENCODING,
    SCAN_HEAD,
    SCHEMA_ENCODING,
    scan_schema,
)
from scanrack.traces.format.topics import SCAN_TOPIC
from scanrack.traces.write.recorder import CHUNK_BYTES_MAX, ScanRecorder

PERIOD_NS = 2_000_000
BUSY_NS = 20_000
SLOTS = (1, 4, 16)

Tell = Callable[[int, int, int], None]
Write = Callable[["Rack", int, Path], None]

DRAFT_NS = 100_000_000
"""Time on the clock from draft to draft."""


class Rack:
    """A memory block with a 3601 mid-move in every slot."""

    def __init__(self, slots: int) -> None:
        self.slots = [SlotInfo(number, "amci3601", "4.1") for number in range(1, slots + 1)]
        self.memory = bytearray(4 * WORDS * slots)
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

    def run(self, scans: int, tell: Tell, first: int = 0) -> None:
        """Move and tell, scan by scan."""
        for scan in range(first, first + scans):
            self.move(scan)
            tell(scan, scan * PERIOD_NS, 1)


def timed(action: Callable[..., object], *arguments: object) -> float:
    """Return the processor time that an action takes: a busy machine falsifies it less than a wall clock."""
    start = process_time()
    action(*arguments)
    return process_time() - start


def say_nothing(scan: int, now_ns: int, flags: int) -> None:
    pass


def record(rack: Rack, scans: int, path: Path) -> None:
    recorder = ScanRecorder(path, rack.memory, rack.slots, scan_period_ns=PERIOD_NS)
    rack.run(scans, recorder.scan)
    recorder.close()


def drafting(every: int) -> Write:
    """Return what records with a draft every so many scans; the bytes are those of a recording without."""

    def write(rack: Rack, scans: int, path: Path) -> None:
        recorder = ScanRecorder(path, rack.memory, rack.slots, scan_period_ns=PERIOD_NS)
        for first in range(0, scans, every):
            recorder.draft_soon()
            rack.run(min(every, scans - first), recorder.scan, first)
        recorder.close()

    return write


def record_stock(rack: Rack, scans: int, path: Path) -> None:
    """Write the same messages with the stock writer."""
    schema = scan_schema(rack.slots)
    pack, memory = SCAN_HEAD.pack, rack.memory
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start("ros2", "stock")
        number = writer.register_schema(schema.name, SCHEMA_ENCODING, schema.text.encode())
        channel = writer.register_channel(SCAN_TOPIC, MESSAGE_ENCODING, number)

        def tell(scan: int, now_ns: int, flags: int) -> None:
            writer.add_message(channel, now_ns, pack(CDR_PREFIX, scan, flags) + memory, now_ns, scan)

        rack.run(scans, tell)
        writer.finish()


def record_rust(rack: Rack, scans: int, path: Path) -> None:
    """Write the same messages with a writer in Rust."""
    from foxglove import Channel, Context, Schema, open_mcap
    from foxglove.mcap import MCAPWriteOptions

    schema = scan_schema(rack.slots)
    described = Schema(name=schema.name, encoding=SCHEMA_ENCODING, data=schema.text.encode())
    context = Context()
    channel = Channel(SCAN_TOPIC, schema=described, message_encoding=MESSAGE_ENCODING, context=context)
    options = MCAPWriteOptions(
        compression_level=1, compression_threads=0, calculate_data_section_crc=False, profile="ros2"
    )
    pack, memory, log = SCAN_HEAD.pack, rack.memory, channel.log
    with open_mcap(path, allow_overwrite=True, context=context, writer_options=options):

        def tell(scan: int, now_ns: int, flags: int) -> None:
            log(pack(CDR_PREFIX, scan, flags) + memory, log_time=now_ns)

        rack.run(scans, tell)


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
        messages = make_reader(file, validate_crcs=True).iter_messages(SCAN_TOPIC, log_time_order=False)
        count = 0
        for count, (_, _, message) in enumerate(messages, start=1):
            scan = count - 1
            rack.move(scan)
            wanted = SCAN_HEAD.pack(CDR_PREFIX, scan, 1) + rack.memory
            if (message.log_time, message.data) != (scan * PERIOD_NS, wanted):
                raise AssertionError(f"scan {scan} was not recorded as it was")
    if count != scans:
        raise AssertionError(f"{count} scans recorded instead of {scans}")


def writers() -> dict[str, Write]:
    """Return the writers by name, the floor first."""
    found: dict[str, Write] = {"floor": join_and_compress, "recorder": record}
    if find_spec("foxglove"):
        found["Rust"] = record_rust
    found |= {"busy": drafting(DRAFT_NS // BUSY_NS), "paced": drafting(DRAFT_NS // PERIOD_NS)}
    return found | {"stock": record_stock}


def measure(slots: int, scans: int, rounds: int, directory: Path) -> Iterator[str]:
    """Yield lines of the table: the best of some rounds, taken in turns."""
    rack = Rack(slots)
    paths = {name: directory / f"{name}.mcap" for name in writers()}
    best = dict.fromkeys(["bare", *paths], inf)
    for _ in range(rounds):
        best["bare"] = min(best["bare"], timed(rack.run, scans, say_nothing))
        for name, write in writers().items():
            best[name] = min(best[name], timed(write, rack, scans, paths[name]))
    costs = {name: (best[name] - best["bare"]) / scans * 1e6 for name in paths}
    for name, path in paths.items():
        if name != "floor":
            check(rack, scans, path)
        ratios = "".join(f"{costs[name] / max(costs[than], 1e-9):11.1f}" for than in ("floor", "recorder"))
        yield f"{slots:5}  {name:9} {costs[name]:9.2f}{ratios} {path.stat().st_size / scans:11.1f}"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What recording a scan costs.")
    parser.add_argument("--scans", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    scans, rounds = (2_000, 1) if given.smoke else (given.scans, given.rounds)
    print("slots  writer      µs/scan    x floor x recorder  bytes/scan")
    with tempfile.TemporaryDirectory() as directory:
        for slots in SLOTS:
            for line in measure(slots, scans, rounds, Path(directory)):
                print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
