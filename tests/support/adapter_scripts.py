"""Random scripts for adapters: what a PLC can do to a 3601, for hardware that answers after a while.

The single steps are those of `scripts3601`; the motions are of a size that both controllers make in a
second or so, with now and then one that a controller can't do. What goes wrong on the line is added.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import oracle_bits as bits
import scripts3601 as one
from adapter_steps import DevicePower, Disturb, Haste, LinkLoss, PutRight
from dice3601 import BYTES, Dice, any_of, drawn, pick, story
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME
from scanrack.io_images import strategies as images
from scripts3601 import command
from steps3601 import NOTHING, Out, ToRest

START = 1000


@dataclass(frozen=True)
class Setting:
    """Which adapter it is, and what it is bolted to.

    Attributes:
        controller: PCL601 or PMC006.
        options: of the adapter.
        configuration: output words of the usual one.
        switches: (input, first, last), normally open.
        counts_per_step: of the encoder on the shaft; 0 = there is none.
    """

    controller: str
    options: dict
    configuration: tuple[int, ...]
    switches: tuple[tuple[int, int | None, int | None], ...] = ()
    counts_per_step: int = 0


# ---- values

DISTANCES = [1000, 200, -300, 2000, -2500, 77, 2, 1, -1, 0]
SPEEDS = [5000, 5000, 2000, 12_000, START, START + 1, 30_000]
RATES = [(100, 100), (100, 50), (50, 200), (1000, 1000), (20, 30)]
SHAPES = [0, 0, bits.S_CURVE, bits.S_CURVE | bits.TRAPEZOIDAL]
FAR = [8000, -8000, 12_000, -20_000, 8_000_000]
SHORT, LONG, EITHER_LONG = [20, 60, 200], [200, 600, 1000], [20, 200, 600]
EITHER = [bits.MANUAL_CW, bits.MANUAL_CCW]

# ---- steps

rest, device_power, put_right = ToRest(), DevicePower(), PutRight()
move = command([bits.RELATIVE], SHAPES, DISTANCES, SPEEDS, RATES, SHORT)
absolute = command([bits.ABSOLUTE], SHAPES, DISTANCES, SPEEDS, RATES, SHORT)
long_move = command([bits.RELATIVE], SHAPES, FAR, SPEEDS, RATES, LONG)
manual = command(EITHER, SHAPES, [0], SPEEDS, RATES, EITHER_LONG)
motion = any_of(long_move, manual)
resume = command([bits.RESUME], SHAPES, [0], SPEEDS, RATES, SHORT)
too_fast = command([bits.RELATIVE, bits.MANUAL_CW], [0], [0, 1000, -300], [60_000, 300_000], RATES, SHORT)
too_gentle = command([bits.RELATIVE, *EITHER], [0], [0], SPEEDS, [(5, 100)], SHORT)
respeed = one.speed_changed(START)
estop, external, capture = one.pressed(ESTOP), one.pressed(EXTERNAL), one.pressed(CAPTURE)
limit = one.pressed(CW_LIMIT, CCW_LIMIT)
find_home = command([bits.FIND_HOME_CCW, bits.FIND_HOME_CW], [0], [0], [2000, 5000], RATES, SHORT)
registration = command(EITHER, [0], [300, 3000, 5000], [2000, 5000, START], RATES, SHORT)
blend = drawn(images.blend_profiles(START, most=2), lambda profile: Out(tuple(profile.blocks()[0]), 2))
wrong = any_of(one.two_bits, one.no_number(START), one.slip(START), one.sloppy_reset, one.hostile)
refused = any_of(too_fast, too_gentle, one.encoder_move(START), blend, one.follow([0]))
disturbed = any_of(Disturb(1, 0), Disturb(2, 0), Disturb(0, 1), Disturb(0, 2), Disturb(1, 1))

A_MOVE, A_MANUAL_MOVE = (bits.RELATIVE, 0, 1, 0, 5, 0, 100, 100), (bits.MANUAL_CW, 0, 0, 0, 5, 0, 100, 100)
lost_link = pick(LinkLoss, [NOTHING, A_MOVE, A_MANUAL_MOVE], [False, False, True])
HASTY = [
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


def haste(dice):
    """Three to eight images, each for one to twenty scans."""
    images_written = dice.one_of(range(3, 9))
    return Haste(tuple((dice.one_of(HASTY), dice.one_of([1, 2, 3, 5, 9, 20])) for _ in range(images_written)))


# ---- stories

THEMES = {
    "moves": [
        story(move, rest, absolute, rest),
        story(one.preset, one.idle, absolute, rest),
        story(one.one_shot, one.release, move, rest),
        story(manual, one.release, rest),
        story(one.turn, one.preset, one.turn, move, rest),
        story(move, capture, rest),
        story(long_move, one.stop, rest, absolute, rest),
    ],
    "stops": [
        story(long_move, one.hold, rest, resume, rest),
        story(long_move, external, rest, resume, rest),
        story(motion, one.stop, rest, absolute, rest),
        story(motion, estop, rest, move, rest),
        story(manual, one.release, rest),
        story(manual, respeed, any_of(one.release, one.stop, limit, estop), rest),
        story(manual, respeed, respeed, one.release, rest),
        story(registration, one.release, rest),
        story(registration, respeed, one.release, rest),
    ],
    "limits": [
        story(long_move, rest, one.idle, one.reset, manual, one.release, rest),
        story(motion, rest, one.idle, one.one_shot, one.release, absolute, rest),
        story(motion, limit, rest, one.idle, one.reset, manual, one.release, rest),
        story(motion, rest, one.idle, move, rest),
    ],
    "states": [
        story(refused, rest, one.reset),
        story(wrong, rest, one.idle, wrong, rest),
        story(motion, wrong, rest),
        story(motion, one.stopped_plc, one.wait, one.running_plc, rest),
        story(motion, one.power, one.wait),
        story(one.reconfigured, move, rest),
        story(motion, one.reconfigured, rest),
    ],
    "line": [
        story(motion, lost_link, absolute, rest),
        story(any_of(motion, rest), device_power, absolute, rest),
        story(disturbed, any_of(motion, move), disturbed, rest),
        story(motion, disturbed, any_of(one.hold, one.stop, one.release), rest),
        story(haste, move, rest),
        story(Out(A_MOVE, 20), rest, device_power, put_right, Out(A_MOVE, 20), rest),
    ],
    "homing": [
        story(find_home, rest, manual, rest),
        story(manual, one.release, rest, find_home, rest),
        story(find_home, any_of(one.stop, estop), rest),
        story(find_home, lost_link, find_home, rest),
    ],
}
"""What a script may be about."""


STORIES_MOST = 4
SETTING_BYTES = 4


@cache
def scripts(controller, theme):
    """A setting and the steps to play on it."""
    return _script(controller, theme)


@st.composite
def _script(draw, controller, theme):
    """Configured, then story after story; in between everything is put right."""
    size = SETTING_BYTES + STORIES_MOST * BYTES
    thrown = draw(st.binary(min_size=size, max_size=size))
    machines = MACHINES[controller][theme] if theme in MACHINES[controller] else MACHINES[controller]["any"]
    setting = pick(SETTING[controller], *CHOICES[controller], machines)(Dice(thrown, draw))
    steps: list[Any] = [Out(setting.configuration, 20), Out(NOTHING, 20)]
    for at in range(SETTING_BYTES, size, BYTES):
        dice = Dice(thrown[at : at + BYTES], draw)
        if dice.one_of([False, True, True, True]):
            steps += [PutRight(), *dice.one_of(THEMES[theme])(dice)]
    return setting, steps


# ---- settings

WITH_ENCODER, WITH_CAPTURE, PLAIN = 0x853F, 0x843F, 0x843E
ESTOP_ON_FSET, EXTERNAL_ON_FSET = 0x843C, 0x8436
LIMITS = ((CW_LIMIT, 1537, None), (CCW_LIMIT, None, -1461))
HOME_BETWEEN = ((HOME, 60, 90), (CW_LIMIT, 3023, None), (CCW_LIMIT, None, -2029))
HOME_AT_THE_END = ((HOME, None, -2029), (CW_LIMIT, 3023, None))
"""Limits lie where no move ends: on a PMC006 one that is met with the last step is in the way."""


def configuration(msw):
    return one.configuration_words(msw, 0x3F, START)


def pcl601_setting(msw, options, machine):
    return Setting("PCL601", options, configuration(msw), machine, 4 if msw & bits.QUADRATURE else 0)


def pmc006_setting(msw, options, machine):
    """A move can only be held by an option, which the external input needs, too."""
    hold_allowed = {"hold": "immediate"} if msw == EXTERNAL_ON_FSET else options
    return Setting("PMC006", {"home_stroke": 20_000} | hold_allowed, configuration(msw), machine)


SETTING = {"PCL601": pcl601_setting, "PMC006": pmc006_setting}
CHOICES = {
    "PCL601": ([PLAIN, WITH_ENCODER, WITH_CAPTURE], [{}, {"respeed": "restart"}]),
    "PMC006": (
        [ESTOP_ON_FSET, EXTERNAL_ON_FSET],
        [{"hold": "immediate"}, {}, {"respeed": "restart"}],
    ),
}
"""Configurations and options."""

MACHINES = {
    "PCL601": {
        "any": [LIMITS, (), ((HOME, 300, 350),), HOME_BETWEEN],
        "limits": [LIMITS, HOME_BETWEEN],
        "homing": [HOME_BETWEEN],
    },
    "PMC006": {
        "any": [LIMITS[:1], (), HOME_AT_THE_END],
        "limits": [LIMITS[:1], LIMITS],
        "homing": [HOME_AT_THE_END],
    },
}
"""By theme; a search for home has to end, wherever it begins."""
