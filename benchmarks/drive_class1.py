"""Late packets of a served drive at EtherNet/IP, with an idle machine and beside two busy loops.

    python benchmarks/drive_class1.py [--seconds N] [--rpi-ms N] [--smoke]

The drive runs in a process of its own, time and packets of the scanner in this one: it sends words every RPI
and takes the drive's packets. A received packet is late if two RPIs or more lie between it and the one
before. The server counts the same of the scanner's packets, and its own that it sends an RPI or more after
they are due; `late_received` and `late_sent` of its test port are these counts. The busy loops are
processes without end, one for each of two cores.

Exit status 1 if a packet is missing, if words or counts of the drive are wrong, or if it ends the connection.
"""

from __future__ import annotations

import argparse
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from itertools import pairwise
from pathlib import Path
from statistics import median, quantiles
from time import perf_counter
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from drive_scanner import Scanner, with_settings
from drive_served import ControlLine, serving

BUSY_LOOPS = 2
ENABLE = 0x8000
ENABLED = 0x8000


class Server(NamedTuple):
    """Where a drive is served."""

    port: int
    io_port: int
    control: ControlLine

    def late(self) -> tuple[int, int]:
        """Return the server's own counts of late packets, received and sent."""
        state: Any = self.control.ask(state=1)["state"]
        return state["late_received"], state["late_sent"]


@contextmanager
def served() -> Iterator[Server]:
    """Serve an SMD23E2 in another process."""
    words = ("smd23e2", "--ethernet-ip", "0", "--io-port", "0", "--test-port", "0")
    with serving(*words) as started, closing(ControlLine(started.line)) as control:
        line = [word.strip(",;") for word in started.line.split()]
        yield Server(int(line[0].rpartition(":")[2]), int(line[line.index("UDP") + 1]), control)


@contextmanager
def busy(loops: int) -> Iterator[None]:
    """Keep cores busy."""
    running = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(loops)]
    try:
        yield
    finally:
        for each in running:
            each.kill()
            each.wait()


def exchange(scanner: Scanner, rpi_s: float, seconds: float) -> tuple[list[float], list[float]]:
    """Exchange packets; return when packets were sent and received, s."""
    sent: list[float] = []
    received: list[float] = []
    start = perf_counter()
    while (now := perf_counter()) < start + seconds:
        due = start + len(sent) * rpi_s
        if now >= due:
            scanner.send(0, ENABLE)
            sent.append(now)
        elif select.select([scanner.udp], [], [], due - now)[0]:
            number, sequence, words = scanner.receive()
            received.append(perf_counter())
            if not number == sequence == len(received) & 0xFFFF:
                sys.exit(f"packet {len(received)} has the counts {number} and {sequence}")
            if len(received) > 100 and not words[1] & ENABLED:
                sys.exit(f"the driver is off: {words[1]:04x}h")
    return sent, received


def late(instants: list[float], rpi_s: float) -> int:
    """Return how many packets came two intervals or more after the one before."""
    return sum(later - earlier > 2 * rpi_s for earlier, later in pairwise(instants))


def report(name: str, server: Server, rpi_ms: int, seconds: float) -> None:
    """Exchange packets and print what was late."""
    rpi_s = rpi_ms / 1000
    with closing(Scanner(server.port, server.io_port)) as scanner:
        before = server.late()
        opened = scanner.open(with_settings(), rpi_us=1000 * rpi_ms, multiplier=5)
        if opened[2]:
            sys.exit(f"the connection is refused: {opened.hex(' ')}")
        sent, received = exchange(scanner, rpi_s, seconds)
        if scanner.shut()[2]:
            sys.exit("the drive has ended the connection")
        told = [after - earlier for after, earlier in zip(server.late(), before, strict=True)]
    gaps = [1000 * (later - earlier) for earlier, later in pairwise(received)]
    print(
        f"{name:<18} {len(sent):>6,} sent, {len(received):>6,} received; between two "
        f"{median(gaps):.1f} ms in the middle, {quantiles(gaps, n=100)[98]:.1f} ms at 99 %, "
        f"{max(gaps):.1f} ms at most"
    )
    print(
        f"{'':<18} late: scanner received {late(received, rpi_s)} and sent {late(sent, rpi_s)}; "
        f"server received {told[0]} and sent {told[1]}"
    )


def main() -> int:
    """Run with an idle machine, then beside busy loops; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=30.0, help="how long each of both")
    parser.add_argument("--rpi-ms", type=int, default=8)
    parser.add_argument("--smoke", action="store_true", help="a second each")
    options = parser.parse_args()
    with ExitStack() as opened:
        server = opened.enter_context(served())
        for name, loops in (("nothing beside it", 0), ("two busy loops", BUSY_LOOPS)):
            with busy(loops):
                report(name, server, options.rpi_ms, 2.0 if options.smoke else options.seconds)
    return 0


if __name__ == "__main__":
    sys.exit(main())
