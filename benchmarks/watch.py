"""What looking costs the scans: late ones though a processor was free, processor time, the speed reached.

    python benchmarks/watch.py [--seconds 10] [--rounds 3] [--turns 40] [--smoke]

The feeder in real time, scans of 2 ms, recorded, in four ways that take turns, each in a process of its own:

    nobody     scans without a monitor
    monitor    with a monitor, no page
    page       with a page that reads
    deaf       with three pages that never read, and a monitor that is killed half-way

A scan is late if the time from the scan before exceeds the period by more than 0.5 ms, or 2 ms. Counted are
those in which the thread has waited less than 0.3 ms for a processor: the scheduler's own figure, on Linux
only. Then the same at full speed: machine time per second, processor time of the scan process per scan, and
that of a plain run as a share of it. There a plain run and the first three ways take turns of 0.2 s or so:
each share is of two neighboring turns, and the median of them holds although the machine is used by others.
Checked: every scan was made. The design allows 0.3 % of late scans, and wants a share of 0.85 or more.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import secrets
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path

from scanrack.jobs.load.loading import load_job
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.runtime.live.ring import Ring
from scanrack.runtime.live.session import Session
from scanrack.runtime.live.tap import PipeInbox, Tap
from scanrack.runtime.loop.pace import AdjustablePace
from scanrack.runtime.loop.realtime import frozen_collector
from scanrack.watch.history.watched_machines import PER_SLOT, MachineFigures
from scanrack.watch.history.watched_program import LadderNotes, written_to
from scanrack.watch.monitor_supervisor import MonitorSupervisor
from scanrack.watch.monitors.monitor import SessionFacts
from scanrack.watch.monitors.session_monitor import Setup
from scanrack.watch.monitors.stretched import SessionProgram
from websockets.asyncio.client import connect

FEEDER = Path(__file__).parents[1] / "examples" / "feeder" / "feeder.toml"
WAYS = ("nobody", "monitor", "page", "deaf")
RUN = "run"

TURN_SCANS = 16_384
"""Scans of a turn at full speed: 32 s of the machine."""

WAITED_MS = 0.3
SETTLE_S = 3.0


class Probe:
    """Notes when each scan was, and how long the thread has waited for a processor; a listener."""

    def __init__(self) -> None:
        self.walls: list[int] = []
        self.waits: list[int] = []
        self._schedule: int | None = None

    def event(self, *_event: object) -> None:
        """Ignore events."""

    def scan(self, _scan: int, _now_ns: int, _flags: int) -> None:
        """Note a scan."""
        if self._schedule is None:
            self._schedule = os.open("/proc/thread-self/schedstat", os.O_RDONLY)
        self.walls.append(time.monotonic_ns())
        self.waits.append(int(os.pread(self._schedule, 64, 0).split()[1]))

    def close(self) -> None:
        """Nothing is kept open but a file of the system."""

    def late(self, period_ns: int) -> dict[str, float]:
        """Return how many scans in a hundred were late though a processor was free."""
        pairs = list(zip(self.walls, self.walls[1:], self.waits, self.waits[1:], strict=False))
        own = [(b - a - period_ns) / 1e6 for a, b, w, v in pairs if (v - w) / 1e6 < WAITED_MS]
        return {
            "counted": len(own),
            "late_0.5_pct": 100 * sum(each > 0.5 for each in own) / len(own),
            "late_2_pct": 100 * sum(each > 2 for each in own) / len(own),
            "worst_ms": max(own),
        }


Turn = Callable[[int], dict[str, object]]
"""Does a number of scans; returns the figures."""


@contextmanager
def plain_run() -> Iterator[Turn]:
    """Open a run without a session."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        run = JobRun(load_job(str(FEEDER)), stack, RunOptions(trace=folder / "run.mcap"))
        stack.enter_context(run.cpu)
        yield partial(turn, run, run.cpu.run)


def turn(run: JobRun, scan: Callable[[int], None], scans: int) -> dict[str, object]:
    """Do scans; return the figures."""
    end = run.cpu.scan + scans
    spent, begun = time.process_time(), time.monotonic()
    scan(scans)
    spent, took = time.process_time() - spent, time.monotonic() - begun
    assert run.cpu.scan == end, "not every scan was made"
    return {
        "scan_process_pct": 100 * spent / took,
        "speed": scans * 0.002 / took,
        "scan_us": 1e6 * spent / scans,
    }


@contextmanager
def watched(way: str, speed: float | None) -> Iterator[Turn]:
    """Open a session that is watched in one way."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        trace = folder / "session.mcap"
        job = load_job(str(FEEDER))
        pacer = AdjustablePace(speed)
        run = JobRun(job, stack, RunOptions(trace=trace, pacer=pacer, handled=True))
        debugger = run.program.debugger
        assert debugger is not None
        figures = MachineFigures(run.rack)
        ring = Ring(len(run.rack.memory), PER_SLOT * len(figures.slots))
        tap = Tap(ring, run.rack, run.cpu.period_ns, figures)
        tap.notes = LadderNotes(debugger, written_to(ring.snapshots))
        mine, _theirs = socket.socketpair()
        keeper = None
        if way == "nobody":
            from multiprocessing.connection import Connection

            inbox = PipeInbox(ring, Connection(mine.detach()))
        else:
            keeper, link = _monitor(ring, figures, trace, stack)
            inbox = PipeInbox(ring, keeper.pipe)
            keeper.watch(inbox)
            stack.callback(keeper.end)
        session = Session(run.cpu, run.hands, pacer, inbox, tap.send, stops=debugger)
        tap.session, session.attend, session.send_values = session, tap.attend, tap.send_values
        probe = Probe()
        if speed is not None:  # it costs as much as half a scan
            run.cpu.add_listener(probe)
        run.cpu.add_listener(tap)
        pages = [] if keeper is None else _pages(way, link)
        for page in pages:
            stack.callback(page.wait)
            stack.callback(page.kill)
        if keeper is not None:
            time.sleep(SETTLE_S)
        stack.enter_context(frozen_collector())
        stack.enter_context(run.cpu)

        def scans(count: int) -> dict[str, object]:
            if way == "deaf" and keeper is not None:
                killer = threading.Timer(count / 1000, os.kill, (keeper.pid, signal.SIGKILL))
                killer.start()
                stack.callback(killer.cancel)
            monitor, begun = _spent(keeper), time.monotonic()
            figures = turn(run, session.run, count)
            if speed is not None:
                figures |= probe.late(run.cpu.period_ns)
            if keeper is not None and way != "deaf":
                figures["monitor_pct"] = 100 * (_spent(keeper) - monitor) / (time.monotonic() - begun)
            return figures

        yield scans


def _monitor(
    ring: Ring, figures: MachineFigures, trace: Path, stack: ExitStack
) -> tuple[MonitorSupervisor, str]:
    listening = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    port, key = listening.getsockname()[1], secrets.token_hex(16)
    about = SessionFacts("0", "feeder", str(FEEDER), "rack", False, False, None)
    programs = (SessionProgram(0, str(FEEDER.parent), "feeder.toml", "feeder.rung"),)
    setup = Setup(ring.shape, about, key, "127.0.0.1", port, tuple(figures.slots), str(trace), programs)
    return MonitorSupervisor(setup, ring, listening, lambda _text: None), f"127.0.0.1:{port} {key}"


def _spent(keeper: MonitorSupervisor | None) -> float:
    """Return the processor time of the monitor so far, s."""
    if keeper is None:
        return 0.0
    fields = Path(f"/proc/{keeper.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _pages(way: str, link: str) -> list[subprocess.Popen[bytes]]:
    count = {"page": 1, "deaf": 3}.get(way, 0)
    command = [sys.executable, __file__, "--page", way, *link.split()]
    return [subprocess.Popen(command) for _ in range(count)]


async def look(way: str, host: str, key: str) -> None:
    """Be a page: one that reads, or one that never does."""
    while True:
        try:
            async with connect(f"ws://{host}/socket", max_size=None, compression=None) as page:
                await page.send(json.dumps({"key": key}))
                await page.send(json.dumps({"id": 1, "do": "show", "routine": "Main", "columns": 88}))
                if way == "deaf":
                    page.transport.pause_reading()
                    await asyncio.sleep(3600)
                async for _message in page:
                    pass
        except OSError:
            await asyncio.sleep(0.2)


class Apart:
    """One way in a process of its own, which does scans when it is told to.

    Args:
        speed: times real time, or `max`.
    """

    def __init__(self, way: str, speed: str) -> None:
        command = [sys.executable, __file__, "--way", way, "--speed", speed]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8"
        )

    def turn(self, scans: int) -> dict[str, float]:
        """Do a number of scans; return the figures."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(scans, file=self._process.stdin, flush=True)
        found: dict[str, float] = json.loads(self._process.stdout.readline())
        return found

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def be_apart(way: str, speed: float | None) -> None:
    """Be such a process."""
    with plain_run() if way == RUN else watched(way, speed) as scan:
        for line in sys.stdin:
            print(json.dumps(scan(int(line))), flush=True)


def in_turns(ways: Sequence[str], turns: int, scans: int) -> dict[str, list[dict[str, float]]]:
    """Measure some ways at full speed in turns; the first turn of each loads and learns."""
    with ExitStack() as stack:
        all_ways = {way: stack.enter_context(closing(Apart(way, "max"))) for way in ways}
        found = [{way: each.turn(scans) for way, each in all_ways.items()} for _ in range(turns + 1)]
        return {way: [each[way] for each in found[1:]] for way in ways}


def report(title: str, found: dict[str, list[dict[str, float]]]) -> None:
    """Print the medians of all turns, one way per line."""
    print(title)
    for way, runs in found.items():
        keys = [key for key in runs[0] if key != "counted"]
        told = (f"{key} {statistics.median(each[key] for each in runs):.3g}" for key in keys)
        print(f"  {way:<8}", "  ".join(told))


def main() -> None:
    """Measure all ways in turns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--turns", type=int, default=40, help="of each way at full speed")
    parser.add_argument("--fast", action="store_true", help="only what is at full speed")
    parser.add_argument("--smoke", action="store_true", help="one short round: does it run at all?")
    parser.add_argument("--way", choices=(RUN, *WAYS), help=argparse.SUPPRESS)
    parser.add_argument("--speed", default="1", help=argparse.SUPPRESS)
    parser.add_argument("--page", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.page:
        asyncio.run(look(*options.page))
    if options.way:
        be_apart(options.way, None if options.speed == "max" else float(options.speed))
        return
    if not Path("/proc/thread-self/schedstat").exists():
        print("this system does not tell how long a thread waits for a processor: nothing is measured")
        return
    seconds, rounds, turns = (
        (0.2, 1, 1) if options.smoke else (options.seconds, options.rounds, options.turns)
    )
    if not options.fast:
        real: dict[str, list[dict[str, float]]] = {way: [] for way in WAYS}
        for way in WAYS * rounds:
            with closing(Apart(way, "1")) as apart:
                real[way].append(apart.turn(round(seconds * 500)))
        report(f"real time, {seconds:g} s each, medians of {rounds}", real)
    fast = in_turns((RUN, *WAYS[:3]), turns, TURN_SCANS)
    report(f"as fast as it goes, {TURN_SCANS:,} scans each, medians of {turns}", fast)
    for way in WAYS[:3]:
        shares = [run["scan_us"] / own["scan_us"] for run, own in zip(fast[RUN], fast[way], strict=True)]
        low, middle, high = statistics.quantiles(shares, n=4) if len(shares) > 1 else shares * 3
        half = f"half of the turns {low:.2f} to {high:.2f}"
        print(f"  {way:<8} run's processor time is {middle:.2f} of it, {half}")


if __name__ == "__main__":
    main()
