"""Recipes of single steps: what a PLC programmer does, and now and then what he shouldn't."""

from __future__ import annotations

from functools import cache

import oracle_bits as bits
from dice3601 import any_of, drawn, pick
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

FEW = [1, 2, 5]
RATES = [*images.RATES, *images.RATES, *images.FAULTY_RATES]
STARTING_SPEEDS = [1000, *images.STARTING_SPEEDS]


@cache
def speeds(start):
    """Mostly legal programmed speeds for a starting speed."""
    legal = images.plain_speeds(start)
    return [*legal, *legal, 1_000_000, 7_777, max(0, start - 1)]


def shown(image, ticks):
    """A step that writes an image."""
    return Out(tuple(image), ticks)


def command(msws, lsws, targets, programmed_speeds, some_rates=RATES, durations=TICKS):
    """A step that writes a command."""

    def made(msw, lsw, target, speed, pair, ticks):
        return Out(images.parameter_words(msw, lsw, target, speed, pair), ticks)

    return pick(made, msws, lsws, targets, programmed_speeds, some_rates, durations)


def plain(*msws):
    """A step that writes a command without parameters."""
    return pick(lambda msw, ticks: Out((msw, *NOTHING[1:]), ticks), msws, FEW)


def altered(index, values, durations=TICKS):
    """A step that changes one word."""
    return pick(lambda value, ticks: Alter(((index, value),), ticks), values, durations)


# ---- single steps

idle = pick(lambda ticks: Alter(((0, 0), (1, 0)), ticks), FEW)
wait = pick(Wait, TICKS)
rest = pick(ToRest)
release = altered(0, [0])
all_zero = pick(lambda ticks: Out(NOTHING, ticks), TICKS)
hold = altered(0, [bits.HOLD])
stop = plain(bits.IMMEDIATE_STOP)
reset = plain(bits.RESET_ERRORS)
preset = command(
    [bits.PRESET_POSITION, bits.PRESET_POSITION, bits.PRESET_ENCODER],
    [0, 0, 0, 1],
    [0, 500, -12_345, 8_388_607, -8_388_608],
    [0, 0, 0, 1],
    [(0, 0)],
    FEW,
)
press = pick(
    Input,
    [EXTERNAL, EXTERNAL, HOME, CAPTURE, ESTOP, CW_LIMIT, CCW_LIMIT],
    [True, True, True, False],
    [0, 1, 5, 100],
)


def pressed(*inputs):
    """An input that comes on, for a while or to stay."""
    return pick(Input, inputs, [True], [0, 0, 5, 100])


turn = pick(Turn, [100, -100, 4000, -3, 1001], TICKS, [False, True])
marker = pick(Marker, TICKS)
proximity = altered(1, [0, PROXIMITY])
lsw_changed = altered(1, [0, 1, 2, 4, 0x1000], FEW)
target_changed = altered(3, [0, 1, 500])
plc, running_plc, stopped_plc = (pick(Plc, states, FEW) for states in ([False, True], [True], [False]))
power = pick(PowerCycle)
hostile = drawn(images.hostile_images(), lambda image: shown(image, 2))
stored_minimum = command(
    [0], [bits.STORE_MINIMUM], [50, 200, 0, 1000, -1, 8_388_607], [0, 0, 0, 1], [(0, 0)], FEW
)


@cache
def resume(start):
    return command([bits.RESUME], SHAPES, [0, 7, -9], speeds(start))


@cache
def speed_changed(start):
    def altered_speed(speed, some_rates, ticks):
        pairs = list(zip((4, 5), split_thousands(speed), strict=True))
        if some_rates:
            pairs += zip((6, 7), some_rates, strict=True)
        return Alter(tuple(pairs), ticks)

    faster = [*speeds(start), *[0, 1, 2 * start, 3 * start, 10 * start] * 3]
    return pick(altered_speed, faster, [*[None] * 32, *RATES], TICKS)


two_bits = plain(
    bits.ABSOLUTE | bits.RELATIVE,
    bits.RELATIVE | bits.HOLD,
    bits.MANUAL_CW | bits.MANUAL_CCW,
    bits.PRESET_POSITION | bits.RESET_ERRORS,
)
sloppy_reset = pick(
    lambda lsw, ticks: Out((bits.RESET_ERRORS, lsw, *NOTHING[2:]), ticks), [1, 4, 0x1000], FEW
)


@cache
def no_number(start):
    """A relative move whose target or speed is a pair of words that is not a value."""
    pairs = [(3, 1000), (3, -1), (5, 1000), (5, -999), (3, 2001)]
    return pick(
        lambda speed, pair: Alter(
            (*enumerate(images.parameter_words(2, 0, 1000, speed, (100, 50))), pair), 2
        ),
        speeds(start),
        pairs,
    )


@cache
def slip(start):
    """A command with a slip of the pen."""
    return drawn(images.nearly_right_images(start), lambda image: shown(image, 2))


# ---- starts of motions


@cache
def move(start):
    return command([bits.RELATIVE, bits.RELATIVE, bits.ABSOLUTE], SHAPES, images.DISTANCES, speeds(start))


@cache
def absolute(start):
    return command([bits.ABSOLUTE], [0], images.DISTANCES, speeds(start), images.RATES)


@cache
def long_move(start):
    return command([bits.RELATIVE], SHAPES, [600, -900, 20_000, 8_388_607], speeds(start), images.RATES)


MANUAL = [bits.MANUAL_CW, bits.MANUAL_CCW]


@cache
def manual(start):
    some = [*speeds(start), *[1, 3 * start // 4, 10 * start] * 5]
    return command(MANUAL, [*SHAPES, bits.ENCODER_MOVE], [0], some)


one_shot = command(MANUAL, SHAPES, [0], [0], RATES, FEW)


@cache
def registration(start):
    return command(MANUAL, SHAPES, [300, 3000, 20_000, 1, -5], speeds(start))


@cache
def good_registration(start):
    """One that starts, unless an input or the firmware is against it."""
    fast = [2 * start, start, start + 1, 3 * start]
    return command(MANUAL, SHAPES, [300, 3000, 20_000], fast, [(1000, 1000), (2000, 2000)])


@cache
def find_home(start):
    return command(
        [bits.FIND_HOME_CW, bits.FIND_HOME_CCW],
        [0, 0, 0, 0, PROXIMITY, bits.TRAPEZOIDAL, bits.S_CURVE],
        [0, 0, 0, 0, 0, 1],
        speeds(start),
    )


@cache
def encoder_move(start):
    return command(
        [bits.RELATIVE, bits.RELATIVE, bits.ABSOLUTE],
        [4, 4, 5, 7],
        [100, -100, 1000, 4000, -3, 0],
        speeds(start),
    )


RATIOS = [(1, 1), (7, 3), (3, 7), (1, 1000)]


def follow(msws, ratios=(*RATIOS, (1, 1), (0, 1), (5, -1)), lsws=(bits.FOLLOW, bits.FOLLOW, bits.FOLLOW, 0)):
    """Words of the mode, mostly legal."""

    def made(msw, ratio, lsw, ticks):
        return Out((msw, lsw, *ratio, 0, 0, 0, 0), ticks)

    return pick(made, msws, ratios, lsws, TICKS)


def steady_follow(msws):
    """Words that keep the module in the mode."""
    return follow(msws, RATIOS, [bits.FOLLOW])


blend_run = plain(bits.RUN_BLEND_CW, bits.RUN_BLEND_CCW)

# ---- blend programming


TOLERATED = {"types": (0, 4, 0b10), "reserved words": (0, 7, 5), "a block too many": None}
"""What the module overlooks in a blend profile (reading A-60)."""


@cache
def good_blend_program(start):
    return drawn(images.blend_profiles(start, most=3), lambda profile: blocks_sent(profile.blocks()))


@cache
def faulty_blend_program(start):
    return drawn(images.faulty_blends(max(start, 2)), lambda faulty: blocks_sent(faulty.blocks))


@cache
def incomplete_blend_program(start):
    return drawn(images.blend_profiles(start, most=4), lambda profile: blocks_sent(profile.blocks()[:-1]))


@cache
def blend_program(start):
    """Header and segments, block by block, with or without a fault."""
    good = images.blend_profiles(start, most=4)

    def accepted(dice):
        oddity = dice.one_of([None, None, None, None, *TOLERATED])
        return blocks_sent(made_odd(dice.draw(good).blocks(), oddity))

    return any_of(accepted, accepted, faulty_blend_program(start))


def made_odd(blocks, odd):
    """Blocks in which nothing is wrong, as far as the module looks."""
    if odd == "a block too many":
        blocks.append(blocks[-1])
    elif odd is not None:
        change = TOLERATED[odd]
        assert change is not None, odd
        block, index, word = change
        blocks[block][index] = word
    return blocks


def blocks_sent(blocks):
    """The handshake, an image per tick."""
    return [shown(image, 1) for image in images.handshake(blocks)]


# ---- configurations


def configuration_words(msw, levels, start):
    return (msw - 65_536, levels, *split_thousands(start), 0, 0, 0, 0)


good_configuration = pick(configuration_words, CONFIGURATIONS, [0x3F], STARTING_SPEEDS)
few_inputs = pick(
    lambda start: [Out(configuration_words(0x8414, 0x3F, start), 2), Out(NOTHING, 2)], STARTING_SPEEDS
)
"""Home switch and CW limit, nothing else: what the other inputs do must not matter."""
any_configuration = drawn(images.configurations(Firmware(2, 0)), lambda it: tuple(it.to_image()))
bad_configuration = drawn(images.faulty_configurations(Firmware(2, 0)), lambda it: tuple(it.image))


def reconfigured(dice):
    """Another configuration, or none."""
    config = any_of(good_configuration, any_configuration, bad_configuration)(dice)
    return [Out(config, dice.one_of(TICKS)), Out(NOTHING, 2)]
