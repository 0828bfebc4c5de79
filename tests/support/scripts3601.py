"""Random but plausible scripts for a 3601: what a PLC programmer does, and now and then what he shouldn't.

A script is a setting and a list of steps. Steps are small frozen objects with
`play(bench)`; some of them look at the state of the oracle (`ToRest`,
`Recover`), so that most commands find an axis that can take them and deep
states are reached. Stories put steps into an order that makes sense (a move, a
hold, a resume); meddling comes in between.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import oracle_bits as bits
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME, PROXIMITY
from scanrack.io_images import split_thousands
from scanrack.io_images import strategies as images
from scanrack.io_images.amci3601 import Firmware

ERRORS = bits.COMMAND_ERROR | bits.INVALID_PROFILE | bits.HOME_INVALID | bits.INPUT_ERROR
NOTHING = (0,) * 8

# ---- steps


@dataclass(frozen=True)
class Out:
    """These eight words, for so many ticks."""

    words: tuple[int, ...]
    ticks: int

    def play(self, bench):
        bench.out(self.words)
        bench.run(self.ticks)


@dataclass(frozen=True)
class Alter:
    """Some words changed, the others as they are: (index, value) each."""

    changes: tuple[tuple[int, int], ...]
    ticks: int

    def play(self, bench):
        words = list(bench.words)
        for index, value in self.changes:
            words[index] = value
        bench.out(words)
        bench.run(self.ticks)


@dataclass(frozen=True)
class Wait:
    ticks: int

    def play(self, bench):
        bench.run(self.ticks)


@dataclass(frozen=True)
class ToRest:
    """Until nothing moves, for at most so many ticks."""

    ticks: int = 2_000

    def play(self, bench):
        bench.run_to_rest(self.ticks)


@dataclass(frozen=True)
class Input:
    """An input on or off; with `ticks`, the other way again after them."""

    bit: int
    energised: bool
    ticks: int

    def play(self, bench):
        bench.input(self.bit, self.energised)
        if self.ticks:
            bench.run(self.ticks)
            bench.input(self.bit, not self.energised)


@dataclass(frozen=True)
class Turn:
    """Somebody turns the encoder during the next ticks; `waited` says whether the script waits for it."""

    counts: int
    ticks: int
    waited: bool = True

    def play(self, bench):
        bench.turn(self.counts, self.ticks)
        if self.waited:
            bench.run(self.ticks)


@dataclass(frozen=True)
class Marker:
    """A Z pulse in so many ticks."""

    ticks: int

    def play(self, bench):
        bench.marker(self.ticks)


@dataclass(frozen=True)
class Plc:
    """The PLC goes to run or program mode."""

    running: bool
    ticks: int

    def play(self, bench):
        bench.plc(self.running)
        bench.run(self.ticks)


@dataclass(frozen=True)
class PowerCycle:
    def play(self, bench):
        bench.power_cycle()


@dataclass(frozen=True)
class Recover:
    """What a program does before it goes on: inputs off, errors reset, configured, position preset."""

    config: tuple[int, ...]

    def play(self, bench):
        for bit in (EXTERNAL, ESTOP, CW_LIMIT, CCW_LIMIT):
            if bench.world.hand_levels & bit:
                bench.input(bit, False)
        if not bench.oracle.plc_running:
            bench.plc(True)
        self.command(bench, [0, 0, *bench.words[2:]])
        if bench.oracle.config_error:
            self.command(bench, self.config)
        if bench.oracle.image[0] & ERRORS:
            self.command(bench, [bits.RESET_ERRORS, *NOTHING[1:]])
        bench.run_to_rest(100)
        if bench.oracle.in_motion():
            self.command(bench, [bits.IMMEDIATE_STOP, *NOTHING[1:]])
        if bench.oracle.position_invalid:
            self.command(bench, [bits.PRESET_POSITION, 0, 0, 500, 0, 0, 0, 0])

    def command(self, bench, words):
        if list(words) != bench.words or words[0]:
            bench.out(words)
            bench.run(1)
        if words[0]:
            bench.out(NOTHING)
            bench.run(1)


# ---- values

FIRMWARES = ["4.1", "4.1", "4.1", "3.1", "2.2", "2.0"]
SHAPES = [0, 0, bits.S_CURVE, bits.S_CURVE | bits.TRAPEZOIDAL, bits.TRAPEZOIDAL]
TICKS = [1, 2, 3, 7, 20, 61, 61, 150, 150, 400, 1001]
CONFIGURATIONS = [0x843E, 0x853F, 0x863F, 0x847E, 0x953F, 0x957B, 0x842E, 0x8414]
"""Home switch; with encoder; with diagnostic feedback; with backplane proximity; marker and home switch;
marker and proximity bit; no CCW limit in use... see chapter 3 for the bits."""
MACHINES = [
    (),
    ((HOME, 300, 350),),
    ((HOME, 60, 90), (CW_LIMIT, 1500, None), (CCW_LIMIT, None, -1500)),
    ((HOME, -200, -190), (CW_LIMIT, 900, None), (CCW_LIMIT, None, -3000)),
    ((CW_LIMIT, 400, None), (CCW_LIMIT, None, -400)),
    ((HOME, 0, 0), (CW_LIMIT, 2000, None)),
    ((HOME, 100, 101), (CW_LIMIT, 0, 20)),
    ((HOME, 100, 101), (CAPTURE, 40, 60), (EXTERNAL, 1000, 1010)),
]

ticks = st.sampled_from(TICKS)
few = st.sampled_from([1, 2, 5])
rates = st.sampled_from(images.RATES + images.RATES + images.FAULTY_RATES)
good_rates = st.sampled_from(images.RATES)
shapes = st.sampled_from(SHAPES)
distances = st.sampled_from(images.DISTANCES)
starting_speeds = st.sampled_from([1000, *images.STARTING_SPEEDS])


@cache
def speeds(start):
    """Mostly legal programmed speeds for a starting speed."""
    legal = images.plain_speeds(start)
    return st.sampled_from([*legal, *legal, 1_000_000, 7_777, max(0, start - 1)])


def shown(image, t):
    """A step that writes an image."""
    return Out(tuple(image), t)


def command(msws, lsws, targets, programmed_speeds, some_rates=rates, durations=ticks):
    """A step that writes a command."""
    return st.builds(
        Out,
        st.builds(
            images.parameter_words, st.sampled_from(msws), lsws, targets, programmed_speeds, some_rates
        ),
        durations,
    )


def plain(*msws):
    """A step that writes a command without parameters."""
    return st.builds(Out, st.sampled_from([(msw, *NOTHING[1:]) for msw in msws]), few)


def bit_on(msw):
    """A step that sets one command bit and leaves the parameters as they are."""
    return st.builds(lambda t: Alter(((0, msw),), t), ticks)


# ---- single steps

idle = st.builds(lambda t: Alter(((0, 0), (1, 0)), t), few)
wait = st.builds(Wait, ticks)
rest = st.builds(ToRest)
release = st.builds(lambda t: Alter(((0, 0),), t), ticks)
all_zero = st.builds(lambda t: Out(NOTHING, t), ticks)
hold = bit_on(bits.HOLD)
stop = plain(bits.IMMEDIATE_STOP)
reset = plain(bits.RESET_ERRORS)
preset = command(
    [bits.PRESET_POSITION, bits.PRESET_POSITION, bits.PRESET_ENCODER],
    st.sampled_from([0, 0, 0, 1]),
    st.sampled_from([0, 500, -12_345, 8_388_607, -8_388_608]),
    st.sampled_from([0, 0, 0, 1]),
    st.just((0, 0)),
    few,
)
press = st.builds(
    Input,
    st.sampled_from([EXTERNAL, EXTERNAL, HOME, CAPTURE, ESTOP, CW_LIMIT, CCW_LIMIT]),
    st.sampled_from([True, True, True, False]),
    st.sampled_from([0, 1, 5, 100]),
)
turn = st.builds(Turn, st.sampled_from([100, -100, 4000, -3, 1001]), ticks, st.booleans())
marker = st.builds(Marker, ticks)
proximity = st.builds(lambda on, t: Alter(((1, PROXIMITY if on else 0),), t), st.booleans(), ticks)
lsw_changed = st.builds(lambda lsw, t: Alter(((1, lsw),), t), st.sampled_from([0, 1, 2, 4, 0x1000]), few)
target_changed = st.builds(lambda value, t: Alter(((3, value),), t), st.sampled_from([0, 1, 500]), ticks)
plc = st.builds(Plc, st.booleans(), few)
power = st.just(PowerCycle())
hostile = st.builds(shown, images.hostile_images(), few)
stored_minimum = command(
    [0],
    st.just(bits.STORE_MINIMUM),
    st.sampled_from([50, 200, 0, 1000, -1, 8_388_608 - 1]),
    st.sampled_from([0, 0, 0, 1]),
    st.just((0, 0)),
    few,
)


@cache
def resume(start):
    return command([bits.RESUME], shapes, st.sampled_from([0, 7, -9]), speeds(start))


@cache
def speed_changed(start):
    def alter(speed, some_rates, t):
        pairs = list(zip((4, 5), split_thousands(speed), strict=True))
        if some_rates:
            pairs += zip((6, 7), some_rates, strict=True)
        return Alter(tuple(pairs), t)

    faster = st.one_of(speeds(start), st.sampled_from([0, 1, 2 * start, 3 * start, 10 * start]))
    return st.builds(alter, faster, st.one_of(st.none(), st.none(), rates), ticks)


# ---- starts of motions


@cache
def move(start):
    return command([bits.RELATIVE, bits.RELATIVE, bits.ABSOLUTE], shapes, distances, speeds(start))


@cache
def long_move(start):
    far = st.sampled_from([3000, -5000, 20_000, 8_388_607])
    return command([bits.RELATIVE], shapes, far, speeds(start), good_rates)


@cache
def manual(start):
    return command(
        [bits.MANUAL_CW, bits.MANUAL_CCW],
        st.sampled_from([*SHAPES, bits.ENCODER_MOVE]),
        st.just(0),
        st.one_of(speeds(start), st.sampled_from([1, 3 * start // 4, 10 * start])),
    )


one_shot = command([bits.MANUAL_CW, bits.MANUAL_CCW], shapes, st.just(0), st.just(0), rates, few)


@cache
def registration(start):
    targets = st.sampled_from([300, 3000, 20_000, 1, -5])
    return command([bits.MANUAL_CW, bits.MANUAL_CCW], shapes, targets, speeds(start))


@cache
def find_home(start):
    return command(
        [bits.FIND_HOME_CW, bits.FIND_HOME_CCW],
        st.sampled_from([0, 0, 0, 0, PROXIMITY, bits.TRAPEZOIDAL, bits.S_CURVE]),
        st.sampled_from([0, 0, 0, 0, 0, 1]),
        speeds(start),
        rates,
    )


@cache
def encoder_move(start):
    return command(
        [bits.RELATIVE, bits.RELATIVE, bits.ABSOLUTE],
        st.sampled_from([4, 4, 5, 7]),
        st.sampled_from([100, -100, 1000, 4000, -3, 0]),
        speeds(start),
    )


def follow(msws):
    return st.builds(
        lambda msw, ratio, lsw, t: Out((msw, lsw, *ratio, 0, 0, 0, 0), t),
        st.sampled_from(msws),
        st.sampled_from([(1, 1), (7, 3), (3, 7), (1, 1000), (1, 1), (0, 1), (5, -1)]),
        st.sampled_from([bits.FOLLOW, bits.FOLLOW, bits.FOLLOW, 0]),
        ticks,
    )


blend_run = plain(bits.RUN_BLEND_CW, bits.RUN_BLEND_CCW)

# ---- blend programming


TOLERATED = {"types": (0, 4, 0b10), "reserved words": (0, 7, 5), "a block too many": None}
"""What the module overlooks in a blend profile (reading A-60)."""


@st.composite
def blend_program(draw, start):
    """Header and segments, block by block, with or without a fault."""
    faulty = draw(st.sampled_from([False, False, True]))
    if faulty and start > 1:
        return blocks_sent(draw(images.faulty_blends(start)).blocks)
    blocks = draw(images.blend_profiles(start, most=4)).blocks()
    odd = draw(st.sampled_from([None, None, None, None, *TOLERATED]))
    if odd == "a block too many":
        blocks.append(blocks[-1])
    elif odd is not None:
        block, index, word = TOLERATED[odd]
        blocks[block][index] = word
    return blocks_sent(blocks)


def blocks_sent(blocks):
    """The handshake, an image per tick."""
    return [shown(image, 1) for image in images.handshake(blocks)]


# ---- configurations


def configuration_words(msw, levels, start):
    return (msw - 65_536, levels, *split_thousands(start), 0, 0, 0, 0)


good_configuration = st.builds(
    configuration_words, st.sampled_from(CONFIGURATIONS), st.just(0x3F), starting_speeds
)
any_configuration = images.configurations(Firmware(2, 0)).map(lambda it: tuple(it.to_image()))
bad_configuration = images.faulty_configurations(Firmware(2, 0)).map(lambda faulty: tuple(faulty.image))
reconfigured = st.builds(
    lambda config, t: [Out(config, t), Out(NOTHING, 2)],
    st.one_of(good_configuration, any_configuration, bad_configuration),
    ticks,
)


# ---- stories


@cache
def meddling(start):
    """What comes in between."""
    single = st.one_of(
        *(hold, resume(start), stop, reset, preset, idle, wait, rest, press, press, turn, marker),
        *(speed_changed(start), target_changed, release, all_zero, proximity, lsw_changed),
        *(move(start), manual(start), find_home(start), blend_run, stored_minimum, hostile, plc, power),
    )
    several = st.one_of(single.map(lambda step: [step]), reconfigured, blend_program(start))
    return st.lists(several, max_size=2).map(lambda lists: [step for steps in lists for step in steps])


def story(*parts):
    """Parts one after the other; a part is a strategy of a step or of a list of steps."""
    return st.tuples(*parts).map(
        lambda values: [s for value in values for s in (value if isinstance(value, list) else [value])]
    )


@cache
def stories(start, encoder, follower):
    between = meddling(start)
    home_rest = st.just(ToRest(10_000))
    held = st.one_of(hold, hold, press)
    told = [
        story(move(start), between, rest),
        story(long_move(start), held, rest, between, resume(start), between, rest),
        story(long_move(start), held, rest, idle, resume(start), held, rest, resume(start), rest),
        story(manual(start), speed_changed(start), between, speed_changed(start), release, between, rest),
        story(manual(start), between, release, rest),
        story(one_shot, between, release),
        story(registration(start), between, release, between, rest),
        story(stored_minimum, registration(start), speed_changed(start), release, rest),
        story(stored_minimum, registration(start), press, between, release, rest),
        story(find_home(start), between, home_rest),
        story(find_home(start), proximity, marker, press, proximity, marker, press, home_rest),
        story(blend_program(start), blend_run, between, rest),
        story(blend_program(start), between, blend_run, wait, between, rest, all_zero, blend_run, rest),
        story(hostile, between, hostile),
        story(reconfigured, between),
    ]
    if encoder:
        told.append(story(encoder_move(start), turn, between, turn, rest))
        told.append(story(encoder_move(start), between, rest))
    if follower:
        cw, ccw = [bits.MANUAL_CW], [bits.MANUAL_CCW]
        told.append(story(follow([0]), follow(cw), turn, follow([0]), follow(ccw), turn, all_zero))
        told.append(story(follow([0, *cw]), turn, between, follow([0, *cw, *ccw]), turn, between))
    return st.one_of(told)


@dataclass(frozen=True)
class Setting:
    """Which module it is, what it is bolted to, and how often images are exchanged.

    Attributes:
        switches: (input, first, last), normally open.
        counts_per_step: of the encoder on the shaft; 0 = there is none.
        marker_every: counts between two Z pulses of that encoder; None = no Z wired.
        wired_back: diagnostic feedback wiring.
    """

    firmware: str = "4.1"
    switches: tuple[tuple[int, int | None, int | None], ...] = ()
    counts_per_step: int = 0
    marker_every: int | None = None
    wired_back: bool = False
    scan_ticks: int = 1


@st.composite
def scripts(draw):
    """A setting and the steps to play on it."""
    config = draw(good_configuration)
    encoder = bool(config[0] & bits.QUADRATURE)
    gear = draw(st.sampled_from([0, 0, 1, 4]))
    setting = Setting(
        firmware=draw(st.sampled_from(FIRMWARES)),
        switches=draw(st.sampled_from(MACHINES)),
        counts_per_step=gear,
        marker_every=draw(st.sampled_from([None, 400])) if gear else None,
        wired_back=bool(config[0] & bits.DIAGNOSTIC) and draw(st.booleans()),
        scan_ticks=draw(st.sampled_from([1, 1, 1, 2, 8])),
    )
    start = 1000 * config[2] + config[3]
    told = draw(st.lists(stories(start, encoder, encoder and gear == 0), min_size=1, max_size=4))
    steps = [Out(config, 2), Out(NOTHING, 2)]
    for one in told:
        steps += [Recover(config), *one]
    return setting, steps
