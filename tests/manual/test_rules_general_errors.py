"""One command at a time: several bits, a move during a move, edges [chapter 6, Command Errors 2 and 3].

The parameters of `command` are legal: speed 5000, acceleration 20, deceleration 10; starting speed
1000. The figures of the motions are those of `motions3601`.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    ABSOLUTE,
    BLEND_CW,
    ENCODER,
    HOLD,
    HOME_CCW,
    HOME_CW,
    IMMEDIATE_STOP,
    MANUAL_CCW,
    MANUAL_CW,
    PRESET,
    PRESET_ENCODER,
    RELATIVE,
    RESET,
    RESUME,
    Bench,
    configuration,
)
from motions3601 import ENCODER_MOVE, LONG, MOTIONS, STEPS, TO_STOP, Motion
from refusals3601 import COMMAND_ERRORS, MOTION, after_a_move, goes, refused

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
PROFILES = [
    motion for motion in MOTIONS if motion.name.split()[0] in ("absolute", "relative", "blend", "home")
]
MANUALS = [motion for motion in MOTIONS if motion.name.split()[0] in ("manual", "registration")]


def goes_on(bench: Bench, motion: Motion) -> None:
    """From 200 ms on it makes another 1500 steps in 300 ms, and nothing shows that it is ending."""
    here = bench.position
    bench.run(300)
    assert bench.position - here == motion.direction * 1_500
    assert bench.bits >= {"COMMAND_ERROR", motion.moving}
    assert "DECELERATING" not in bench.bits


# -- 2: more than one bit -------------------------------------------------------------------------

SINGLE = [1 << bit for bit in range(15)]
PAIRS = [(one, SINGLE[(at + 1) % 15]) for at, one in enumerate(SINGLE)] + [(HOLD, 0x7FFB), (RESET, 0x7FFF)]


@EVERY_SCAN
@pytest.mark.rules("CMD-02", "IOM-18")
@pytest.mark.parametrize(("one", "other"), PAIRS, ids=[f"{one | other:04X}h" for one, other in PAIRS])
def test_two_command_bits_at_once(one, other, scan_ms):
    bench = after_a_move(scan_ms=scan_ms)
    bench.command(one | other, 0)
    refused(bench, "CMD-02", errors=COMMAND_ERRORS)


@pytest.mark.rules("CMD-02", "IOM-18")
def test_two_bits_with_a_minimum_distance_are_no_fault_of_the_distance():
    """The command word is looked at first (reading A-93); nothing is stored."""
    bench = after_a_move()
    bench.command(ABSOLUTE | RELATIVE, 9, lsw=0x0400)
    refused(bench, "CMD-02", errors=COMMAND_ERRORS)


@pytest.mark.rules("CMD-02", "IOM-18", "IOM-19")
def test_a_second_bit_beside_one_that_stays_set():
    """The check is made when a bit comes on (reading A-34): one that goes off is none."""
    bench = after_a_move().absolute(0, ms=2)
    bench.command(ABSOLUTE | RESET, 0)
    refused(bench, "CMD-02", errors=COMMAND_ERRORS)
    bench.command(ABSOLUTE | RESET, 0).run(2)
    assert "COMMAND_ERROR" in bench.bits
    bench.reset_errors()
    bench.command(ABSOLUTE | RESET, 0).run(2).command(RESET).run(2)  # no edge of either bit
    assert "COMMAND_ERROR" in bench.bits
    bench.idle().command(RESET).run(2)
    assert "COMMAND_ERROR" not in bench.bits


@EVERY_SCAN
@pytest.mark.rules("CMD-02")
@pytest.mark.parametrize("motion", PROFILES, ids=lambda motion: motion.name)
def test_two_bits_during_a_motion_do_not_touch_it(motion, scan_ms):
    """A move, a homing, a blend go on (reading A-33)."""
    bench = motion.started(200, scan_ms=scan_ms)
    bench.out(motion.msw | PRESET, *list(bench.outputs)[1:]).run(scan_ms)
    assert (bench.fired, bench.bits) == (["CMD-02"], {"MODULE_OK", "COMMAND_ERROR"} | motion.shown)
    goes_on(bench, motion)


@EVERY_SCAN
@pytest.mark.rules("CMD-02")
@pytest.mark.parametrize("motion", MANUALS, ids=lambda motion: motion.name)
def test_two_bits_stop_a_manual_move(motion, scan_ms):
    """With deceleration, though its own bit is still set (reading A-33)."""
    bench = motion.started(200, scan_ms=scan_ms)
    bench.out(motion.msw | PRESET, *list(bench.outputs)[1:]).run(scan_ms)
    assert bench.fired == ["CMD-02"]
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR", "DECELERATING"} | motion.shown
    steps, lasts = TO_STOP[200]
    bench.run(lasts - scan_ms)
    assert bench.bits == {"MODULE_OK", "COMMAND_ERROR", "STOPPED"}
    assert bench.position == motion.direction * (STEPS[200] + steps)


# -- 3: busy --------------------------------------------------------------------------------------

STARTS = {
    "absolute": (ABSOLUTE, {"target": 7}),
    "absolute encoder": (ABSOLUTE, {"target": 7, "lsw": ENCODER_MOVE}),
    "relative": (RELATIVE, {"target": 7}),
    "relative encoder": (RELATIVE, {"target": 7, "lsw": ENCODER_MOVE}),
    "home cw": (HOME_CW, {}),
    "home ccw": (HOME_CCW, {}),
    "manual cw": (MANUAL_CW, {}),
    "manual ccw": (MANUAL_CCW, {}),
    "registration": (MANUAL_CW, {"target": LONG}),
    "one-shot": (MANUAL_CW, {"speed": 0}),
}
BLENDS = [BLEND_CW, BLEND_CW << 1]


@EVERY_SCAN
@pytest.mark.rules("CMD-03", "MOV-10")
@pytest.mark.parametrize("motion", PROFILES, ids=lambda motion: motion.name)
def test_no_second_move_during_a_move(motion, scan_ms):
    """Whatever it is, with the error of being busy and no other; illegal words: test_rules_several_faults."""
    for command, parameters in STARTS.values():
        bench = motion.started(200, scan_ms=scan_ms)
        bench.idle(scan_ms).command(command, **parameters).run(scan_ms)
        expected = (["CMD-03"], {"MODULE_OK", "COMMAND_ERROR"} | motion.shown)
        assert (bench.fired, bench.bits) == expected, (command, parameters)
        goes_on(bench, motion)
    for command in BLENDS:
        bench = motion.started(200, scan_ms=scan_ms)
        bench.idle(scan_ms).out(command).run(scan_ms)
        assert (bench.fired, bench.bits) == (["CMD-03"], {"MODULE_OK", "COMMAND_ERROR"} | motion.shown)
        goes_on(bench, motion)


@EVERY_SCAN
@pytest.mark.rules("CMD-03", "MC-01", "STS-M07")
def test_second_move_at_302_ms(scan_ms):
    """5000 steps take 0.2 s + 0.4 s of ramps and 3200 steps at 5000/s, 0.64 s (reading A-27)."""
    bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(300).idle(2)
    bench.relative(5_000).run(2).idle(2)
    # 600 + 106 ms at 5000/s
    assert (bench.position, bench.bits) == (1_130, {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"})
    bench.run(1_240 - 306)
    assert (bench.position, bench.bits) == (5_000, {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"})
    bench.reset_errors()
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    goes(bench, 5_000)


@EVERY_SCAN
@pytest.mark.rules("CMD-03")
@pytest.mark.parametrize("late", [False, True], ids=["one scan early", "at the end"])
def test_the_next_move_as_soon_as_this_one_is_complete(late, scan_ms):
    """5000 steps end at 1240 ms: words written before the scan that ends then still find it busy."""
    bench = Bench.ready(scan_ms=scan_ms).relative(5_000).run(100).idle(1_140 - (0 if late else scan_ms))
    assert ("MOVE_COMPLETE" in bench.bits) == late
    bench.relative(400).run(scan_ms)
    if late:
        assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}
    else:
        assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"}
        assert (bench.fired, bench.position) == (["CMD-03"], 5_000)


@EVERY_SCAN
@pytest.mark.rules("CMD-03")
@pytest.mark.parametrize("command", [MANUAL_CW, MANUAL_CCW, RELATIVE], ids=["again", "opposite", "relative"])
def test_a_manual_move_that_still_decelerates_is_busy(command, scan_ms):
    """5000/s for 0.4 s from 1 s on, 1200 steps; the new bit changes nothing (reading A-45)."""
    bench = Bench.ready(scan_ms=scan_ms).manual().run(1_000).idle(200).command(command).run(scan_ms)
    assert bench.fired == ["CMD-03"]
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING", "COMMAND_ERROR"}
    bench.run(200 - scan_ms)
    assert (bench.position, bench.bits) == (5_800, {"MODULE_OK", "STOPPED", "COMMAND_ERROR"})


@pytest.mark.rules("CMD-03")
def test_neither_a_hold_nor_a_one_shot_is_a_move_under_way():
    bench = Bench.ready().relative(LONG, ms=400).out(HOLD).run(500)
    bench.relative(7).run(1)
    assert "MOVING_CW" in bench.bits
    bench = Bench.ready().manual(speed=0, ms=5).relative(7).run(1)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}
    assert bench.fired == []


@pytest.mark.rules("CMD-03")
def test_switch_no_move_complete_after_an_error():
    """Option `complete_after_error` (reading A-27): Reset Errors on the way does not help."""
    bench = Bench.ready(complete_after_error=False).relative(5_000).run(300).idle().relative(1).run(1)
    bench.reset_errors()
    bench.until("MODULE_OK", clear=sorted(MOTION))
    assert (bench.position, bench.bits) == (5_000, {"MODULE_OK"})
    goes(bench)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


# -- 7, 8: nothing to hold, nothing to resume -------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize(
    "words", [(), (-1, 1, 5, -1, 2_001, 0), (0, 0, 5, 0, 20, 10)], ids=["zeros", "illegal words", "legal"]
)
@pytest.mark.rules("CMD-07")
def test_hold_at_rest(words, scan_ms):
    """Command Error only (reading A-24), whatever the other words are: they are not looked at."""
    bench = after_a_move(scan_ms=scan_ms)
    bench.out(HOLD, 0, *words)
    refused(bench, "CMD-07", errors=COMMAND_ERRORS)


@EVERY_SCAN
@pytest.mark.rules("CMD-08")
@pytest.mark.parametrize("target", [(), (-1, 1)], ids=["no target", "an illegal target"])
def test_resume_at_rest(target, scan_ms):
    """Command Error only; the target words of a Resume are not looked at."""
    bench = after_a_move(scan_ms=scan_ms)
    bench.out(RESUME, 0, *(target or (0, 0)), 5, 0, 20, 10)
    refused(bench, "CMD-08", errors=COMMAND_ERRORS)


# -- edges ----------------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("IOM-19")
@pytest.mark.parametrize(
    ("command", "speed"), [(RELATIVE, 5_000), (MANUAL_CW, 0)], ids=["relative", "one-shot"]
)
def test_a_bit_that_stays_set_does_nothing_more(command, speed, scan_ms):
    """Neither while nothing else changes nor when other words do; from 0 to 1 it starts again."""
    bench = Bench.ready(scan_ms=scan_ms)
    one_step = 0 if command == MANUAL_CW else 1
    bench.command(command, one_step, speed=speed, ms=100)
    bench.command(command, one_step, speed=speed, up=30, lsw=8, ms=100)
    assert bench.position == 1
    bench.idle(scan_ms).command(command, one_step, speed=speed, ms=100)
    assert bench.position == 2


@pytest.mark.rules("IOM-19")
def test_one_command_may_follow_another_without_a_zero_between():
    """Preset 50, preset 60, Reset Errors, an absolute move to 61: each bit rises as another falls."""
    bench = Bench.ready(config=configuration(add=ENCODER))
    bench.out(PRESET, 0, 0, 50).run(0.25).out(PRESET_ENCODER, 0, 0, 60).run(0.25).out(IMMEDIATE_STOP).run(
        0.25
    )
    assert (bench.position, bench.encoder) == (50, 60)
    bench.absolute(61, ms=50)
    assert (bench.position, bench.bits, bench.fired) == (61, {"MODULE_OK", "MOVE_COMPLETE"}, [])
