"""What the simulated PCL601 costs, and a million damaged and random frames.

    python benchmarks/pcl601.py [--frames N] [--smoke]

    read          38 registers, request and reply: the device alone, and on the bus in virtual time
    decode        the same request and reply, decoded and built by pymodbus's own PDU classes: a floor
    move          an index move of 10,000 steps with both switches and an output on the fly on its way
    damage        damaged, truncated, random and foreign frames, on a line and by length; after each a
                  good one, which must be answered; memory must not grow, nothing may be raised

Everything computed is checked; the exit status is 1 if a check fails.
"""

from __future__ import annotations

import argparse
import sys
import tracemalloc
from collections.abc import Callable
from random import Random
from time import process_time

from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import ReadHoldingRegistersResponse
from scanrack.io_images.pcl601 import MAP, Register, word_of
from scanrack.runtime.controllers.pcl601.line import FORMATS, SERIAL_TIMING, Pcl601
from scanrack.runtime.line.rtu import Timing, crc, frame
from scanrack.runtime.line.wire import SerialBus
from scanrack.runtime.machine.contacts import Contact

MS = 1_000_000
PORT_TIMING = Timing(
    gap_ns=5 * MS, by_length=True
)  # of a port that does not keep the time between characters
READ_ALL = frame(1, bytes.fromhex("03 00 00 00 26"))
WORDS = [word_of(row.default, word) for row in MAP for word in range(row.words)]
ALL = frame(1, bytes((3, 76)) + b"".join(word.to_bytes(2, "big") for word in WORDS))
IDENT, IDENTITY = frame(1, b"\x11"), frame(1, bytes.fromhex("11 05 01 31 2e 30 30"))
GROWTH_BYTES_PER_FRAME = 0.5
"""What may be allocated more after the damage than before: less than a byte a frame."""


class WrongError(Exception):
    """A check has failed."""


def check(got: object, wanted: object, what: str) -> None:
    if got != wanted:
        raise WrongError(f"{what}: {got!r}, should be {wanted!r}")


def timed(count: int, action: Callable[[], object]) -> float:
    """Return processor time per call in µs, the best of three rounds."""
    rounds = []
    for _ in range(3):
        start = process_time()
        for _ in range(count):
            action()
        rounds.append((process_time() - start) / count * 1e6)
    return min(rounds)


def reads(count: int) -> None:
    unit, now_ns = Pcl601(timing=PORT_TIMING), 0

    def alone() -> None:
        nonlocal now_ns
        now_ns += 20 * MS
        unit.advance(now_ns)
        unit.receive(now_ns, READ_ALL)
        check(unit.advance(now_ns), ALL, "38 registers")

    on_bus = Pcl601()
    bus = SerialBus(on_bus)

    def on_the_bus() -> None:
        bus.send(READ_ALL, FORMATS[on_bus.controller.protocol])
        bus.run_until(bus.now_ns + 40 * MS)
        check(bus.take(), ALL, "38 registers over the bus")

    requests, framer = DecodePDU(True), FramerRTU(DecodePDU(False))

    def by_pymodbus() -> None:
        requests.decode(READ_ALL[1:-2])
        check(framer.buildFrame(ReadHoldingRegistersResponse(registers=WORDS, dev_id=1)), ALL, "pymodbus")

    print(f"read 38 registers      alone {timed(count, alone):8.1f} µs")
    print(f"                  on the bus {timed(count // 10 or 1, on_the_bus):8.1f} µs")
    print(f"     floor: pymodbus's PDUs  {timed(count, by_pymodbus):8.1f} µs")


def moves(count: int) -> None:
    def one() -> None:
        unit = Pcl601()
        controller, values = unit.controller, unit.controller.values
        controller.pins.connect("soft_plus", Contact(low=8000))
        controller.pins.connect("home", Contact(4000, 4100))
        values[Register.OUTPUT_ON_FLY], values[Register.FIRST_OUTPUT_POSITION] = 1, 2000
        values[Register.STEPS_BETWEEN_OUTPUTS], values[Register.NUMBER_OF_OUTPUTS] = 1000, 5
        controller.move(10_000)
        controller.settle(0)
        unit.advance(60_000 * MS)
        check(controller.motor.position, 10_000, "position")
        check(list(controller.axis.fly.positions), [2000, 3000, 4000, 5000, 6000], "pulses")

    print(f"move of 10,000 steps         {timed(count, one):8.1f} µs")


def damaged(draw: Random) -> bytes:
    """Return a frame as lines spoil it: cut, flipped, noise, or of another unit."""
    kind = draw.randrange(4)
    if kind == 0:
        return draw.randbytes(draw.randrange(1, 40))
    if kind == 1:
        return frame(draw.randrange(2, 248), draw.randbytes(draw.randrange(1, 30)))
    good = bytearray(frame(1, bytes((draw.choice((1, 2, 3, 4, 5, 6, 15, 16, 17)),)) + draw.randbytes(4)))
    if kind == 2:
        return bytes(good[: draw.randrange(1, len(good))])
    good[draw.randrange(len(good))] ^= 1 << draw.randrange(8)
    return bytes(good)


def is_frame_for_it(data: bytes) -> bool:
    return len(data) >= 4 and crc(data[:-2]) == data[-2:] and data[0] in (0, 1)


class Damage:
    """One unit under damaged frames, each followed by silence and by a good one."""

    def __init__(self, timing: Timing, seed: int) -> None:
        self._unit = Pcl601(timing=timing)
        self._draw = Random(seed)
        self._now_ns = 0

    def run(self, frames: int) -> None:
        for _ in range(frames):
            data = damaged(self._draw)
            if not is_frame_for_it(data):
                self._say(data)
            check(self._say(IDENT), IDENTITY, "a good frame after a damaged one")

    def _say(self, data: bytes) -> bytes:
        self._now_ns += 20 * MS
        reply = self._unit.advance(self._now_ns)
        self._unit.receive(self._now_ns, data)
        self._now_ns += 20 * MS
        return reply + self._unit.advance(self._now_ns)


def damage(frames: int) -> None:
    for name, timing in (("on a line", SERIAL_TIMING), ("by length", PORT_TIMING)):
        trial = Damage(timing, 601)
        traced = min(20_000, frames)
        growth = grown(trial, traced)
        if growth > GROWTH_BYTES_PER_FRAME * traced:
            raise WrongError(f"memory grew by {growth} bytes in {traced} frames")
        start = process_time()
        trial.run(frames)
        spent = (process_time() - start) / frames * 1e6
        print(f"damage {name}: {frames:,} frames, all good ones answered, {spent:5.1f} µs each")
        print(f"                  memory {growth:+,} bytes in {traced:,} of them")


def grown(trial: Damage, frames: int) -> int:
    """Return the bytes allocated more after so many frames, warmed up before."""
    trial.run(1000)
    tracemalloc.start()
    trial.run(100)
    before, _ = tracemalloc.get_traced_memory()
    trial.run(frames)
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return after - before


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What the simulated PCL601 costs and withstands.")
    parser.add_argument("--frames", type=int, default=500_000, help="damaged frames, for each of two timings")
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    try:
        reads(100 if given.smoke else 10_000)
        moves(10 if given.smoke else 300)
        damage(1000 if given.smoke else given.frames)
    except WrongError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
