"""Reads per second of a served drive, beside pymodbus's own server: ten registers.

    python benchmarks/drive_modbus.py [--reads N] [--rounds N] [--smoke]

Both run in a process of their own. One client reads input registers 0 to 9 by function 4; then six
connections take turns; then function 23 reads the ten and writes one. A reply is compared with the first
one, without the heartbeat. The servers take turns; the best round counts.

Exit status 1 if a reply is wrong, or if the drive answers fewer reads than pymodbus's server with one
connection, fewer with six than with one by more than a twentieth, or fewer by function 23 than by 4 by more
than a twentieth (not with --smoke).
"""

from __future__ import annotations

import argparse
import json
import socket
import sys
from contextlib import ExitStack
from time import perf_counter

from modbus_tcp import PYMODBUS_SERVER, free_port, served

READ = bytes.fromhex("0001 0000 0006 01 04 0000 000A")
BOTH = bytes.fromhex("0001 0000 000D 01 17 0000 000A 0409 0001 02 0000")
REPLY_BYTES = 9 + 20
HEARTBEAT = 0x08
CONNECTIONS = 6
SLACK = 0.95
"""Share of the rate that counts as the same."""


def ask(client: socket.socket, request: bytes) -> bytes:
    """Return the reply, without the heartbeat."""
    client.sendall(request)
    reply = client.recv(1024)
    while len(reply) < REPLY_BYTES:
        reply += client.recv(1024)
    return reply[:11] + bytes((reply[11] & ~HEARTBEAT,)) + reply[12:]


def rate(clients: list[socket.socket], request: bytes, reads: int) -> float:
    """Return replies per second, the clients in turns; end the benchmark at a wrong reply."""
    expected = ask(clients[0], request)
    start = perf_counter()
    for at in range(reads):
        reply = ask(clients[at % len(clients)], request)
        if reply != expected:
            sys.exit(f"wrong reply: {reply.hex(' ')} instead of {expected.hex(' ')}")
    return reads / (perf_counter() - start)


def main() -> int:
    """Run both servers in turns; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--reads", type=int, default=5_000, help="reads in a round")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--smoke", action="store_true", help="few reads, no comparison of speed")
    options = parser.parse_args()
    reads, rounds = (100, 1) if options.smoke else (options.reads, options.rounds)
    best = compare(reads, rounds)
    for name, found in best.items():
        print(f"{name:<32} {found:>8,.0f} reads/s")
    one, six, both, theirs = best.values()
    slow = one < theirs or six < SLACK * one or both < SLACK * one
    print(f"ratios: to pymodbus {one / theirs:.2f}, six to one {six / one:.2f}, 23 to 4 {both / one:.2f}")
    return int(slow and not options.smoke)


def compare(reads: int, rounds: int) -> dict[str, float]:
    """Return the best rates by name."""
    best = dict.fromkeys(("one connection", "six connections", "function 23", "pymodbus's server"), 0.0)
    with ExitStack() as opened:
        ours = opened.enter_context(served("-m", "scanrack", "serve", "smd23e2", "--tcp", "0", "--quiet"))
        place = ours.getpeername()
        more = [opened.enter_context(socket.create_connection(place, 10)) for _ in range(CONNECTIONS - 1)]
        registers = json.dumps([0] * 10)
        theirs = opened.enter_context(served("-c", PYMODBUS_SERVER, registers, str(free_port())))
        for each in more:
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        rows = (([ours], READ), ([ours, *more], READ), ([ours], BOTH), ([theirs], READ))
        for _ in range(rounds):
            for name, (clients, request) in zip(best, rows, strict=True):
                best[name] = max(best[name], rate(clients, request, reads))
    return best


if __name__ == "__main__":
    sys.exit(main())
