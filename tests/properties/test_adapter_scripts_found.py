"""Scripts that long random runs of `test_adapters_against_oracle` have found, cut down to what matters."""

from __future__ import annotations

import oracle_bits as bits
import pytest
from adapter_scripts import LIMITS, PLAIN, WITH_CAPTURE, WITH_ENCODER, pcl601_setting
from adapter_steps import PutRight
from lockstep_adapters import played
from oracle_bits import CW_LIMIT, HOME
from steps3601 import NOTHING, Alter, Input, Out, ToRest

RESTART = {"respeed": "restart"}
HOME_SWITCH = ((HOME, 300, 350),)


def manual(command, speed, rates, ticks, steps=0):
    """A manual move, or a registration move over so many steps."""
    return Out((command, 0, 0, steps, *divmod(speed, 1000), *rates), ticks)


def speed(value, rates, ticks):
    """Another speed, and other rates, in the same manual move."""
    pairs = zip((4, 5, 6, 7), (*divmod(value, 1000), *rates), strict=True)
    return Alter(tuple(pairs), ticks)


def released(ticks=20):
    return Alter(((0, 0),), ticks)


def play(machine, *steps, msw=PLAIN):
    setting = pcl601_setting(msw, RESTART, machine)
    played((setting, [Out(setting.configuration, 20), Out(NOTHING, 20), PutRight(), *steps, ToRest(500)]))


@pytest.mark.slow
@pytest.mark.parametrize("ticks", [20, 420, 820, 1180, 1500])
def test_a_release_while_a_move_restarts_has_the_ramp_of_the_old_rates(ticks):
    """5,000 to 20,000 steps/s at rates of 1: released in the stop at 20 steps/ms/s, or in the slow start."""
    play((), manual(bits.MANUAL_CCW, 5000, (20, 30), 2000), speed(20_000, (1, 1), ticks), released())


def test_a_release_after_two_changes_of_speed_may_still_find_the_ramp_of_the_first():
    first, second = speed(2000, (1, 1), 3500), speed(1001, (100, 50), 20)
    play((), manual(bits.MANUAL_CCW, 5000, (100, 100), 200), first, second, released())


def test_a_stop_by_a_refused_speed_is_given_room_for_the_gentlest_of_the_ramps():
    """The 3601 still slows down at 1 step/ms/s from 2000 steps/s, which takes 1500 steps."""
    gentle, refused = speed(1001, (1, 1), 20), speed(1, (1, 1), 20)
    play(LIMITS, manual(bits.MANUAL_CCW, 2000, (20, 30), 500), gentle, refused, msw=WITH_CAPTURE)


def test_a_stop_on_either_side_of_the_edge_of_the_home_switch():
    """An adapter stops some steps elsewhere, and so may see the home switch where a 3601 does not."""
    registration = manual(bits.MANUAL_CW, 1000, (50, 200), 20, steps=300)
    play(HOME_SWITCH, registration, released(), msw=WITH_ENCODER)


def test_a_registration_move_is_ended_early_by_a_speed_that_is_refused():
    play((), manual(bits.MANUAL_CW, 2000, (50, 200), 20, steps=300), speed(1, (50, 200), 20))


@pytest.mark.slow
def test_a_limit_that_comes_while_a_move_restarts_is_found_out_by_the_motion_that_follows():
    """It is the CW limit, in a CCW move: the standstill between two speeds tells nothing of its side."""
    fast, slow = manual(bits.MANUAL_CCW, 5000, (100, 50), 200), speed(2000, (100, 50), 20)
    for ticks in range(0, 500, 50):
        play((), fast, slow, Input(CW_LIMIT, True, ticks), released(), msw=WITH_CAPTURE)
