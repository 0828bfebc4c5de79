"""For each error of the manual's lists, the steps that make it: no rule is left to chance."""

from __future__ import annotations

from functools import cache

import oracle_bits as bits
import scripts3601 as one
from dice3601 import drawn
from oracle_bits import CCW_LIMIT, CW_LIMIT, EXTERNAL
from scanrack.io_images import split_thousands
from scanrack.io_images import strategies as images
from scanrack.io_images.amci3601 import Acceleration, BlendHeader, BlendSegment, Firmware
from scanrack.io_images.amci3601.configuration import INVALID_CONFIGURATIONS
from steps3601 import NOTHING, Alter, Input, Out, ToRest

RATES = (1000, 1000)
TYPES = (Acceleration.CONSTANT, Acceleration.CONSTANT)


def told(msw, lsw, target, speed, rates=RATES, ticks=4):
    """A step that writes these words."""
    return Out(images.parameter_words(msw, lsw, target, speed, rates), ticks)


def configured(msw, start):
    """Steps that configure, with what MSW says."""
    return [Out(one.configuration_words(msw, 0x3F, start), 2), Out(NOTHING, 2)]


def changed_speed(speed, *rates):
    """A step that alters the programmed speed, and the rates if they are given."""
    return Alter((*zip((4, 5), split_thousands(speed), strict=True), *zip((6, 7), rates, strict=False)), 4)


@cache
def faults(start):
    """Stories by the rule that they break: lists of steps, or recipes of them."""
    fast, cw, home = min(5 * start, 1_000_000), bits.MANUAL_CW, bits.FIND_HOME_CW
    manual, registration = told(cw, 0, 0, fast), told(cw, 0, 20_000, fast)
    external, blend = Input(EXTERNAL, True, 0), [one.shown(image, 1) for image in _blend(start)]
    with_encoder, plain = configured(0x853F, start), configured(0x843E, start)
    follow = Out((cw, bits.FOLLOW, 1, 1, 0, 0, 0, 0), 4)
    made = {
        "CMD-09": [told(bits.PRESET_POSITION, 0, 500, 1, (0, 0))],
        "CMD-13": [told(cw, 0, 0, start), changed_speed(2 * start)],
        "CMD-20": [told(0, bits.STORE_MINIMUM, -1, 0, (0, 0))],
        "CMD-24": [told(cw, 0, -5, fast)],
        "CMD-14": [manual, Out(NOTHING, 4)],
        "CMD-15": [manual, changed_speed(2 * start, 0, 10)],
        "CMD-17": [*blend, Out((bits.RUN_BLEND_CW, 0, 0, 1, 0, 0, 0, 0), 4)],
        "CMD-22": [external, registration],
        "CMD-25": [manual, Alter(((3, 1),), 4)],
        "CMD-26": [registration, Alter(((3, 1),), 4)],
        "CMD-27": [registration, changed_speed(fast + 1)],
        "CMD-28": [registration, changed_speed(2 * start, 999, 1000)],
        "CMD-29": [*plain, follow],
        "CMD-30": [*with_encoder, told(bits.RELATIVE, 0, 20_000, fast), follow],
        "CMD-31": [*with_encoder, Out((cw, bits.FOLLOW, 1, 0, 0, 0, 0, 0), 4)],
        "CMD-32": [*with_encoder, Out((cw, bits.FOLLOW, 1, 1, 0, 1, 0, 0), 4)],
        "CMD-33": [*with_encoder, follow, Out((bits.MANUAL_CCW, bits.FOLLOW, 1, 1, 0, 0, 0, 0), 4)],
        "CMD-34": [*with_encoder, follow, Out((bits.HOLD, bits.FOLLOW, 1, 1, 0, 0, 0, 0), 4)],
        "CMD-35": [*with_encoder, follow, Out((cw, 0, 1, 1, 0, 0, 0, 0), 4)],
        "CMD-36": [*with_encoder, Out((cw, bits.FOLLOW | bits.S_CURVE, 1, 1, 0, 0, 0, 0), 4)],
        "ENC-05": [*plain, told(bits.RELATIVE, bits.ENCODER_MOVE, 1000, fast)],
        "HOM-01": [*plain, told(home, 0, 0, start - 1)],
        "HOM-02": [*plain, told(home, 0, 1, fast)],
        "HOM-03": [*configured(0x8424, start), told(home, 0, 0, fast)],
        "HOM-04": [
            *(*plain, told(home, 0, 0, fast), Input(CW_LIMIT, True, 0)),
            *(Input(CCW_LIMIT, True, 0), ToRest(100)),
        ],
        "HOM-05": [*plain, told(home, 0, 0, fast), Input(CCW_LIMIT, True, 0), ToRest(100)],
    }
    stories = dict(made)
    for rule, _ in INVALID_CONFIGURATIONS:
        stories[rule] = _configurations(rule)
    for rule in images.BLEND_FAULTS:
        faulty = images.faulty_blends(min(max(start, 2), 100_000), [rule], most=3)
        stories[f"blend {rule}"] = drawn(faulty, lambda faulty: one.blocks_sent(faulty.blocks))
    return stories


def _configurations(rule):
    """Words that break one rule, if need be in the oldest firmware only."""
    faulty = images.faulty_configurations(Firmware(2, 0), (rule,))
    return drawn(faulty, lambda faulty: [Out(tuple(faulty.image), 2), Out(NOTHING, 2)])


def _blend(start):
    """The images that send a profile."""
    segments = (BlendSegment(1000, start, 1000), BlendSegment(1000, start + 1, 1000))
    return images.handshake(images.BlendProfile(BlendHeader(TYPES, 1000), segments).blocks())
