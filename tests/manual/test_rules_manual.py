"""Manual moves [chapter 4, Manual Move; chapter 6, Command Errors 12 to 15].

The example throughout: 5000/s from 1000/s, acceleration 20, deceleration 10. After 400 ms 1600 steps;
a controlled stop then takes 400 ms and 1200 steps.
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil

import pytest
from bench3601 import ENCODER, MANUAL_CCW, MANUAL_CW, Bench, configuration
from scanrack.io_images.thousands import split_thousands

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("sign", [1, -1], ids=["cw", "ccw"])
STOPPED = {"MODULE_OK", "STOPPED"}
REFUSED = {"COMMAND_ERROR", "INVALID_PROFILE"}


def moving(sign: int) -> str:
    return "MOVING_CW" if sign > 0 else "MOVING_CCW"


# -- as long as the bit is set --------------------------------------------------------------------


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.rules("MAN-01", "MAN-04", "MAN-05", "MAN-20", "STOP-01")
def test_a_manual_move_from_start_to_end(sign, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).manual(sign, ms=100)
    assert (bench.position, bench.bits) == (sign * 200, {"MODULE_OK", moving(sign), "ACCELERATING"})
    bench.run(100)
    assert (bench.position, bench.bits) == (sign * 600, {"MODULE_OK", moving(sign)})
    bench.run(10_000)
    assert (bench.position, bench.bits) == (sign * 50_600, {"MODULE_OK", moving(sign)})
    bench.idle(400 - scan_ms)
    assert bench.bits == {"MODULE_OK", moving(sign), "DECELERATING"}
    bench.scan()
    assert (bench.position, bench.bits, bench.fired) == (sign * 51_800, STOPPED, [])


@EVERY_SCAN
@pytest.mark.rules("MAN-05", "STOP-01")
def test_released_while_accelerating(scan_ms):
    """3000/s and 200 steps after 100 ms; 200 ms and 400 steps to stop."""
    bench = Bench.ready(scan_ms=scan_ms).manual(ms=100).idle(200)
    assert (bench.position, bench.bits) == (600, STOPPED)


@EVERY_SCAN
@pytest.mark.rules("MAN-01", "MAN-05")
def test_only_the_bit_counts_not_how_the_others_are_left(scan_ms):
    """The parameters may stay or go; the deceleration is the one that was accepted."""
    bench = Bench.ready(scan_ms=scan_ms).manual(ms=400)
    bench.out(0, 0, 0, 0, 0, 0, 20, 2_000).run(400)
    assert (bench.position, bench.bits, bench.fired) == (2_800, STOPPED, [])


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.rules("MAN-05", "CMD-03")
def test_the_other_manual_bit_stops_the_move_and_starts_nothing(sign, scan_ms):
    """It is a move before the previous one has ended, and the release of the bit."""
    bench = Bench.ready(scan_ms=scan_ms).manual(sign, ms=400).manual(-sign, ms=scan_ms)
    assert bench.bits == {"MODULE_OK", moving(sign), "DECELERATING", "COMMAND_ERROR"}
    bench.run(1_000)
    assert (bench.position, bench.bits) == (sign * 2_800, STOPPED | {"COMMAND_ERROR"})
    assert bench.fired == ["CMD-03"]


@EVERY_SCAN
@pytest.mark.parametrize("other", [0x0001, 0x0004, 0x0010, 0x0100, 0x0200, 0x0800, 0x4000])
@pytest.mark.rules("CMD-02", "MAN-05")
def test_another_bit_beside_the_manual_bit(other, scan_ms):
    """Reading A-33: the error, and a controlled stop; Immediate Stop included."""
    bench = Bench.ready(scan_ms=scan_ms).manual(ms=400)
    bench.command(MANUAL_CW | other).run(400)
    assert (bench.position, bench.bits) == (2_800, STOPPED | {"COMMAND_ERROR"})
    assert bench.fired == ["CMD-02"]


@EVERY_SCAN
@pytest.mark.parametrize("encoder", [ENCODER, 0], ids=["encoder", "no encoder"])
@pytest.mark.rules("MAN-18", "ENC-08", "LSW-02")
def test_the_encoder_bit_is_ignored(encoder, scan_ms):
    """Neither an error without an encoder nor an end at an encoder count."""
    bench = Bench.ready(config=configuration(add=encoder), scan_ms=scan_ms)
    bench.manual(lsw=0x0004, ms=400)
    bench.turn_encoder(1_000, ms=100)
    assert (bench.position, bench.bits, bench.fired) == (2_100, {"MODULE_OK", "MOVING_CW"}, [])
    assert bench.idle(400).position == 3_300


@EVERY_SCAN
@pytest.mark.parametrize(("lsw", "factor"), [(1, 2), (3, Fraction(4, 3)), (2, 1)])
@pytest.mark.rules("MAN-04", "MAN-05", "PRO-10")
def test_manual_moves_may_use_s_curves(lsw, factor, scan_ms):
    """Chapter 4, Acceleration Types: all moves but homing and the follower."""
    bench = Bench.ready(scan_ms=scan_ms).manual(lsw=lsw)
    accelerated = bench.until(clear=["ACCELERATING"])
    assert 0 <= accelerated - 200 * factor < scan_ms
    bench.run(800 - accelerated)
    released = 600 * factor + 5 * (800 - 200 * factor)
    assert bench.position == int(released)
    bench.idle(scan_ms).until("STOPPED")
    assert bench.position == ceil(released + 1_200 * factor)  # the stop ends on a whole step


# -- constant speed mode --------------------------------------------------------------------------


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.parametrize("rates", [(20, 10), (0, 0), (-1, 2_001), (-32_768, 32_767)])
@pytest.mark.parametrize(("speed", "steps"), [(1, 0), (500, 50), (1_000, 100)])
@pytest.mark.rules("MAN-02", "MAN-19", "STOP-01")
def test_constant_speed_mode_ignores_the_rates(speed, steps, rates, sign, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).manual(sign, speed=speed, up=rates[0], down=rates[1])
    for _ in range(round(100 / scan_ms)):
        assert bench.scan().bits == {"MODULE_OK", moving(sign)}
    assert bench.position == sign * steps
    bench.idle(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (sign * steps, STOPPED, [])


@EVERY_SCAN
@pytest.mark.rules("MAN-02", "MAN-04")
def test_one_step_a_second_faster_than_the_starting_speed_has_a_ramp(scan_ms):
    """1001/s: 1/20,000 s of acceleration, and rates that have to be legal."""
    bench = Bench.ready(scan_ms=scan_ms).manual(speed=1_001, up=0, ms=scan_ms)
    assert bench.bits == {"MODULE_OK"} | REFUSED
    assert set(bench.fired) == {"CMD-04", "PRF-02"}
    bench.reset_errors().manual(speed=1_001, ms=1_000)
    assert bench.position == 1_000  # 1001 less the fraction lost in 50 µs of ramp
    bench.command(MANUAL_CW, speed=2_000, ms=100)
    assert bench.fired[2:] == []


CHANGES = [
    pytest.param((0, 999), id="slower"),
    pytest.param((2, 0), id="faster"),
    pytest.param((0, 0), id="to zero"),
    pytest.param((1_000, 1), id="out of range"),
    pytest.param((0, 1_000), id="no value"),
]


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.parametrize("start", [500, 1_000])
@pytest.mark.parametrize("words", CHANGES)
@pytest.mark.rules("MAN-03", "CMD-13", "PRF-09")
def test_the_speed_may_not_be_changed_in_constant_speed_mode(words, start, sign, scan_ms):
    """Reading A-42: it stops at once, and the position stays valid."""
    msw = MANUAL_CW if sign > 0 else MANUAL_CCW
    bench = Bench.ready(scan_ms=scan_ms).manual(sign, speed=start, ms=100)
    bench.out(msw, 0, 0, 0, *words, 20, 10).run(scan_ms)
    assert (bench.position, bench.bits) == (sign * start // 10, STOPPED | REFUSED)
    assert set(bench.fired) == {"CMD-13", "PRF-09"}
    assert bench.run(100).position == sign * start // 10
    assert bench.reset_errors().bits == STOPPED


@EVERY_SCAN
@pytest.mark.rules("MAN-03", "MAN-02", "CMD-13")
def test_other_words_may_be_changed_in_constant_speed_mode(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).manual(speed=500, ms=100)
    bench.manual(speed=500, up=0, down=-7, lsw=3, ms=100)
    assert (bench.position, bench.bits, bench.fired) == (100, {"MODULE_OK", "MOVING_CW"}, [])


# -- one shot -------------------------------------------------------------------------------------


@EVERY_SCAN
@EITHER_WAY
@pytest.mark.parametrize("rates", [(20, 10), (0, 0), (-1, 2_001)])
@pytest.mark.rules("MAN-15", "MAN-16", "STOP-06")
def test_a_one_shot_is_one_step_and_a_direction_bit_that_stays(rates, sign, scan_ms):
    """Readings A-43 and A-44."""
    bench = Bench.ready(scan_ms=scan_ms).manual(sign, speed=0, up=rates[0], down=rates[1])
    for _ in range(5):
        assert bench.scan().bits == {"MODULE_OK", moving(sign)}
        assert bench.position == sign
    bench.run(1_000).idle(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (sign, {"MODULE_OK"}, [])


@EVERY_SCAN
@pytest.mark.rules("MAN-15", "MAN-16", "MC-02")
def test_one_shots_one_after_the_other(scan_ms):
    """Each needs its bit set anew; the first clears what the last move has left."""
    bench = Bench.ready(scan_ms=scan_ms).manual(ms=400).idle(400)
    assert bench.bits == STOPPED
    for times in range(1, 6):
        bench.manual(speed=0, ms=10)
        assert (bench.position, bench.bits) == (2_800 + times, {"MODULE_OK", "MOVING_CW"})
        bench.idle(scan_ms)
        assert bench.bits == {"MODULE_OK"}
    bench.manual(-1, speed=0, ms=10).manual(1, speed=0, ms=10)  # straight from one bit to the other
    assert (bench.position, bench.bits, bench.fired) == (2_805, {"MODULE_OK", "MOVING_CW"}, [])


@EVERY_SCAN
@pytest.mark.rules("MAN-15", "MAN-16", "CMD-03")
def test_a_one_shot_holds_up_nothing(scan_ms):
    """Its step is made: another move may start while its bit is still set."""
    bench = Bench.ready(scan_ms=scan_ms).manual(speed=0, ms=10)
    bench.relative(500).until("MOVE_COMPLETE")
    assert (bench.position, bench.bits, bench.fired) == (501, {"MODULE_OK", "MOVE_COMPLETE"}, [])


@pytest.mark.rules("MAN-15")
def test_every_one_shot_is_written_down():
    """Whether its bit is reset, or another command follows straight on."""
    bench = Bench.ready()
    ended = []
    for words in [
        (MANUAL_CW,),
        (MANUAL_CCW,),
        (MANUAL_CW,),
        (0x0002, 0, 0, 1, 1, 0, 1, 1),
        (MANUAL_CW,),
        (0,),
    ]:
        for _ in range(8):
            bench.now_ns += bench.scan_ns
            bench.module.update(bench.now_ns, bench.out(*words).outputs)
        ended += [event.name for event in bench.module.events if event.kind == "move"]
        bench.module.events.clear()
    assert ended == ["one-shot manual"] * 3 + ["relative", "one-shot manual"]


@EVERY_SCAN
@pytest.mark.rules("MAN-16", "MAN-15")
def test_other_words_do_not_end_or_repeat_a_one_shot(scan_ms):
    """A speed that comes later makes no move of it: the bit has been used."""
    bench = Bench.ready(scan_ms=scan_ms).manual(speed=0, ms=10).manual(speed=5_000, ms=100)
    assert (bench.position, bench.bits, bench.fired) == (1, {"MODULE_OK", "MOVING_CW"}, [])


@EVERY_SCAN
@pytest.mark.parametrize(
    ("name", "added"),
    [
        pytest.param("estop", {"INPUT_ERROR"}, id="estop", marks=pytest.mark.rules("EST-02", "POS-03")),
        pytest.param("cw_limit", set(), id="cw limit", marks=pytest.mark.rules("POS-04", "INP-02")),
        pytest.param("ccw_limit", set(), id="ccw limit", marks=pytest.mark.rules("POS-04", "INP-02")),
    ],
)
@pytest.mark.rules("MAN-15", "MAN-16")
def test_a_stop_input_after_the_step_of_a_one_shot_stops_no_motion(name, added, scan_ms):
    """The direction bit is still on, but the step is made: the position stays valid."""
    bench = Bench.ready(scan_ms=scan_ms).manual(speed=0, ms=10).inputs(**{name: 1}).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "IN_" + name.upper()} | added
    bench.idle(scan_ms)
    assert (bench.position, bench.bits) == (1, {"MODULE_OK", "IN_" + name.upper()} | added)


@EVERY_SCAN
@pytest.mark.rules("IST-04", "MAN-16")
def test_immediate_stop_after_the_step_of_a_one_shot_stops_no_motion(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).manual(speed=0, ms=10).out(0x0010).run(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (1, {"MODULE_OK"}, [])


# -- firmware before 3.1 --------------------------------------------------------------------------

TARGETS = [(0, 1), (1, 0), (0, -1), (8_388, 607), (9_000, 0), (1, -1), (0, 1_000)]


@EVERY_SCAN
@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("speed", [5_000, 500, 0])
@pytest.mark.rules("CMD-12", "PRF-08")
def test_a_manual_move_with_target_data_before_firmware_3_1(target, speed, scan_ms):
    bench = Bench.ready("2.2", scan_ms=scan_ms)
    bench.out(MANUAL_CW, 0, *target, *split_thousands(speed), 20, 10).run(100)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK"} | REFUSED)
    assert set(bench.fired) == {"CMD-12", "PRF-08"}
    bench.reset_errors().manual(speed=500, ms=100)
    assert bench.position == 50


@EVERY_SCAN
@pytest.mark.parametrize("firmware", ["3.1", "4.1"])
@pytest.mark.rules("CMD-12", "PRF-08", "REG-17")
def test_from_firmware_3_1_on_target_data_make_a_registration_move(firmware, scan_ms):
    bench = Bench.ready(firmware, scan_ms=scan_ms).manual(target=2_000, ms=400)
    bench.command(0, 2_000, ms=400)
    assert bench.fired == []
    bench.until("STOPPED")
    assert bench.position == 3_600


@EVERY_SCAN
@pytest.mark.rules("CMD-12")
def test_target_data_that_come_later_are_not_looked_at_before_3_1(scan_ms):
    """Reading A-105."""
    bench = Bench.ready("2.2", scan_ms=scan_ms).manual(ms=400).manual(target=77, ms=100)
    assert (bench.position, bench.bits, bench.fired) == (2_100, {"MODULE_OK", "MOVING_CW"}, [])


@EVERY_SCAN
@pytest.mark.parametrize(
    ("firmware", "fired"),
    [("2.0", ["CMD-14"]), ("2.2", ["CMD-14"]), ("3.1", []), ("4.1", [])],
)
@pytest.mark.rules("CMD-14", "MAN-17")
def test_all_eight_words_zero(firmware, fired, scan_ms):
    """A controlled stop in either case, with the deceleration that was accepted (reading A-39)."""
    bench = Bench.ready(firmware, scan_ms=scan_ms).manual(ms=400).out(0).run(400)
    errors = {"COMMAND_ERROR"} if fired else set()
    assert (bench.position, bench.bits, bench.fired) == (2_800, STOPPED | errors, fired)


@EVERY_SCAN
@pytest.mark.parametrize("word", range(1, 8))
@pytest.mark.rules("CMD-14", "MAN-17")
def test_seven_words_zero_are_no_error(word, scan_ms):
    words = [0] * 8
    words[word] = 1
    bench = Bench.ready("2.2", scan_ms=scan_ms).manual(ms=400).out(*words).run(400)
    assert (bench.position, bench.bits, bench.fired) == (2_800, STOPPED, [])


@EVERY_SCAN
@pytest.mark.rules("CMD-14", "MAN-17")
def test_zero_words_after_the_command_word_are_no_error(scan_ms):
    """The bit first, the rest while the axis decelerates."""
    bench = Bench.ready("2.2", scan_ms=scan_ms).manual(ms=400).idle(100).out(0).run(300)
    assert (bench.position, bench.bits, bench.fired) == (2_800, STOPPED, [])
