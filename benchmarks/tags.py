"""What recording ten tags costs per scan, beside recording the images alone.

    python benchmarks/tags.py [--scans N] [--smoke]

A ladder program's ten tags: a REAL, two ACC of timers, a step and six bits. Two recorders, one with the
tags and one without, take turns of some thousand scans in one process, so that both meet the same load;
times are processor time, the best of the turns. The loop that changes the tags is taken off both.
Afterwards both traces are read back, and images and tags are compared scan by scan.

Exit status 1 if ten tags cost more than 0.25 us.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from math import inf
from pathlib import Path
from time import process_time

import numpy as np
from scanrack.io_images.image import WORDS
from scanrack.jobs.record.tag_source import tags_of
from scanrack.ladder.files.rungfile import parse_program
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.arrays import read_columns
from scanrack.traces.read.reader import open_trace
from scanrack.traces.write.recorder import CHUNK_SCANS, ScanRecorder

PERIOD_NS = 2_000_000
SLOTS = [SlotInfo(1, "amci3601", "4.1")]
MOST_US = 0.25

PROGRAM = """
PROGRAM line
TAG Level : REAL
TAG Fill : TIMER
TAG Drain : TIMER
TAG Step : INT
TAG B0 : BOOL
TAG B1 : BOOL
TAG B2 : BOOL
TAG B3 : BOOL
TAG B4 : BOOL
TAG B5 : BOOL
ROUTINE Main
XIC(B0)OTE(B1);
END
"""
PATTERNS = ["Level", "Fill.ACC", "Drain.ACC", "Step", "B?"]


class Line:
    """The tags of a program, changed as a machine of three steps changes them."""

    def __init__(self, memory: bytearray) -> None:
        logic = parse_program(PROGRAM)
        self.source = tags_of(logic, PATTERNS, memory)
        self._write = logic.engine.memory.write
        self._fill, self._step, self._bit = map(logic.engine.memory.layout.leaf, ("Fill.ACC", "Step", "B0"))
        self._memory = memory

    def move(self, scan: int) -> None:
        """Change what changes in a scan: a word of the module, a timer; a step and a bit every 500 scans."""
        self._memory[4:6] = (scan & 0x7FFF).to_bytes(2, "little")
        self._write(self._fill, 0, 2 * (scan % 1000))
        self._write(self._step, 0, scan // 500 % 3)
        self._write(self._bit, 0, scan % 1000 < 500)


def measure(folder: Path, scans: int) -> tuple[float, float]:
    """Return what a scan costs without tags and with them, us, less the loop that changes them."""
    memory = bytearray(4 * WORDS)
    line = Line(memory)
    plain, tagged = folder / "plain.mcap", folder / "tagged.mcap"
    recorders = {
        "loop": None,
        "plain": ScanRecorder(plain, memory, SLOTS, scan_period_ns=PERIOD_NS),
        "tagged": ScanRecorder(tagged, memory, SLOTS, scan_period_ns=PERIOD_NS, tags=line.source),
    }
    best = dict.fromkeys(recorders, inf)
    for start in range(0, scans, CHUNK_SCANS):
        for name, recorder in recorders.items():
            begin = process_time()
            for scan in range(start, start + CHUNK_SCANS):
                line.move(scan)
                if recorder is not None:
                    recorder.scan(scan, scan * PERIOD_NS, 0)
            best[name] = min(best[name], process_time() - begin)
    for recorder in recorders.values():
        if recorder is not None:
            recorder.close()
    check(plain, tagged)
    return tuple((best[name] - best["loop"]) / CHUNK_SCANS * 1e6 for name in ("plain", "tagged"))  # type: ignore[return-value]


def check(plain: Path, tagged: Path) -> None:
    """Read both traces back.

    Raises:
        AssertionError: a value is not what was recorded.
    """
    with open_trace(plain) as one, open_trace(tagged) as other:
        images, both = read_columns(one), read_columns(other, tags=True)
    assert (images.words == both.words).all()
    assert both.tags is not None
    assert len(both.tags.dtype.names or ()) == len(PATTERNS) - 1 + 6
    assert (both.tags["fill_acc"] == 2 * (both.scan % 1000)).all()
    assert (both.tags["b0"] == (both.scan % 1000 < 500)).all()
    assert (both.tags["step"] == both.scan // 500 % 3).all()
    assert both.tags["fill_acc"].dtype == np.int32


def main() -> int:
    """Measure, print, and say whether the bound holds."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scans", type=int, default=100 * CHUNK_SCANS)
    parser.add_argument("--smoke", action="store_true", help="a few scans, only to see that it works")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        plain, tagged = measure(Path(folder), 2 * CHUNK_SCANS if arguments.smoke else arguments.scans)
    print(f"images {plain:.2f} us a scan, with ten tags {tagged:.2f}: {tagged - plain:+.2f}")
    return int(not arguments.smoke and tagged - plain > MOST_US)


if __name__ == "__main__":
    sys.exit(main())
