"""What drawing a long trace costs, beside the least it could cost.

    python benchmarks/plot.py [--scans N] [--slots N] [--smoke]

Two million scans of four 3601s that move to and fro, with pulses of one scan:

    floor      going through the columns of the trace and doing nothing with them
    query      the longest time between command and motion
    chart      all that a picture shows: curves, lanes, marks
    picture    chart, and drawing it as PNG (needs matplotlib)
    page       the HTML page with every scan in it
    vcd        the value change dump with every change in it

Times are processor time of one run. What was found is checked: no pulse may be missing, and the
curves must reach the ends of every move. `peak` is the most memory that the process has held until
then; the trace itself is many times that.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from time import process_time

from scanrack.io_images.image import WORDS
from scanrack.traces.export import write_vcd
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.plot import Chart, Curve, Envelope, read_chart, save_figure, save_page
from scanrack.traces.query import query
from scanrack.traces.read.reader import Trace, open_trace
from scanrack.traces.signals import blocks
from scanrack.traces.write.recorder import ScanRecorder

PERIOD_NS = 2_000_000
STROKE = 4_000
"""Scans of a move; ten steps each."""

PULSE_EVERY = 100_000
"""Scans from one pulse of a single scan to the next."""


def record(path: Path, scans: int, slots: int) -> None:
    """Record the moves: scan by scan, as a rack would."""
    memory = bytearray(4 * WORDS * slots)
    words = memoryview(memory).cast("h")
    racks = [SlotInfo(number, "amci3601", "4.1") for number in range(1, slots + 1)]
    recorder = ScanRecorder(path, memory, racks, scan_period_ns=PERIOD_NS)
    for scan in range(scans):
        phase = scan % (2 * STROKE)
        back = phase >= STROKE
        msw, lsw = divmod(10 * (2 * STROKE - phase if back else phase), 1000)
        for at in range(0, len(words), 16):
            words[at] = phase % STROKE == STROKE - 1  # the next ABSOLUTE_MOVE, one scan ahead
            words[at + 8] = 0x4002 if back else 0x4001
            words[at + 9] = scan % PULSE_EVERY == PULSE_EVERY // 2  # IN_CAPTURE
            words[at + 10], words[at + 11] = msw, lsw
        recorder.scan(scan, scan * PERIOD_NS, 1)
    recorder.close()


def go_through(trace: Trace) -> None:
    for _ in blocks(trace):
        pass


def ask(trace: Trace, scans: int) -> None:
    found = query(trace, "longest(slot1.out.ABSOLUTE_MOVE then rose(slot1.in.MOVING_CCW))")
    if scans > 3 * STROKE and found.occurrences[0].duration_ns != (STROKE + 1) * PERIOD_NS:
        raise AssertionError(f"the longest took {found.occurrences[0].duration_ns} ns")


def chart(trace: Trace, scans: int) -> Chart[Curve]:
    made = read_chart(trace, Envelope)
    for panel in made.panels:
        pulses = next(lane for lane in panel.lanes if lane.name == "IN_CAPTURE")
        if pulses.value.sum() != (scans + PULSE_EVERY // 2 - 1) // PULSE_EVERY:
            raise AssertionError(f"{pulses.value.sum()} pulses found")
        position = panel.curves[0][1]
        if (position.low.min(), position.high.max()) != (0, 10 * STROKE):
            raise AssertionError("the curve does not reach the ends of the moves")
    return made


def timed(path: Path, action: Callable[[Trace], object]) -> float:
    with open_trace(path) as trace:
        start = process_time()
        action(trace)
        return process_time() - start


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What drawing a long trace costs.")
    parser.add_argument("--scans", type=int, default=2_000_000)
    parser.add_argument("--slots", type=int, default=4)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    scans = 60_000 if given.smoke else given.scans
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.mcap"
        record(path, scans, given.slots)
        jobs: dict[str, Callable[[Trace], object]] = {
            "floor": go_through,
            "query": lambda trace: ask(trace, scans),
            "chart": lambda trace: chart(trace, scans),
            "page": lambda trace: save_page(trace, Path(folder) / "long.html"),
            "vcd": lambda trace: write_vcd(trace, Path(folder) / "long.vcd"),
        }
        if find_spec("matplotlib"):
            jobs["picture"] = lambda trace: save_figure(chart(trace, scans), Path(folder) / "long.png")
        print(f"{scans:,} scans of {given.slots} slots, {path.stat().st_size / 1e6:.1f} MB")
        print("           seconds   x floor   µs/scan  peak MB")
        floor = 0.0
        for name, job in jobs.items():
            took = timed(path, job)
            floor = floor or took
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(f"{name:9} {took:8.2f} {took / floor:9.1f} {took / scans * 1e6:9.2f} {peak:8.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
