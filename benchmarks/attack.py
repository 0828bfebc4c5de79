"""Good clients of a tag server while others attack it over EtherNet/IP, and the recording of that.

    python benchmarks/attack.py [--packets 10000] [--smoke]

`scanrack run --realtime --server ethernet-ip` serves and records a rack of 2 ms scans. Two good clients read
batches of 21 tags 200 times a second, while processes of their own attack it, one kind after the other:

    beginnings  the start of a good frame, 0 to all bytes of it, then nothing
    lengths     frames whose length or counts lie
    services    all 256 services, at paths of all kinds
    random      whole frames of random bytes, with and without a session
    slow        40 clients that send a byte a second, and read nothing
    sessions    200 connections with a session each; when all places are taken, silent ones give way

Exit status 1 if a good client got a wrong answer or none, if the server's process died, if the CPU faulted,
if the recording lacks a scan, or (not with --smoke) if a good client waited for more than 50 ms.
"""

from __future__ import annotations

import argparse
import os
import random
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import Process
from pathlib import Path
from time import perf_counter

from ethernet_ip import BATCH, Asker, frame, is_torn, read, write_rack
from scanrack.traces import open_trace

WORST_S = 0.050
PERIOD_S = 0.005
SLOW_CLIENTS, SLOW_S = 40, 8
"""Clients that send a byte a second, and for how long: a frame that is not whole ends after 5 s."""

SESSIONS = 200
Attack = Callable[[int, int], None]


def dialled(port: int) -> socket.socket:
    """Return a connection; it waits for no answer for long."""
    found = socket.create_connection(("127.0.0.1", port), timeout=30)
    found.settimeout(1)
    return found


def in_session(where: socket.socket) -> int:
    """Begin a session; return its handle."""
    where.sendall(frame(0x65, b"\1\0\0\0"))
    return int.from_bytes(where.recv(1 << 12)[4:8], "little")


def packet(session: int, message: bytes) -> bytes:
    """Return a frame with a message."""
    items = struct.pack("<IHHHHHH", 0, 0, 2, 0, 0, 0xB2, len(message))
    return frame(0x6F, items + message, session)


def tried(port: int, sent: Callable[[int], Iterator[bytes]]) -> None:
    """Send messages; connect again whenever the server has ended the connection."""
    where = dialled(port)
    for data in sent(in_session(where)):
        try:
            where.sendall(data)
            if select.select([where], [], [], 0.0005)[0] and not where.recv(1 << 16):
                raise ConnectionError
        except OSError:
            where.close()
            where = dialled(port)
            in_session(where)
    where.close()


def beginnings(port: int, _packets: int) -> None:
    """Leave frames unfinished."""
    whole = packet(1, BATCH)
    for length in range(0, len(whole), 3):
        with dialled(port) as where:
            where.sendall(whole[:length])


def lengths(port: int, packets: int) -> None:
    """Lie about lengths, counts and offsets."""
    rng = random.Random(1)

    def sent(session: int) -> Iterator[bytes]:
        for _ in range(packets // 10):
            data = bytearray(packet(session, BATCH))
            at = rng.choice((2, 24 + 6, 24 + 14, 40 + 6, 40 + 8, rng.randrange(2, len(data) - 2)))
            struct.pack_into("<H", data, at, rng.choice((0, 1, 0xFFFF, 0x8000, rng.randrange(1 << 16))))
            yield bytes(data)

    tried(port, sent)


def services(port: int, _packets: int) -> None:
    """Ask for all services at paths that exist and at such that do not."""
    paths = (
        read("Scan")[2:-2],
        b"\x20\x02\x24\x01",
        b"\x20\x6b\x25\0\1\0",
        b"\x91\xff",
        b"\x20\x67\x24\x01",
        b"",
    )

    def sent(session: int) -> Iterator[bytes]:
        for service in range(256):
            for path in paths:
                for data in (b"", b"\1\0", b"\xff" * 40):
                    yield packet(session, bytes((service, len(path) // 2)) + path + data)

    tried(port, sent)


def noise(port: int, packets: int) -> None:
    """Send random bytes in whole frames."""
    rng = random.Random(2)

    def sent(session: int) -> Iterator[bytes]:
        for _ in range(packets):
            body = rng.randbytes(rng.randrange(120))
            if rng.random() < 0.5:
                yield packet(session, body)
            else:
                command = rng.choice((0x04, 0x63, 0x64, 0x65, 0x6F, 0x70, rng.randrange(1 << 16)))
                yield frame(command, body, rng.choice((0, session)))

    tried(port, sent)


def slow(port: int, packets: int) -> None:
    """Send a byte a second from many clients, which also read nothing."""
    clients = [dialled(port) for _ in range(SLOW_CLIENTS)]
    whole = packet(1, BATCH)
    for second in range(min(SLOW_S, packets // 1000 + 1)):
        for each in clients:
            with suppress(OSError):
                each.sendall(whole[second : second + 1])
        time.sleep(1)
    for each in clients:
        each.close()


def sessions(port: int, _packets: int) -> None:
    """Take all places."""
    held = []
    for _ in range(SESSIONS):
        with suppress(OSError):
            held.append(dialled(port))
            held[-1].sendall(frame(0x65, b"\1\0\0\0"))
    time.sleep(1)
    for each in held:
        each.close()


ATTACKS: dict[str, Attack] = {
    "beginnings": beginnings,
    "lengths": lengths,
    "services": services,
    "random": noise,
    "slow": slow,
    "sessions": sessions,
}


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


def watched(clients: list[Asker], attack: Process) -> tuple[int, float, float]:
    """Let good clients ask while an attack lasts.

    Returns:
        (answers, longest time of one, longest lateness of a question), s: on a busy machine the second is no
        less than the third.
    """
    answers, worst, late = 0, 0.0, 0.0
    due = perf_counter()
    while attack.is_alive():
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


def attacked(port: int, packets: int) -> float:
    """Play all attacks; return the longest time that a good client waited, s."""
    clients = [Asker(port, BATCH) for _ in range(2)]
    longest = 0.0
    for name, function in ATTACKS.items():
        attack = Process(target=function, args=(port, packets))
        begun = perf_counter()
        attack.start()
        answers, worst, late = watched(clients, attack)
        attack.join()
        took = perf_counter() - begun
        print(
            f"{name:<11} {took:5.1f} s, {answers:6,} good answers, the slowest after {worst * 1e3:5.1f} ms;"
            f" the client itself was late by {late * 1e3:.1f} ms",
            flush=True,
        )
        if attack.exitcode:
            raise RuntimeError(f"{name} ended with {attack.exitcode}")
        longest = max(longest, worst)
    for each in clients:
        each.socket.close()
    return longest


def main() -> int:
    """Run the benchmark; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--packets", type=int, default=10_000, help="random packets")
    parser.add_argument("--smoke", action="store_true", help="200 packets, no bar for the time")
    options = parser.parse_args()
    packets = 200 if options.smoke else options.packets
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        trace, log = Path(folder, "run.mcap"), Path(folder, "log")
        with served(write_rack(Path(folder), 0), trace, log) as (process, port):
            longest = attacked(port, packets)
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
