"""Encoder follower: every error, at the start and while it follows [chapter 4, New Error Bit Functions].

All of them set Command Error alone. While it follows, the steps stop, the mode
ends and Stopped is set (reading A-65); the position stays valid.
"""

from __future__ import annotations

import pytest
from bench3601 import BLEND_CW, DIAGNOSTIC, HOLD, HOME_CW, IMMEDIATE_STOP, RESET, Bench, configuration
from blends3601 import program
from follower3601 import FOLLOW, MSW, follow, follower_bench, words

BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])

IN_MODE = {"MODULE_OK", "ENC_FOLLOWER"}
S_CURVE, TRAPEZOIDAL = 0x0001, 0x0002

OTHER_BITS = [1 << bit for bit in range(15) if bit not in (7, 8)]
"""Command bits other than the two manual moves."""


def changed(direction: int, **replaced: int) -> list[int]:
    """The words of a follower with some of them changed, w1 to w7."""
    given = words(direction)
    for name, value in replaced.items():
        given[int(name[1:])] = value
    return given


WRONG_WORDS = [
    pytest.param({"w2": 0}, "CMD-31", id="multiplier 0"),
    pytest.param({"w2": -1}, "CMD-31", id="multiplier -1"),
    pytest.param({"w2": -32_768}, "CMD-31", id="multiplier -32,768"),
    pytest.param({"w3": 0}, "CMD-31", id="divisor 0"),
    pytest.param({"w3": -1}, "CMD-31", id="divisor -1"),
    pytest.param({"w4": 1}, "CMD-32", id="speed MSW 1"),
    pytest.param({"w5": 1}, "CMD-32", id="speed LSW 1"),
    pytest.param({"w4": -1}, "CMD-32", id="speed MSW -1"),
    pytest.param({"w5": -999}, "CMD-32", id="speed LSW -999"),
    pytest.param({"w1": FOLLOW | S_CURVE}, "CMD-36", id="triangular S"),
    pytest.param({"w1": FOLLOW | S_CURVE | TRAPEZOIDAL}, "CMD-36", id="trapezoidal S"),
    pytest.param({"w6": 2001}, "FOL-02", id="acceleration 2001"),
    pytest.param({"w6": -1}, "FOL-02", id="acceleration -1"),
    pytest.param({"w7": 2001}, "FOL-02", id="deceleration 2001"),
    pytest.param({"w7": -1}, "FOL-02", id="deceleration -1"),
]
"""Readings A-103 for the rates."""


def assert_ended(bench: Bench, direction: int, position: int) -> None:
    """The mode is over; it comes back after Reset Errors, when the bit rises again."""
    shown = {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}
    assert bench.bits == shown
    bench.turn_encoder(100, 20).run(1)
    assert (bench.position, bench.bits) == (position, shown)
    bench.out(*words(direction)).run(1)
    assert bench.bits == shown
    bench.idle().reset_errors()
    follow(bench, direction).turn_encoder(10, 10).run(1)
    assert (bench.position, bench.bits) == (position + direction * 10, IN_MODE)


# -- while it follows


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("CMD-31", "CMD-32", "CMD-36", "FOL-13", "FOL-14", "FOL-18", "FOL-02", "PRO-12", "FOL-06")
@pytest.mark.parametrize(("replaced", "rule"), WRONG_WORDS)
def test_words_that_become_wrong(replaced, rule, direction, scan_ms):
    bench = follow(follower_bench(scan_ms=scan_ms), direction).turn_encoder(100, 20).run(scan_ms)
    bench.out(*changed(direction, **replaced)).scan()
    assert (bench.position, bench.fired) == (direction * 100, [rule])
    assert_ended(bench, direction, direction * 100)


@EITHER_WAY
@pytest.mark.rules("CMD-31", "CMD-32", "CMD-36", "FOL-02", "FOL-13")
@pytest.mark.parametrize(
    "replaced",
    [
        {"w2": 1},
        {"w2": 32_767},
        {"w3": 32_767},
        {"w6": 2000},
        {"w7": 2000},
        {"w6": 1, "w7": 1},
        {"w1": FOLLOW | TRAPEZOIDAL},
    ],
    ids=str,
)
def test_words_at_the_ends_of_their_ranges(replaced, direction):
    """LSW bit 1 counts only with bit 0 [chapter 5]."""
    bench = follow(follower_bench(), direction)
    bench.out(*changed(direction, **replaced)).turn_encoder(100, 20)
    assert (bench.fired, "ENC_FOLLOWER" in bench.bits) == ([], True)


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("CMD-33", "FOL-15")
def test_direction_changed_without_a_zero_word(direction, scan_ms):
    bench = follow(follower_bench(scan_ms=scan_ms), direction).turn_encoder(100, 20).run(scan_ms)
    bench.out(*words(-direction)).scan()
    assert (bench.position, bench.fired) == (direction * 100, ["CMD-33"])
    assert_ended(bench, direction, direction * 100)


@pytest.mark.rules("CMD-33", "FOL-15")
def test_a_zero_word_that_no_exchange_carries_does_not_count():
    bench = follow(follower_bench(scan_ms=2), 1)
    bench.out(*words(0)).out(*words(-1)).scan()
    assert bench.fired == ["CMD-33"]


@EITHER_WAY
@pytest.mark.rules("CMD-34", "FOL-16", "HLD-10")
@pytest.mark.parametrize("with_manual", [False, True])
@pytest.mark.parametrize("msw", OTHER_BITS, ids="{:04X}".format)
def test_any_other_command_bit(msw, with_manual, direction):
    bench = follow(follower_bench(), direction).turn_encoder(100, 20).scan()
    bench.out(msw | (MSW[direction] if with_manual else 0), FOLLOW, 1, 1).scan()
    assert (bench.position, bench.fired) == (direction * 100, ["CMD-34"])
    assert_ended(bench, direction, direction * 100)


@pytest.mark.rules("CMD-34", "FOL-16", "HLD-10")
@pytest.mark.parametrize("msw", [bit for bit in OTHER_BITS if bit != RESET], ids="{:04X}".format)
def test_any_other_command_with_a_command_lsw_of_zero(msw):
    """The mode is left with it, and yet the command was given in the mode: it is not passed over."""
    bench = follow(follower_bench(), 1).turn_encoder(100, 20).scan()
    bench.out(msw, 0, 0, 50, 5, 0, 20, 10).run(20)
    assert (bench.position, bench.fired) == (100, ["CMD-34"])
    assert_ended(bench, 1, 100)


@pytest.mark.rules("CMD-34", "RST-01")
def test_reset_errors_leaves_the_mode_and_is_carried_out():
    """An input error of before is cleared, too."""
    bench = follow(follower_bench().inputs(estop=1).run(1).inputs(estop=0).run(1), 1)
    bench.out(RESET).scan()
    assert bench.bits == {"MODULE_OK", "STOPPED"}


@pytest.mark.rules("RST-02")
def test_reset_errors_with_a_command_lsw_leaves_the_mode_and_is_refused():
    """Its LSW has to be 0, in this mode as anywhere else (reading A-31)."""
    bench = follow(follower_bench(), 1)
    bench.out(RESET, 0x0003).scan()
    assert bench.fired == ["RST-02"]
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}


@EITHER_WAY
@pytest.mark.rules("CMD-02")
def test_both_manual_bits(direction):
    bench = follow(follower_bench(), direction).turn_encoder(100, 20).scan()
    bench.out(MSW[1] | MSW[-1], FOLLOW, 1, 1).scan()
    assert bench.fired == ["CMD-02"]
    assert_ended(bench, direction, direction * 100)


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("CMD-35", "FOL-17")
def test_follower_bit_reset_while_a_manual_bit_is_set(direction, scan_ms):
    """It does not become a manual move."""
    bench = follow(follower_bench(scan_ms=scan_ms), direction).turn_encoder(100, 20).run(scan_ms)
    bench.out(MSW[direction], 0, 1, 1).scan()
    assert (bench.position, bench.fired) == (direction * 100, ["CMD-35"])
    assert_ended(bench, direction, direction * 100)


@pytest.mark.rules("CMD-31", "FOL-13")
def test_an_error_stops_what_is_owed():
    bench = follow(follower_bench(), 1, (1, 1), (20, 10)).turn_encoder(3000, 300)
    position = bench.position
    bench.out(*changed(1, w2=0)).run(200)
    assert (bench.position, bench.bits) == (position, {"MODULE_OK", "STOPPED", "COMMAND_ERROR"})


@pytest.mark.rules("CMD-31")
def test_one_rule_is_named_for_the_one_bit_that_all_of_them_set():
    bench = follow(follower_bench(), 1)
    bench.out(*changed(1, w2=0, w4=1, w6=-1)).scan()
    assert bench.fired == ["CMD-31"]


# -- at the start


@EITHER_WAY
@pytest.mark.rules("CMD-31", "CMD-32", "CMD-36", "FOL-13", "FOL-14", "FOL-18", "FOL-02")
@pytest.mark.parametrize(("replaced", "rule"), WRONG_WORDS)
def test_words_that_are_wrong_at_the_start(replaced, rule, direction):
    """The mode is not entered, so Stopped is not touched, nor is Move Complete."""
    bench = follower_bench()
    bench.relative(5).until("MOVE_COMPLETE")
    bench.idle().out(*changed(direction, **replaced)).turn_encoder(100, 20).run(1)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"}
    assert (bench.position, bench.fired) == (5, [rule])
    bench.idle().reset_errors()
    follow(bench, direction).turn_encoder(10, 10).run(1)
    assert (bench.position, bench.bits) == (5 + direction * 10, IN_MODE)


@pytest.mark.rules("CMD-34", "FOL-16", "CMD-02")
@pytest.mark.parametrize("msw", [*OTHER_BITS, MSW[1] | MSW[-1]], ids="{:04X}".format)
def test_another_command_in_the_image_that_enters(msw):
    bench = follower_bench()
    bench.out(msw, FOLLOW, 1, 1).run(5)
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR"}
    assert bench.fired == ["CMD-02" if msw & MSW[1] else "CMD-34"]


@EITHER_WAY
@pytest.mark.rules("CMD-29", "FOL-11")
@pytest.mark.parametrize("feedback", [0, DIAGNOSTIC], ids=["nothing", "diagnostic feedback"])
def test_no_encoder_configured(feedback, direction):
    bench = Bench.ready(config=configuration(add=feedback))
    follow(bench, direction).turn_encoder(100, 20).run(1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-29"])
    assert bench.position == 0
    bench.idle().reset_errors()
    assert bench.bits == {"MODULE_OK"}


MOTIONS = {
    "relative": lambda bench: bench.relative(3000, ms=100),
    "blend": lambda bench: program(bench).out(BLEND_CW).run(100),
    "held up by a dwell": lambda bench: bench.inputs(cw_limit=1).command(HOME_CW, ms=100),
}
ENDS = {"relative": 3000, "blend": 5200, "held up by a dwell": None}


@BOTH_PERIODS
@pytest.mark.rules("CMD-30", "FOL-12")
@pytest.mark.parametrize("motion", MOTIONS)
def test_motion_under_way(motion, scan_ms):
    """The move runs to completion; the bit has to rise again."""
    bench = follower_bench(scan_ms=scan_ms)
    MOTIONS[motion](bench)
    before = bench.bits
    bench.out(MSW[1], FOLLOW, 1, 1).scan()
    assert bench.bits - {"IN_CW_LIMIT"} == (before | {"COMMAND_ERROR"}) - {"IN_CW_LIMIT"}
    assert bench.fired == ["CMD-30"]
    if ENDS[motion] is None:
        bench.run(2_000)
        assert "MOVING_CCW" in bench.bits
        return
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.bits) == (ENDS[motion], {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"})
    bench.turn_encoder(10, 10).idle().reset_errors()
    follow(bench, 0)
    assert bench.bits == IN_MODE


@EITHER_WAY
@pytest.mark.rules("CMD-30", "FOL-12")
def test_a_running_manual_move_goes_on(direction):
    """Its words 2 and 3 are the follower's now, which is not another error; the release stops it."""
    bench = follower_bench().manual(direction, ms=400)
    bench.out(*words(direction)).run(100)
    assert bench.fired == ["CMD-30"]
    assert bench.position == direction * 2100
    bench.out(0, FOLLOW, 1, 1).run(400)
    assert (bench.position, bench.bits) == (direction * 3300, {"MODULE_OK", "STOPPED", "COMMAND_ERROR"})


@pytest.mark.rules("FOL-01", "STS-M12")
def test_it_is_not_entered_under_a_command_error():
    bench = follower_bench()
    bench.out(HOLD).run(1)
    follow(bench, 1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-07"])
    bench.out(IMMEDIATE_STOP, FOLLOW).run(1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-07"])
