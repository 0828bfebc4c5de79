"""Reads per second over Modbus TCP: the simulated PCL601 beside pymodbus's own server.

    python benchmarks/modbus_tcp.py [--reads N] [--rounds N] [--smoke]

Both run in a process of their own and answer the same 38 registers; pymodbus's server holds those
that the PCL601 was read to have at first. One client reads all 38, waiting for each reply before
it sends the next request, and compares every reply byte for byte. The servers take turns; the best
round counts, and the rounds are shown.

Exit status 1 if a reply is wrong, or if the PCL601 is slower than pymodbus's server (not with --smoke).
"""

from __future__ import annotations

import argparse
import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

READ_ALL = bytes.fromhex("0001 0000 0006 01 03 0000 0026")
REPLY_BYTES = 9 + 2 * 38

PYMODBUS_SERVER = """
import asyncio, json, sys
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

registers, port = json.loads(sys.argv[1]), int(sys.argv[2])

async def main():
    device = SimDevice(1, simdata=[SimData(0, values=registers, datatype=DataType.REGISTERS)])
    server = ModbusTcpServer(device, address=("127.0.0.1", port))
    await server.serve_forever(background=True)
    print(f"127.0.0.1:{port}  ready", flush=True)
    await asyncio.Event().wait()

asyncio.run(main())
"""


@contextmanager
def served(*arguments: str) -> Iterator[socket.socket]:
    """Run a server that prints where it is found; yield a connection to it."""
    process = subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.PIPE, text=True, encoding="utf-8"
    )
    try:
        assert process.stdout is not None
        host, port = process.stdout.readline().split()[0].split(":")
        with socket.create_connection((host, int(port)), timeout=10) as client:
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            yield client
    finally:
        process.terminate()
        process.communicate()


def free_port() -> int:
    """Return a port without a listener."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return int(listening.getsockname()[1])


def read(client: socket.socket) -> bytes:
    """Read all registers; return the reply."""
    client.sendall(READ_ALL)
    reply = client.recv(1024)
    while len(reply) < REPLY_BYTES:
        reply += client.recv(1024)
    return reply


def rate(client: socket.socket, reads: int, expected: bytes) -> float:
    """Return reads per second; end the benchmark at a wrong reply."""
    start = perf_counter()
    for _ in range(reads):
        reply = read(client)
        if reply != expected:
            sys.exit(f"wrong reply: {reply.hex(' ')} instead of {expected.hex(' ')}")
    return reads / (perf_counter() - start)


def registers_of(reply: bytes) -> list[int]:
    """Return the registers in a reply."""
    return [int.from_bytes(reply[at : at + 2]) for at in range(9, REPLY_BYTES, 2)]


def main() -> int:
    """Run both servers in turns; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--reads", type=int, default=10_000, help="reads in a round")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--smoke", action="store_true", help="few reads, no comparison of speed")
    options = parser.parse_args()
    reads, rounds = (200, 1) if options.smoke else (options.reads, options.rounds)
    ours, theirs = compare(reads, rounds)
    for name, rates in (("scanrack serve pcl601", ours), ("pymodbus's server", theirs)):
        shown = " ".join(f"{each:,.0f}" for each in rates)
        print(f"{name:<22} {max(rates):>8,.0f} reads/s   (rounds: {shown})")
    print(f"ratio {max(ours) / max(theirs):.2f}; every reply compared, 38 registers each")
    return int(max(ours) < max(theirs) and not options.smoke)


def compare(reads: int, rounds: int) -> tuple[list[float], list[float]]:
    """Return the rates of the PCL601 and of pymodbus's server, round by round."""
    with served("-m", "scanrack", "serve", "pcl601", "--tcp", "0", "--quiet") as ours:
        expected = read(ours)
        registers = json.dumps(registers_of(expected))
        with served("-c", PYMODBUS_SERVER, registers, str(free_port())) as theirs:
            pairs = [(rate(ours, reads, expected), rate(theirs, reads, expected)) for _ in range(rounds)]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


if __name__ == "__main__":
    sys.exit(main())
