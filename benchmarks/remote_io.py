"""Exchanges per second with a 3601 as remote I/O, and whether one was torn.

    python benchmarks/remote_io.py [--exchanges N] [--smoke]

A client writes eight equal words with function 17h and reads them back; every hundredth time it writes half
of them afterwards. All recorded output images must have eight equal words but for those
halves, and the halves must have been counted.

Exit status 1 if an image was torn, or a half write was not counted.
"""

from __future__ import annotations

import argparse
import signal
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from struct import pack
from time import perf_counter_ns

from scanrack.traces.read.reader import open_trace

HALVES_EVERY = 100


def request(words: list[int]) -> bytes:
    """Return a request of function 17h that writes words, and reads the eight output words."""
    pdu = pack(f">BHHHHB{len(words)}H", 0x17, 0, 8, 0, len(words), 2 * len(words), *words)
    return pack(">HHHB", 1, 0, len(pdu) + 1, 1) + pdu


def exchange(client: socket.socket, words: list[int]) -> list[int]:
    """Carry out a request; return the output words that come back."""
    client.sendall(request(words))
    reply = b""
    while len(reply) < 25:
        reply += client.recv(64)
    return [int.from_bytes(reply[at : at + 2], "big") for at in range(9, 25, 2)]


def measured(port: int, exchanges: int) -> tuple[list[int], int, int]:
    """Return the time of each exchange in ns, the number of wrong replies, and that of half writes."""
    times, wrong, halves = [], 0, 0
    with socket.create_connection(("127.0.0.1", port), timeout=10) as client:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for number in range(exchanges):
            words = [number % 30_000 + 1] * 8
            begun_ns = perf_counter_ns()
            wrong += exchange(client, words) != words
            times.append(perf_counter_ns() - begun_ns)
            if number % HALVES_EVERY == HALVES_EVERY - 1:
                exchange(client, [0] * 4)
                halves += 1
                exchange(client, [0] * 8)
        client.sendall(bytes.fromhex("0001 0000 0006 01 04 0009 0001"))
        counted = int.from_bytes(client.recv(64)[9:11], "big")
    return times, wrong, halves - counted


def torn_images(trace: Path) -> int:
    """Return the number of recorded images that are neither whole nor half zero."""
    with open_trace(trace) as recorded:
        images = {tuple(scan.outputs(1).words) for scan in recorded.scans()}
    return sum(1 for words in images if len(set(words)) > 1 and (any(words[:4]) or len(set(words[4:])) > 1))


def main() -> int:
    """Run the benchmark; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--exchanges", type=int, default=10_000)
    parser.add_argument("--smoke", action="store_true", help="300 exchanges")
    options = parser.parse_args()
    exchanges = 300 if options.smoke else options.exchanges
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "t.mcap"
        words = ["-m", "scanrack", "serve", "amci3601", "--tcp", "0", "--record", str(trace), "--quiet"]
        process = subprocess.Popen(
            [sys.executable, *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
        )
        assert process.stdout is not None
        port = int(process.stdout.readline().split("  ")[0].split(":")[1])
        times, wrong, uncounted = measured(port, exchanges)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        torn = torn_images(trace)
    times.sort()
    rate = len(times) / (sum(times) / 1e9)
    late_us = times[len(times) * 99 // 100] // 1000
    spread = f"median {median(times) / 1000:.0f} µs, 99 % {late_us} µs"
    print(f"{exchanges:,} exchanges, {rate:,.0f} a second, {spread}")
    print(f"wrong replies {wrong}, torn images {torn}, half writes not counted {uncounted}")
    return 1 if wrong or torn or uncounted else 0


if __name__ == "__main__":
    sys.exit(main())
