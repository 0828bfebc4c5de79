"""Shaft, switches and encoder, with numbers that can be done in the head."""

from __future__ import annotations

from fractions import Fraction

from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.machine import EncoderSpec, Jam, Machine, MachineSpec, Slip, Switch

HOME, CW_LIMIT, CCW_LIMIT = InputBit.HOME, InputBit.CW_LIMIT, InputBit.CCW_LIMIT


def moved(spec: MachineSpec, *travel: int, seed: int = 0) -> Machine:
    """Return a machine after motor steps, signed."""
    machine = Machine(spec, seed)
    for steps in travel:
        machine.follow(1 if steps > 0 else -1, abs(steps), 0)
    return machine


def test_without_obstacles_the_shaft_is_the_motor() -> None:
    machine = moved(MachineSpec(), 8_388_607, -10)
    assert machine.shaft == 8_388_597
    assert machine.steps_to_shaft(-1, 0) == 8_388_597


def test_a_target_behind_is_never_reached_and_one_underfoot_at_once() -> None:
    machine = moved(MachineSpec(), 50)
    assert machine.steps_to_shaft(1, 50) == machine.steps_to_shaft(-1, 50) == 0
    assert machine.steps_to_shaft(1, 49) is None
    assert machine.steps_to_shaft(-1, 51) is None


# --- slips: 7 steps lost where the motor sets out from 100


def test_a_slip_loses_its_steps_once() -> None:
    spec = MachineSpec(slips=(Slip(100, 7),))
    assert moved(spec, 100).shaft == 100
    assert moved(spec, 107).shaft == 100
    assert moved(spec, 108).shaft == 101
    assert moved(spec, 200, -200).shaft == -7
    assert Machine(spec).steps_to_shaft(1, 100) == 100  # the slip is on the way out, not on the way in
    assert Machine(spec).steps_to_shaft(1, 200) == 207


def test_a_slip_acts_in_its_direction_only() -> None:
    assert moved(MachineSpec(slips=(Slip(100, 7, direction=1),)), 200).shaft == 193
    assert moved(MachineSpec(slips=(Slip(100, 7, direction=-1),)), 200).shaft == 200
    assert moved(MachineSpec(slips=(Slip(100, 7, direction=-1),)), 200, -150).shaft == 57


def test_a_slip_can_happen_twice_and_no_more() -> None:
    spec = MachineSpec(slips=(Slip(100, 7, times=2),))
    assert moved(spec, 207, -107).shaft == 200 - 107 + 7  # there and back: both lose 7
    assert moved(spec, 207, -207, 200).shaft == 200


def test_a_slip_without_end_happens_every_time() -> None:
    # 5 ahead: 3 lost, the shaft comes to 2. 5 back: 2 to the place, 3 lost there.
    spec = MachineSpec(slips=(Slip(0, 3, times=None),))
    assert moved(spec, *[5, -5] * 100).shaft == 0
    assert moved(spec, *[5, -5] * 100, 5).shaft == 2


def test_reversing_ends_a_slip() -> None:
    spec = MachineSpec(slips=(Slip(100, 7, direction=1),))
    machine = moved(spec, 103, -1)  # three of the seven are lost; one step back is followed at once
    assert machine.shaft == 99
    assert moved(spec, 103, -1, 11).shaft == 110  # the rest of them is forgotten


def test_two_slips_at_one_place_add_up() -> None:
    assert moved(MachineSpec(slips=(Slip(100, 7), Slip(100, 5))), 200).shaft == 188


def test_pushing_against_a_jam_ends_a_slip_too() -> None:
    # at 100, 3 of 7 steps lost backward; 5 against the jam; then the slip begins anew: 7 lost, 3 followed
    spec = MachineSpec(slips=(Slip(100, 7, direction=-1, times=2),), jams=(Jam(100, 1),))
    assert moved(spec, 100, -3, 5, -10).shaft == 97


def test_chance_is_drawn_at_each_passage() -> None:
    machine, lost = Machine(MachineSpec(slips=(Slip(0, 1, direction=1, times=None, chance=0.25),)), seed=1), 0
    for _ in range(1000):
        machine.follow(1, 2, 0)
        lost += machine.shaft == 1
        machine.follow(-1, machine.shaft, 0)
    assert 200 < lost < 300  # 250 of 1000 are expected, standard deviation 14


def test_chance_is_seeded_and_foretold() -> None:
    spec = MachineSpec(slips=tuple(Slip(at, 1, chance=0.5) for at in range(1000)))
    machine = Machine(spec, seed=5)
    steps = machine.steps_to_shaft(1, 1000)
    assert steps is not None
    assert steps == Machine(spec, seed=5).steps_to_shaft(1, 1000)
    assert steps != Machine(spec, seed=6).steps_to_shaft(1, 1000)
    assert 1400 < steps < 1600  # 500 of 1000 are expected to slip, standard deviation 16
    machine.follow(1, steps, 0)
    assert machine.shaft == 1000


def test_chance_nought_never_happens() -> None:
    assert moved(MachineSpec(slips=(Slip(0, 9, chance=0, times=None),)), 100, -100, 50).shaft == 50


# --- jams


def test_a_jam_stops_the_shaft_in_one_direction() -> None:
    machine = moved(MachineSpec(jams=(Jam(500, 1),)), 800)
    assert machine.shaft == 500
    assert machine.steps_to_shaft(1, 501) is None
    machine.follow(-1, 20, 0)
    assert machine.shaft == 480


def test_a_jam_in_the_other_direction_is_not_felt() -> None:
    assert moved(MachineSpec(jams=(Jam(500, -1),)), 800).shaft == 800
    assert moved(MachineSpec(jams=(Jam(500, -1),)), 800, -800).shaft == 500


# --- switches


def test_switches_as_the_shaft_passes() -> None:
    spec = MachineSpec(
        switches=(
            Switch(HOME, 3000, 3500),
            Switch(CW_LIMIT, 9000, None, normally_closed=True),
            Switch(CCW_LIMIT, None, -1),
        )
    )
    machine = Machine(spec)
    assert machine.levels(0) == CW_LIMIT
    assert machine.steps_to_switch(-1) == 1
    for steps, levels in ((3000, CW_LIMIT | HOME), (501, CW_LIMIT), (5499, 0)):
        assert machine.steps_to_switch(1) == steps
        machine.follow(1, steps - 1, 0)
        before = machine.levels(0)
        machine.follow(1, 1, 0)
        assert before != machine.levels(0) == levels
    assert machine.steps_to_switch(1) is None
    assert machine.steps_to_switch(-1) == 1


def test_switches_that_overlap_on_one_input_show_one_range() -> None:
    spec = MachineSpec(switches=(Switch(HOME, 10, 20), Switch(HOME, 15, 30), Switch(HOME, 31, 40)))
    machine = moved(spec, 12)
    assert machine.levels(0) == HOME
    assert machine.steps_to_switch(1) == 29
    assert machine.steps_to_switch(-1) == 3


def test_normally_closed_switches_on_one_input_are_in_series() -> None:
    spec = MachineSpec(switches=(Switch(HOME, 10, 20, True), Switch(HOME, 30, 40, True)))
    levels = [moved(spec, at).levels(0) for at in (9, 15, 25, 35, 41)]
    assert levels == [HOME, 0, HOME, 0, HOME]


def test_a_switch_beyond_a_slip_comes_later_and_beyond_a_jam_never() -> None:
    home = Switch(HOME, 200, 300)
    assert Machine(MachineSpec(switches=(home,), slips=(Slip(100, 7),))).steps_to_switch(1) == 207
    assert Machine(MachineSpec(switches=(home,), jams=(Jam(199, 1),))).steps_to_switch(1) is None


# --- encoder


def test_counts_are_the_floor_of_the_ratio() -> None:
    spec = MachineSpec(encoder=EncoderSpec(Fraction(2, 5)))  # 1000 lines x4 on a motor of 10,000 steps
    assert [moved(spec, at).encoder_counts(0) for at in (-5, -1, 2, 3, 5)] == [-2, -1, 0, 1, 2]


def test_direction_turns_the_counts_around() -> None:
    spec = MachineSpec(encoder=EncoderSpec(Fraction(2, 5), direction=-1))
    assert [moved(spec, at).encoder_counts(0) for at in (-5, -1, 3, 5)] == [2, 1, -1, -2]


def test_without_an_encoder_only_the_hand_counts() -> None:
    machine = moved(MachineSpec(), 100)
    machine.turn_encoder(-8, 0, 0)
    assert machine.encoder_counts(0) == -8
    assert machine.steps_to_counts(1, -8, 0) == 0
    assert machine.steps_to_counts(1, 0, 0) is None
    assert machine.steps_to_marker(1) is None


def test_steps_to_counts_in_the_motors_sense() -> None:
    machine = moved(MachineSpec(encoder=EncoderSpec(Fraction(4))), 100)  # 400 counts
    assert machine.steps_to_counts(1, 1001, 0) == 151  # 250 steps are 1000 counts, 251 are 1004
    assert machine.steps_to_counts(-1, 0, 0) == 100
    assert machine.steps_to_counts(1, 300, 0) == 0
    machine.turn_encoder(600, 0, 0)
    assert machine.steps_to_counts(1, 1001, 0) == 1


def test_an_encoder_that_counts_the_other_way_never_gets_there() -> None:
    machine = Machine(MachineSpec(encoder=EncoderSpec(Fraction(4), direction=-1)))
    assert machine.steps_to_counts(1, 1000, 0) is None
    assert machine.steps_to_counts(1, -1000, 0) == 0


def test_a_marker_is_met_from_either_side_and_not_when_left() -> None:
    # 4 counts a step, 4000 counts a turn: the Z line is under the shaft at 0, 1000, 2000 ...
    machine = Machine(MachineSpec(encoder=EncoderSpec(Fraction(4), marker_every=4000)))
    assert machine.steps_to_marker(1) == 1000
    assert machine.steps_to_marker(-1) == 1000
    machine.follow(1, 1500, 0)
    assert machine.steps_to_marker(1) == machine.steps_to_marker(-1) == 500


def test_a_marker_between_two_steps_is_passed() -> None:
    # 5 counts a step, Z at 7, 107, ...: the second step goes from 5 to 10, back from 10 to 5
    spec = MachineSpec(encoder=EncoderSpec(Fraction(5), marker_every=100, marker_at=7))
    assert Machine(spec).steps_to_marker(1) == 2
    assert moved(spec, 2).steps_to_marker(-1) == 1
    assert moved(spec, 2).steps_to_marker(1) == 20  # 107 lies between the 21st and the 22nd step


def test_a_marker_with_a_coarse_encoder_and_counts_downward() -> None:
    # one count in 10 steps, downward; Z at -3: counts are -floor(shaft / 10), -3 from shaft 30 to 39
    spec = MachineSpec(encoder=EncoderSpec(Fraction(1, 10), -1, marker_every=50, marker_at=-3))
    assert Machine(spec).steps_to_marker(1) == 30
    assert moved(spec, 45).steps_to_marker(-1) == 6
