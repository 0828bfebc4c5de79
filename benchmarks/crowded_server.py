"""Good clients of a tag server among as many others as it allows, over EtherNet/IP, and its recording.

    python benchmarks/crowded_server.py [--smoke]

`scanrack run --realtime --server ethernet-ip` serves and records a rack of 2 ms scans. Two good clients read
batches of 21 tags 200 times a second, while others come, in processes of their own, one kind after the other:

    short       connections that send the start of a good frame, and end
    silent      clients that send nothing for some seconds
    crowd       one client more than there are places, each with a session: silent ones give way

Exit status 1 if a good client got a wrong answer or none, if the server's process died, if the CPU faulted,
if the recording lacks a scan, or (not with --smoke) if a good client waited for more than 50 ms.
"""

from __future__ import annotations

import argparse
import os
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import Process
from pathlib import Path
from time import perf_counter

from ethernet_ip import BATCH, Asker, frame, is_torn, write_rack
from scanrack.runtime.line.ports.places import CLIENTS_MAX
from scanrack.traces import open_trace

WORST_S = 0.050
PERIOD_S = 0.005
SILENT_CLIENTS = 40
Others = Callable[[int, int], None]


def dialled(port: int) -> socket.socket:
    """Return a connection; it waits for no answer for long."""
    found = socket.create_connection(("127.0.0.1", port), timeout=30)
    found.settimeout(1)
    return found


def packet(session: int, message: bytes) -> bytes:
    """Return a frame with a message."""
    items = struct.pack("<IHHHHHH", 0, 0, 2, 0, 0, 0xB2, len(message))
    return frame(0x6F, items + message, session)


def short(port: int, seconds: int) -> None:
    """Begin a frame and end the connection."""
    whole = packet(1, BATCH)
    for length in range(0, len(whole), 3):
        with dialled(port) as where:
            where.sendall(whole[:length])


def silent(port: int, seconds: int) -> None:
    """Connect, and send nothing."""
    with ExitStack() as clients:
        for _ in range(SILENT_CLIENTS):
            clients.enter_context(dialled(port))
        time.sleep(seconds)


def crowd(port: int, seconds: int) -> None:
    """Take one place more than there are."""
    with ExitStack() as clients:
        for _ in range(CLIENTS_MAX + 1):
            with suppress(OSError):
                where = clients.enter_context(dialled(port))
                where.sendall(frame(0x65, b"\1\0\0\0"))
        time.sleep(seconds)


OTHERS: dict[str, Others] = {"short": short, "silent": silent, "crowd": crowd}


@contextmanager
def served(rack: Path, trace: Path, log: Path) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """Run a rack that is served and recorded; yield its process and the port of its server."""
    words = [
        "run",
        str(rack),
        "--realtime",
        "--for",
        "1h",
        "--record",
        str(trace),
        "--server",
        "ethernet-ip:0",
    ]
    with log.open("wb") as errors:
        process = subprocess.Popen([sys.executable, "-m", "scanrack", *words, "--quiet"], stderr=errors)
    try:
        end = perf_counter() + 60
        while b"server on" not in (said := log.read_bytes()):
            if perf_counter() > end or process.poll() is not None:
                raise RuntimeError(said.decode("utf-8"))
            time.sleep(0.05)
        yield process, int(said.split(b"server on ")[1].split(b": ")[0].rpartition(b":")[2])
    finally:
        process.kill()
        process.wait()


def watched(clients: list[Asker], others: Process) -> tuple[int, float, float]:
    """Let good clients ask while the others are there.

    Returns:
        (answers, longest time of one, longest lateness of a question), s: on a busy machine the second is no
        less than the third.
    """
    answers, worst, late = 0, 0.0, 0.0
    due = perf_counter()
    while others.is_alive():
        for each in clients:
            each.ask()
            if is_torn(each.take()):
                raise ValueError("a batch has values of two scans")
            worst = max(worst, perf_counter() - each.sent)
            answers += 1
        due = max(due + PERIOD_S, perf_counter() - PERIOD_S)
        time.sleep(max(0.0, due - perf_counter()))
        late = max(late, perf_counter() - due)
    return answers, worst, late


def crowded(port: int, seconds: int) -> float:
    """Let all kinds of others come; return the longest time that a good client waited, s."""
    clients = [Asker(port, BATCH) for _ in range(2)]
    longest = 0.0
    for name, function in OTHERS.items():
        others = Process(target=function, args=(port, seconds))
        begun = perf_counter()
        others.start()
        answers, worst, late = watched(clients, others)
        others.join()
        took = perf_counter() - begun
        print(
            f"{name:<11} {took:5.1f} s, {answers:6,} good answers, the slowest after {worst * 1e3:5.1f} ms;"
            f" the client itself was late by {late * 1e3:.1f} ms",
            flush=True,
        )
        if others.exitcode:
            raise RuntimeError(f"{name} ended with {others.exitcode}")
        longest = max(longest, worst)
    for each in clients:
        each.socket.close()
    return longest


def main() -> int:
    """Run the benchmark; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--smoke", action="store_true", help="a second of each, no bar for the time")
    options = parser.parse_args()
    seconds = 1 if options.smoke else 8
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        trace, log = Path(folder, "run.mcap"), Path(folder, "log")
        with served(write_rack(Path(folder), 0), trace, log) as (process, port):
            longest = crowded(port, seconds)
            if process.poll() is not None:
                missed.append("the rack ended")
            process.send_signal(signal.SIGINT)
            status = process.wait(60)
        said = log.read_text("utf-8")
        if status != 130 or "started again" in said or "fault" in said:
            missed.append(f"the rack runs, and its server lives (status {status}): {said}")
        with open_trace(trace) as recorded:
            scans = [scan.scan for scan in recorded.scans()]
            if recorded.notes or scans != list(range(len(scans))):
                missed.append(f"the recording is whole: {recorded.notes}")
        print(f"recorded: {len(scans):,} scans, whole; load {os.getloadavg()[0]:.1f}")
    if longest > WORST_S and not options.smoke:
        missed.append(f"good clients wait for {WORST_S * 1e3:.0f} ms at most: {longest * 1e3:.1f} ms")
    for each in missed:
        print(f"missed: {each}")
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
