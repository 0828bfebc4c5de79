"""The function blocks: PLCopen's rules for their outputs, and what the 3601 is told underneath.

Starting speed 1000, speed 5000, rates 20 up and 10 down: 0.2 s and 600 steps up, 0.4 s and 1200 steps down.
"""

import pytest
from bench3601 import configuration
from blocks3601 import (
    CONTINUOUS,
    DISABLED,
    DISCRETE,
    ERROR_STOP,
    HOMING,
    INSTANCES,
    STANDSTILL,
    STOPPING,
    SYNCHRONIZED,
    BlocksBench,
)
from scanrack.runtime import ModuleFault

BOTH = pytest.mark.parametrize("interpreted", [False, True], ids=["compiled", "interpreted"])
REFUSED, PARAMETER, NO_POSITION = 64, 128, 256
COMMAND, PROFILE, INPUT, LOST = 1, 2, 8, 32
ENCODER = 0x0100


# -- Execute and what becomes of it


@pytest.mark.slow
@BOTH
def test_a_move_from_execute_to_done(interpreted):
    """2,000 steps: 200 + 400 ms of ramps, 200 steps at 5000/s: 640 ms."""
    bench = BlocksBench.ready(interpreted=interpreted)
    bench.go("Move", Position=2_000).scan()
    assert (bench.said("Move"), bench.state) == ({"Busy"}, DISCRETE)
    started = bench.cpu.now_ns
    assert bench.scan().said("Move") == {"Busy", "Active"}
    bench.until("Move", "Done")
    assert (bench.position, bench.said("Move")) == (2_000, {"Done"})
    assert 640 <= (bench.cpu.now_ns - started) / 1e6 <= 650
    assert bench.scan(50).said("Move") == {"Done"}  # as long as Execute
    assert bench.state == STANDSTILL
    assert bench.drop("Move").scan().said("Move") == set()
    assert bench.diary.fired == []


@pytest.mark.parametrize("scan_ms", [1, 2, 10, 100])
def test_an_execute_that_fell_earlier_shows_done_for_one_scan(scan_ms):
    bench = BlocksBench.ready(scan_ms=scan_ms)
    bench.go("Move", Position=100).scan().drop("Move").until("Move", "Done")
    assert bench.said("Move") == {"Done"}
    assert bench.scan().said("Move") == set()


def test_the_inputs_are_those_of_the_scan_in_which_execute_rose():
    bench = BlocksBench.ready().go("Move", Position=2_000).scan()
    bench.tags.Move_Position = 9_000
    assert bench.until("Move", "Done").position == 2_000


def test_execute_during_a_move_starts_it_anew():
    """The first target is given up: held, and on to the second one."""
    bench = BlocksBench.ready().go("Move", Position=50_000).run(400).drop("Move").scan()
    bench.go("Move", Position=3_000).scan()
    assert bench.said("Move") == {"Busy"}
    assert bench.until("Move", "Done").position == 3_000
    assert bench.diary.fired == []


def test_an_execute_that_is_on_at_power_up_is_no_edge():
    bench = BlocksBench()
    bench.go("Configure").scan(20)
    assert (bench.said("Configure"), bench.state) == (set(), DISABLED)


@pytest.mark.parametrize("name", [name for name in INSTANCES if name not in ("Configure", "Probe")])
def test_before_a_configuration_everything_is_refused(name):
    bench = BlocksBench().scan()
    bench.go(name, **LEGAL.get(name, {})).scan()
    assert (bench.said(name), bench.tags[f"{name}.ErrorID"] & REFUSED) == ({"Error"}, REFUSED)
    assert bench.scan(20).diary.fired == ["CER-01"]  # of power-up; nothing went out


LEGAL = {
    "Relative": {"Distance": 100},
    "Gear": {"RatioNumerator": 1, "RatioDenominator": 1, "Acceleration": 0, "Deceleration": 0},
    "Register": {"Distance": 3_000},
    "Blend": {"Segments": 2, "FinalDeceleration": 10},
}


# -- every block by itself


@pytest.mark.slow
@pytest.mark.parametrize("shape", [0, 1, 3])
def test_a_relative_move_there_and_back(shape):
    bench = BlocksBench.configured().go("Relative", Distance=-12_345, Shape=shape)
    assert bench.until("Relative", "Done").position == -12_345
    bench.drop("Relative").scan().go("Relative", Distance=12_345)
    assert bench.until("Relative", "Done").position == 0


def test_an_absolute_move_needs_a_position():
    bench = BlocksBench.configured().go("Move", Position=5).scan()
    assert (bench.said("Move"), bench.tags["Move.ErrorID"]) == ({"Error"}, NO_POSITION)


@pytest.mark.parametrize("velocity", [5_000, -5_000])
def test_a_velocity_is_reached_and_held(velocity):
    bench = BlocksBench.ready().go("Velocity", Velocity=velocity).until("Velocity", "InVelocity")
    assert bench.state == CONTINUOUS
    here = bench.position
    bench.run(1_000)
    assert bench.position - here == velocity
    assert bench.said("Velocity") == {"Busy", "Active", "InVelocity"}


def test_a_new_velocity_of_the_same_sign_needs_no_standstill():
    """From 5000 down to 2000/s at 10 steps/ms/s: 300 ms; the module never stops."""
    bench = BlocksBench.ready().go("Velocity").until("Velocity", "InVelocity").drop("Velocity").scan()
    bench.go("Velocity", Velocity=2_000).scan()
    assert bench.said("Velocity") == {"Busy"}
    bench.run(290)
    assert bench.said("Velocity") == {"Busy", "Active"}
    bench.run(20)
    assert bench.said("Velocity") == {"Busy", "Active", "InVelocity"}
    assert not bench.status.STOPPED


def test_the_other_sign_comes_to_rest_first():
    bench = BlocksBench.ready().go("Velocity").until("Velocity", "InVelocity").drop("Velocity").scan()
    bench.go("Velocity", Velocity=-5_000).until("Velocity", "InVelocity")
    assert bench.status.MOVING_CCW
    assert bench.diary.fired == []


@pytest.mark.parametrize("direction", [1, -1])
def test_home_is_where_the_position_is_zero(direction):
    machine = {"home": (2_000, 2_300), "cw_limit": (9_000, None), "ccw_limit": (None, -9_000)}
    bench = BlocksBench.configured(machine=machine)
    if direction < 0:
        bench.go("Relative", Distance=5_000).until("Relative", "Done")
    bench.go("Home", Direction=direction).until("Home", "Active").scan()
    assert bench.state == HOMING
    bench.until("Home", "Done")
    assert (bench.position, bench.status.AT_HOME, bench.status.POSITION_INVALID) == (0, True, False)
    assert bench.module.machine.shaft == (2_000 if direction > 0 else 2_300)


def test_set_position_makes_it_valid():
    bench = BlocksBench.configured()
    assert bench.status.POSITION_INVALID
    bench.go("SetPosition", Position=-1_234_567).until("SetPosition", "Done")
    assert (bench.position, bench.status.POSITION_INVALID) == (-1_234_567, False)


def test_halt_brings_to_rest_with_the_ramp():
    """5000 to 1000/s at 10 steps/ms/s: 400 ms and 1200 steps."""
    bench = BlocksBench.ready().go("Move", Position=90_000).run(600)
    here = bench.position
    bench.go("Halt").until("Halt", "Done")
    assert 1_200 <= bench.position - here <= 1_200 + 5_000 * 0.004
    assert (bench.said("Move"), bench.state) == ({"CommandAborted"}, STANDSTILL)


@pytest.mark.slow
def test_a_halt_that_reaches_a_move_at_its_very_end():
    """A Hold with nothing to hold is CMD-07 to the module [chapter 6]; the axis resets it, and is at rest."""
    fired = []
    for scans in range(30, 50):  # 79 ms: up to 1528/s at 20, down at 10
        bench = BlocksBench.ready(rpi_ms=10).go("Relative", Distance=100).scan(scans).go("Halt")
        bench.until("Halt", "Done", scans=100)
        assert (bench.state, bench.run(50).status.COMMAND_ERROR) == (STANDSTILL, False)
        assert bench.said("Relative") <= {"Done", "CommandAborted"}
        fired += bench.diary.fired
    assert set(fired) == {"CMD-07"}


@pytest.mark.parametrize("rpi_ms", [None, 2, 5, 10])
def test_the_same_command_twice_is_two_edges(rpi_ms):
    """Zero words stand long enough to cross the backplane in between."""
    bench = BlocksBench.ready(rpi_ms=rpi_ms)
    for position in range(1, 9):  # at eight different instants between two exchanges
        bench.go("SetPosition", Position=position).until("SetPosition", "Done")
        assert bench.position == position
        bench.drop("SetPosition").scan(position)


def test_stop_keeps_the_axis_as_long_as_execute():
    bench = BlocksBench.ready().go("Velocity").run(600).go("Stop").scan()
    assert (bench.said("Velocity") & {"Done", "Error"}, bench.state) == (set(), STOPPING)
    assert bench.scan().said("Velocity") == {"CommandAborted"}
    bench.until("Stop", "Done")
    assert bench.state == STOPPING
    bench.go("Relative", Distance=5).scan()
    assert (bench.said("Relative"), bench.tags["Relative.ErrorID"]) == ({"Error"}, REFUSED)
    bench.drop("Stop", "Relative").scan(2)
    assert bench.state == STANDSTILL
    bench.go("Relative", Distance=5).until("Relative", "Done")
    assert bench.diary.fired == []


def test_the_probe_records_where_the_input_came():
    """The capture switch is at 1500; the axis runs over it."""
    bench = BlocksBench.ready(config=configuration(add=1), machine={"capture": (1_500, 1_700)})
    bench.go("Probe").scan()
    assert bench.said("Probe") == {"Busy"}
    bench.go("Move", Position=4_000).until("Probe", "Done")
    assert bench.position < 4_000
    assert bench.tags["Probe.RecordedPosition"] == 1_500
    assert bench.until("Move", "Done").said("Probe") == {"Done"}


@pytest.mark.parametrize(("numerator", "moved"), [(3, 300), (-3, -300)])
def test_gear_in_follows_the_encoder(numerator, moved):
    """200 counts at 3:2 are 300 steps."""
    bench = BlocksBench.ready(config=configuration(add=ENCODER))
    legal = LEGAL["Gear"] | {"RatioNumerator": numerator, "RatioDenominator": 2}
    bench.go("Gear", **legal).until("Gear", "InGear")
    assert (bench.state, bench.said("Gear")) == (SYNCHRONIZED, {"Busy", "Active", "InGear"})
    now = bench.cpu.now_ns
    bench.module.machine.turn_encoder(200, now, now + 100_000_000)
    assert bench.run(200).position == moved
    bench.go("Halt").until("Halt", "Done")
    assert (bench.said("Gear"), bench.diary.fired) == ({"CommandAborted"}, [])


@pytest.mark.parametrize("velocity", [5_000, -5_000])
def test_registration_goes_on_for_its_distance(velocity):
    bench = BlocksBench.ready().go("Register", Distance=3_000, Velocity=velocity).run(800)
    here = bench.position
    bench.tags["Register.Register"] = True
    bench.until("Register", "Done")
    assert 0 <= abs(bench.position - here) - 3_000 <= 10  # the scan in between, at 5000/s
    assert bench.diary.fired == []


def test_the_minimum_registration_distance_is_stored():
    bench = BlocksBench.ready().go("Minimum", Distance=2_500).until("Minimum", "Done")
    assert bench.status.MIN_REG_NONZERO


@pytest.mark.parametrize("direction", [1, -1])
def test_a_blend_is_programmed_and_run(direction):
    bench = programmed([(3_000, 5_000, 20), (2_200, 2_000, 10)])
    bench.go("RunBlend", Direction=direction).until("RunBlend", "Active")
    assert bench.state == DISCRETE
    assert bench.until("RunBlend", "Done").position == direction * 5_200
    assert bench.diary.fired == []


@pytest.mark.slow
def test_sixteen_segments_with_their_shapes():
    """A staircase of 500 steps each; the shapes of nine and on go in a word of their own."""
    segments = [(1_500, 1_100 + 100 * number, 20) for number in range(16)]
    bench = programmed(segments, EarlyShapes=0x5555, LateShapes=0x1555, FinalShape=1)
    assert bench.go("RunBlend").until("RunBlend", "Done").position == 16 * 1_500


def programmed(segments, **inputs):
    bench = BlocksBench.ready()
    for number, values in enumerate(segments):
        for name, value in zip(("Lengths", "Velocities", "Rates"), values, strict=True):
            bench.tags[f"{name}[{number}]"] = value
    return bench.go("Blend", Segments=len(segments), FinalDeceleration=10, **inputs).until("Blend", "Done")


# -- errors


def test_an_illegal_profile_is_the_modules_error_and_reset_ends_it():
    """Speed below starting speed: CMD-05 and PRF-01, so Command Error and Invalid Profile."""
    bench = BlocksBench.ready().go("Relative", Distance=500, Velocity=10).until("Relative", "Error")
    assert (bench.tags["Relative.ErrorID"], bench.state) == (COMMAND | PROFILE, ERROR_STOP)
    assert bench.diary.fired == ["CMD-05", "PRF-01"]
    bench.go("Halt").scan()
    assert bench.tags["Halt.ErrorID"] == REFUSED
    bench.go("Reset").until("Reset", "Done")
    assert bench.state == STANDSTILL
    bench.drop("Relative").scan().go("Relative", Distance=500).until("Relative", "Done")


def test_a_limit_in_the_way_of_a_move():
    bench = BlocksBench.ready(machine={"cw_limit": (3_000, None)}).go("Move", Position=9_000)
    bench.until("Move", "Error")
    assert (bench.tags["Move.ErrorID"], bench.state, bench.position) == (INPUT, ERROR_STOP, 3_000)
    bench.go("Reset").until("Reset", "Done").go("Velocity", Velocity=-2_000).until("Velocity", "InVelocity")
    assert bench.run(1_000).position < 2_000  # a manual move leaves the limit


def test_a_reset_that_does_not_help_says_so():
    bench = BlocksBench.ready(machine={"estop": (1_000, None)}).go("Move", Position=9_000)
    bench.until("Move", "Error").go("Reset").until("Reset", "Done")
    bench.drop("Move", "Reset").scan().go("Relative", Distance=-5).until("Relative", "Error")
    assert bench.tags["Relative.ErrorID"] & INPUT


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("Move", {"Position": 8_388_608}),
        ("Move", {"Velocity": 1_000_001}),
        ("Move", {"Velocity": -1}),
        ("Relative", {"Distance": -8_388_608}),
        ("Velocity", {"Velocity": 0}),
        ("Velocity", {"Velocity": -1_000_001}),
        ("Home", {"Direction": 0}),
        ("Gear", {"RatioNumerator": 0, "RatioDenominator": 1}),
        ("Gear", {"RatioNumerator": 1, "RatioDenominator": -1}),
        ("Register", {"Distance": 0}),
        ("Blend", {"Segments": 17}),
        ("RunBlend", {"Direction": 2}),
        ("SetPosition", {"Position": -8_388_608}),
    ],
)
def test_parameters_that_would_not_fit_into_the_words(name, inputs):
    """They are refused before they are cut: a wrapped word could be a legal one."""
    bench = BlocksBench.ready().go(name, **inputs).scan()
    assert (bench.said(name), bench.tags[f"{name}.ErrorID"]) == ({"Error"}, PARAMETER)
    assert (bench.scan(20).diary.fired, bench.state) == ([], STANDSTILL)


def test_a_module_that_is_lost_ends_what_was_under_way():
    """Pulled out of the rack, it reads as zeros; back in, it has to be configured again."""
    bench = BlocksBench.ready().go("Move", Position=90_000).run(400)
    bench.module.inject(ModuleFault.REMOVED)
    bench.until("Move", "Error", scans=5)
    assert (bench.state, bench.tags["Move.ErrorID"] & LOST) == (DISABLED, LOST)


# -- two blocks on one axis

MOTIONS = {
    "Move": {"Position": 40_000},
    "Relative": {"Distance": 40_000},
    "Velocity": {},
    "Register": {"Distance": 3_000},
    "Gear": LEGAL["Gear"],
}


@pytest.mark.parametrize("second", [*MOTIONS, "Halt", "Stop"])
@pytest.mark.parametrize("first", MOTIONS)
def test_the_later_block_takes_the_axis(first, second):
    """Whatever was moving is brought to rest, and the module never sees a wrong command."""
    bench = BlocksBench.ready(config=configuration(add=ENCODER))
    bench.go(first, **MOTIONS[first]).run(500)
    assert bench.said(first) & {"Busy", "Active"} == {"Busy", "Active"}
    before = first if first != second else None
    if before is None:
        bench.drop(first).scan()
    bench.go(second, **MOTIONS.get(second, {})).scan(2)
    if before:
        assert bench.said(first) == {"CommandAborted"}
    if (first, second) == ("Register", "Move"):
        bench.until("Move", "Error")
        assert bench.tags["Move.ErrorID"] == NO_POSITION
    else:
        bench.until(second, "Active" if second in MOTIONS else "Done")
    lost = ["POS-02"] if first == "Register" else []  # what can't be held is stopped without a ramp
    assert bench.run(100).diary.fired == lost
