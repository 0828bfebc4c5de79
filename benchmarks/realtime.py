"""How late scans begin on a busy computer, without and with what `--realtime` asks of the system.

    python benchmarks/realtime.py [--seconds 10] [--rounds 3] [--period 2] [--busy 2]

`busy` endless loops run beside, in processes of their own. The ways of running alternate, each in a
process of its own, because the load of a computer changes while it is measured. Checked: every run
makes all of its scans, and begins none before it is due.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.pace import LATE_FROM_NS, RealTime
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.runtime.loop.realtime import frozen_collector, real_time
from scanrack.runtime.modules.amci3601 import Amci3601

WAYS = {"before": (False, False), "after": (True, False), "after, --spin": (True, True)}
"""By name: whether the system is asked for real time, and whether the pacer spins."""


def measure(way: str, period_ns: int, seconds: float) -> dict[str, Any]:
    """Run one way; return its counts."""
    asks, spins = WAYS[way]
    scans = round(seconds * 1e9 / period_ns)
    garbage = []

    def logic(scan):
        garbage.append([scan.number])  # what a program leaves behind for the collector
        if len(garbage) > 1000:
            garbage.clear()

    asked: AbstractContextManager[Any] = real_time() if asks else nullcontext([])
    with asked as outcomes:
        cpu = Cpu(Rack([Card(1, Amci3601())]), logic, period_ns, pacer=RealTime(spin=spins))
        with frozen_collector() if asks else nullcontext():
            cpu.run(scans)
    pacer = cpu.pacer
    assert cpu.scan == scans == sum(pacer.late), "not every scan was made and counted"
    assert pacer.worst_late_ns >= 0, "a scan began early"
    return {
        "late": pacer.late,
        "overruns": pacer.overruns,
        "worst_ms": pacer.worst_late_ns / 1e6,
        "refused": [str(outcome) for outcome in outcomes if outcome.refusal],
    }


@contextmanager
def busy(loops: int):
    """Keep processors busy with so many endless loops."""
    processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(loops)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def in_a_process(way: str, arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure one way in a process of its own."""
    words = [sys.executable, __file__, "--way", way]
    words += ["--period", str(arguments.period), "--seconds", str(arguments.seconds)]
    return json.loads(
        subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True, encoding="utf-8").stdout
    )


def row(way: str, counts: dict[str, Any]) -> str:
    """Return a line of the table."""
    late, total = counts["late"], sum(counts["late"])
    sizes = " ".join(f"{count:>7}" for count in late[1:])
    shares = f"{sum(late[1:]) / total:>8.2%} {counts['overruns'] / total:>9.2%}"
    return f"{way:<14} {shares} {sizes} {counts['worst_ms']:>9.2f}"


def compare(arguments: argparse.Namespace) -> None:
    """Alternate the ways, and print what each of them came to."""
    sizes = " ".join(f"{f'>{bound_ns / 1e6:g}':>7}" for bound_ns in LATE_FROM_NS)
    print(f"{arguments.period:g} ms scans, {arguments.busy} busy loops, {os.cpu_count()} processors")
    print(f"{'ms':<14} {'late':>8} {'overruns':>9} {sizes} {'longest':>9}")
    refused: set[str] = set()
    with busy(arguments.busy):
        for _ in range(arguments.rounds):
            for way in WAYS:
                counts = in_a_process(way, arguments)
                refused.update(counts["refused"])
                print(row(way, counts), flush=True)
    for line in sorted(refused):
        print(line)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=10.0, help="of each run")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--period", type=float, default=2.0, help="ms")
    parser.add_argument("--busy", type=int, default=2, help="endless loops beside it")
    parser.add_argument("--way", choices=WAYS, help=argparse.SUPPRESS)
    parser.add_argument("--smoke", action="store_true", help="one short round, to see that it works")
    arguments = parser.parse_args()
    if arguments.smoke:
        arguments.seconds, arguments.rounds = 0.2, 1
    if arguments.way is None:
        compare(arguments)
    else:
        print(json.dumps(measure(arguments.way, round(arguments.period * 1e6), arguments.seconds)))


if __name__ == "__main__":
    main()
