"""What recording ten tags costs per scan, beside recording the images alone.

    python benchmarks/tags.py [--scans N] [--smoke]

A ladder program's ten tags: a REAL, two ACC of timers, a step and six bits. Two recorders, one with the
tags and one without, take turns of some thousand scans in one process, so that both meet the same load;
times are processor time, the best of the turns. The loop that changes the tags is taken off both.
Afterwards both traces are read back, and images and tags are compared scan by scan.

`tags = ["*"]` is measured before the first scan and after an edit, with ten times the tags as well. One
function for each tag with all variables took 100 times as long; one with all of them takes 17 to 20.

Exit status 1 if ten tags cost more than 0.25 us, or ten times the tags take more than 25 times as long.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from math import inf
from pathlib import Path
from time import process_time

import numpy as np
from bars import Bars
from scanrack.io_images.image import WORDS
from scanrack.jobs.record.tag_source import tags_of
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files.rungfile import parse_program
from scanrack.ladder.lowering.runnable import LadderLogic
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.arrays import read_columns
from scanrack.traces.read.reader import open_trace
from scanrack.traces.write.recorder import CHUNK_SCANS, ScanRecorder

PERIOD_NS = 2_000_000
SLOTS = [SlotInfo(1, "amci3601", "4.1")]
MOST_US = 0.25
FEW, MANY = 1_000, 10_000
MOST_RATIO = 25
WHEN = ("before the first scan", "after an edit")

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


def with_tags(count: int, value: int) -> LadderLogic:
    """Return a program of so many tags that moves a value."""
    tags = "".join(f"TAG A{number} : DINT\n" for number in range(count))
    return parse_program(f"PROGRAM line\n{tags}ROUTINE Main\nMOV({value},A0);\nEND\n")


def starts(count: int, rounds: int) -> tuple[float, float]:
    """Return what `tags = ["*"]` takes before the first scan and after an edit, s: the least of rounds."""
    debugger = Debugger(with_tags(count, 1), remembered=0)
    first = after = inf
    for value in range(2, 2 + rounds):
        begin = process_time()
        source = tags_of(debugger, ["*"], bytearray(4 * WORDS))
        first = min(first, process_time() - begin)
        debugger.edit(with_tags(count, value))
        begin = process_time()
        scan = source.take()
        after = min(after, process_time() - begin)
        assert len(scan) == 4 * WORDS + 4 * count
    return first, after


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
    bars = Bars(count=not arguments.smoke)
    cost = tagged - plain
    bar = bars.most("us a scan with ten tags", cost, MOST_US)
    print(f"images {plain:.2f} us a scan, with ten tags {tagged:.2f}: {cost:+.2f} ({bar})")
    rounds = 1 if arguments.smoke else 9
    for what, few, many in zip(WHEN, starts(FEW, rounds), starts(MANY, rounds), strict=True):
        bar = bars.most(f"times as long for {MANY:,} tags {what}", many / few, MOST_RATIO)
        times = f"{FEW:,} tags {few * 1e3:.0f} ms, {MANY:,} {many * 1e3:.0f}"
        print(f"{what}: {times}, {many / few:.1f} times ({bar})")
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
