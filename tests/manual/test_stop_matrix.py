"""What stops which motion, and how: every cause against every kind of motion [chapters 4 and 6].

"Cut" is a stop without deceleration, in the very tick in which its cause is seen: the position is
the one that the axis had reached by then, and is not valid any more. A controlled stop ramps down
with the programmed deceleration and leaves the position valid. The figures are those of
`motions3601`.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from bench3601 import HOLD, IMMEDIATE_STOP, Bench
from motions3601 import AT_REST, FOLLOW, FOLLOW_ONE_TO_ONE, MOTIONS, REGISTERED, TO_STOP, Motion

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
WHILE_IT_RUNS = pytest.mark.parametrize(
    "ms", [pytest.param(100, id="accelerating"), pytest.param(400, id="at speed")]
)

Outcome = Callable[[Bench, Motion, int], None]

# -- what can happen to a motion ------------------------------------------------------------------


def is_cut(bench: Bench, motion: Motion, ms: int) -> None:
    """By the command: the position is lost, nothing else is wrong."""
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
    assert bench.fired == ["POS-02"]
    stays(bench, motion.steps(ms))


def is_cut_by_estop(bench: Bench, motion: Motion, ms: int) -> None:
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID", "INPUT_ERROR", "IN_ESTOP"}
    assert set(bench.fired) == {"INP-01", "POS-03"}
    stays(bench, motion.steps(ms))


def is_cut_by_limit(bench: Bench, motion: Motion, ms: int) -> None:
    limits = {name for name in bench.bits if name.startswith("IN_")}
    assert limits in ({"IN_CW_LIMIT"}, {"IN_CCW_LIMIT"})
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID", "INPUT_ERROR"} | limits
    assert set(bench.fired) == {"INP-02", "POS-04"}
    stays(bench, motion.steps(ms))


def waits_at_limit(bench: Bench, motion: Motion, ms: int) -> None:
    """Homing: cut as by an emergency stop, but no error and no STOPPED [chapter 4, Find Home]."""
    assert {name for name in bench.bits if not name.startswith("IN_")} == {"MODULE_OK"}
    assert bench.fired == []
    stays(bench, motion.steps(ms))


def finds_no_home(bench: Bench, motion: Motion, ms: int) -> None:
    """Homing met the wrong limit; STOPPED is not for homing [chapter 6, Stopped 4]."""
    bits = {name for name in bench.bits if not name.startswith("IN_")}
    assert bits == {"MODULE_OK", "HOME_INVALID", "POSITION_INVALID", "INPUT_ERROR"}
    assert set(bench.fired) == {"HOM-05", "POS-06", "INP-05"}
    stays(bench, motion.steps(ms))


def is_held(bench: Bench, motion: Motion, ms: int) -> None:
    ramps_down(bench, motion, ms, {"MODULE_OK", "HOLD_STATE"})
    assert bench.fired == []


def is_stopped(bench: Bench, motion: Motion, ms: int) -> None:
    ramps_down(bench, motion, ms, {"MODULE_OK", "STOPPED"})
    assert bench.fired == []


def registers(bench: Bench, motion: Motion, ms: int) -> None:
    """So many steps more, constant speed and deceleration together [chapter 4, Registration Move]."""
    assert bench.fired == []
    bench.until("STOPPED")
    assert bench.position == motion.steps(ms) + motion.direction * REGISTERED
    assert bench.bits - {"IN_EXTERNAL"} == {"MODULE_OK", "STOPPED"}


def goes_on(bench: Bench, motion: Motion, ms: int) -> None:
    """Nothing happens to it: in 0.3 s at speed it makes 1500 steps."""
    assert bench.fired == []
    assert {name for name in bench.bits if not name.startswith("IN_")} >= {"MODULE_OK"} | motion.shown
    if ms < 400:
        bench.run(400 - ms)
    here = bench.position
    bench.run(300)
    assert bench.position - here == motion.direction * 1_500
    assert bench.bits.isdisjoint({"STOPPED", "HOLD_STATE", "DECELERATING", "COMMAND_ERROR", "INPUT_ERROR"})


def stays(bench: Bench, position: int) -> None:
    bits = bench.bits
    assert bench.position == position
    bench.run(500)
    assert (bench.position, bench.bits) == (position, bits)


def ramps_down(bench: Bench, motion: Motion, ms: int, finally_: set[str]) -> None:
    """A controlled stop: neither a step more nor a tick longer than the deceleration takes."""
    steps, lasts = TO_STOP[ms]
    shown = {name for name in bench.bits if not name.startswith("IN_")}
    errors = finally_ & {"COMMAND_ERROR"}
    assert shown == {"MODULE_OK", "DECELERATING"} | motion.shown | errors
    bench.run(lasts - 2 * bench.scan_ns / 1_000_000)
    assert "DECELERATING" in bench.bits
    bench.run(bench.scan_ns / 1_000_000)
    assert {name for name in bench.bits if not name.startswith("IN_")} == finally_
    stays(bench, motion.steps(ms) + motion.direction * steps)


# -- the stop matrix ------------------------------------------------------------------------------

IMMEDIATE = ("IST-01", "IST-02", "IST-05", "POS-02", "STOP-03")
ESTOP = ("EST-01", "EST-02", "INP-01", "POS-03", "STOP-02")
LIMIT = ("INP-02", "POS-04", "STOP-04", "GEN-04")
WRONG_LIMIT = ("HOM-05", "POS-06", "INP-05")

# cause: what it does to the motion, and the rules that say so
MATRIX: dict[str, dict[str, tuple[Outcome, tuple[str, ...]]]] = {
    "immediate stop": {
        "absolute": (is_cut, IMMEDIATE),
        "relative": (is_cut, IMMEDIATE),
        "absolute encoder": (is_cut, (*IMMEDIATE, "ENC-10")),
        "relative encoder": (is_cut, (*IMMEDIATE, "ENC-10")),
        "manual": (is_cut, (*IMMEDIATE, "MAN-07")),
        "registration": (is_cut, (*IMMEDIATE, "MAN-07")),
        "home": (is_cut, IMMEDIATE),
        "blend": (is_cut, IMMEDIATE),
    },
    "emergency stop": {
        "absolute": (is_cut_by_estop, ESTOP),
        "relative": (is_cut_by_estop, ESTOP),
        "absolute encoder": (is_cut_by_estop, (*ESTOP, "ENC-10")),
        "relative encoder": (is_cut_by_estop, (*ESTOP, "ENC-10")),
        "manual": (is_cut_by_estop, (*ESTOP, "MAN-08")),
        "registration": (is_cut_by_estop, (*ESTOP, "MAN-08")),
        "home": (is_cut_by_estop, ESTOP),
        "blend": (is_cut_by_estop, ESTOP),
        "follower": (is_cut_by_estop, ESTOP),
    },
    "limit ahead": {
        "absolute": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "relative": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "absolute encoder": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "relative encoder": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "manual": (is_cut_by_limit, (*LIMIT, "LIM-02", "MAN-09")),
        "registration": (is_cut_by_limit, (*LIMIT, "LIM-02", "MAN-09")),
        "home": (waits_at_limit, ("STOP-04", "POS-04")),
        "blend": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "follower": (is_cut_by_limit, (*LIMIT, "FOL-09")),
    },
    "limit behind": {
        "absolute": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "relative": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "absolute encoder": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "relative encoder": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "manual": (goes_on, ("LIM-02", "MAN-10", "POS-04", "INP-02")),
        "registration": (goes_on, ("LIM-02", "REG-16", "POS-04", "INP-02")),
        "home": (finds_no_home, WRONG_LIMIT),
        "blend": (is_cut_by_limit, (*LIMIT, "LIM-01")),
        "follower": (is_cut_by_limit, (*LIMIT, "FOL-09")),
    },
    "external input": {
        "absolute": (is_held, ("EXT-02", "EXT-04", "STS-M02", "STOP-06")),
        "relative": (is_held, ("EXT-02", "EXT-04", "STS-M02", "STOP-06")),
        "absolute encoder": (is_stopped, ("EXT-04", "EXT-06", "ENC-07", "ENC-10")),
        "relative encoder": (is_stopped, ("EXT-04", "EXT-06", "ENC-07", "ENC-10")),
        "manual": (is_stopped, ("EXT-01", "EXT-04", "MAN-06", "MAN-20", "STOP-01")),
        "registration": (registers, ("EXT-04", "REG-02", "REG-03", "STOP-01")),
        "home": (goes_on, ("EXT-04",)),
        "blend": (goes_on, ("EXT-04",)),
        "follower": (goes_on, ("EXT-04", "FOL-08")),
    },
}


def stop_cells():
    for cause, row in MATRIX.items():
        for motion in MOTIONS:
            outcome, rules = row.get(motion.name.rsplit(" ", 1)[0], (None, ()))
            if outcome is not None:
                yield pytest.param(
                    cause, motion, outcome, id=f"{cause}-{motion.name}", marks=pytest.mark.rules(*rules)
                )


def strike(bench: Bench, cause: str, direction: int) -> None:
    """Let the cause come, to be seen by the next tick."""
    ahead, behind = ("cw_limit", "ccw_limit") if direction > 0 else ("ccw_limit", "cw_limit")
    if cause == "immediate stop":
        bench.out(IMMEDIATE_STOP)
    elif cause == "emergency stop":
        bench.inputs(estop=1)
    elif cause == "external input":
        bench.inputs(external=1)
    else:
        bench.inputs(**{ahead if cause == "limit ahead" else behind: 1})


@EVERY_SCAN
@WHILE_IT_RUNS
@pytest.mark.parametrize(("cause", "motion", "outcome"), list(stop_cells()))
def test_what_stops_which_motion(cause, motion, outcome, ms, scan_ms):
    bench = motion.started(ms, scan_ms=scan_ms)
    strike(bench, cause, motion.direction)
    bench.run(scan_ms)
    outcome(bench, motion, ms)


def test_the_matrix_has_every_cell():
    kinds = {motion.name.rsplit(" ", 1)[0] for motion in MOTIONS}
    assert len(kinds) == 9
    for cause, row in MATRIX.items():
        assert set(row) == kinds - ({"follower"} if cause == "immediate stop" else set()), cause


@EVERY_SCAN
@pytest.mark.parametrize("name", ["follower cw", "follower ccw"])
@pytest.mark.rules("CMD-34", "FOL-16", "STOP-05")
def test_immediate_stop_in_follower_mode_is_a_command_error(name, scan_ms):
    """It is one of "any command", so the steps stop, but the position is not lost."""
    motion = Motion.of(name)
    bench = motion.started(400, scan_ms=scan_ms)
    bench.out(IMMEDIATE_STOP, FOLLOW, *FOLLOW_ONE_TO_ONE)
    bench.run(scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR", "STOPPED"}, ["CMD-34"])
    here = bench.position
    bench.run(100)
    assert bench.position == here == motion.steps(400)


# -- the last column: nothing moves ---------------------------------------------------------------

AT_REST_BY_CAUSE = [
    pytest.param(
        "immediate stop", "idle", set(), [], id="immediate stop-idle", marks=pytest.mark.rules("IST-04")
    ),
    pytest.param(
        "immediate stop", "held", set(), [], id="immediate stop-held", marks=pytest.mark.rules("IST-04")
    ),
    pytest.param(
        "emergency stop",
        "idle",
        {"INPUT_ERROR", "IN_ESTOP"},
        ["INP-01"],
        id="emergency stop-idle",
        marks=pytest.mark.rules("EST-02", "INP-01", "POS-03", "STOP-02"),
    ),
    pytest.param(
        "emergency stop",
        "held",
        {"INPUT_ERROR", "IN_ESTOP"},
        ["INP-01"],
        id="emergency stop-held",
        marks=pytest.mark.rules("EST-02", "INP-01", "POS-03", "STOP-02"),
    ),
    *(
        pytest.param(
            cause, name, {bit}, [], id=f"{bit}-{name}", marks=pytest.mark.rules("INP-02", "POS-04", "STOP-04")
        )
        for name in ("idle", "held")
        for cause, bit in (("limit ahead", "IN_CW_LIMIT"), ("limit behind", "IN_CCW_LIMIT"))
    ),
    *(
        pytest.param("external input", name, {"IN_EXTERNAL"}, [], id=f"external input-{name}")
        for name in ("idle", "held")
    ),
]


@EVERY_SCAN
@pytest.mark.parametrize(("cause", "name", "added", "fired"), AT_REST_BY_CAUSE)
def test_what_a_stop_does_to_an_axis_at_rest(cause, name, added, fired, scan_ms):
    """The position stays valid, and STOPPED is not set: nothing was stopped."""
    bench = Motion.of(name).bench(scan_ms=scan_ms)
    bits, position = bench.bits, bench.position
    strike(bench, cause, direction=1)
    bench.run(scan_ms)
    assert (bench.bits, bench.fired, bench.position) == (bits | added, fired, position)


# -- Hold -----------------------------------------------------------------------------------------


def is_refused_and_goes_on(rule: str) -> Outcome:
    def check(bench: Bench, motion: Motion, ms: int) -> None:
        assert bench.fired == [rule]
        assert bench.bits - {"ACCELERATING"} == {"MODULE_OK", "COMMAND_ERROR"} | motion.shown
        bench.run(500 - ms)
        here = bench.position
        bench.run(200)
        assert bench.position - here == motion.direction * 1_000
        assert bench.bits == {"MODULE_OK", "COMMAND_ERROR"} | motion.shown

    return check


def is_refused_and_stops(rule: str) -> Outcome:
    def check(bench: Bench, motion: Motion, ms: int) -> None:
        assert bench.fired == [rule]
        ramps_down(bench, motion, ms, {"MODULE_OK", "STOPPED", "COMMAND_ERROR"})

    return check


def ends_the_mode(bench: Bench, motion: Motion, ms: int) -> None:
    assert bench.fired == ["CMD-34"]
    assert bench.bits == {"MODULE_OK", "STOPPED", "COMMAND_ERROR"}
    stays(bench, motion.steps(ms))


HOLD_TABLE: dict[str, tuple[Outcome, tuple[str, ...]]] = {
    "absolute": (is_held, ("HLD-01", "STS-M02", "STOP-06")),
    "relative": (is_held, ("HLD-01", "STS-M02", "STOP-06")),
    "absolute encoder": (is_refused_and_goes_on("CMD-07"), ("CMD-07", "HLD-09", "ENC-06")),
    "relative encoder": (is_refused_and_goes_on("CMD-07"), ("CMD-07", "HLD-09", "ENC-06")),
    "manual": (is_refused_and_stops("CMD-07"), ("CMD-07", "HLD-08", "MAN-20")),
    "registration": (is_refused_and_stops("CMD-21"), ("CMD-21", "REG-27")),
    "home": (is_refused_and_goes_on("CMD-07"), ("CMD-07", "HLD-06")),
    "blend": (is_refused_and_goes_on("CMD-19"), ("CMD-19", "HLD-07")),
    "follower": (ends_the_mode, ("CMD-34", "HLD-10", "FOL-16", "STOP-05")),
}


def hold_cells():
    for motion in MOTIONS:
        outcome, rules = HOLD_TABLE[motion.name.rsplit(" ", 1)[0]]
        yield pytest.param(motion, outcome, id=motion.name, marks=pytest.mark.rules(*rules))


@EVERY_SCAN
@WHILE_IT_RUNS
@pytest.mark.parametrize(("motion", "outcome"), list(hold_cells()))
def test_what_hold_does_to_which_motion(motion, outcome, ms, scan_ms):
    bench = motion.started(ms, scan_ms=scan_ms)
    if motion.follows:
        bench.out(HOLD, FOLLOW, *FOLLOW_ONE_TO_ONE)
    elif motion.target == REGISTERED:
        bench.out(HOLD, *list(bench.outputs)[1:])  # a registration move watches its target words
    else:
        bench.out(HOLD)
    bench.run(scan_ms)
    outcome(bench, motion, ms)


@EVERY_SCAN
@pytest.mark.parametrize("name", ["registration cw", "registration ccw"])
@pytest.mark.rules("CMD-07", "CMD-21")
def test_hold_of_a_registration_move_after_its_input(name, scan_ms):
    """Reading A-54: the error, and the steps are completed."""
    motion = Motion.of(name)
    bench = motion.started(400, scan_ms=scan_ms)
    bench.idle(100).out(HOLD, *list(bench.outputs)[1:]).run(scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR", motion.moving}, ["CMD-07"])
    bench.until("STOPPED")
    assert bench.position == motion.direction * (1_600 + REGISTERED)


@EVERY_SCAN
@pytest.mark.parametrize("motion", AT_REST, ids=lambda motion: motion.name)
@pytest.mark.rules("CMD-07")
def test_hold_of_an_axis_at_rest_is_a_command_error(motion, scan_ms):
    bench = motion.bench(scan_ms=scan_ms)
    bits, position = bench.bits, bench.position
    bench.out(HOLD).run(scan_ms)
    assert (bench.bits, bench.fired) == (bits | {"COMMAND_ERROR"}, ["CMD-07"])
    assert bench.position == position
