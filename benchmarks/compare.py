"""How long it takes to compare two traces.

    python benchmarks/compare.py                  two traces of a million scans
    python benchmarks/compare.py --scans 100000   of so many
    python benchmarks/compare.py --smoke          a check that it runs

Traces of one slot whose axis goes to and fro: twice the same; one whose positions are off by two
counts and whose scans have jitter, compared within a tolerance; and one that differs in a single bit.
The result of each comparison is checked.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scanrack.io_images.image import WORDS
from scanrack.traces.compare import EXACT, Tolerance, compare
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.reader import open_trace
from scanrack.traces.write.recorder import ScanRecorder

PERIOD_NS = 2_000_000
STATUS_MSW, POSITION_MSW, POSITION_LSW = 8, 10, 11
LOOSE = Tolerance(time_ns=2 * PERIOD_NS, counts=2)


def words(scans: int, *, off: int = 0, flipped: int | None = None) -> np.ndarray:
    """Return the words of an axis that moves 7 steps per scan, turning every 1,000 scans."""
    count = np.arange(scans) % 2000
    position = 7 * np.minimum(count, 2000 - count) + off
    result = np.zeros((scans, 2 * WORDS), np.int16)
    result[:, STATUS_MSW] = np.where(count < 1000, 0x4001, 0x4002)
    result[:, POSITION_MSW], result[:, POSITION_LSW] = position // 1000, position % 1000
    if flipped is not None:
        result[flipped, STATUS_MSW] ^= 0x1000
    return result


def record(path: Path, images: np.ndarray, jitter_ns: int = 0) -> Path:
    """Record images, a rule every 1,000 scans beside them."""
    memory = bytearray(4 * WORDS)
    recorder = ScanRecorder(path, memory, [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=PERIOD_NS)
    rule: dict[str, Any] = {"slot": 1, "kind": "rule", "name": "CMD-03", "text": "A rule."}
    for scan, image in enumerate(images):
        now_ns = scan * PERIOD_NS + (scan * 7_919 % jitter_ns if jitter_ns else 0)
        memory[:] = image.tobytes()
        if scan % 1000 == 0:
            recorder.event(scan, now_ns, "/events", rule)
        recorder.scan(scan, now_ns, 1)
    recorder.close()
    return path


def best(action: Callable[[], object]) -> float:
    """Return the shortest of three times, s."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scans", type=int, default=1_000_000)
    parser.add_argument("--smoke", action="store_true")
    options = parser.parse_args()
    scans = 20_000 if options.smoke else options.scans
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        one = record(folder / "one.mcap", words(scans))
        cases = {
            "the same": (record(folder / "same.mcap", words(scans)), EXACT, 0),
            "one bit differs": (record(folder / "bit.mcap", words(scans, flipped=scans // 2)), EXACT, 1),
            "jitter and counts, with a tolerance": (
                record(folder / "loose.mcap", words(scans, off=2), jitter_ns=900_000),
                LOOSE,
                0,
            ),
        }
        for name, (other, tolerance, differing) in cases.items():

            def comparing(
                other: Path = other, tolerance: Tolerance = tolerance, wanted: int = differing
            ) -> None:
                with open_trace(one) as a, open_trace(other) as b:
                    assert compare(a, b, tolerance).differing == wanted

            print(f"{name}: {best(comparing):.2f} s for two of {scans:,} scans")


if __name__ == "__main__":
    main()
