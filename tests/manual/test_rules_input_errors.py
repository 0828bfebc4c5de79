"""Stop inputs that are on before a move, and Input Error [chapter 6; chapter 4, Manual Move]."""

from __future__ import annotations

import pytest
from bench3601 import ABSOLUTE, HOME_CCW, HOME_CW, IMMEDIATE_STOP, RELATIVE, RESUME, Bench
from motions3601 import MOTIONS, held

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
CUT = {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
LIMITS = [("cw_limit", "IN_CW_LIMIT"), ("ccw_limit", "IN_CCW_LIMIT")]


# -- inputs that are on when a move is commanded --------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
@pytest.mark.rules("INP-01", "EST-03", "STS-M11")
def test_no_motion_starts_while_the_emergency_stop_is_on(motion, scan_ms):
    """Readings A-16 and A-87: Input Error and nothing else, which Reset Errors clears all the same."""
    bench = motion.bench(scan_ms=scan_ms).relative(7).inputs(estop=0)
    bench.until("MOVE_COMPLETE")
    bench.idle(scan_ms).inputs(estop=1).run(scan_ms)
    bench.reset_errors(scan_ms)
    done = {"MODULE_OK", "MOVE_COMPLETE", "IN_ESTOP"}
    assert bench.bits == done
    bench.fired.clear()
    motion.start(bench).run(100)
    assert (bench.position, bench.bits, bench.fired) == (7, done | {"INPUT_ERROR"}, ["INP-01"])
    bench.out(0, bench.outputs[1]).run(scan_ms)
    bench.out(0).inputs(estop=0).run(scan_ms)
    motion.start(bench).run(scan_ms)
    assert bench.bits.isdisjoint({"INPUT_ERROR", "MOVE_COMPLETE"})
    assert bench.run(20).position != 7


AGAINST_A_LIMIT = [
    motion for motion in MOTIONS if not motion.name.startswith(("manual", "registration", "home"))
]


@EVERY_SCAN
@pytest.mark.parametrize("motion", AGAINST_A_LIMIT, ids=lambda motion: motion.name)
@pytest.mark.parametrize(("name", "bit"), LIMITS)
@pytest.mark.rules("INP-02", "POS-04", "STS-M11", "FOL-07")
def test_a_move_does_not_start_on_an_end_limit(motion, name, bit, scan_ms):
    """Reading A-17: either limit; the position stays valid and nothing else changes."""
    bench = motion.bench(scan_ms=scan_ms).inputs(**{name: 1}).run(scan_ms)
    motion.start(bench).run(100)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "INPUT_ERROR", bit})
    assert bench.fired == ["INP-02"]


@EVERY_SCAN
@pytest.mark.parametrize(("name", "bit"), LIMITS)
@pytest.mark.rules("INP-02", "RSM-01")
def test_a_move_is_not_resumed_on_an_end_limit(name, bit, scan_ms):
    bench = held(scan_ms=scan_ms).inputs(**{name: 1}).command(RESUME).run(100)
    assert bench.position == 2_800
    assert {"HOLD_STATE", bit} <= bench.bits
    assert "MOVING_CW" not in bench.bits


BY_HAND = [motion for motion in MOTIONS if motion.name.startswith(("manual", "registration"))]


@EVERY_SCAN
@pytest.mark.parametrize("motion", BY_HAND, ids=lambda motion: motion.name)
@pytest.mark.rules("INP-03", "LIM-02", "MAN-10")
def test_a_manual_move_starts_only_away_from_an_active_limit(motion, scan_ms):
    (ahead, bit), (behind, _) = LIMITS[:: motion.direction]
    bench = motion.bench(scan_ms=scan_ms).inputs(**{ahead: 1}).run(scan_ms)
    motion.start(bench).run(100)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "INPUT_ERROR", bit})
    assert bench.fired == ["INP-03"]
    away = motion.bench(scan_ms=scan_ms).inputs(**{behind: 1}).run(scan_ms)
    motion.start(away).run(100)
    assert (away.position, away.fired) == (motion.direction * 200, [])


@EVERY_SCAN
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.rules("INP-03", "MAN-15", "LIM-02")
def test_a_one_shot_is_prevented_by_the_limit_ahead_and_the_emergency_stop(sign, scan_ms):
    """Reading A-43."""
    (ahead, bit), (behind, other) = LIMITS[::sign]
    bench = Bench.ready(scan_ms=scan_ms).inputs(**{ahead: 1}).manual(sign, speed=0).run(20)
    assert (bench.position, bench.bits, bench.fired) == (0, {"MODULE_OK", "INPUT_ERROR", bit}, ["INP-03"])
    bench = Bench.ready(scan_ms=scan_ms).inputs(**{behind: 1}).manual(sign, speed=0).run(20)
    assert (bench.position, bench.fired) == (sign, [])
    assert bench.bits == {"MODULE_OK", "MOVING_CW" if sign > 0 else "MOVING_CCW", other}
    bench = Bench.ready(scan_ms=scan_ms).inputs(estop=1).run(scan_ms).manual(sign, speed=0).run(20)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP"})


@EVERY_SCAN
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.rules("MAN-09", "MAN-10", "LIM-02", "INP-03", "STS-M11")
def test_an_axis_is_moved_off_a_limit_by_hand(sign, scan_ms):
    """Run into the switch at 3000, refused to go farther, moved back off it."""
    name, bit = LIMITS[0 if sign > 0 else 1]
    machine = {name: (3_000, None) if sign > 0 else (None, -3_000)}
    bench = Bench.ready(scan_ms=scan_ms, machine=machine).manual(sign)
    bench.until("STOPPED")
    assert (bench.position, bench.bits) == (sign * 3_000, CUT | {"INPUT_ERROR", bit})
    bench.idle().manual(sign, ms=50)
    assert (bench.position, bench.fired[-1]) == (sign * 3_000, "INP-03")
    bench.idle().manual(-sign, ms=100)
    assert bench.position == sign * 2_800
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "ACCELERATING"} | {
        "MOVING_CCW" if sign > 0 else "MOVING_CW"
    }


@EVERY_SCAN
@pytest.mark.parametrize(("command", "sign"), [(HOME_CW, 1), (HOME_CCW, -1)])
@pytest.mark.rules("GEN-05")
def test_homing_starts_from_either_limit(command, sign, scan_ms):
    """From the one ahead after two seconds backward, from the other one at once."""
    (ahead, _), (behind, _) = LIMITS[::sign]
    machine = {ahead: (0, None) if sign > 0 else (None, 0), "home": (-3_000 * sign, -2_500 * sign)[::sign]}
    bench = Bench.ready(scan_ms=scan_ms, machine=machine).command(command).run(1_990)
    assert (bench.position, bench.fired) == (0, [])
    bench.until("AT_HOME", ms=20_000)
    assert bench.fired == []
    machine = {behind: (None, 0) if sign > 0 else (0, None), "home": (2_500 * sign, 3_000 * sign)[::sign]}
    bench = Bench.ready(scan_ms=scan_ms, machine=machine).command(command).run(100)
    assert (bench.position, bench.fired) == (200 * sign, [])
    bench.until("AT_HOME", ms=20_000)


# -- homing between two limits --------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize(("command", "sign"), [(HOME_CW, 1), (HOME_CCW, -1)])
@pytest.mark.rules("POS-05", "INP-04", "HOM-04", "STOP-04", "STOP-06")
def test_a_search_that_meets_both_limits(command, sign, scan_ms):
    """1600 steps ahead, then back to the one behind: three errors, no Command Error, no Stopped."""
    machine = {"cw_limit": (1_600, None), "ccw_limit": (None, -1_600)}
    bench = Bench.ready(scan_ms=scan_ms, machine=machine).command(command)
    assert bench.until(clear=["MOVING_CW", "MOVING_CCW"]) == 400 + scan_ms
    assert (bench.position, bench.fired) == (1_600 * sign, [])
    assert "POSITION_INVALID" not in bench.bits
    bench.until("HOME_INVALID")
    bit = "IN_CCW_LIMIT" if sign > 0 else "IN_CW_LIMIT"
    assert bench.position == -1_600 * sign
    assert bench.bits == {"MODULE_OK", "HOME_INVALID", "POSITION_INVALID", "INPUT_ERROR", bit}
    assert set(bench.fired) == {"HOM-04", "POS-05", "INP-04"}


@EVERY_SCAN
@pytest.mark.parametrize(
    ("cause", "added"),
    [("immediate stop", set()), ("estop", {"INPUT_ERROR", "IN_ESTOP"})],
)
@pytest.mark.rules("IST-01", "EST-01", "POS-02", "POS-03")
def test_the_wait_of_a_search_counts_as_motion(cause, added, scan_ms):
    """Reading A-29: on the limit, in the two seconds before the search turns round."""
    bench = Bench.ready(scan_ms=scan_ms, machine={"cw_limit": (1_600, None)}).command(HOME_CW, ms=1_000)
    assert bench.bits == {"MODULE_OK", "IN_CW_LIMIT"}
    bench.out(IMMEDIATE_STOP) if cause == "immediate stop" else bench.inputs(estop=1)
    assert bench.scan().bits == CUT | added | {"IN_CW_LIMIT"}
    assert bench.run(3_000).position == 1_600


# -- Input Error -----------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("EST-02", "INP-01")
def test_an_emergency_stop_that_stays_on_is_one_event(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, ms=400).inputs(estop=1).run(100)
    bench.inputs(external=1).idle(100)
    assert bench.fired == ["INP-01", "POS-03"]
    bench.reset_errors(scan_ms)
    assert "INPUT_ERROR" not in bench.run(100).bits  # reading A-87
    bench.inputs(estop=0).run(10).inputs(estop=1).run(scan_ms)
    assert bench.fired == ["INP-01", "POS-03", "INP-01"]
    assert "INPUT_ERROR" in bench.bits


@EVERY_SCAN
@pytest.mark.parametrize("msw", [ABSOLUTE, RELATIVE])
@pytest.mark.rules("STS-M11", "INP-02")
def test_input_error_does_not_lock_the_module(msw, scan_ms):
    """Unlike a command error: it goes off with the next move, and a refused one leaves it."""
    bench = Bench.ready(scan_ms=scan_ms).inputs(cw_limit=1).relative(10_000, ms=20)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_CW_LIMIT"}
    bench.inputs(cw_limit=0).idle().command(msw, 500, speed=999, ms=20)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "COMMAND_ERROR", "INVALID_PROFILE"}
    bench.reset_errors().inputs(cw_limit=1).command(msw, 500, ms=20)
    bench.inputs(cw_limit=0).idle().command(msw, 500, ms=20)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}


@EVERY_SCAN
@pytest.mark.parametrize("name", ["estop", "cw_limit", "ccw_limit"])
@pytest.mark.rules("INP-01", "INP-02", "POS-03", "POS-04")
def test_an_input_that_comes_with_the_command_prevents_the_move(name, scan_ms):
    """Nothing has moved: the position stays valid."""
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000).inputs(**{name: 1}).run(100)
    assert bench.position == 0
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_" + name.upper()}
