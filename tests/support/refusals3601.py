"""What a refused command leaves behind, looked at in the same way for every rule that refuses one.

bench = after_a_move()                       # at 0, position valid, MOVE_COMPLETE set
bench.relative(0, speed=999)
refused(bench, "CMD-05", "PRF-01", errors=PROFILE_ERRORS)
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from bench3601 import Bench

ERRORS = {
    "HOME_INVALID",
    "INVALID_PROFILE",
    "POSITION_INVALID",
    "INPUT_ERROR",
    "COMMAND_ERROR",
    "CONFIG_ERROR",
}
MOTION = {"MOVING_CW", "MOVING_CCW", "ACCELERATING", "DECELERATING"}
COMMAND_ERRORS = {"COMMAND_ERROR"}
PROFILE_ERRORS = {"COMMAND_ERROR", "INVALID_PROFILE"}


def after_a_move(firmware: str = "4.1", *, position: int = 0, **kwargs) -> Bench:
    """Return a bench on which a move is complete: a bit that no refused command may touch."""
    bench = Bench.ready(firmware, position=position - 1, **kwargs)
    bench.relative(1)
    bench.until("MOVE_COMPLETE")
    bench.idle(10)
    bench.fired.clear()
    return bench


def refused(bench: Bench, *rules: str, errors: AbstractSet[str]) -> None:
    """Let the words that were just written be refused, and be forgiven.

    Exactly these rules fire, exactly these error bits come on, and nothing else of the image
    changes; with a command error even a correct move is ignored; Reset Errors clears what the
    refusal set, and the correct move is made.
    """
    words, bits = bench.words, bench.bits
    bench.fired.clear()
    bench.scan()
    assert bench.fired == list(rules)
    bench.run(20)
    assert bench.bits == bits | errors
    assert bench.words[2:] == words[2:]
    bench.idle(10)
    if "COMMAND_ERROR" in errors:
        bench.relative(5, ms=50)
        assert (bench.bits, bench.words[2:]) == (bits | errors, words[2:])
    bench.reset_errors(10)
    assert bench.bits == bits - {"INPUT_ERROR"}
    assert bench.fired == list(rules)
    goes(bench, 5)


def goes(bench: Bench, distance: int = 5) -> None:
    """Make a short relative move and return to rest."""
    position = bench.position
    bench.idle(10).relative(distance)
    bench.until("MOVE_COMPLETE", clear=sorted(MOTION))
    assert bench.position == position + distance
    bench.idle(10)
