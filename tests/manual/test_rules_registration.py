"""Registration moves: a manual move that ends an exact number of steps after its input [chapter 4].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s: 0.2 s and 600 steps up,
then 5 steps per ms, and 0.4 s and 1,200 steps down. After 1 s a move has made 600 + 4,000 steps.
"""

from __future__ import annotations

import pytest
from bench3601 import CONFIGURATION, HOLD, RELATIVE, Bench
from scanrack.io_images.thousands import split_thousands

STORE = 0x0400
BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
REFUSED = {"COMMAND_ERROR", "INVALID_PROFILE", "MODULE_OK"}
MADE_AFTER_1_S = 4_600
RULES = pytest.mark.rules


def release(bench: Bench) -> Bench:
    """Reset the manual bit and leave the other words as they are."""
    return bench.out(0, *bench.words_out[1:])


def store(bench: Bench, distance: int | tuple[int, int]) -> Bench:
    """Send a minimum registration distance, then zeros."""
    words = distance if isinstance(distance, tuple) else split_thousands(distance)
    bench.out(0, STORE, *words).run(2)
    return bench.out().run(2)


# -- the move itself ------------------------------------------------------------------------------


@BOTH_PERIODS
@RULES("REG-01", "REG-02", "REG-03", "STOP-01")
@pytest.mark.parametrize("source", ["bit", "external input"])
@pytest.mark.parametrize("direction", [1, -1])
def test_the_target_is_made_after_the_registration_input(scan_ms, source, direction):
    bench = Bench.ready(scan_ms=scan_ms).manual(direction, 3_000, ms=1_000)
    assert abs(bench.position) == MADE_AFTER_1_S
    if source == "bit":
        release(bench)
    else:
        bench.inputs(external=1)
    # 3,000 - 1,200 steps at 5,000/s are 360 ms, the ramp is 400 ms
    bench.run(358)
    assert (abs(bench.position), "DECELERATING" in bench.bits) == (MADE_AFTER_1_S + 1_790, False)
    bench.run(402)
    assert (bench.position, bench.bits - {"IN_EXTERNAL"}) == (direction * 7_600, {"MODULE_OK", "STOPPED"})


@RULES("REG-01")
def test_without_a_target_it_is_a_plain_manual_move():
    bench = Bench.ready().manual(ms=1_000).idle(400)
    assert (bench.position, bench.bits) == (MADE_AFTER_1_S + 1_200, {"MODULE_OK", "STOPPED"})


@RULES("REG-02")
@pytest.mark.parametrize(
    ("lsw", "ramp"), [(0, 1_200), (1, 2_400), (3, 1_600)], ids=["constant", "triangular", "trapezoidal"]
)
def test_the_total_is_exact_with_every_shape(lsw, ramp):
    # an S-curve takes 2 or 4/3 times the time, hence the way, of the 1,200 steps
    bench = Bench.ready().manual(1, 3_000, lsw=lsw, ms=1_000)
    made = bench.position
    release(bench).until("DECELERATING")
    assert abs(bench.position - made - (3_000 - ramp)) <= 2
    bench.until("STOPPED")
    assert bench.position == made + 3_000


@RULES("REG-02")
def test_an_input_during_the_acceleration_keeps_the_speed_of_that_instant():
    # after 100 ms: 3,000 steps/s, 200 steps made; of 3,000 more the last (9e6 - 1e6)/2e4 = 400 brake
    bench = Bench.ready().manual(1, 3_000, ms=100)
    assert bench.position == 200
    release(bench).run(0.25)
    assert "ACCELERATING" not in bench.bits
    bench.until("DECELERATING")
    assert abs(bench.position - 2_800) <= 1
    bench.until("STOPPED")
    assert bench.position == 3_200


@RULES("REG-07", "REG-04", "REG-05", "REG-06", "REG-12", "LSW-10", "STS-L10")
@pytest.mark.parametrize("source", ["bit", "external input"])
@pytest.mark.parametrize("start", [0, 50_000])
def test_the_minimum_distance_counts_from_the_start_and_is_kept(source, start):
    bench = store(Bench.ready(position=start), 10_000)
    assert "MIN_REG_NONZERO" in bench.bits
    for _ in range(2):  # stored once, it serves every move
        begin = bench.position
        bench.manual(1, 3_000, ms=1_000)
        if source == "bit":
            release(bench)
        else:
            bench.inputs(external=1)
        # ignored until more than 10,000 steps are made (a tick is 1.25 steps), then 3,000 more
        bench.until("STOPPED")
        assert 0 < bench.position - begin - 13_000 <= 3
        bench.inputs(external=0).idle(5)


@RULES("REG-04", "REG-06")
def test_an_input_that_comes_and_goes_within_the_minimum_distance_is_ignored():
    bench = store(Bench.ready(), 10_000).manual(1, 3_000, ms=1_000)
    bench.inputs(external=1).run(100).inputs(external=0).run(2_000)
    # 3.1 s: 600 + 2.9 s at 5,000/s
    assert (bench.position, "MOVING_CW" in bench.bits) == (15_100, True)
    bench.inputs(external=1).until("STOPPED")
    assert bench.position == 18_100


@RULES("REG-16")
def test_the_opposite_end_limit_does_not_stop_it_and_its_own_does():
    bench = Bench.ready().manual(1, 3_000, ms=500).inputs(ccw_limit=1).run(100)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "IN_CCW_LIMIT"}
    bench.inputs(cw_limit=1).run(1)
    assert {"INPUT_ERROR", "POSITION_INVALID", "STOPPED"} < bench.bits
    assert bench.position == 2_600


@RULES("REG-17")
def test_older_firmware_refuses_a_target_and_ignores_the_store_bit():
    bench = Bench.ready("2.2").manual(1, 3_000, ms=5)
    assert (bench.position, bench.bits) == (0, REFUSED)
    assert bench.fired[-2:] == ["CMD-12", "PRF-08"]
    assert store(Bench.ready("2.2"), 10_000).bits == {"MODULE_OK"}


# -- the words while it runs ----------------------------------------------------------------------


@RULES("REG-08")
def test_the_speed_may_fall_and_the_distance_stays_exact():
    bench = Bench.ready().manual(1, 3_000, ms=1_000).manual(1, 3_000, speed=2_000).run(0.25)
    assert "DECELERATING" in bench.bits
    bench.run(500)  # 3,000 steps/s less at 10,000 steps/s/s: 300 ms
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    made = bench.position
    release(bench).until("STOPPED")
    assert bench.position == made + 3_000


@RULES("REG-15")
def test_speed_changes_after_the_input_are_ignored():
    bench = release(Bench.ready().manual(1, 10_000, ms=1_000)).run(10)
    bench.out(0, 0, 10, 0, 9, 0, 20, 10).run(100)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    bench.until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 10_000


@RULES("REG-09")
def test_rates_alone_change_nothing_and_raise_nothing():
    bench = Bench.ready().manual(1, 3_000, ms=1_000).manual(1, 3_000, up=500, down=2_000).run(100)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    took = release(bench).until("STOPPED")
    # the accepted rate of 10 brakes: 1,800 steps at 5,000/s and 0.4 s; with 2,000 it would be sooner
    assert (bench.position, took) == (MADE_AFTER_1_S + 500 + 3_000, 760)


@BOTH_PERIODS
@pytest.mark.parametrize(
    ("change", "fired"),
    [
        pytest.param(
            {"target": 3_001},
            ["CMD-26", "PRF-16"],
            id="target",
            marks=RULES("REG-19", "REG-24", "CMD-26", "PRF-16"),
        ),
        pytest.param(
            {"speed": 5_001}, ["CMD-27", "PRF-17"], id="faster", marks=RULES("REG-25", "CMD-27", "PRF-17")
        ),
        pytest.param(
            {"speed": 4_999, "down": 11},
            ["CMD-28", "PRF-18"],
            id="slower, other deceleration",
            marks=RULES("REG-26", "CMD-28", "PRF-18"),
        ),
        pytest.param(
            {"speed": 4_999, "up": 19},
            ["CMD-28", "PRF-18"],
            id="slower, other acceleration",
            marks=RULES("REG-26", "CMD-28", "PRF-18"),
        ),
    ],
)
def test_illegal_changes_stop_at_once(scan_ms, change, fired):
    bench = Bench.ready(scan_ms=scan_ms).manual(1, 3_000, ms=1_000)
    bench.manual(1, **({"target": 3_000} | change)).run(scan_ms)
    assert {"COMMAND_ERROR", "INVALID_PROFILE", "DECELERATING"} < bench.bits
    assert bench.fired[-2:] == fired
    bench.until("STOPPED")
    # 1,200 steps down from 4,600; the position stays valid (reading A-56)
    assert bench.position == MADE_AFTER_1_S + 1_200
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR", "INVALID_PROFILE"}
    assert bench.reset_errors().bits == {"MODULE_OK", "STOPPED"}


@RULES("REG-24", "CMD-26")
def test_zeroing_the_target_in_the_image_that_releases_the_bit_is_a_change():
    bench = Bench.ready().manual(1, 3_000, ms=1_000).out()
    bench.until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 1_200
    assert bench.fired[-2:] == ["CMD-26", "PRF-16"]


@RULES("REG-24", "CMD-26")
def test_a_target_changed_after_the_input_is_a_change_too():
    bench = release(Bench.ready().manual(1, 8_000, ms=1_000)).run(100)
    bench.out(0, 0, 7, 0, 5, 0, 20, 10).until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 500 + 1_200
    assert bench.fired[-2:] == ["CMD-26", "PRF-16"]


@RULES("REG-23", "CMD-25", "PRF-15")
@pytest.mark.parametrize("target", [1, 3_000, -1])
def test_a_target_given_to_a_plain_manual_move(target):
    bench = Bench.ready().manual(ms=1_000).manual(1, target).run(0.25)
    assert bench.fired[-2:] == ["CMD-25", "PRF-15"]
    bench.until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 1_200
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR", "INVALID_PROFILE"}


@RULES("REG-27", "CMD-21")
def test_hold_before_the_input_is_an_error_and_a_controlled_stop():
    bench = Bench.ready().manual(1, 3_000, ms=1_000).out(HOLD, 0, 3).run(0.25)
    assert bench.fired[-1] == "CMD-21"
    bench.until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 1_200
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}


@RULES("CMD-07")
def test_hold_after_the_input_is_an_error_and_the_steps_are_completed():
    bench = release(Bench.ready().manual(1, 3_000, ms=1_000)).run(10)
    bench.out(HOLD, *bench.words_out[1:]).run(0.25)
    assert bench.fired[-1] == "CMD-07"
    bench.until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 3_000


# -- refused at the start -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "fired"),
    [
        pytest.param(1_200, [], id="just enough to stop in"),
        pytest.param(
            1_199, ["CMD-23", "PRF-13"], id="one too few", marks=RULES("REG-20", "CMD-23", "PRF-13")
        ),
        pytest.param(-1, ["CMD-24", "PRF-14"], id="negative", marks=RULES("REG-21", "CMD-24", "PRF-14")),
        pytest.param(-3_000, ["CMD-24", "PRF-14"], id="thousands", marks=RULES("REG-21", "CMD-24", "PRF-14")),
    ],
)
def test_the_target_at_the_start(target, fired):
    bench = Bench.ready()
    bench.fired.clear()
    bench.manual(1, target, ms=5)
    assert bench.fired == fired
    if fired:
        assert (bench.position, bench.bits) == (0, REFUSED)
    else:
        release(bench.run(995)).until("STOPPED")
        assert bench.position == MADE_AFTER_1_S + 1_200


@RULES("REG-20", "CMD-23")
@pytest.mark.parametrize(("lsw", "least"), [(1, 2_400), (3, 1_600)], ids=["triangular", "trapezoidal"])
def test_an_s_curve_needs_a_longer_way_to_stop(lsw, least):
    # 1,200 steps times 2, times 4/3
    assert Bench.ready().manual(1, least - 1, lsw=lsw, ms=5).bits == REFUSED
    assert "MOVING_CW" in Bench.ready().manual(1, least, lsw=lsw, ms=5).bits


@RULES("REG-22", "CMD-22", "PRF-12", "EXT-05")
@pytest.mark.parametrize("minimum", [0, 10_000])
def test_the_external_input_at_the_start(minimum):
    bench = store(Bench.ready(), minimum).inputs(external=1).run(1)
    bench.manual(1, 3_000, ms=5)
    assert (bench.position, bench.bits - {"IN_EXTERNAL", "MIN_REG_NONZERO"}) == (0, REFUSED)
    assert bench.fired[-2:] == ["CMD-22", "PRF-12"]


# -- the minimum distance -------------------------------------------------------------------------

OUT_OF_RANGE = RULES("REG-11", "REG-13", "CMD-20")


@pytest.mark.parametrize(
    ("words", "good"),
    [
        pytest.param((0, 1), True, id="1"),
        pytest.param((8_388, 607), True, id="greatest"),
        pytest.param((8_388, 608), False, id="one more", marks=OUT_OF_RANGE),
        pytest.param((0, -1), False, id="negative", marks=OUT_OF_RANGE),
        pytest.param((-1, 0), False, id="negative thousands", marks=OUT_OF_RANGE),
        pytest.param((0, 1_000), False, id="LSW 1000", marks=OUT_OF_RANGE),
    ],
)
@RULES("REG-10")
def test_the_range_of_the_minimum_distance(words, good):
    bench = store(Bench.ready(), 77)
    bench.fired.clear()
    store(bench, words)
    assert bench.fired == ([] if good else ["CMD-20"])
    assert bench.bits == {"MODULE_OK", "MIN_REG_NONZERO"} | (set() if good else {"COMMAND_ERROR"})
    assert bench.module.layer.minimum_registration == (1_000 * words[0] + words[1] if good else 77)


@RULES("REG-12")
def test_zero_disables_it():
    bench = store(store(Bench.ready(), 10_000), 0)
    assert bench.bits == {"MODULE_OK"}
    release(bench.manual(1, 3_000, ms=1_000)).until("STOPPED")
    assert bench.position == MADE_AFTER_1_S + 3_000


@RULES("REG-10")
@pytest.mark.parametrize("at", [4, 5, 6, 7])
def test_data_in_words_4_to_7_is_refused(at):
    bench = Bench.ready().out(0, STORE, 10, 0, *(int(word == at) for word in range(4, 8))).run(1)
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR"}
    assert bench.fired[-1] == "REG-10"


@RULES("REG-10")
def test_with_a_command_bit_or_during_a_move_it_is_refused():
    assert Bench.ready().out(RELATIVE, STORE, 10).run(1).bits == {"MODULE_OK", "COMMAND_ERROR"}
    moving = Bench.ready().relative(10_000, ms=100).out(0, STORE, 10).run(1)
    assert {"COMMAND_ERROR", "MOVING_CW"} < moving.bits
    assert "MIN_REG_NONZERO" not in moving.bits
    moving.until("MOVE_COMPLETE")
    assert moving.position == 10_000


@RULES("LSW-10", "REG-10")
def test_it_is_stored_on_the_rise_of_its_bit_only():
    bench = Bench.ready().out(0, STORE, 10).run(1).out(0, STORE, 20).run(1)
    assert bench.module.layer.minimum_registration == 10_000


@RULES("REG-14", "CFG-25")
@pytest.mark.parametrize("what", ["configuration", "power cycle"])
def test_configuration_and_power_up_reset_it(what):
    bench = store(Bench.ready(), 10_000)
    if what == "power cycle":
        bench.power_cycle()
    bench.out(*CONFIGURATION).run(2).out().run(2)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
