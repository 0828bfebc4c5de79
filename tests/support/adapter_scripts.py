"""Random scripts for adapters: what a PLC can do to a 3601, for hardware that answers after a while.

The single steps are those of `scripts3601`; the motions are of a size that both controllers make in a
second or so, with now and then one that a controller can't do.
"""

from __future__ import annotations

from dataclasses import dataclass

import oracle_bits as bits
import scripts3601 as one
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME
from steps3601 import NOTHING, Out, Recover, ToRest
from stories3601 import story

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


@dataclass(frozen=True)
class LinkLoss:
    """The line is cut for a while, words come meanwhile, and the controller may lose its power, too."""

    words: tuple[int, ...]
    loses_power: bool
    ms: int = 750

    def play(self, bench):
        bench.link_loss(self.ms, self.words, self.loses_power)


@dataclass(frozen=True)
class DevicePower:
    """The controller's power is cycled, the adapter's is not."""

    def play(self, bench):
        bench.device_power()


@dataclass(frozen=True)
class Disturb:
    """Replies get lost, and damaged: no more than two in a row, which must not be noticed."""

    lost: int
    damaged: int

    def play(self, bench):
        bench.disturb(self.lost, self.damaged)


# ---- values

distances = st.sampled_from([1000, 200, -300, 2000, -2500, 77, 2, 1, -1, 0])
speeds = st.sampled_from([5000, 5000, 2000, 12_000, START, START + 1, 30_000])
rates = st.sampled_from([(100, 100), (100, 50), (50, 200), (1000, 1000), (500, 100)])
shapes = st.sampled_from([0, 0, bits.S_CURVE, bits.S_CURVE | bits.TRAPEZOIDAL])
far = st.sampled_from([8000, -8000, 12_000, -20_000])
short = st.sampled_from([20, 60, 200])
either = [bits.MANUAL_CW, bits.MANUAL_CCW]

# ---- steps

rest = st.just(ToRest())
move = one.command([bits.RELATIVE], shapes, distances, speeds, rates, short)
absolute = one.command([bits.ABSOLUTE], shapes, distances, speeds, rates, short)
long_move = one.command([bits.RELATIVE], shapes, far, speeds, rates, st.sampled_from([200, 600, 1000]))
manual = one.command(either, shapes, st.just(0), speeds, rates, st.sampled_from([20, 200, 600]))
one_shot = one.one_shot
resume = one.command([bits.RESUME], shapes, st.just(0), speeds, rates, short)
too_fast = one.command(
    [bits.RELATIVE, bits.MANUAL_CW],
    st.just(0),
    st.just(0) | distances,
    st.sampled_from([60_000, 300_000]),
    rates,
    short,
)
too_gentle = one.command([bits.RELATIVE, *either], st.just(0), st.just(0), speeds, st.just((5, 100)), short)
respeed = one.speed_changed(START)
release, hold, stop, reset, preset = one.release, one.hold, one.stop, one.reset, one.preset
estop, external, capture = one.pressed(ESTOP), one.pressed(EXTERNAL), one.pressed(CAPTURE)
limit = one.pressed(CW_LIMIT) | one.pressed(CCW_LIMIT)
find_home = one.command(
    [bits.FIND_HOME_CCW, bits.FIND_HOME_CCW, bits.FIND_HOME_CW],
    st.just(0),
    st.just(0),
    st.sampled_from([2000, 5000]),
    rates,
    short,
)
registration = one.command(
    either, st.just(0), st.sampled_from([300, 3000, 5000]), st.sampled_from([2000, 5000, START]), rates, short
)
A_MOVE, A_MANUAL_MOVE = (bits.RELATIVE, 0, 1, 0, 5, 0, 100, 100), (bits.MANUAL_CW, 0, 0, 0, 5, 0, 100, 100)
meanwhile = st.sampled_from([NOTHING, A_MOVE, A_MANUAL_MOVE])
lost_link = st.builds(LinkLoss, meanwhile, st.sampled_from([False, False, True]))
device_power = st.just(DevicePower())
disturbed = st.sampled_from([Disturb(1, 0), Disturb(2, 0), Disturb(0, 1), Disturb(0, 2), Disturb(1, 1)])
wrong = one.two_bits | one.no_number(START) | one.slip(START) | one.sloppy_reset | one.hostile

STORIES = [
    story(move, rest),
    story(move, rest, absolute, rest),
    story(long_move, hold, rest, resume, rest),
    story(long_move, external, rest, resume, rest),
    story(long_move, stop, rest, absolute, rest),
    story(long_move, estop, rest, move, rest),
    story(manual, release, rest),
    story(manual, respeed, release, rest),
    story(manual, limit, rest, reset, manual, release, rest),
    story(one_shot, release, move, rest),
    story(preset, one.idle, absolute, rest),
    story(too_fast | too_gentle, rest, reset),
    story(wrong, rest, one.idle, wrong, rest),
    story(long_move | manual, wrong, rest),
    story(long_move | manual, one.stopped_plc, one.wait, one.running_plc, rest),
    story(long_move | manual, one.power, one.wait),
    story(one.reconfigured, move, rest),
    story(move, capture, rest),
    story(registration, release, rest),
    story(long_move | manual, lost_link, absolute, rest),
    story(long_move | manual | rest, device_power, absolute, rest),
    story(disturbed, move | long_move | manual, disturbed, rest),
    story(long_move | manual, disturbed, hold | stop | release, rest),
    story(one.turn, preset, one.turn, move, rest),
]
HOMING = [
    story(find_home, rest, move, rest),
    story(manual, release, rest, find_home, rest),
    story(find_home, stop | estop, rest),
]


@st.composite
def scripts(draw, controller):
    """A setting and the steps to play on it."""
    setting, config = draw(SETTINGS[controller])
    stories = STORIES + HOMING * can_home(setting)
    told = draw(st.lists(st.one_of(stories), min_size=1, max_size=5))
    steps = [Out(config, 20), Out(NOTHING, 20)]
    for each in told:
        steps += [Recover(config), *each]
    return setting, steps


def can_home(setting):
    """Whether a search for home ends: it is on the way to an end limit, from wherever it begins."""
    return len(setting.switches) > 1 and setting.switches[0][0] == HOME


def configured(msw):
    return one.configuration_words(msw, 0x3F, START)


PCL601_MACHINES = [
    (),
    ((HOME, 300, 350),),
    ((CW_LIMIT, 1500, None), (CCW_LIMIT, None, -1500)),
    ((HOME, 60, 90), (CW_LIMIT, 5000, None), (CCW_LIMIT, None, -4000)),
]
PMC006_MACHINES = [
    (),
    ((CW_LIMIT, 1500, None),),
    ((HOME, None, -4000), (CW_LIMIT, 5000, None)),
]

pcl601 = st.builds(
    lambda msw, machine, respeeds: (
        Setting(
            "PCL601", {"respeed": "restart"} if respeeds else {}, machine, 4 if msw & bits.QUADRATURE else 0
        ),
        configured(msw),
    ),
    st.sampled_from([0x843E, 0x843E, 0x853F, 0x843F]),
    st.sampled_from(PCL601_MACHINES),
    st.booleans(),
)
pmc006 = st.builds(
    lambda msw, machine: (
        Setting(
            "PMC006", {"home_stroke": 20_000, **({"hold": "immediate"} if msw != 0x843C else {})}, machine
        ),
        configured(msw),
    ),
    st.sampled_from([0x843C, 0x8436]),
    st.sampled_from(PMC006_MACHINES),
)
SETTINGS = {"PCL601": pcl601, "PMC006": pmc006}
