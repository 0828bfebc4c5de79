"""The external input [chapter 6, External Input; chapters 3 and 4].

What it does to a motion that runs stands in `test_stop_matrix`; here is what it does to one that is
started while it is on, and how its level counts. A step at the starting speed of 1000/s takes 1 ms.
"""

from __future__ import annotations

import pytest
from bench3601 import ENCODER, MANUAL_CW, RELATIVE, RESUME, Bench, configuration
from motions3601 import ENCODER_MOVE, MOTIONS, STEPS, Motion

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
HELD = {"MODULE_OK", "HOLD_STATE", "IN_EXTERNAL"}

# -- on at the start ------------------------------------------------------------------------------

HOLDS = ("MOV-11", "EXT-03", "EXT-04")
STOPS = ("EXT-03", "EXT-04")
ONE_STEP = {
    "absolute": ("HOLD_STATE", HOLDS),
    "relative": ("HOLD_STATE", HOLDS),
    "absolute encoder": ("STOPPED", STOPS),
    "relative encoder": ("STOPPED", STOPS),
    "manual": ("STOPPED", STOPS),
}
UNAFFECTED = ("home", "blend", "follower")


def one_step_rows():
    for motion in MOTIONS:
        end, rules = ONE_STEP.get(motion.name.rsplit(" ", 1)[0], (None, ()))
        if end is not None:
            yield pytest.param(motion, end, id=motion.name, marks=pytest.mark.rules(*rules))


@EVERY_SCAN
@pytest.mark.parametrize(("motion", "end"), list(one_step_rows()))
def test_a_move_started_with_the_input_on_makes_one_step(motion, end, scan_ms):
    bench = motion.bench(scan_ms=scan_ms).inputs(external=1).run(scan_ms)
    motion.start(bench)
    if scan_ms < 1:
        assert bench.run(1 - scan_ms).bits == {"MODULE_OK", "IN_EXTERNAL", motion.moving}
        assert bench.position == 0
    bench.run(scan_ms)
    assert (bench.position, bench.bits) == (motion.direction, {"MODULE_OK", "IN_EXTERNAL", end})
    bench.run(500)
    assert (bench.position, bench.fired) == (motion.direction, [])


@EVERY_SCAN
@pytest.mark.parametrize("distance", [1, -1])
@pytest.mark.rules("MOV-11", "EXT-03")
def test_a_move_by_one_step_started_with_the_input_on_is_held_at_its_target(distance, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).inputs(external=1).relative(distance, ms=20)
    assert (bench.position, bench.bits, bench.fired) == (distance, HELD, [])


@EVERY_SCAN
@pytest.mark.parametrize(
    ("speed", "ms"),
    [
        pytest.param(1_000, 1, id="at the starting speed"),
        pytest.param(5_000, 1, id="faster: at the starting speed all the same"),
        pytest.param(100, 10, id="slower: at its own speed"),
    ],
)
@pytest.mark.rules("EXT-03", "MAN-02")
def test_the_one_step_of_a_manual_move(speed, ms, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).inputs(external=1).manual(speed=speed)
    assert bench.until("STOPPED") == max(ms, scan_ms)
    assert bench.position == 1


@EVERY_SCAN
@pytest.mark.parametrize("name", ["relative cw", "manual ccw", "relative encoder cw"])
@pytest.mark.rules("EXT-03", "MOV-11")
def test_the_input_may_come_with_the_command(name, scan_ms):
    motion = Motion.of(name)
    bench = motion.start(motion.bench(scan_ms=scan_ms)).inputs(external=1).run(500)
    assert bench.position == motion.direction
    assert {"HOLD_STATE", "STOPPED"} & bench.bits


@EVERY_SCAN
@pytest.mark.rules("EXT-03", "MAN-15")
def test_a_one_shot_is_one_step_anyway(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).inputs(external=1).manual(speed=0, ms=20)
    assert (bench.position, bench.bits) == (1, {"MODULE_OK", "MOVING_CW", "IN_EXTERNAL"})


@EVERY_SCAN
@pytest.mark.parametrize("lsw", [0, ENCODER_MOVE], ids=["steps", "counts"])
@pytest.mark.rules("EXT-03")
def test_a_move_without_distance_makes_no_step(lsw, scan_ms):
    """There is no direction to make it in; it is complete at once (reading A-35)."""
    bench = Bench.ready(config=configuration(add=ENCODER), scan_ms=scan_ms).inputs(external=1)
    bench.command(RELATIVE, 0, lsw=lsw).run(20)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "MOVE_COMPLETE", "IN_EXTERNAL"})


REGISTRATIONS = [motion for motion in MOTIONS if motion.name.startswith("registration")]


@EVERY_SCAN
@pytest.mark.parametrize("minimum", [0, 500])
@pytest.mark.parametrize("motion", REGISTRATIONS, ids=lambda motion: motion.name)
@pytest.mark.rules("EXT-05", "CMD-22", "PRF-12", "REG-22")
def test_a_registration_move_is_not_started_with_the_input_on(motion, minimum, scan_ms):
    bench = motion.bench(scan_ms=scan_ms).out(0, 0x0400, 0, minimum).run(scan_ms)
    bench.idle(scan_ms).inputs(external=1).run(scan_ms)
    bits = bench.bits
    motion.start(bench).run(100)
    assert (bench.position, bench.bits) == (0, bits | {"COMMAND_ERROR", "INVALID_PROFILE"})
    assert set(bench.fired) == {"CMD-22", "PRF-12"}
    bench.reset_errors().inputs(external=0)
    assert bench.bits == bits
    motion.start(bench).run(100)
    assert bench.position == motion.direction * STEPS[100]


@EVERY_SCAN
@pytest.mark.parametrize(
    "motion", [m for m in MOTIONS if m.name.startswith(UNAFFECTED)], ids=lambda motion: motion.name
)
@pytest.mark.rules("EXT-04")
def test_motions_that_do_not_know_the_input_start_as_ever(motion, scan_ms):
    bench = motion.bench(scan_ms=scan_ms).inputs(external=1).run(scan_ms)
    motion.start(bench).run(400)
    assert (bench.position, bench.fired) == (motion.steps(400), [])


@EVERY_SCAN
@pytest.mark.rules("EXT-03", "CFG-20")
def test_an_input_that_is_not_configured_does_not_count_at_the_start(scan_ms):
    bench = Bench.ready(config=configuration(drop=0x02), scan_ms=scan_ms).inputs(external=1)
    assert bench.relative(20_000, ms=400).position == 1_600


@EVERY_SCAN
@pytest.mark.rules("EXT-03", "EXT-02", "CFG-19")
def test_an_input_that_is_active_low(scan_ms):
    bench = Bench.ready(config=configuration(levels=0x3D), scan_ms=scan_ms)
    bench.relative(20_000, ms=100)
    assert (bench.position, bench.bits) == (1, HELD)
    bench.idle().inputs(external=1).relative(20_000, ms=400)
    assert bench.position == 1_601
    bench.inputs(external=0).run(400)
    assert (bench.position, bench.bits) == (2_801, HELD)


# -- a hold by the input, and after it ------------------------------------------------------------


def held_by_input(**kwargs) -> Bench:
    """A relative move of 20,000 held at 2800 by the input, which is still on."""
    bench = Bench.ready(config=configuration(add=ENCODER), **kwargs).relative(20_000, ms=400)
    bench.inputs(external=1).run(400)
    assert (bench.position, bench.bits, bench.fired) == (2_800, HELD, [])
    return bench.idle(bench.scan_ns / 1_000_000)


@EVERY_SCAN
@pytest.mark.rules("HLD-11", "RSM-01", "EXT-02", "MC-01")
def test_resume_with_the_input_off_goes_on_to_the_target(scan_ms):
    """17,200 steps: 200 + 400 ms for the ramps, 15,400/5 for the rest."""
    bench = held_by_input(scan_ms=scan_ms).inputs(external=0).run(100)
    assert (bench.position, bench.bits) == (2_800, {"MODULE_OK", "HOLD_STATE"})
    assert bench.command(RESUME).until("MOVE_COMPLETE") == 3_680
    assert bench.position == 20_000


@EVERY_SCAN
@pytest.mark.rules("HLD-11", "RSM-05", "MOV-11")
def test_resume_with_the_input_on_makes_a_step_and_is_held_again(scan_ms):
    """Reading A-47; in the end the move is still exact."""
    bench = held_by_input(scan_ms=scan_ms)
    for times in range(1, 4):
        bench.command(RESUME).run(20)
        assert (bench.position, bench.bits) == (2_800 + times, HELD)
        bench.idle(scan_ms)
    bench.inputs(external=0).command(RESUME).until("MOVE_COMPLETE")
    assert (bench.position, bench.fired) == (20_000, [])


AFTER_A_HOLD = [
    pytest.param((RESUME, 0, 0, 0, 5, 0, 20, 10), id="resume"),
    pytest.param((RELATIVE, 0, 1, 0, 5, 0, 20, 10), id="relative"),
    pytest.param((RELATIVE, ENCODER_MOVE, 1, 0, 5, 0, 20, 10), id="encoder"),
    pytest.param((MANUAL_CW, 0, 0, 0, 5, 0, 20, 10), id="manual"),
]


@EVERY_SCAN
@pytest.mark.parametrize("words", AFTER_A_HOLD)
@pytest.mark.rules("HLD-11")
def test_switch_for_a_move_that_has_to_wait_for_the_input(words, scan_ms):
    """Reading A-47 the other way: the input has to be off before another move is performed."""
    bench = held_by_input(scan_ms=scan_ms, one_step_under_external=False).out(*words).run(50)
    assert (bench.position, bench.bits) == (2_800, HELD | {"COMMAND_ERROR"})
    assert bench.fired == ["HLD-11"]
    bench.idle(scan_ms).inputs(external=0).reset_errors().relative(1_000).until("MOVE_COMPLETE")
    assert (bench.position, bench.fired) == (3_800, ["HLD-11"])


@EVERY_SCAN
@pytest.mark.rules("MOV-11", "HLD-11")
def test_the_switch_leaves_other_starts_with_the_input_on_alone(scan_ms):
    """A move is refused only after a hold by the input; held by command there is one step."""
    bench = Bench.ready(scan_ms=scan_ms, one_step_under_external=False).relative(20_000, ms=400)
    bench.out(0x0004).run(400)
    bench.inputs(external=1).relative(500, ms=20)
    assert (bench.position, bench.bits, bench.fired) == (2_801, HELD, [])


@EVERY_SCAN
@pytest.mark.rules("MOV-11", "HLD-11")
def test_the_switch_forgets_a_hold_that_is_over(scan_ms):
    """A move has been made since then; the next one with the input on makes its one step."""
    bench = held_by_input(scan_ms=scan_ms, one_step_under_external=False)
    bench.inputs(external=0).relative(200).until("MOVE_COMPLETE")
    bench.idle(scan_ms).inputs(external=1).relative(500, ms=20)
    assert (bench.position, bench.bits, bench.fired) == (3_001, HELD, [])


# -- its level ------------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize("on_ms", [0.25, 2, 100])
@pytest.mark.parametrize(
    ("name", "end"),
    [("relative cw", "HOLD_STATE"), ("manual cw", "STOPPED"), ("relative encoder cw", "STOPPED")],
)
@pytest.mark.rules("EXT-01", "EXT-02", "ENC-07")
def test_a_stop_that_has_begun_is_finished(name, end, on_ms, scan_ms):
    """However soon the input is off again, and nothing starts by itself, manual bit or not."""
    bench = Motion.of(name).started(400, scan_ms=scan_ms).inputs(external=1).run(on_ms)
    bench.inputs(external=0).run(1_000)
    assert (bench.position, bench.bits, bench.fired) == (2_800, {"MODULE_OK", end}, [])


@EVERY_SCAN
@pytest.mark.rules("EXT-01", "MAN-01", "MAN-06")
def test_a_manual_move_needs_a_new_command_after_the_input(scan_ms):
    bench = Motion.of("manual cw").started(400, scan_ms=scan_ms).inputs(external=1).run(500)
    bench.inputs(external=0).idle(scan_ms).manual(ms=100)
    assert (bench.position, bench.bits) == (3_000, {"MODULE_OK", "MOVING_CW", "ACCELERATING"})


@EVERY_SCAN
@pytest.mark.rules("EXT-01", "MAN-20")
def test_the_input_leaves_the_position_valid(scan_ms):
    bench = Motion.of("manual cw").started(400, scan_ms=scan_ms).inputs(external=1).run(500)
    bench.inputs(external=0).absolute(0).until("MOVE_COMPLETE")
    assert (bench.position, bench.fired) == (0, [])


@EVERY_SCAN
@pytest.mark.rules("EXT-02", "EXT-01")
def test_the_input_at_rest_does_nothing(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms)
    for level in (1, 0, 1):
        bench.inputs(external=level).run(10)
        assert (bench.bits - {"IN_EXTERNAL"}, bench.position, bench.fired) == ({"MODULE_OK"}, 0, [])
