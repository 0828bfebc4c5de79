"""Blend profiles, block by block, and what the manual's arithmetic makes of them.

program(bench, [(3000, 5000, 20, C), (2200, 2000, 10, C)], final=(10, C))

A segment is (length, speed, rate, type), the end (final deceleration, type).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from bench3601 import BLEND_CW, Bench
from scanrack.io_images.thousands import split_thousands

PROGRAM, TRANSMIT = 0x0100, 0x0200

C, T, Z = 0b00, 0b01, 0b11
"""Acceleration types: constant, triangular S, trapezoidal S."""

FACTOR = {C: Fraction(1), T: Fraction(2), Z: Fraction(4, 3)}
"""On the time of a ramp [chapter 2]."""

Words = Sequence[int]
Segment = tuple[int, int, int, int]

TWO: list[Segment] = [(3000, 5000, 20, C), (2200, 2000, 10, C)]
"""600 steps up in 200 ms, 480 ms at 5000/s; 1050 steps down in 300 ms, 500 ms at 2000/s; 150 in 100 ms."""

TWO_MS = 200 + 480 + 300 + 500 + 100
TWO_STEPS = 3000 + 2200


def signed(word: int) -> int:
    return word - 0x10000 if word > 0x7FFF else word


def header(
    types: Sequence[int] = (C, C), final: int = 10, final_type: int = C, *, count: int | None = None
) -> list[int]:
    """Words 2 to 7 of the first block; `count` if it is not the number of types."""
    early = sum(kind << 2 * number for number, kind in enumerate(types[:8]))
    late = sum(kind << 2 * number for number, kind in enumerate(types[8:]))
    last = final | final_type << 14
    return [len(types) if count is None else count, signed(late), signed(early), signed(last), 0, 0]


def block(length: int, speed: int, rate: int) -> list[int]:
    """Words 2 to 7 of a segment's block."""
    return [*split_thousands(length), *split_thousands(speed), rate, 0]


def transmit(bench: Bench, words: Words) -> Bench:
    """Set the transmit bit with these words, for one exchange."""
    return bench.out(0, PROGRAM | TRANSMIT, *words).scan()


def drop(bench: Bench) -> Bench:
    """Reset the transmit bit alone, for one exchange."""
    return bench.out(0, PROGRAM, *list(bench.outputs)[2:]).scan()


def send(bench: Bench, *blocks: Words) -> Bench:
    """Send blocks, each with its handshake; the program bit stays set."""
    for words in blocks:
        transmit(bench, words)
        assert "BLEND_ACK" in bench.bits
        drop(bench)
        assert "BLEND_ACK" not in bench.bits
    return bench


def blocks_of(segments: Sequence[Segment], final: tuple[int, int] = (10, C)) -> list[list[int]]:
    types = [kind for *_, kind in segments]
    return [header(types, *final), *(block(*segment[:3]) for segment in segments)]


def program(
    bench: Bench, segments: Sequence[Segment] = TWO, final: tuple[int, int] = (10, C), *, end: bool = True
) -> Bench:
    """Program a profile; without `end` the program bit stays set."""
    send(bench, *blocks_of(segments, final))
    return bench.out().scan() if end else bench


def is_stored(bench: Bench) -> bool:
    """Run the stored profile CW; return whether there is one. Without one this is a command error."""
    bench.idle().out(BLEND_CW).run(1)
    running = "BLEND_RUNNING" in bench.bits
    assert running != ("CMD-16" in bench.fired)
    return running


Leg = tuple[Fraction, Fraction, Fraction, int]
"""When it ends (ms), where (steps), with which speed (steps/s), and its ramp: +1, -1, 0."""


def legs(start: int, segments: Sequence[Segment], final: tuple[int, int]) -> list[Leg]:
    """Ramps and constant speeds of a profile: T = k*dv/a, D = T*(v0 + v1)/2 [chapter 2].

    The last segment contains the final ramp.
    """
    speeds = [start, *(speed for _, speed, _, _ in segments)]
    ms, done, result = Fraction(0), Fraction(0), []

    def ramp(before: int, after: int, rate: int, kind: int) -> tuple[Fraction, Fraction, int]:
        time = FACTOR[kind] * abs(after - before) / rate  # dv/(1000 a) s are dv/a ms
        return time, time * (before + after) / 2000, (after > before) - (after < before)

    closing = ramp(speeds[-1], start, *final)
    for number, ((before, after), (length, _, rate, kind)) in enumerate(
        zip(pairwise(speeds), segments, strict=True), start=1
    ):
        time, way, sense = ramp(before, after, rate, kind)
        rest = length - way - (closing[1] if number == len(segments) else 0)
        for each_ms, each_way, each_sense in [(time, way, sense), (rest * 1000 / after, rest, 0)]:
            ms, done = ms + each_ms, done + each_way
            result.append((ms, done, Fraction(after), each_sense))
    ms, done = ms + closing[0], done + closing[1]
    return [*result, (ms, done, Fraction(start), closing[2])]
