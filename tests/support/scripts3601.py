"""Strategies of single steps: what a PLC programmer does, and now and then what he shouldn't."""

from __future__ import annotations

from functools import cache

import oracle_bits as bits
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME, PROXIMITY
from scanrack.io_images import split_thousands
from scanrack.io_images import strategies as images
from scanrack.io_images.amci3601 import Firmware
from steps3601 import NOTHING, Alter, Input, Marker, Out, Plc, PowerCycle, ToRest, Turn, Wait

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


def pressed(bit):
    """An input that comes on, for a while or to stay."""
    return st.builds(Input, st.just(bit), st.just(True), st.sampled_from([0, 0, 5, 100]))


turn = st.builds(Turn, st.sampled_from([100, -100, 4000, -3, 1001]), ticks, st.booleans())
marker = st.builds(Marker, ticks)
proximity = st.builds(lambda on, t: Alter(((1, PROXIMITY if on else 0),), t), st.booleans(), ticks)
lsw_changed = st.builds(lambda lsw, t: Alter(((1, lsw),), t), st.sampled_from([0, 1, 2, 4, 0x1000]), few)
target_changed = st.builds(lambda value, t: Alter(((3, value),), t), st.sampled_from([0, 1, 500]), ticks)
plc = st.builds(Plc, st.booleans(), few)
running_plc, stopped_plc = st.builds(Plc, st.just(True), few), st.builds(Plc, st.just(False), few)
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


two_bits = plain(
    bits.ABSOLUTE | bits.RELATIVE,
    bits.RELATIVE | bits.HOLD,
    bits.MANUAL_CW | bits.MANUAL_CCW,
    bits.PRESET_POSITION | bits.RESET_ERRORS,
)
sloppy_reset = st.builds(
    lambda lsw, t: Out((bits.RESET_ERRORS, lsw, *NOTHING[2:]), t), st.sampled_from([1, 4, 0x1000]), few
)


@cache
def no_number(start):
    """A relative move whose target or speed is a pair of words that is no value."""
    pairs = st.sampled_from([(3, 1000), (3, -1), (5, 1000), (5, -999), (3, 2001)])
    return st.builds(
        lambda speed, pair: Alter(
            (*enumerate(images.parameter_words(2, 0, 1000, speed, (100, 50))), pair), 2
        ),
        speeds(start),
        pairs,
    )


@cache
def slip(start):
    """A command with a slip of the pen."""
    return st.builds(shown, images.nearly_right_images(start), few)


# ---- starts of motions


@cache
def move(start):
    return command([bits.RELATIVE, bits.RELATIVE, bits.ABSOLUTE], shapes, distances, speeds(start))


@cache
def absolute(start):
    return command([bits.ABSOLUTE], st.just(0), distances, speeds(start), good_rates)


@cache
def long_move(start):
    far = st.sampled_from([600, -900, 20_000, 8_388_607])
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
def good_registration(start):
    """One that starts, unless an input or the firmware is against it."""
    fast = st.sampled_from([2 * start, start, start + 1, 3 * start])
    steep = st.sampled_from([(1000, 1000), (2000, 2000)])
    return command(
        [bits.MANUAL_CW, bits.MANUAL_CCW], shapes, st.sampled_from([300, 3000, 20_000]), fast, steep
    )


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


def steady_follow(msws):
    """Words that keep the module in the mode."""
    ratios = st.sampled_from([(1, 1), (7, 3), (3, 7), (1, 1000)])
    return st.builds(
        lambda msw, ratio, t: Out((msw, bits.FOLLOW, *ratio, 0, 0, 0, 0), t),
        st.sampled_from(msws),
        ratios,
        ticks,
    )


blend_run = plain(bits.RUN_BLEND_CW, bits.RUN_BLEND_CCW)

# ---- blend programming


TOLERATED = {"types": (0, 4, 0b10), "reserved words": (0, 7, 5), "a block too many": None}
"""What the module overlooks in a blend profile (reading A-60)."""


@cache
def good_blend_program(start):
    return images.blend_profiles(start, most=3).map(lambda profile: blocks_sent(profile.blocks()))


@cache
def faulty_blend_program(start):
    return images.faulty_blends(max(start, 2)).map(lambda faulty: blocks_sent(faulty.blocks))


@cache
def incomplete_blend_program(start):
    return images.blend_profiles(start, most=4).map(lambda profile: blocks_sent(profile.blocks()[:-1]))


@st.composite
def blend_program(draw, start):
    """Header and segments, block by block, with or without a fault."""
    faulty = draw(st.sampled_from([False, False, True]))
    if faulty:
        return draw(faulty_blend_program(start))
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
few_inputs = st.builds(
    lambda start: [Out(configuration_words(0x8414, 0x3F, start), 2), Out(NOTHING, 2)], starting_speeds
)
"""Home switch and CW limit, nothing else: what the other inputs do must not matter."""
any_configuration = images.configurations(Firmware(2, 0)).map(lambda it: tuple(it.to_image()))
bad_configuration = images.faulty_configurations(Firmware(2, 0)).map(lambda faulty: tuple(faulty.image))
reconfigured = st.builds(
    lambda config, t: [Out(config, t), Out(NOTHING, 2)],
    st.one_of(good_configuration, any_configuration, bad_configuration),
    ticks,
)
