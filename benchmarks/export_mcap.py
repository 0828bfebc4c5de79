"""What a copy of a trace with decoded values costs, beside the least that a copy could cost.

    python benchmarks/export_mcap.py [--scans N] [--smoke]

A million scans of one 3601 that moves to and fro, with a configuration now and then:

    floor      going through the columns of the trace and doing nothing with them
    export     scanrack export --mcap: position, speed and 51 bits of every scan, after what was recorded

Times are processor time of one run. The copy is read by our reader, whose columns must be those of the
recording, and by the stock MCAP reader: in scans all over the trace position and speed must be those that
were recorded, NaN in configuration mode.

Exit status 1 if a million scans cost more than 1.5 s.
"""

from __future__ import annotations

import argparse
import struct
import sys
import tempfile
from math import isnan
from pathlib import Path
from time import process_time

import numpy as np
from mcap.reader import make_reader
from scanrack.io_images.image import WORDS
from scanrack.traces.export import write_mcap
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.arrays import read_columns
from scanrack.traces.read.reader import open_trace
from scanrack.traces.signals import blocks
from scanrack.traces.write.recorder import ScanRecorder

PERIOD_NS = 2_000_000
STROKE = 4_000
"""Scans of a move; ten steps each, 5,000 steps/s."""

CONFIGURED = range(6_000, 6_010)
"""Scans of every 50,000 in which the module is in configuration mode."""

DECODED_AT = 4 + 8 + 4 * WORDS + 0
"""Byte of a payload at which the decoded values begin: speed, position, encoder, captured."""

MOST_S = 1.5
CHECKED_EVERY = 997


def phase_of(scan: int) -> tuple[int, bool, bool]:
    """Return position in steps, whether it moves back, and whether the module is being configured."""
    phase = scan % (2 * STROKE)
    back = phase >= STROKE
    return 10 * (2 * STROKE - phase if back else phase), back, scan % 50_000 in CONFIGURED


def record(path: Path, scans: int) -> None:
    """Record the moves scan by scan, as a rack would."""
    memory = bytearray(4 * WORDS)
    words = memoryview(memory).cast("h")
    recorder = ScanRecorder(path, memory, [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=PERIOD_NS)
    for scan in range(scans):
        position, back, configured = phase_of(scan)
        words[8] = -0x4000 if configured else 0x4002 if back else 0x4001
        words[10], words[11] = divmod(position, 1000)
        recorder.scan(scan, scan * PERIOD_NS, 1)
    recorder.close()


def check(path: Path, copy: Path, scans: int) -> None:
    """Read the copy with our reader and with the stock one.

    Raises:
        AssertionError: a value is not what was recorded.
    """
    with open_trace(path) as one, open_trace(copy) as other:
        assert not other.notes
        for a, b in zip(read_columns(one).images(), read_columns(other).images(), strict=True):
            assert np.array_equal(a, b)
    count = 0
    with copy.open("rb") as file:
        for _, _, message in make_reader(file).iter_messages(topics=["/scan"]):
            if message.sequence % CHECKED_EVERY == 0:
                check_scan(message.sequence, message.data)
            count += 1
    assert count == scans, count


def check_scan(scan: int, payload: bytes) -> None:
    speed, position = struct.unpack_from("<dd", payload, DECODED_AT)
    wanted, back, configured = phase_of(scan)
    assert isnan(position) if configured else position == wanted, (scan, position, wanted)
    steady = all(phase_of(scan + near)[1:] == (back, False) for near in (-6, 6))
    assert not steady or speed == (-5_000 if back else 5_000), (scan, speed)


def main() -> int:
    """Measure, print, and say whether the bound holds."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scans", type=int, default=1_000_000)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args()
    scans = 60_000 if given.smoke else given.scans
    with tempfile.TemporaryDirectory() as folder:
        path, copy = Path(folder) / "a.mcap", Path(folder) / "b.mcap"
        record(path, scans)
        with open_trace(path) as trace:
            start = process_time()
            for _ in blocks(trace):
                pass
            floor = process_time() - start
            start = process_time()
            write_mcap(trace, copy)
            took = process_time() - start
        check(path, copy, scans)
        sizes = [each.stat().st_size / scans for each in (path, copy)]
    million = took / scans * 1e6
    print(f"{scans:,} scans: floor {floor:.2f} s, export {took:.2f} s, {million:.2f} s a million")
    print(f"bytes a scan: recording {sizes[0]:.1f}, copy {sizes[1]:.1f}")
    return int(not given.smoke and million > MOST_S)


if __name__ == "__main__":
    sys.exit(main())
