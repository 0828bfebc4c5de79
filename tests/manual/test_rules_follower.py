"""Encoder follower: entering, the steps that follow the counts, leaving [chapter 4].

The module counts scan by scan and makes the steps within the scan. What is owed
and is not a whole step yet stays owed (reading A-66), so the position is always
less than a step from counts * multiplier / divisor.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from bench3601 import CONFIGURATION, HOLD, PRESET_ENCODER, RESUME, Bench
from follower3601 import FOLLOW, MSW, WITH_ENCODER, follow, follower_bench, words
from scanrack.runtime.machine import EncoderSpec

BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])

IN_MODE = {"MODULE_OK", "ENC_FOLLOWER"}


# -- entering and leaving


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("FOL-01", "FOL-06", "LSW-07", "STS-L07", "STOP-05", "STOP-06")
def test_enter_follow_leave(direction, scan_ms):
    """The mode clears what the last move left, and sets Stopped when it is left."""
    bench = follower_bench(scan_ms=scan_ms)
    bench.relative(30).until("MOVE_COMPLETE")
    follow(bench.idle(), 0)
    assert bench.bits == IN_MODE
    follow(bench, direction).turn_encoder(100, 50).scan()
    bench.run(20)
    assert (bench.bits, bench.position) == (IN_MODE, 30 + direction * 100)
    follow(bench, 0).run(20)
    assert bench.bits == IN_MODE
    bench.out().scan()
    assert (bench.bits, bench.position) == ({"MODULE_OK", "STOPPED"}, 30 + direction * 100)
    assert bench.fired == []


@pytest.mark.rules("FOL-06", "FOL-17", "CMD-35")
def test_both_words_may_be_zeroed_at_once():
    bench = follow(follower_bench(), 1).turn_encoder(100, 50)
    bench.out().run(50)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "STOPPED"}, [])


@EITHER_WAY
@pytest.mark.rules("FOL-01", "FOL-03")
def test_mode_and_direction_in_one_image(direction):
    bench = follower_bench()
    bench.out(*words(direction)).turn_encoder(100, 50).scan()
    assert bench.position == direction * 100


@pytest.mark.rules("FOL-01", "LSW-07")
def test_the_mode_is_entered_when_the_bit_rises():
    """Here it rose in an image that was refused, and stayed."""
    bench = follower_bench()
    bench.inputs(estop=1).run(1)
    follow(bench, 0).inputs(estop=0).run(1)
    bench.out(*words(0, (2, 1))).run(5)
    assert "ENC_FOLLOWER" not in bench.bits
    follow(bench.idle(), 0)
    assert "ENC_FOLLOWER" in bench.bits


@pytest.mark.rules("FOL-01")
def test_a_bit_that_is_set_when_configuration_mode_is_left_has_risen():
    bench = follower_bench()
    bench.out(*WITH_ENCODER).run(5)
    follow(bench, 1)
    assert "ENC_FOLLOWER" in bench.bits


@pytest.mark.rules("FOL-01", "RSM-01", "HLD-12")
def test_it_takes_the_place_of_a_held_move():
    bench = follower_bench().relative(9000, ms=400)
    bench.out(HOLD).until("HOLD_STATE")
    follow(bench, 0)
    assert bench.bits == IN_MODE
    bench.out().run(1).command(RESUME, ms=1)
    assert bench.fired == ["CMD-08"]


@pytest.mark.rules("FOL-19", "LSW-07")
def test_before_firmware_4_1_the_bit_is_ignored():
    """Reading A-94."""
    for firmware, known in (("3.1", False), ("4.1", True)):
        bench = follow(follower_bench(firmware), 0).run(5)
        assert ("ENC_FOLLOWER" in bench.bits, bench.fired) == (known, [])


@pytest.mark.rules("FOL-06", "CFG-14")
def test_a_request_for_configuration_ends_it():
    """All command bits count as reset (reading A-10)."""
    bench = follow(follower_bench(), 1).turn_encoder(100, 20)
    bench.out(*CONFIGURATION).run(1)
    assert bench.bits == {"MODULE_OK", "MODE_CONFIG"}
    assert bench.fired == []


@pytest.mark.rules("FOL-01", "PRG-01")
def test_program_mode_ends_it():
    """And run mode does not bring it back (reading A-78)."""
    bench = follow(follower_bench(), 1).turn_encoder(100, 20)
    position = bench.position
    bench.plc("program").turn_encoder(100, 20)
    assert "ENC_FOLLOWER" not in bench.bits
    bench.plc("run").turn_encoder(100, 20).run(1)
    assert {"STOPPED", "POSITION_INVALID"} <= bench.bits
    assert bench.position == position


# -- the steps


@EITHER_WAY
@pytest.mark.rules("FOL-03", "STS-M00", "STS-M01")
@pytest.mark.parametrize("counts", [500, -500])
def test_the_manual_bit_gives_the_sense(counts, direction):
    bench = follow(follower_bench(), direction)
    bench.module.machine.turn_encoder(counts, bench.now_ns, bench.now_ns + 50_000_000)
    bench.run(20)
    assert bench.bits == {*IN_MODE, "MOVING_CW" if counts * direction > 0 else "MOVING_CCW"}  # 2.5 a tick
    bench.run(31)
    assert (bench.bits, bench.position) == (IN_MODE, direction * counts)


@EITHER_WAY
@pytest.mark.rules("FOL-03", "FOL-05")
def test_counts_of_an_encoder_that_is_preset_or_far_from_zero(direction):
    bench = follower_bench()
    bench.turn_encoder(-12_345, 10).out(PRESET_ENCODER, 0, -8, -1).run(1).idle()
    follow(bench, direction).turn_encoder(77, 10).scan()
    assert (bench.position, bench.encoder) == (direction * 77, -8001 + 77)


@pytest.mark.rules("FOL-04")
def test_without_a_manual_bit_nothing_moves_nor_is_made_up_for():
    bench = follow(follower_bench(), 0).turn_encoder(100, 20).run(1)
    assert (bench.position, bench.bits) == (0, IN_MODE)
    follow(bench, 1).turn_encoder(10, 20).run(1)
    assert bench.position == 10
    follow(bench, 0).turn_encoder(-50, 20).run(1)
    follow(bench, -1).turn_encoder(3, 20).run(1)
    assert (bench.position, bench.fired) == (10 - 3, [])


RATIOS = [(1, 1), (7, 3), (3, 7), (1, 32_767), (32_767, 1), (32_767, 32_766), (999, 1000), (2, 1)]


@pytest.mark.slow
@EITHER_WAY
@pytest.mark.rules("FOL-05", "FOL-02")
@pytest.mark.parametrize("ratio", RATIOS, ids=lambda ratio: "{}/{}".format(*ratio))
def test_multiplier_and_divisor(ratio, direction):
    """Turned back and forth: less than a step off, and exact where the ratio gives whole steps."""
    bench = follow(follower_bench(scan_ms=2), direction, ratio)
    counted = 0
    for counts in (40, -37, 1, -30, 13, 13, ratio[1] % 1000):
        bench.turn_encoder(counts, 20).run(max(2, abs(counts) * ratio[0] / ratio[1] / 900))  # 1000 steps/ms
        counted += counts
        exact = direction * counted * Fraction(*ratio)
        assert abs(bench.position - exact) < 1
        if exact.denominator == 1:
            assert bench.position == exact
    assert bench.fired == []


@pytest.mark.slow
@pytest.mark.rules("FOL-05", "FOL-10")
def test_hours_of_it_are_exact():
    """Three hours of a winder at 1000 counts/s, another ratio every ten minutes; ticks of 250 ms."""
    bench = follow(follower_bench(scan_ms=250, input_scan_us=250_000), 1)
    exact = Fraction(0)
    for number in range(18):
        ratio = (1 + 1911 * number, 32_767 - 1213 * number)  # up to 32,488/12,146
        follow(bench, 1, ratio).turn_encoder(600_000 + number, 600_000).scan()
        exact += (600_000 + number) * Fraction(*ratio)
        assert abs(bench.module.machine.shaft - exact) < 1
    assert bench.module.machine.shaft > 8_000_000


@EITHER_WAY
@pytest.mark.rules("FOL-05")
def test_the_ratio_may_change_at_any_tick(direction):
    """The fraction of a step that is owed stays owed: 1/3 + 2/3, and 5/7 + 1/7 + 1/7."""
    bench = follow(follower_bench(), direction, (1, 3)).turn_encoder(1, 1).scan()
    assert bench.position == 0
    follow(bench, direction, (2, 3)).turn_encoder(1, 1).scan()
    assert bench.position == direction
    follow(bench, direction, (5, 7)).turn_encoder(1, 1).scan()
    follow(bench, direction, (1, 7)).turn_encoder(1, 1).scan()
    assert bench.position == direction
    bench.turn_encoder(1, 1).scan()
    assert bench.position == direction * 2


@pytest.mark.rules("FOL-10", "FOL-05")
def test_a_count_is_a_step_in_the_scan_that_it_falls_into():
    """Rates of zero: no speed is carried over, and the motion bit lasts for that scan."""
    bench = follow(follower_bench(), 1)
    bench.module.machine.turn_encoder(1, bench.now_ns, bench.now_ns + 100_000)
    assert (bench.scan().position, bench.bits) == (1, {*IN_MODE, "MOVING_CW"})
    assert (bench.scan().position, bench.bits) == (1, IN_MODE)


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("FOL-03", "FOL-04", "FOL-05")
def test_what_has_been_counted_is_followed_before_the_next_word_is_obeyed(direction, scan_ms):
    """The last count falls into the last scan before the word, and is a step of that scan."""
    bench = follow(follower_bench(scan_ms=scan_ms), direction, (100, 1)).turn_encoder(20, 20)
    assert bench.position == direction * 2_000
    assert follow(bench, 0).run(10).position == direction * 2_000


@BOTH_PERIODS
@pytest.mark.rules("FOL-09", "EST-01")
def test_what_has_been_counted_is_followed_before_an_input_stops_it(scan_ms):
    bench = follow(follower_bench(scan_ms=scan_ms), 1, (100, 1)).turn_encoder(20, 20)
    bench.inputs(estop=1).turn_encoder(20, 20)
    assert (bench.position, "STOPPED" in bench.bits) == (2_000, True)


@EITHER_WAY
@pytest.mark.rules("FOL-10")
def test_no_more_than_a_million_steps_a_second(direction):
    """Maximum output frequency [chapter 1]: 250 a tick, and none is lost: 3 * 32,767 steps take 394 ticks."""
    bench = follow(follower_bench(), direction, (32_767, 1)).turn_encoder(3, 1)
    assert bench.position == direction * 250 * 3  # counts in the second scan, the third and the fourth
    for _ in range(300):
        before = bench.position
        bench.scan()
        assert bench.position - before == direction * 250
    bench.run(100)
    assert bench.position == direction * 3 * 32_767


@pytest.mark.rules("FOL-03", "FOL-05")
def test_the_shafts_own_encoder_can_be_followed_too():
    """Every step makes half a count more: 100 + 50 + 25 + ... end at 200 or just below."""
    bench = follower_bench(encoder=EncoderSpec(Fraction(1, 2)))
    follow(bench, 1).turn_encoder(100, 20).run(20)
    assert bench.position in (199, 200)


@pytest.mark.rules("FOL-15", "CMD-33", "FOL-03")
def test_direction_is_changed_with_a_zero_word_in_between():
    """Of the MSW only (reading A-64)."""
    bench = follow(follower_bench(), 1).turn_encoder(50, 20).run(1)
    follow(bench, 0)
    follow(bench, -1).turn_encoder(80, 20).run(1)
    assert (bench.position, bench.fired) == (50 - 80, [])


# -- what the inputs do


@EITHER_WAY
@pytest.mark.rules("FOL-08", "EXT-04")
def test_the_external_input_has_no_effect(direction):
    bench = follower_bench()
    bench.inputs(external=1)
    follow(bench, direction).turn_encoder(100, 20).run(1)
    assert (bench.position, bench.bits) == (direction * 100, {*IN_MODE, "IN_EXTERNAL"})


@BOTH_PERIODS
@EITHER_WAY
@pytest.mark.rules("FOL-09", "STOP-04", "STOP-02", "POS-03", "POS-04", "INP-01", "INP-02")
@pytest.mark.parametrize(
    ("name", "fired"),
    [
        ("cw_limit", ["INP-02", "POS-04"]),
        ("ccw_limit", ["INP-02", "POS-04"]),
        ("estop", ["INP-01", "POS-03"]),
    ],
)
def test_limits_and_emergency_stop_end_it(name, fired, direction, scan_ms):
    """Either limit, in either direction (reading A-17)."""
    bench = follow(follower_bench(scan_ms=scan_ms), direction).turn_encoder(200, 40)
    bench.inputs(**{name: 1}).scan()
    position = bench.position
    shown = {"MODULE_OK", "STOPPED", "POSITION_INVALID", "INPUT_ERROR", "IN_" + name.upper()}
    assert (bench.bits, bench.fired) == (shown, fired)
    bench.inputs(**{name: 0}).turn_encoder(200, 40).run(1)
    assert bench.position == position
    bench.out(MSW[direction], FOLLOW, 2, 1).run(1)
    assert "ENC_FOLLOWER" not in bench.bits  # the bit has to rise anew
    follow(bench.out().run(1), direction).turn_encoder(10, 10).run(1)
    assert (bench.position, bench.bits) == (position + direction * 10, {*IN_MODE, "POSITION_INVALID"})


@EITHER_WAY
@pytest.mark.rules("FOL-07", "INP-01", "INP-02")
@pytest.mark.parametrize(
    ("name", "rule"), [("cw_limit", "INP-02"), ("ccw_limit", "INP-02"), ("estop", "INP-01")]
)
def test_it_cannot_be_started_on_a_limit(name, rule, direction):
    """Input Error alone; the mode is not entered (reading A-63), nor is Stopped touched."""
    bench = follower_bench()
    bench.inputs(**{name: 1}).run(1).reset_errors()
    bench.fired.clear()
    follow(bench, direction).turn_encoder(100, 20).run(1)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_" + name.upper()}
    assert (bench.position, bench.fired) == (0, [rule])


def test_a_bench_without_counts_stands_still():
    bench: Bench = follow(follower_bench(), 1).run(50)
    assert (bench.position, bench.bits) == (0, IN_MODE)
