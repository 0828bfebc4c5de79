"""Reads per second of a served drive, beside pymodbus's own server: ten registers.

    python benchmarks/drive_modbus.py [--reads N] [--rounds N] [--smoke]

Both run in a process of their own. One client reads input registers 0 to 9 by function 4; then six
connections take turns; then function 23 reads the ten and writes one. A reply is compared with the first
one, without the heartbeat. A round is short and has all four. The best rates are compared, which other
processes have disturbed least; beside them stand the ratios within a round: median and quartiles.

Exit status 1 if a reply is wrong, or if the drive answers fewer reads than pymodbus's server with one
connection, or fewer than 0.95 times those of one connection by function 4 with six connections, or by
function 23 (not with --smoke).
"""

from __future__ import annotations

import argparse
import json
import socket
import sys
from contextlib import ExitStack
from statistics import median, quantiles
from time import perf_counter

from modbus_tcp import PYMODBUS_SERVER, free_port, served

READ = bytes.fromhex("0001 0000 0006 01 04 0000 000A")
BOTH = bytes.fromhex("0001 0000 000D 01 17 0000 000A 0409 0001 02 0000")
REPLY_BYTES = 9 + 20
HEARTBEAT = 0x08
CONNECTIONS = 6
ONE, SIX, BOTH_WAYS, THEIRS = "one connection", "six connections", "function 23", "pymodbus's server"
BARS = ((ONE, THEIRS, 1.0), (SIX, ONE, 0.95), (BOTH_WAYS, ONE, 0.95))
"""What is compared with what, and the least ratio; 0.95 counts as the same."""


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
    parser.add_argument("--reads", type=int, default=400, help="reads in a round")
    parser.add_argument("--rounds", type=int, default=41)
    parser.add_argument("--smoke", action="store_true", help="few reads, no comparison of speed")
    options = parser.parse_args()
    reads, rounds = (50, 2) if options.smoke else (options.reads, options.rounds)
    rates = compare(reads, rounds)
    for name, found in rates.items():
        print(f"{name:<20} {median(found):>8,.0f} reads/s in the middle, {max(found):>8,.0f} at most")
    good = [shown(name, base, rates, least) for name, base, least in BARS]
    return int(not all(good) and not options.smoke)


def shown(name: str, base: str, rates: dict[str, list[float]], least: float) -> bool:
    """Print the ratio of two rates; return whether it is high enough."""
    best = max(rates[name]) / max(rates[base])
    low, middle, high = quantiles([a / b for a, b in zip(rates[name], rates[base], strict=True)], n=4)
    print(
        f"{name} to {base}: {best:.2f}, at least {least:.2f}; rounds {middle:.2f} ({low:.2f} to {high:.2f})"
    )
    return best >= least


def compare(reads: int, rounds: int) -> dict[str, list[float]]:
    """Return the rates of all rounds by name."""
    rates: dict[str, list[float]] = {name: [] for name in (ONE, SIX, BOTH_WAYS, THEIRS)}
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
            for name, (clients, request) in zip(rates, rows, strict=True):
                rates[name].append(rate(clients, request, reads))
    return rates


if __name__ == "__main__":
    sys.exit(main())
