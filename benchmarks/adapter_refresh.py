"""How often an adapter on a real port refreshes its image, beside what the line alone would take.

    python benchmarks/adapter_refresh.py [--seconds N] [--scan-ms N] [--smoke]

The controller is `scanrack serve` in another process, on a pseudo-terminal; over it the adapter makes
moves to and fro in real time. A refresh is what lies between two readings of the controller's
position: status, position and inputs are asked one after the other, over again, and starts and parameters in
between. The wire's floor is what the characters of that refresh, questions and answers, and the silence
that the protocol wants before a question, take at the line's speed; a pseudo-terminal takes no time for
them. So on a real line a refresh takes at most about the sum of the two.

In the end the processor's time of a scan of 2 ms with each adapter over its simulated controller, moving to
and fro in virtual time; `amci-drive` is to take at most 1.5 times that of `pcl601-adapter`.

Exit status 1 if a move does not end where it should, or the link was lost.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median, quantiles
from time import perf_counter, process_time, sleep
from typing import Any

from scanrack.io_images import Image
from scanrack.io_images.amci3601 import status_names
from scanrack.io_images.pcl601 import Register
from scanrack.io_images.thousands import join_reported, split_thousands
from scanrack.runtime.config.rackspec import SlotSpec
from scanrack.runtime.line import pcl601_frames as pcl601
from scanrack.runtime.line import pmc006_frames as pmc006
from scanrack.runtime.line.master import LineTiming
from scanrack.runtime.line.pcl601_pdus import read_registers
from scanrack.runtime.modules.adapters.live import LiveAdapter
from scanrack.runtime.modules.adapters.pcl601.driver import LINE_TIMING as PCL601_MANNERS
from scanrack.runtime.modules.adapters.pmc006.driver import LINE_TIMING as PMC006_MANNERS

CONFIGURE = (0x843C, 63, 1, 0)
SIMULATED: dict[str, dict[str, Any]] = {
    "pcl601-adapter": {},
    "pmc006-adapter": {"home_stroke": 100_000},
    "amci-drive": {"unwired": "inactive"},
}
SCAN_NS = 2_000_000
STROKE = 2000


@dataclass(frozen=True)
class Kind:
    """A hardware: how it is served, how its line is used, and how it is asked for its position."""

    module: str
    controller: str
    options: dict[str, Any]
    line_timing: LineTiming
    question: bytes


KINDS = (
    Kind(
        "pcl601-adapter",
        "pcl601",
        {},
        PCL601_MANNERS,
        pcl601.request(1, read_registers(Register.POSITION, 2)).frame,
    ),
    Kind(
        "pmc006-adapter",
        "pmc006",
        {"home_stroke": 100_000},
        PMC006_MANNERS,
        pmc006.reading(255, "read_position").frame,
    ),
)


@contextmanager
def served(controller: str) -> Iterator[str]:
    """Serve a controller in another process; yield the path of its pseudo-terminal."""
    words = [sys.executable, "-m", "scanrack", "serve", controller, "--pty", "--quiet"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split("  ")[0]
    finally:
        process.kill()
        process.communicate()


@dataclass
class Run:
    """An adapter that is scanned in real time.

    Attributes:
        asked_s: instants at which its position was asked for.
        wire_s: by then, what everything that was said would have taken on the line.
        moves: how many have ended where they should.
    """

    kind: Kind
    port: str
    scan_s: float
    asked_s: list[float] = field(default_factory=list)
    wire_s: list[float] = field(default_factory=list)
    moves: int = 0
    scans: int = 0
    said_s: float = 0.0

    def __post_init__(self) -> None:
        """Open the port, and listen to the line."""
        slot = SlotSpec(number=1, module=self.kind.module, port=self.port, options=self.kind.options)
        module = slot.open()
        assert isinstance(module, LiveAdapter)
        self.module: LiveAdapter[Any] = module
        self.start = perf_counter()
        line = self.module.controller.line
        send, take, line_timing = line.send, line.take, self.kind.line_timing

        def asks(data: bytes, line_format: Any) -> None:
            if data == self.kind.question:
                self.asked_s.append(perf_counter())
                self.wire_s.append(self.said_s)
            self.said_s += (line_timing.line_format.span_ns(len(data)) + line_timing.gap_ns) / 1e9
            send(data, line_format)

        def hears() -> bytes:
            data = take()
            self.said_s += line_timing.line_format.span_ns(len(data)) / 1e9
            return data

        line.send, line.take = asks, hears  # type: ignore[method-assign]

    def give(self, *words: int, until: str = "", without: str = "") -> None:
        """Put words until a bit is set or clear; end the benchmark after ten seconds."""
        outputs = Image(words)
        for turn in range(round(10 / self.scan_s)):
            self.scans += 1
            sleep(max(0.0, self.start + self.scans * self.scan_s - perf_counter()))
            image = self.module.update(round(self.scans * self.scan_s * 1e9), outputs)
            self.position = join_reported(image[2], image[3])
            bits = status_names(image[0] & 0xFFFF, image[1] & 0xFFFF)
            if turn > 2 and (until in bits or (without and without not in bits)):
                return
        sys.exit(f"{self.kind.module}: {until or 'not ' + without} does not come: {bits}")

    def prepare(self) -> None:
        """Configure, and make the position valid at 0."""
        self.give(until="MODULE_OK")
        self.give(*CONFIGURE, without="CONFIG_ERROR")
        self.give(until="MODULE_OK")
        self.give(512, without="POSITION_INVALID")
        self.give(without="POSITION_INVALID")
        self.asked_s.clear()
        self.wire_s.clear()

    def move_for(self, seconds: float) -> None:
        """Move to and fro."""
        end, sign = perf_counter() + seconds, 1
        while perf_counter() < end:
            target = self.position + sign * STROKE
            self.give(2, 0, *split_thousands(sign * STROKE), 5, 0, 50, 50, until="MOVE_COMPLETE")
            if self.position != target:
                sys.exit(f"{self.kind.module}: a move ended at {self.position}, not at {target}")
            self.give(without="MOVING_CW")
            self.moves, sign = self.moves + 1, -sign


def periods(instants: list[float]) -> list[float]:
    """Return what lies between instants, ms."""
    return [1e3 * (later - earlier) for earlier, later in pairwise(instants)]


def report(run: Run) -> None:
    """Print what it came to."""
    refresh, floor = periods(run.asked_s), periods(run.wire_s)
    print(
        f"{run.kind.module}: refresh {median(refresh):.1f} ms in the middle, "
        f"{quantiles(refresh, n=100)[98]:.1f} ms at 99 %; the wire's floor {median(floor):.1f} ms; "
        f"{run.moves} moves, {len(refresh)} refreshes, {run.module.driver.master.failures} exchanges failed"
    )


def scan_us(module: str, scans: int) -> float:
    """Return the processor's time of a scan with a simulated adapter that moves to and fro, us."""
    adapter = SlotSpec(number=1, module=module, options=SIMULATED[module]).make(0)
    now_ns = 0

    def give(*words: int, scans: int) -> None:
        nonlocal now_ns
        outputs = Image(words)
        for _ in range(scans):
            now_ns += SCAN_NS
            adapter.update(now_ns, outputs)

    for words in ((), CONFIGURE, (), (512,), ()):
        give(*words, scans=200)
    began = process_time()
    for turn in range(scans // 500):
        give(2, 0, *split_thousands(STROKE if turn % 2 else -STROKE), 5, 0, 50, 50, scans=400)
        give(scans=100)
    return (process_time() - began) / (scans // 500 * 500) * 1e6


def report_scans(scans: int) -> None:
    """Print the time of a scan with each adapter, the best of three."""
    took = {module: min(scan_us(module, scans) for _ in range(3)) for module in SIMULATED}
    for module, each_us in took.items():
        print(f"{module}: {each_us:.1f} us a scan, {each_us / took['pcl601-adapter']:.2f} times the PCL601's")


def main() -> int:
    """Run one hardware after the other; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long for each hardware")
    parser.add_argument("--scan-ms", type=float, default=2.0)
    parser.add_argument("--smoke", action="store_true", help="a second for each")
    options = parser.parse_args()
    for kind in KINDS:
        with served(kind.controller) as port:
            run = Run(kind, port, options.scan_ms / 1e3)
            run.prepare()
            run.move_for(1.0 if options.smoke else options.seconds)
            run.module.close()
        report(run)
    report_scans(1000 if options.smoke else 20_000)
    return 0


if __name__ == "__main__":
    sys.exit(main())
