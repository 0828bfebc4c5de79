"""The axis: each command from call to end, what refuses it, and what its extras say.

Starting speed 1000, speed 5000, rates 20 up and 10 down: 0.2 s and 600 steps up, 0.4 s and 1200 steps down.
"""

import pytest
from axis_hand import Geared, Hand, OneAxis, configured
from bench3601 import BACKPLANE_PROXIMITY
from scanrack import Axis3601, AxisError, CommandAborted, Direction, ErrorId, State, dwell, sequence, until
from scanrack.io_images.amci3601 import Acceleration, BlendSegment, InputBit
from scanrack.ladder.files.rungreader import load_library
from scanrack.ladder.python.axis3601 import kinds
from sequence_bench import RATES, SETUP, SLOW

SEGMENTS = [BlendSegment(3_000, 5_000, 20), BlendSegment(2_200, 2_000, 10)]


def test_states_from_power_up_on():
    hand = Hand()
    hand.bench.scan()
    assert hand.axis.state is State.DISABLED
    hand.does(lambda axis: axis.configure())
    assert (hand.axis.state, hand.axis.status.POSITION_INVALID) == (State.STANDSTILL, True)
    hand.does(lambda axis: axis.set_position(-1_234_567))
    assert (hand.axis.position, hand.axis.status.POSITION_INVALID) == (-1_234_567, False)


@pytest.mark.parametrize("shape", Acceleration)
def test_moves_there_and_back(shape):
    hand = Hand.ready()
    hand.does(lambda axis: axis.move_to(12_345, **SLOW, shape=shape))
    assert hand.axis.position == 12_345
    hand.does(lambda axis: axis.move_by(-345, **SLOW))
    assert hand.axis.position == 12_000


@pytest.mark.parametrize("way", Direction)
def test_home(way):
    """The home switch is at 2000 to 2300 either way; home is at its near end."""
    ends = (2_000, 2_300) if way is Direction.CW else (-2_300, -2_000)
    hand = Hand.configured(switches={"home": ends, "cw_limit": (9_000, None), "ccw_limit": (None, -9_000)})
    command = hand.ask(lambda axis: axis.home(way, speed=2_000, **RATES))
    assert hand.run(100).axis.state is State.HOMING
    hand.bench.until(lambda: command.done)
    assert (hand.axis.position, hand.axis.status.AT_HOME) == (0, True)


def test_the_proximity_follows_the_program_while_home_is_searched():
    """Word 1, bit 12; with its rise the module slows down to the starting speed [chapter 4]."""

    class Near(OneAxis):
        axis = Axis3601(1, configured(BACKPLANE_PROXIMITY))

    hand = Hand.configured(Near, switches={"home": (9_000, 9_300), "cw_limit": (20_000, None)})
    hand.ask(
        lambda axis: axis.home(Direction.CW, speed=5_000, **RATES, proximity=lambda: axis.position > 3_000)
    )
    seen = set()
    for _ in range(1_000):
        hand.bench.scan()
        seen.add((hand.axis.position > 3_000, bool(hand.bench.words[1] & 0x1000)))
    assert seen == {(False, False), (True, True)}
    assert hand.axis.state is State.HOMING


def test_a_velocity_is_reached_after_its_ramp():
    """5000 steps/s after 200 ms; and the words take a scan each way."""
    hand = Hand.ready().run(40)
    run = hand.ask(lambda axis: axis.run(-5_000, **RATES))
    began = hand.bench.cpu.now_ns
    hand.bench.until(lambda: run.in_velocity)
    assert 200 <= (hand.bench.cpu.now_ns - began) / 1e6 <= 210
    assert (run.active, hand.axis.state) == (True, State.CONTINUOUS_MOTION)
    slower = hand.ask(lambda axis: axis.run(-3_000, **RATES))
    assert (run.aborted, run.in_velocity, slower.in_velocity) == (True, False, False)
    hand.bench.until(lambda: slower.in_velocity)
    with pytest.raises(CommandAborted, match=r"axis\.run\(-5000\): another command has taken the axis"):
        run.result()


def test_registration_goes_its_distance_after_the_input():
    hand = Hand.ready()
    run = hand.ask(lambda axis: axis.run(5_000, register=3_000, **RATES))
    hand.run(800)
    here = hand.axis.position
    run.register()
    hand.bench.until(lambda: run.done)
    assert 0 <= hand.axis.position - here - 3_000 <= 10  # the scan in between, at 5000/s


def test_a_registration_input_before_the_minimum_is_ignored():
    """Minimum 4000: the input at 2000 counts for nothing, `register` at 5000 or more does."""
    hand = Hand.ready(switches={"external": (2_000, 2_200)})
    hand.does(lambda axis: axis.store_minimum(4_000))
    assert hand.axis.status.MIN_REG_NONZERO
    run = hand.ask(lambda axis: axis.run(5_000, register=3_000, **RATES))
    hand.bench.until(lambda: hand.axis.position > 6_000)
    assert run.busy
    run.register()
    hand.bench.until(lambda: run.done)
    assert 9_000 <= hand.axis.position <= 9_050


@pytest.mark.parametrize(("numerator", "moved"), [(3, 300), (-3, -300)])
def test_gear_follows_the_encoder_until_gear_out(numerator, moved):
    """200 counts at 3:2 are 300 steps."""
    hand = Hand.ready(Geared)
    gear = hand.ask(lambda axis: axis.gear(numerator, 2))
    hand.bench.until(lambda: gear.in_gear)
    assert hand.axis.state is State.SYNCHRONIZED_MOTION
    now = hand.bench.cpu.now_ns
    hand.bench.module.machine.turn_encoder(200, now, now + 100_000_000)
    assert hand.run(200).axis.position == moved
    hand.does(lambda axis: axis.gear_out())
    assert (gear.aborted, hand.axis.state) == (True, State.STANDSTILL)
    hand.bench.module.machine.turn_encoder(200, hand.bench.cpu.now_ns, hand.bench.cpu.now_ns + 100_000_000)
    assert hand.run(200).axis.position == moved


def test_gear_out_is_refused_where_nothing_follows():
    command = Hand.ready().ask(lambda axis: axis.gear_out())
    assert (command.error, command.error_id) == (True, ErrorId.WRONG_STATE)


@pytest.mark.parametrize("way", Direction)
def test_a_blend_is_programmed_and_run(way):
    hand = Hand.ready()
    hand.does(lambda axis: axis.program_blend(SEGMENTS, final_deceleration=10))
    hand.does(lambda axis: axis.run_blend(way))
    assert hand.axis.position == way * 5_200


@pytest.mark.slow
def test_sixteen_segments_with_their_shapes():
    segments = [BlendSegment(1_500, 1_100 + 100 * number, 20) for number in range(16)]
    shapes = [Acceleration.TRIANGULAR] * 8 + [Acceleration.TRAPEZOIDAL] * 8
    hand = Hand.ready()
    hand.does(lambda axis: axis.program_blend(segments, final_deceleration=10, shapes=shapes))
    hand.does(lambda axis: axis.run_blend(Direction.CW))
    assert hand.axis.position == 16 * 1_500


def test_halt_brings_to_rest_with_the_ramp():
    hand = Hand.ready()
    move = hand.ask(lambda axis: axis.move_to(90_000, **SLOW))
    here = hand.run(600).axis.position
    hand.does(lambda axis: axis.halt())
    assert 1_200 <= hand.axis.position - here <= 1_200 + 5_000 * 0.006
    assert (move.aborted, hand.axis.state) == (True, State.STANDSTILL)


class Stopping(OneAxis):
    """Stops, and keeps the axis for 100 ms."""

    def __init__(self):
        super().__init__()
        self.wanted = False

    @sequence
    async def stopping(self):
        await until(lambda: self.wanted)
        with self.axis.stop() as stop:
            await stop
            await dwell("100 ms")


def test_stop_keeps_the_axis_for_the_length_of_its_with():
    hand = Hand.ready(Stopping)
    run = hand.ask(lambda axis: axis.run(5_000, **RATES))
    hand.run(600)
    hand.bench.logic.wanted = True
    hand.bench.scan()
    assert (run.aborted, hand.axis.state) == (True, State.STOPPING)
    refused = hand.ask(lambda axis: axis.move_by(5, **SLOW))
    assert (refused.error, refused.error_id) == (True, ErrorId.WRONG_STATE)
    hand.bench.until(lambda: hand.bench.logic.stopping.waits_for == "dwell 100 ms")
    assert hand.axis.state is State.STOPPING
    assert hand.ask(lambda axis: axis.halt()).error
    hand.bench.until(lambda: hand.bench.logic.stopping.over)
    assert hand.axis.state is State.STANDSTILL
    hand.does(lambda axis: axis.move_by(5, **SLOW))


def test_a_stop_without_a_with_keeps_the_axis_until_rest():
    hand = Hand.ready()
    hand.ask(lambda axis: axis.run(5_000, **RATES))
    hand.run(600)
    hand.does(lambda axis: axis.stop())
    assert hand.axis.state is State.STANDSTILL


# -- touch probe


class Probing(OneAxis):
    axis = Axis3601(1, configured(1))

    def __init__(self):
        super().__init__()
        self.found = []

    @sequence
    async def probe(self):
        await until(lambda: self.axis.state == State.STANDSTILL)
        while True:
            self.found.append(await self.axis.captured())


def test_the_probe_records_where_the_input_came():
    """The capture switch is at 1500; the axis runs over it twice, and into it from either side."""
    hand = Hand.ready(Probing, switches={"capture": (1_500, 1_700)})
    hand.does(lambda axis: axis.move_to(4_000, **SLOW))
    assert hand.bench.logic.found == [1_500]
    hand.does(lambda axis: axis.move_to(0, **SLOW))
    assert hand.bench.logic.found == [1_500, 1_700]


def test_the_probe_of_a_lost_axis_raises():
    class Caught(Probing):
        said = None

        @sequence
        async def probe(self):
            await until(lambda: self.axis.state == State.STANDSTILL)
            try:
                await self.axis.captured()
            except AxisError as error:
                self.said = error.id

    hand = Hand.ready(Caught)
    hand.bench.module.power_cycle()
    hand.bench.scan(3)
    assert hand.bench.logic.said is ErrorId.WRONG_STATE


# -- errors


def test_an_illegal_profile_is_the_modules_error_and_reset_ends_it():
    """Speed below starting speed: CMD-05 and PRF-01, so Command Error and Invalid Profile."""
    hand = Hand.ready()
    with pytest.raises(AxisError, match="INVALID_PROFILE") as caught:
        hand.does(lambda axis: axis.move_by(500, speed=10, **RATES))
    assert caught.value.id == ErrorId.COMMAND_ERROR | ErrorId.INVALID_PROFILE
    assert hand.axis.state is State.ERROR_STOP
    assert hand.ask(lambda axis: axis.halt()).error_id == ErrorId.WRONG_STATE
    hand.does(lambda axis: axis.reset())
    hand.does(lambda axis: axis.move_by(500, **SLOW))


def test_a_limit_in_the_way():
    hand = Hand.ready(switches={"cw_limit": (3_000, None)})
    with pytest.raises(AxisError, match="INPUT_ERROR"):
        hand.does(lambda axis: axis.move_to(9_000, **SLOW))
    assert (hand.axis.state, hand.axis.position) == (State.ERROR_STOP, 3_000)


def test_an_absolute_move_needs_a_position():
    command = Hand.configured().ask(lambda axis: axis.move_to(5, **SLOW))
    assert command.error_id == ErrorId.POSITION_INVALID


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda axis: axis.move_to(8_388_608, **SLOW), "target position 8388608 is out of range"),
        (lambda axis: axis.move_to(5, speed=1_000_001, **RATES), "speed 1000001 is out of range"),
        (lambda axis: axis.move_by(5, speed=0, **RATES), "speed 0 is out of range"),
        (lambda axis: axis.move_by("5", **SLOW), "target position '5' is not allowed"),
        (lambda axis: axis.run(0, **RATES), "speed is 0; must not be 0"),
        (lambda axis: axis.run(-1_000_001, **RATES), "speed -1000001 is out of range"),
        (lambda axis: axis.run(500, register=0, **RATES), "registration distance is 0; must be 1 to 8388607"),
        (lambda axis: axis.home(1, speed=500, **RATES), "direction 1 is not allowed"),
        (lambda axis: axis.gear(0), "multiplier 0 is out of range"),
        (lambda axis: axis.gear(1, -1), "divisor -1 is out of range"),
        (lambda axis: axis.run_blend(2), "direction 2 is not allowed"),
        (lambda axis: axis.set_position(-8_388_609), "out of range"),
        (lambda axis: axis.store_minimum(-1), "out of range"),
        (lambda axis: axis.program_blend(SEGMENTS[:1], final_deceleration=10), "segments 1 is out of range"),
        (
            lambda axis: axis.program_blend(
                SEGMENTS, final_deceleration=10, shapes=[Acceleration.CONSTANT] * 3
            ),
            "the header is for 3 segments, not 2",
        ),
    ],
)
def test_parameters_that_no_word_can_carry_are_refused(ask, says):
    hand = Hand.ready()
    command = hand.ask(ask)
    assert command.error_id == ErrorId.PARAMETER
    with pytest.raises(AxisError, match=says):
        command.result()
    assert hand.run(40).axis.state is State.STANDSTILL
    assert hand.bench.words == [0] * 8


def test_an_error_names_the_call_the_reason_and_the_number():
    command = Hand().ask(lambda axis: axis.set_position(5))
    with pytest.raises(AxisError) as caught:
        command.result()
    assert str(caught.value) == (
        "axis.set_position(5): the state of the axis does not allow it [ErrorID 64]: state DISABLED"
    )


def test_a_command_keeps_its_outcome():
    hand = Hand.ready()
    first = hand.does(lambda axis: axis.move_by(5, **SLOW))
    hand.ask(lambda axis: axis.move_by(5, **SLOW))
    assert (first.done, first.busy, first.active, first.aborted, first.error) == (
        True,
        False,
        False,
        False,
        False,
    )


@pytest.mark.parametrize(
    ("slot", "configuration", "round_trip_ms"),
    [(0, SETUP, 10), ("1", SETUP, 10), (1, None, 10), (1, SETUP, -1)],
)
def test_what_an_axis_can_not_be(slot, configuration, round_trip_ms):
    with pytest.raises(ValueError, match=r"slot|configuration|round_trip_ms"):
        Axis3601(slot, configuration, round_trip_ms=round_trip_ms)


def test_a_round_trip_is_ten_ms_at_least():
    assert Axis3601(1, SETUP, round_trip_ms=3).round_trip_ms == 10


def test_an_estop_at_rest_is_no_error():
    """The module reports INPUT_ERROR only for a motion [chapter 6]."""
    hand = Hand.ready(switches={})
    hand.bench.module.machine.set_input(InputBit.ESTOP, True)
    hand.bench.module.look_again()
    hand.run(20)
    assert (hand.axis.status.IN_ESTOP, hand.axis.state) == (True, State.STANDSTILL)


def test_each_kind_is_a_block_of_the_rung_library():
    """But for MC_GearOut, which is MC_Halt of an axis that follows."""
    blocks = {each.block.upper() for each in vars(kinds).values() if isinstance(each, kinds.CommandKind)}
    library = load_library("axis3601").add_ons
    assert blocks - library.keys() == {"MC_GEAROUT"}
    helpers = {"AMCI3601", "REQUEST3601", "PROFILE3601", "MC_TOUCHPROBE"}
    assert library.keys() - blocks == helpers
