"""The encoder follower in words: a bench with an encoder, the mode's words, and what exact following is.

bench = follow(follower_bench(), 1, 7, 3)
bench.turn_encoder(300, 100).scan()
assert bench.position == 700

The module counts scan by scan and makes the steps within the scan, so the image at
the end of a turn shows them all.
"""

from __future__ import annotations

from bench3601 import ENCODER, MANUAL_CCW, MANUAL_CW, Bench, configuration

FOLLOW = 0x0080
"""Command LSW bit 7."""

WITH_ENCODER = configuration(add=ENCODER)

MSW = {1: MANUAL_CW, -1: MANUAL_CCW, 0: 0}


def follower_bench(firmware: str = "4.1", **kwargs) -> Bench:
    """Return a bench with an encoder configured, its position 0 and valid."""
    return Bench.ready(firmware, config=WITH_ENCODER, **kwargs)


def words(direction: int, ratio: tuple[int, int] = (1, 1), rates: tuple[int, int] = (0, 0)) -> list[int]:
    """Return the eight words of the mode; direction 0 = neither manual bit."""
    return [MSW[direction], FOLLOW, *ratio, 0, 0, *rates]


def follow(
    bench: Bench, direction: int, ratio: tuple[int, int] = (1, 1), rates: tuple[int, int] = (0, 0)
) -> Bench:
    """Write the words of the mode, for one exchange."""
    bench.out(*words(direction, ratio, rates)).scan()
    return bench
