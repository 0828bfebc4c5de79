"""The axis in Python on a networked drive: commands, errors, declarations, and what ends a wait."""

from typing import Any

import pytest
from bench3601 import CONFIGURATION
from drive_bench import BINARY_LOW, CAPTURE, ESTOP, HOME, STOP_JOG, LinkedDrive, drive_words
from scanrack import (
    Axis3601,
    AxisError,
    Configuration,
    Direction,
    ErrorId,
    Logic,
    State,
    WaitTimeout,
    sequence,
    within,
)
from scanrack.io_images.amci3601 import Acceleration, BlendSegment, InputBit
from scanrack.io_images.image import Image
from scanrack.runtime import Amci3601, Card, Cpu, Rack
from scanrack.runtime.machine import Machine, MachineSpec, Switch

RATES: Any = {"acceleration": 20, "deceleration": 10}
SLOW: Any = {"speed": 5_000, **RATES}
SEGMENTS = [BlendSegment(3_000, 5_000, 20), BlendSegment(2_200, 2_000, 10)]
SETUP = Configuration.from_image(Image(CONFIGURATION))


class DriveHand:
    """An axis on a drive in the hand of a test: configured, position 0."""

    def __init__(self, model="smd23e2", inputs=(HOME, ESTOP), format=0, home=(-2_300, -2_000)):
        words = drive_words(model, inputs=inputs, format=format)

        class OneAxis(Logic):
            axis = Axis3601(1, words)

            def __init__(self) -> None:
                self.ask = self.command = None

            def every_scan(self) -> None:
                ask, self.ask = self.ask, None
                if ask is not None:
                    self.command = ask(self.axis)

        machine = Machine(MachineSpec(switches=(Switch(InputBit.HOME, *home),)))
        self.drive = LinkedDrive(model, machine, inputs)
        self.logic = OneAxis()
        rack = Rack([Card(1, self.drive, model, words=self.drive.model.words)])
        self.cpu = Cpu(rack, self.logic, 10_000_000)
        self.axis = self.logic.axis
        self.cpu.run(1)
        self.does(lambda axis: axis.configure())
        self.does(lambda axis: axis.set_position(0))

    def ask(self, ask):
        self.logic.ask = ask
        self.cpu.run(1)
        return self.logic.command

    def until(self, condition, scans=2_000):
        for _ in range(scans):
            if condition():
                return self
            self.cpu.run(1)
        raise AssertionError(f"never: {self.axis.state!r}, {self.axis.status!r}")

    def does(self, ask):
        command = self.ask(ask)
        self.until(lambda: not command.busy)
        command.result()
        return command

    def press(self, on):
        self.drive.machine.set_input(InputBit.ESTOP, on)
        self.drive.look_again()


def test_status_and_position_have_the_names_and_the_format_of_the_drive():
    hand = DriveHand(format=BINARY_LOW)
    hand.does(lambda axis: axis.move_to(-70_000, speed=300_000, acceleration=4_000, deceleration=4_000))
    assert hand.axis.position == -70_000
    assert (hand.axis.status.STOPPED, hand.axis.status.MOVE_COMPLETE) == (True, True)
    assert "DRIVE_ENABLED" in repr(hand.axis.status)
    with pytest.raises(
        AttributeError, match="IN_ESTOP is not a status bit of the SMD23E2; choose from MOVING_CW"
    ):
        _ = hand.axis.status.IN_ESTOP


@pytest.mark.parametrize(("shape", "jerk"), [(Acceleration.TRIANGULAR, 250), (Acceleration.TRAPEZOIDAL, 750)])
def test_an_s_curve_is_a_jerk(shape, jerk):
    """4000 steps/s at 10 steps/ms/s take 0.4 s; the rate rises in all of it, or a third: 100 / 0.4 = 250."""
    hand = DriveHand()
    hand.ask(lambda axis: axis.move_to(30_000, **SLOW, shape=shape))
    hand.until(lambda: hand.axis.moving)
    assert hand.drive.words[9] == jerk


def test_a_blend_runs_both_ways():
    hand = DriveHand()
    hand.does(lambda axis: axis.program_blend(SEGMENTS, final_deceleration=10))
    hand.does(lambda axis: axis.run_blend(Direction.CW))
    assert hand.axis.position == 5_200
    hand.does(lambda axis: axis.run_blend(Direction.CCW))
    assert hand.axis.position == 0


def test_a_registration_move_ends_behind_its_input():
    """The minimum distance, 400 steps, is over; the input comes between two scans."""
    hand = DriveHand(inputs=(HOME, STOP_JOG))
    hand.does(lambda axis: axis.store_minimum(400))
    run = hand.ask(lambda axis: axis.run(2_500, **RATES, register=1_500))
    hand.until(lambda: hand.axis.position > 3_000)
    before = hand.axis.position
    hand.drive.machine.set_input(InputBit.EXTERNAL, True)
    hand.drive.look_again()
    hand.until(lambda: not run.busy)
    assert run.done
    assert before + 1_500 <= hand.axis.position <= before + 1_500 + 25
    assert hand.drive.words[8:10] == (0, 400)


def test_the_capture_input_is_the_one_of_the_configuration():
    hand = DriveHand(inputs=(HOME, CAPTURE))
    wait = hand.axis.captured()
    wait.begin(0)
    hand.drive.machine.set_input(InputBit.CAPTURE, True)
    hand.drive.look_again()
    hand.until(lambda: wait.poll(0), 5)


@pytest.mark.parametrize(
    ("model", "ask", "text"),
    [
        ("smd23e2", lambda axis: axis.gear(1), "the SMD23E2 can't follow an encoder"),
        (
            "anf2",
            lambda axis: axis.move_by(5, **SLOW, shape=Acceleration.TRIANGULAR),
            "the ANF2 has no S-curve",
        ),
        (
            "anf2",
            lambda axis: axis.run(2_000, **RATES, register=9),
            "registration moves of the ANF2 are not supported",
        ),
        ("anf2", lambda axis: axis.run_blend(Direction.CW), "blends of the ANF2 are not supported"),
        (
            "smd23e2",
            lambda axis: axis.program_blend(SEGMENTS, final_deceleration=20),
            "a drive's last segment has one rate",
        ),
        (
            "smd23e2",
            lambda axis: axis.program_blend(
                SEGMENTS, final_deceleration=10, final_shape=Acceleration.TRIANGULAR
            ),
            "a drive's blend has no S-curve",
        ),
    ],
)
def test_what_a_drive_lacks_is_refused_before_anything_is_sent(model, ask, text):
    hand = DriveHand(model)
    command = hand.ask(ask)
    assert command.error_id is ErrorId.NOT_AVAILABLE
    assert text in command.detail
    assert hand.drive.words[0] == 0


def test_an_emergency_stop_is_an_input_error_as_on_a_3601():
    hand = DriveHand()
    move = hand.ask(lambda axis: axis.move_to(9_000, **SLOW))
    hand.until(lambda: hand.axis.position > 2_000)
    hand.press(True)
    hand.until(lambda: not move.busy, 5)
    assert move.error_id is ErrorId.INPUT_ERROR
    assert (hand.axis.state, hand.axis.status.POSITION_INVALID) == (State.ERROR_STOP, True)
    hand.press(False)
    hand.does(lambda axis: axis.reset())
    assert hand.ask(lambda axis: axis.move_to(0, **SLOW)).error_id is ErrorId.POSITION_INVALID


def test_an_input_error_at_rest_is_reset_before_the_next_move():
    """A drive keeps it until Reset Errors [17 p. 82]; the next move of a 3601 clears it."""
    hand = DriveHand()
    hand.press(True)
    hand.cpu.run(2)
    hand.press(False)
    hand.cpu.run(2)
    assert hand.axis.status.INPUT_ERROR
    hand.does(lambda axis: axis.move_to(500, **SLOW))
    assert hand.axis.position == 500
    assert not hand.axis.status.INPUT_ERROR


@pytest.mark.parametrize(
    "happen",
    [LinkedDrive.lose_connection, LinkedDrive.stall, lambda drive: drive.set_driver_fault(True)],
    ids=["not enabled", "stall", "driver fault"],
)
def test_a_drive_that_does_not_move_any_more_ends_the_command(happen):
    hand = DriveHand()
    hand.drive.layer.state.configuration = configured_for_stalls(hand)
    move = hand.ask(lambda axis: axis.move_to(9_000, **SLOW))
    hand.until(lambda: hand.axis.position > 2_000)
    happen(hand.drive)
    hand.until(lambda: not move.busy, 5)
    assert move.error_id & ErrorId.DRIVE_FAULT
    assert hand.axis.state is State.ERROR_STOP


def configured_for_stalls(hand):
    """Return the drive's configuration with stall detection, which needs an encoder on the shaft."""
    from dataclasses import replace

    return replace(hand.drive.layer.state.configuration, stall_detection=True)


def test_a_refused_new_speed_is_an_error_as_on_a_3601():
    """INVALID_JOG_CHANGE, where a 3601 has INVALID_PROFILE [17 p. 84]: 5 steps/s are too slow."""
    hand = DriveHand()
    run = hand.ask(lambda axis: axis.run(3_000, **RATES))
    hand.until(lambda: run.in_velocity)
    slower = hand.ask(lambda axis: axis.run(5, **RATES))
    hand.until(lambda: not slower.busy, 10)
    assert slower.error_id is ErrorId.INVALID_PROFILE
    hand.until(lambda: not hand.axis.moving)
    hand.does(lambda axis: axis.reset())
    assert "INVALID_JOG_CHANGE" not in repr(hand.axis.status)


def rack_of(axis, module=None):
    class OneAxis(Logic):
        pass

    setattr(OneAxis, "axis", axis)  # noqa: B010 - declared by its own name
    axis.__set_name__(OneAxis, "axis")
    drive = LinkedDrive("smd23e2", Machine(MachineSpec()))
    card = Card(1, drive, words=drive.model.words) if module is None else Card(1, module)
    return Cpu(Rack([card]), OneAxis(), 2_000_000)


@pytest.mark.parametrize(
    ("axis", "module", "text"),
    [
        (Axis3601(1, SETUP), None, "slot 1, SMD23E2: its configuration must be 10 words, not a 3601"),
        (
            Axis3601(1, (0x8007, 3, 1, 0, 20, 0, 0, 50, 28, 0)),
            None,
            r"configuration: The motor steps per turn are outside their range. \[CFG-04, EDS Param4\]",
        ),
        (
            Axis3601(1, drive_words("smd23e2")),
            Amci3601(),
            "its configuration must be a Configuration, not ten words",
        ),
    ],
)
def test_a_configuration_that_the_module_can_not_have_names_the_axis(axis, module, text):
    with pytest.raises(ValueError, match=text):
        rack_of(axis, module).run(1)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ((7, 0, 1, 0, 2_000, 0, 0, 50, 28, 0), r"word 0 is 0007h; bit 15 \(configuration mode\)"),
        (
            (0x8007, 1),
            r"configuration \(32775, 1\) is not a Configuration; for a networked drive, pass 10 words",
        ),
        ((0x8007, 0, 1, 0, 2_000, 0, 0, 50, 28, 70_000), "is not a Configuration; for a networked drive"),
    ],
)
def test_words_that_are_no_configuration_are_refused(given, text):
    with pytest.raises(ValueError, match=text):
        Axis3601(1, given)


class Cycle(Logic):
    """A sequence on a drive: what happens at its await."""

    axis = Axis3601(1, drive_words("smd23e2"))

    def __init__(self) -> None:
        self.told: list[str] = []

    @sequence
    async def cycle(self) -> None:
        try:
            await self.axis.configure()
            await self.axis.home(Direction.CCW, speed=2_000, **RATES)
            self.told.append(f"home {self.axis.position}")
            try:
                await within("500 ms", self.axis.move_to(9_000, **SLOW))
            except WaitTimeout:
                await self.axis.halt()
                self.told.append("halted")
            await self.axis.move_to(0, **SLOW)
            self.told.append(f"back {self.axis.position}")
            await self.axis.move_to(9_000, **SLOW)
        except AxisError as error:
            self.told.append(str(error))
            await self.axis.reset()
        finally:
            await self.axis.halt()
            self.told.append("over")


def played(until):
    """Play the cycle up to a condition; return logic, drive and CPU."""
    drive = LinkedDrive("smd23e2", Machine(MachineSpec(switches=(Switch(InputBit.HOME, -2_300, -2_000),))))
    cycle = Cycle()
    cpu = Cpu(Rack([Card(1, drive, words=drive.model.words)]), cycle, 10_000_000)
    for _ in range(2_000):
        if until(cycle):
            break
        cpu.run(1)
    assert cpu.fault is None
    return cycle, drive, cpu


def test_a_timeout_halts_and_the_sequence_goes_on():
    cycle, _, _ = played(lambda cycle: len(cycle.told) == 3)
    assert cycle.told == ["home 0", "halted", "back 0"]


def test_an_error_ends_at_its_await():
    cycle, drive, cpu = played(lambda cycle: len(cycle.told) == 3 and cycle.axis.position > 1_000)
    drive.machine.set_input(InputBit.ESTOP, True)
    drive.look_again()
    cpu.run(60)
    assert cycle.told[3:] == ["axis.move_to(9000): the module reports INPUT_ERROR [ErrorID 8]", "over"]
    assert cycle.axis.state is State.STANDSTILL


def test_an_abort_cancels_the_wait_and_restart_begins_again():
    cycle, _, cpu = played(lambda cycle: len(cycle.told) == 3 and cycle.axis.position > 1_000)
    control: Any = cycle.cycle
    control.restart()
    cpu.run(400)
    assert cycle.told[3:5] == ["over", "home 0"]
