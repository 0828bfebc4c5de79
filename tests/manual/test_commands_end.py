"""Every command ends, in rungs and in Python: a lost link, an external input, a command that never arrives.

A lost link cuts a motion, as program mode does: rest, STOPPED, POSITION_INVALID [A-78, A-90]. The round trip
is 10 ms and two scans of 2 ms; a command that neither moves nor ends for two of them has come to nothing.
"""

import pytest
from axis_hand import Geared, Hand, OneAxis
from bench3601 import ENCODER, configuration
from blocks3601 import ERROR_STOP, STANDSTILL, BlocksBench
from scanrack import AxisError, Direction, ErrorId, State, sequence
from scanrack.io_images.amci3601 import BlendSegment, InputBit, Move, MoveKind, PresetPosition
from scanrack.io_images.image import Image
from scanrack.ladder.python.axis3601 import Command
from scanrack.ladder.python.axis3601.drive import Drive
from scanrack.ladder.python.axis3601.kinds import PRESET, RELATIVE
from scanrack.ladder.python.axis3601.link import Link
from scanrack.ladder.python.sequences.parts import Clock
from scanrack.runtime import ModuleFault
from sequence_bench import RATES, SLOW, SequenceBench

LINK, NOT_DONE = 512, 1024
MODULE_OK, COMMAND_ERROR, POSITION_INVALID = 0x4000, 0x1000, 0x0400
LEAST = 60
"""Scans in which a command has to have ended behind a lost link: four round trips and more."""

BLOCKS = {
    "Move": {"Position": 90_000},
    "Relative": {"Distance": -90_000},
    "Velocity": {},
    "Register": {"Distance": 3_000},
    "Gear": {"RatioNumerator": 1, "RatioDenominator": 1, "Acceleration": 0, "Deceleration": 0},
    "Home": {},
}

ASKS = {
    "Move": lambda axis: axis.move_to(90_000, **SLOW),
    "Relative": lambda axis: axis.move_by(-90_000, **SLOW),
    "Velocity": lambda axis: axis.run(5_000, **RATES),
    "Register": lambda axis: axis.run(5_000, register=3_000, **RATES),
    "Gear": lambda axis: axis.gear(1),
    "Home": lambda axis: axis.home(Direction.CW, **SLOW),
}

MACHINE = {"home": (90_000, 90_500), "external": (20_000, None)}


def lose(bench, scans):
    """Lose the link for so many scans."""
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.scan(scans)
    bench.module.inject(None)


def rungs(name=None, **options):
    """Return a bench at position 0, 400 ms into a motion."""
    bench = BlocksBench.ready(config=configuration(add=ENCODER), machine=MACHINE, **options)
    return bench if name is None else bench.go(name, **BLOCKS[name]).run(400)


def drive_on(inputs):
    """Return a drive on a module that shows these words whatever comes, and what lets scans pass."""
    clock, drive = Clock(), Drive(10_000_000)
    drive.attach(inputs, Image(), clock, Link())

    def scans(number):
        for _ in range(number):
            clock.now_ns += 2_000_000
            drive.judge(clock.now_ns)
            drive.send(clock.now_ns)

    return drive, scans


# -- a motion that the loss has cut


@pytest.mark.parametrize("told", [True, False], ids=["told", "untold"])
@pytest.mark.parametrize("name", BLOCKS)
def test_a_block_ends_behind_a_lost_link(name, told):
    """40 ms. A program that tells the axis of `I.Fault` gets the link and the instant, too."""
    bench = rungs(name, told=told)
    lost_ms = bench.cpu.now_ns // 1_000_000
    lose(bench, 20)
    assert bench.said(name) >= {"Busy"}
    bench.until(name, "Error", LEAST)
    assert bench.tags[f"{name}.ErrorID"] == NOT_DONE + LINK * told
    assert bench.tags["Axis.LostAt"] == (lost_ms if told else 0)
    assert bench.state == ERROR_STOP
    bench.drop(name).scan().go("Reset").until("Reset", "Done", LEAST)
    assert bench.drop("Reset").run(30).state == STANDSTILL
    assert bench.go("SetPosition", Position=0).until("SetPosition", "Done").drop("SetPosition").run(30)
    assert bench.go("Relative", Distance=100).until("Relative", "Done").position == 100


@pytest.mark.parametrize("name", ASKS)
def test_a_command_in_python_ends_behind_a_lost_link(name):
    hand = Hand.ready(Geared, switches=MACHINE)
    command = hand.ask(ASKS[name])
    hand.run(400)
    lost_ns = hand.bench.cpu.now_ns
    lose(hand.bench, 20)
    hand.bench.until(lambda: not command.busy, LEAST)
    assert (command.error, command.error_id) == (True, ErrorId.LINK_LOST | ErrorId.NOT_DONE)
    told = f"the link to slot 1 was lost at {lost_ns / 1e9:g} s and came back at {lost_ns / 1e9 + 0.04:g} s"
    with pytest.raises(AxisError, match=f"{told}; the status is STOPPED POSITION_INVALID MODULE_OK"):
        command.result()
    assert hand.axis.state is State.ERROR_STOP
    hand.does(lambda axis: axis.reset())
    hand.does(lambda axis: axis.set_position(0))
    hand.does(lambda axis: axis.move_by(100, **SLOW))
    assert hand.axis.position == 100


def test_a_blend_ends_behind_a_lost_link_and_its_programming_goes_on():
    hand = Hand.ready()
    segments = [BlendSegment(30_000, 5_000, 20), BlendSegment(2_200, 2_000, 10)]
    programming = hand.ask(lambda axis: axis.program_blend(segments, final_deceleration=10))
    lose(hand.bench, 20)
    hand.bench.until(lambda: programming.done)
    run = hand.ask(lambda axis: axis.run_blend(Direction.CW))
    hand.run(400)
    lose(hand.bench, 20)
    hand.bench.until(lambda: run.error, LEAST)
    assert run.error_id == ErrorId.LINK_LOST | ErrorId.NOT_DONE


def test_a_move_that_was_over_when_the_link_was_lost_is_done():
    hand = Hand.ready()
    move = hand.ask(lambda axis: axis.move_to(100, **SLOW))
    lose(hand.bench.until(lambda: hand.axis.status.MOVE_COMPLETE), 20)
    assert move.done


def test_a_motion_seen_behind_the_loss_has_begun_behind_it():
    """A registration has no completion bit: one that begins behind the loss ends well at rest."""
    hand = Hand.ready()
    hand.bench.module.inject(ModuleFault.LINK_LOST)
    run = hand.ask(lambda axis: axis.run(5_000, register=3_000, **RATES))
    lose(hand.bench, 20)
    run.register()
    hand.bench.until(lambda: not run.busy)
    assert (run.done, hand.axis.position >= 3_000) == (True, True)


@pytest.mark.parametrize("told", [True, False], ids=["told", "untold"])
def test_a_registration_without_a_valid_position_ends_well_at_rest(told):
    """Its position was invalid before, so that says nothing of its end."""
    bench = BlocksBench.configured(told=told).go("Register", Distance=3_000).run(400)
    bench.tags["Register.Register"] = True
    bench.until("Register", "Done")
    hand = Hand.configured()
    run = hand.ask(ASKS["Register"])
    hand.run(400)
    run.register()
    hand.bench.until(lambda: run.done)


def test_a_registration_that_the_loss_cut_is_not_done_even_without_a_valid_position():
    bench = BlocksBench.configured().go("Register", Distance=3_000).run(400)
    lose(bench, 20)
    bench.until("Register", "Error", LEAST)
    hand = Hand.configured()
    run = hand.ask(ASKS["Register"])
    lose(hand.run(400).bench, 20)
    hand.bench.until(lambda: run.error, LEAST)


def test_a_loss_before_the_motion_began_is_not_blamed_for_its_end():
    """The external input stops the motion: 1024 alone."""
    bench = BlocksBench.ready(machine={"external": (3_000, None)})
    bench.module.inject(ModuleFault.LINK_LOST)
    lose(bench.scan().go("Move", Position=90_000), 20)
    bench.until("Move", "Error")
    assert bench.tags["Move.ErrorID"] == NOT_DONE
    hand = Hand.ready(switches={"external": (3_000, None)}).run(40)
    hand.bench.module.inject(ModuleFault.LINK_LOST)
    move = hand.ask(ASKS["Move"])
    lose(hand.bench, 20)
    hand.bench.until(lambda: move.error)
    assert move.error_id == ErrorId.NOT_DONE


# -- a command that the loss hides


@pytest.mark.parametrize("scans", [3, 20, 500])
def test_a_command_during_the_loss_begins_behind_it(scans):
    """MOVE_COMPLETE of the move before is still on, and says nothing of this one."""
    bench = rungs().go("Move", Position=100).until("Move", "Done").drop("Move").run(30)
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.scan().go("Move", Position=2_000).scan(scans)
    assert (bench.said("Move"), bench.tags["Axis.LinkDown"]) == ({"Busy", "Active"}, True)
    bench.module.inject(None)
    assert bench.until("Move", "Done").position == 2_000

    hand = Hand.ready()
    hand.does(lambda axis: axis.move_to(100, **SLOW))
    hand.bench.module.inject(ModuleFault.LINK_LOST)
    move = hand.run(2).ask(lambda axis: axis.move_to(2_000, **SLOW))
    hand.bench.scan(scans)
    assert move.busy
    hand.bench.module.inject(None)
    hand.bench.until(lambda: not move.busy)
    assert (move.done, hand.axis.position) == (True, 2_000)


HIDDEN = {
    "Move": {"Position": 2_000},
    "Relative": {"Distance": 2_000},
    "Velocity": {},
    "Register": {"Distance": 3_000},
    "Gear": BLOCKS["Gear"],
    "SetPosition": {"Position": 5_000},
}


@pytest.mark.parametrize("name", HIDDEN)
def test_a_block_that_knows_nothing_of_the_link_does_not_lose_its_command_in_silence(name):
    """The command word is gone when the link is back; Done would be a lie."""
    bench = rungs(told=False).go("Move", Position=100).until("Move", "Done").drop("Move").run(30)
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.scan().go(name, **HIDDEN[name]).scan(LEAST)
    bench.module.inject(None)
    bench.scan(LEAST)
    assert (bench.said(name), bench.tags[f"{name}.ErrorID"], bench.position) == ({"Error"}, NOT_DONE, 100)


@pytest.mark.parametrize(("name", "inputs"), [("Move", {"Position": 100}), ("Relative", {"Distance": 0})])
def test_a_move_to_where_the_axis_is_needs_no_motion(name, inputs):
    bench = rungs().go("Move", Position=100).until("Move", "Done").drop("Move").run(30)
    assert bench.go(name, **inputs).until(name, "Done", LEAST).position == 100
    hand = Hand.ready()
    hand.does(lambda axis: axis.move_to(100, **SLOW))
    asks = {"Move": lambda axis: axis.move_to(100, **SLOW), "Relative": lambda axis: axis.move_by(0, **SLOW)}
    hand.does(asks[name], LEAST)


def test_a_move_that_no_scan_has_seen_is_done_where_it_ended():
    """5 steps within a scan of 100 ms, MOVE_COMPLETE in both: the position has changed."""
    bench = (
        BlocksBench.ready(scan_ms=100).go("Move", Position=100).until("Move", "Done").drop("Move").run(500)
    )
    assert bench.go("Relative", Distance=5).until("Relative", "Done", 10).position == 105
    hand = Hand.ready(scan_ms=100)
    hand.does(lambda axis: axis.move_to(100, **SLOW))
    hand.run(20).does(lambda axis: axis.move_by(5, **SLOW), 10)


def test_a_preset_that_did_not_arrive_is_not_done_where_the_axis_is():
    """Position 0, not valid: a preset to 0 shows in the bit alone."""
    bench = BlocksBench.configured(told=False)
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.go("SetPosition", Position=0).scan(LEAST)
    bench.module.inject(None)
    assert bench.scan(LEAST).tags["SetPosition.ErrorID"] == NOT_DONE
    drive, scans = drive_on(Image([MODULE_OK | POSITION_INVALID]))
    preset = Command("axis", PRESET, "preset")
    preset.set_words(PresetPosition(0).to_image())
    drive.request(preset)
    scans(LEAST)
    assert preset.error_id == ErrorId.NOT_DONE


@pytest.mark.parametrize("name", ["configure", "preset"])
def test_what_the_module_takes_at_rest_waits_for_the_link(name):
    hand = Hand.ready()
    hand.bench.module.inject(ModuleFault.LINK_LOST)
    asks = {"configure": lambda axis: axis.configure(), "preset": lambda axis: axis.set_position(77)}
    command = hand.run(2).ask(asks[name])
    hand.run(1_000)
    assert command.busy
    hand.bench.module.inject(None)
    hand.bench.until(lambda: not command.busy, LEAST)
    assert command.done
    assert (hand.axis.position == 77) is (name == "preset")


# -- what ends a motion otherwise, with a good link


@pytest.mark.parametrize("name", ["Move", "Relative", "Velocity"])
def test_the_external_input_ends_a_motion_for_good(name):
    """A held move goes on with Resume, which no block commands; a manual move is over."""
    bench = BlocksBench.ready(machine={"external": (1_000, None), "ccw_limit": (None, -9_000_000)})
    inputs = {"Distance": 90_000} if name == "Relative" else BLOCKS[name]
    bench.go(name, **inputs).until(name, "Error", 2_000)
    assert bench.tags[f"{name}.ErrorID"] == NOT_DONE
    assert bench.status.HOLD_STATE is (name != "Velocity")

    hand = Hand.ready(switches={"external": (1_000, None)})
    asks = {**ASKS, "Relative": lambda axis: axis.move_by(90_000, **SLOW)}
    command = hand.ask(asks[name])
    hand.bench.until(lambda: command.error, 2_000)
    assert command.error_id == ErrorId.NOT_DONE


def test_a_search_for_home_may_rest_on_an_end_limit():
    """Two seconds [chapter 4, Find Home]: home lies behind the axis, the limit 2000 ahead."""
    switches = {"cw_limit": (2_000, None), "home": (-1_500, -1_200)}
    hand = Hand.configured(switches=switches)
    home = hand.ask(lambda axis: axis.home(Direction.CW, speed=2_000, **RATES))
    hand.bench.until(lambda: not home.busy)
    assert home.done


def test_a_follower_may_rest_with_its_encoder():
    hand = Hand.ready(Geared)
    gear = hand.ask(lambda axis: axis.gear(1))
    hand.run(3_000)
    assert (gear.busy, gear.in_gear) == (True, True)


def test_program_mode_ends_a_block():
    """The axis of a program in rungs outlives program mode, its motion does not."""
    from scanrack.runtime.loop.scan import CpuMode

    bench = rungs("Move")
    bench.cpu.mode = CpuMode.PROGRAM
    bench.scan(5)
    bench.cpu.mode = CpuMode.RUN
    bench.until("Move", "Error", LEAST)
    assert bench.tags["Move.ErrorID"] & ~LINK == NOT_DONE


def test_an_error_that_no_reset_clears_does_not_hold_up_the_next_command():
    """A Hold at the very end of a move is a Command Error. This module shows it whatever comes."""
    inputs = Image([MODULE_OK])
    drive, scans = drive_on(inputs)
    first, second = (Command("axis", RELATIVE, each) for each in ("first", "second"))
    for command, status in ((first, MODULE_OK | 1), (second, MODULE_OK | COMMAND_ERROR)):
        command.set_words(Move(MoveKind.RELATIVE, 10, 5_000, 10, 10).to_image())
        drive.request(command)
        scans(10)
        inputs[0] = status
        scans(10)
    scans(LEAST)
    assert (first.aborted, second.error, second.error_id) == (True, True, ErrorId.COMMAND_ERROR)


# -- what the wait says


class Waits(OneAxis):
    @sequence
    async def cycle(self):
        await self.axis.configure()
        await self.axis.set_position(0)
        await self.axis.move_to(90_000, **SLOW)


def test_the_wait_names_the_link_while_it_is_lost():
    bench = SequenceBench(Waits).scan(300)
    cycle = bench.sequences[0]
    before = cycle.resumed
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.scan(10)
    assert (cycle.waits_for, cycle.resumed) == (
        "axis.move_to(90000) (the link to slot 1 was lost at 0.6 s)",
        before + 1,
    )
    bench.module.inject(None)
    bench.scan(1)
    assert (cycle.waits_for, cycle.resumed) == ("axis.move_to(90000)", before + 2)


def test_so_does_a_wait_for_the_capture_input():
    class Probes(OneAxis):
        @sequence
        async def cycle(self):
            await self.axis.configure()
            await self.axis.captured()

    bench = SequenceBench(Probes).scan(100)
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.scan()
    assert bench.sequences[0].waits_for == "axis.captured() (the link to slot 1 was lost at 0.2 s)"


def test_the_power_that_fails_is_no_lost_link():
    bench = rungs("Move")
    bench.module.power_cycle()
    bench.until("Move", "Error", 5)
    assert bench.tags["Move.ErrorID"] == 16
    assert bench.module.machine.levels(bench.cpu.now_ns) & InputBit.ESTOP.value == 0
