"""What the simulated PMC006 costs, and what noise does to its line.

noise      random bytes and damaged frames: nothing escapes, and once the line has been quiet
           for the receive time-out, the next good frame is answered
exchange   a status question and its answer, frame by frame
move       a move of 100,000 steps with a look at it every 2 ms
program    a user program that loops without end, per instruction

python benchmarks/pmc006.py            a million bytes, and a table
python benchmarks/pmc006.py --smoke    a short run that only checks
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Sequence

from scanrack.io_images.pmc006.frame import command, decode
from scanrack.io_images.pmc006.program import assemble
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import RECEIVE_TIMEOUT_NS, Pmc006

MS = 1_000_000
CHARACTER_NS = 1_041_667


def check(got: object, expected: object, what: str) -> None:
    """Stop if a result is not what it has to be."""
    if got != expected:
        raise SystemExit(f"{what}: {got}, not {expected}")


def burst(draw: random.Random) -> bytes:
    """Return noise: random bytes, or frames of which a few bits are wrong."""
    if draw.random() < 0.5:
        return draw.randbytes(draw.randrange(1, 60))
    frames = bytearray(
        b"".join(
            command(draw.choice((1, 2, 255)), draw.randrange(256), draw.getrandbits(32))
            for _ in range(draw.randrange(1, 8))
        )
    )
    for _ in range(draw.randrange(1, 4)):
        frames[draw.randrange(len(frames))] ^= 1 << draw.randrange(8)
    return bytes(frames)


def noise(count: int) -> tuple[int, float]:
    """Send that many bytes of noise, a good frame after each burst; return the frames and the seconds."""
    draw = random.Random(6)
    device = Pmc006(Pmc006Controller(address=1))
    now_ns = sent = good = 0
    start_s = time.perf_counter()
    while sent < count:
        damaged = burst(draw)
        sent += len(damaged)
        for value in damaged:
            now_ns += CHARACTER_NS
            device.receive(now_ns, bytes((value,)))
        now_ns += RECEIVE_TIMEOUT_NS + CHARACTER_NS
        device.advance(now_ns)
        address = device.controller.address  # noise can carry a good frame that changes it
        device.receive(now_ns, command(address, ord("K")))
        answer = decode(device.advance(now_ns))
        expected = 0x7A, address, device.controller.memory["ext_trigger_mode"]
        check(answer and (answer.second, answer.third, answer.data), expected, f"after {sent} bytes")
        good += 1
    return good, time.perf_counter() - start_s


def exchanges(count: int) -> float:
    """Return the seconds that so many questions take."""
    device, question = Pmc006(Pmc006Controller(address=1)), command(1, ord("j"))
    start_s = time.perf_counter()
    for number in range(count):
        device.receive(number * 17 * MS, question)
        check(len(device.advance(number * 17 * MS)), 8, "bytes of an answer")
    return time.perf_counter() - start_s


def looked_at_move(steps: int) -> tuple[int, float]:
    """Return the number of looks at a move, and the seconds that they took."""
    controller = Pmc006Controller(address=1)
    controller.execute(ord("s"), steps)
    looks, start_s = 0, time.perf_counter()
    while controller.axis.moving:
        looks += 1
        controller.advance(looks * 2 * MS)
    check(controller.axis.position, steps, "end of the move")
    return looks, time.perf_counter() - start_s


def program(instructions: int) -> float:
    """Return the seconds that a looping program takes for so many instructions."""
    controller = Pmc006Controller(address=1, program=assemble("CNT1 0\nCMP 1 5\nJMP 0 0\n"))
    controller.execute(ord("Z"), 0)
    start_s = time.perf_counter()
    controller.advance((instructions - 1) * MS)
    check(controller.interpreter.counter, -(-instructions // 3), "rounds of the loop")
    return time.perf_counter() - start_s


def main(arguments: Sequence[str]) -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    smoke = parser.parse_args(arguments).smoke
    count = 5_000 if smoke else 1_000_000
    good, seconds = noise(count)
    print(f"{count:,} bytes of noise: all {good:,} good frames answered, {count / seconds:,.0f} bytes/s")
    count = 500 if smoke else 50_000
    print(f"exchange: {exchanges(count) / count * 1e6:.1f} µs")
    looks, seconds = looked_at_move(1_000 if smoke else 100_000)
    print(f"look at a move: {seconds / looks * 1e6:.1f} µs")
    count = 300 if smoke else 100_000
    print(f"user instruction: {program(count) / count * 1e6:.1f} µs")


if __name__ == "__main__":
    main(sys.argv[1:])
