"""Random scripts for adapters: what a PLC can do to a 3601, for hardware that answers after a while.

The single steps are those of `scripts3601`; the motions are of a size that both controllers make in a
second or so, with now and then one that a controller can't do. What goes wrong on the line is added.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import oracle_bits as bits
import scripts3601 as one
from adapter_steps import DevicePower, Disturb, Haste, LinkLoss
from dice3601 import any_of, listed, strategy
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME
from scanrack.io_images import strategies as images
from steps3601 import NOTHING, Out, Recover, ToRest

START = 1000


@dataclass(frozen=True)
class Setting:
    """Which adapter it is, and what it is bolted to.

    Attributes:
        controller: PCL601 or PMC006.
        options: of the adapter.
        switches: (input, first, last), normally open.
        counts_per_step: of the encoder on the shaft; 0 = there is none.
    """

    controller: str
    options: dict
    switches: tuple[tuple[int, int | None, int | None], ...] = ()
    counts_per_step: int = 0


# ---- values

distances = st.sampled_from([1000, 200, -300, 2000, -2500, 77, 2, 1, -1, 0])
speeds = st.sampled_from([5000, 5000, 2000, 12_000, START, START + 1, 30_000])
rates = st.sampled_from([(100, 100), (100, 50), (50, 200), (1000, 1000), (500, 100)])
shapes = st.sampled_from([0, 0, bits.S_CURVE, bits.S_CURVE | bits.TRAPEZOIDAL])
far = st.sampled_from([8000, -8000, 12_000, -20_000, 8_000_000])
short = st.sampled_from([20, 60, 200])
long = st.sampled_from([200, 600, 1000])
no_target = st.just(0)
either = [bits.MANUAL_CW, bits.MANUAL_CCW]


def command(msws, lsws, targets, some_speeds, some_rates, durations):
    """A step that writes a command."""
    words = st.builds(images.parameter_words, st.sampled_from(msws), lsws, targets, some_speeds, some_rates)
    return st.builds(Out, words, durations)


def story(*parts):
    """Parts one after the other; a part is a strategy of a step or of a list of steps."""
    return st.tuples(*parts).map(lambda values: [step for value in values for step in listed(value)])


# ---- steps

rest = st.just(ToRest())
move = command([bits.RELATIVE], shapes, distances, speeds, rates, short)
absolute = command([bits.ABSOLUTE], shapes, distances, speeds, rates, short)
long_move = command([bits.RELATIVE], shapes, far, speeds, rates, long)
manual = command(either, shapes, no_target, speeds, rates, st.sampled_from([20, 200, 600]))
one_shot = strategy(one.one_shot)
resume = command([bits.RESUME], shapes, no_target, speeds, rates, short)
fast = st.sampled_from([60_000, 300_000])
too_fast = command([bits.RELATIVE, bits.MANUAL_CW], st.just(0), no_target | distances, fast, rates, short)
too_gentle = command([bits.RELATIVE, *either], st.just(0), no_target, speeds, st.just((5, 100)), short)
respeed = strategy(one.speed_changed(START))
release, hold, stop, reset, preset = map(strategy, (one.release, one.hold, one.stop, one.reset, one.preset))
idle, wait, turn, power, reconfigured = map(
    strategy, (one.idle, one.wait, one.turn, one.power, one.reconfigured)
)
stopped_plc, running_plc = strategy(one.stopped_plc), strategy(one.running_plc)
estop, external, capture = (strategy(one.pressed(bit)) for bit in (ESTOP, EXTERNAL, CAPTURE))
limit = strategy(one.pressed(CW_LIMIT, CCW_LIMIT))
homing_speeds = st.sampled_from([2000, 5000])
directions = [bits.FIND_HOME_CCW, bits.FIND_HOME_CCW, bits.FIND_HOME_CW]
find_home = command(directions, st.just(0), no_target, homing_speeds, rates, short)
registration_speeds = st.sampled_from([2000, 5000, START])
registration_distances = st.sampled_from([300, 3000, 5000])
registration = command(either, st.just(0), registration_distances, registration_speeds, rates, short)
blend = images.blend_profiles(START, most=2).map(lambda profile: Out(tuple(profile.blocks()[0]), 2))
motion = long_move | manual
wrong = strategy(any_of(one.two_bits, one.no_number(START), one.slip(START), one.sloppy_reset, one.hostile))
refused = too_fast | too_gentle | strategy(one.encoder_move(START)) | blend | strategy(one.follow([0]))

A_MOVE, A_MANUAL_MOVE = (bits.RELATIVE, 0, 1, 0, 5, 0, 100, 100), (bits.MANUAL_CW, 0, 0, 0, 5, 0, 100, 100)
meanwhile = st.sampled_from([NOTHING, A_MOVE, A_MANUAL_MOVE])
lost_link = st.builds(LinkLoss, meanwhile, st.sampled_from([False, False, True]))
device_power = st.just(DevicePower())
disturbed = st.sampled_from([Disturb(1, 0), Disturb(2, 0), Disturb(0, 1), Disturb(0, 2), Disturb(1, 1)])
hasty_words = st.sampled_from(
    [
        NOTHING,
        A_MOVE,
        A_MANUAL_MOVE,
        (bits.MANUAL_CCW, 0, 0, 0, 12, 0, 50, 100),
        (bits.RELATIVE, 0, 0, -5, 2, 0, 100, 100),
        (bits.HOLD, 0, 0, 0, 0, 0, 0, 0),
        (bits.RESUME, 0, 0, 0, 5, 0, 100, 100),
        (bits.IMMEDIATE_STOP, 0, 0, 0, 0, 0, 0, 0),
        (bits.RESET_ERRORS, 0, 0, 0, 0, 0, 0, 0),
    ]
)
hasty = st.lists(st.tuples(hasty_words, st.sampled_from([1, 2, 3, 5, 9, 20])), min_size=3, max_size=8)
haste = hasty.map(lambda given: Haste(tuple(given)))

# ---- stories

THEMES = {
    "moves": [
        story(move, rest, absolute, rest),
        story(preset, idle, absolute, rest),
        story(one_shot, release, move, rest),
        story(manual, release, rest),
        story(turn, preset, turn, move, rest),
        story(move, capture, rest),
        story(long_move, stop, rest, absolute, rest),
    ],
    "stops": [
        story(long_move, hold, rest, resume, rest),
        story(long_move, external, rest, resume, rest),
        story(motion, stop, rest, absolute, rest),
        story(motion, estop, rest, move, rest),
        story(manual, release, rest),
        story(manual, respeed, release, rest),
        story(registration, release, rest),
        story(manual, limit, rest, reset, manual, release, rest),
        story(manual | move, rest, manual | move, rest),
    ],
    "states": [
        story(refused, rest, reset),
        story(wrong, rest, idle, wrong, rest),
        story(motion, wrong, rest),
        story(motion, stopped_plc, wait, running_plc, rest),
        story(motion, power, wait),
        story(reconfigured, move, rest),
        story(motion, reconfigured, rest),
    ],
    "line": [
        story(motion, lost_link, absolute, rest),
        story(motion | rest, device_power, absolute, rest),
        story(disturbed, motion | move, disturbed, rest),
        story(motion, disturbed, hold | stop | release, rest),
        story(haste, move, rest),
    ],
    "homing": [
        story(find_home, rest, manual, rest),
        story(manual, release, rest, find_home, rest),
        story(find_home, stop | estop, rest),
        story(find_home, lost_link, find_home, rest),
    ],
}
"""What a script may be about."""


@cache
def scripts(controller, theme):
    """A setting and the steps to play on it."""
    return st.builds(
        script,
        st.sampled_from(HOMING_SETTINGS[controller]) if theme == "homing" else SETTINGS[controller],
        st.lists(st.one_of(THEMES[theme]), min_size=1, max_size=4),
    )


def script(setting_and_configuration, told):
    """Configured, then story after story; in between everything is put right."""
    setting, msw = setting_and_configuration
    config = one.configuration_words(msw, 0x3F, START)
    steps = [Out(config, 20), Out(NOTHING, 20)]
    for each in told:
        steps += [Recover(config), *each]
    return setting, steps


# ---- settings

LIMITS = ((CW_LIMIT, 1500, None), (CCW_LIMIT, None, -1500))
HOME_BETWEEN = ((HOME, 60, 90), (CW_LIMIT, 3000, None), (CCW_LIMIT, None, -2000))
HOME_AT_THE_END = ((HOME, None, -2000), (CW_LIMIT, 3000, None))
WITH_ENCODER, WITH_CAPTURE, PLAIN = 0x853F, 0x843F, 0x843E
ESTOP_ON_FSET, EXTERNAL_ON_FSET = 0x843C, 0x8436
STROKE = {"home_stroke": 20_000}


def pcl601_setting(msw, machine, options):
    return Setting("PCL601", options, machine, 4 if msw & bits.QUADRATURE else 0), msw


def pmc006_setting(msw, machine, options):
    """Without a ramp a move can only be held by an option, which the external input needs, too."""
    hold_allowed = {"hold": "immediate"} if msw == EXTERNAL_ON_FSET else options
    return Setting("PMC006", STROKE | hold_allowed, machine), msw


SETTINGS = {
    "PCL601": st.builds(
        pcl601_setting,
        st.sampled_from([PLAIN, WITH_ENCODER, WITH_CAPTURE]),
        st.sampled_from([LIMITS, (), ((HOME, 300, 350),), HOME_BETWEEN]),
        st.sampled_from([{}, {"respeed": "restart"}]),
    ),
    "PMC006": st.builds(
        pmc006_setting,
        st.sampled_from([ESTOP_ON_FSET, EXTERNAL_ON_FSET]),
        st.sampled_from([LIMITS[:1], (), HOME_AT_THE_END]),
        st.sampled_from([{"hold": "immediate"}, {}, {"respeed": "restart"}]),
    ),
}
HOMING_SETTINGS = {
    "PCL601": [pcl601_setting(PLAIN, HOME_BETWEEN, {}), pcl601_setting(WITH_ENCODER, HOME_BETWEEN, {})],
    "PMC006": [pmc006_setting(ESTOP_ON_FSET, HOME_AT_THE_END, {})],
}
"""Machines on which a search for home ends, wherever it begins."""
