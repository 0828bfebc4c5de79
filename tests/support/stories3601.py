"""Random but plausible scripts for a 3601, by theme.

A script is a setting and a list of steps. Stories put steps into an order that makes sense (a move, a
hold, a resume); meddling comes in between. Themes see to it that each part of the manual gets its turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import oracle_bits as bits
import scripts3601 as one
from faults3601 import faults
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME
from steps3601 import NOTHING, Out, Recover, ToRest


def story(*parts):
    """Parts one after the other; a part is a strategy of a step or of a list of steps."""
    return st.tuples(*parts).map(
        lambda values: [s for value in values for s in (value if isinstance(value, list) else [value])]
    )


@cache
def meddling(start):
    """What comes in between."""
    single = st.one_of(
        *(one.hold, one.resume(start), one.stop, one.reset, one.preset, one.idle, one.wait, one.rest),
        *(one.press, one.press, one.turn, one.marker, one.plc, one.power, one.release, one.all_zero),
        *(one.speed_changed(start), one.target_changed, one.proximity, one.lsw_changed),
        *(one.move(start), one.manual(start), one.find_home(start), one.blend_run),
        *(one.stored_minimum, one.hostile, one.slip(start)),
    )
    several = st.one_of(single.map(lambda step: [step]), one.reconfigured, one.blend_program(start))
    return st.lists(several, max_size=2).map(lambda lists: [step for steps in lists for step in steps])


@cache
def moves(start):
    """Absolute and relative moves, Hold and Resume [chapter 4]."""
    between, rest, resume, long = meddling(start), one.rest, one.resume(start), one.long_move(start)
    held = one.hold | one.pressed(EXTERNAL)
    return [
        story(one.move(start), between, rest),
        story(long, held, rest, between, resume, between, rest),
        story(long, one.hold, rest, resume, rest),
        story(long, one.hold, rest, resume, one.hold, rest, resume, rest),
        story(long, one.hold, rest, one.preset | one.stored_minimum | one.blend_program(start), resume, rest),
        story(long, one.stop, one.absolute(start), rest),
        story(one.pressed(EXTERNAL), one.move(start), rest, resume, rest),
        story(one.slip(start), one.idle, one.slip(start), rest),
        story(one.move(start), one.move(start), rest),
        story(one.no_number(start), rest),
        story(long, one.pressed(ESTOP), rest, resume, rest),
        story(long, one.pressed(CW_LIMIT), rest, one.idle, one.move(start), rest),
        story(long, one.pressed(CCW_LIMIT), rest, one.reset, one.move(start), rest),
    ]


@cache
def manual_moves(start):
    """Manual moves: with ramps, at constant speed, one-shots [chapter 4]."""
    between, rest, manual, release = meddling(start), one.rest, one.manual(start), one.release
    limit = one.pressed(CW_LIMIT) | one.pressed(CCW_LIMIT)
    return [
        story(manual, one.speed_changed(start), between, one.speed_changed(start), release, between, rest),
        story(manual, between, release, rest),
        story(manual, one.all_zero, rest),
        story(manual, one.target_changed, rest),
        story(one.one_shot, between, release),
        story(one.one_shot, release, one.move(start), rest),
        story(limit, manual, one.wait, release, rest),
        story(manual, limit, one.reset, one.idle, manual, rest),
    ]


@cache
def registration_moves(start):
    """Registration moves and the minimum registration distance [chapter 4]."""
    between, rest, move = meddling(start), one.rest, one.registration(start)
    plain, outside = one.good_registration(start), one.pressed(EXTERNAL)
    return [
        story(move, between, one.release, between, rest),
        story(plain, one.release, rest),
        story(plain, outside, rest, one.release),
        story(plain, one.hold, rest),
        story(plain, one.release, one.hold, rest),
        story(plain, one.target_changed, rest),
        story(plain, one.speed_changed(start), one.release, rest),
        story(one.stored_minimum, plain, outside, rest, one.release),
        story(one.stored_minimum, plain, one.speed_changed(start), between, one.release, rest),
        story(outside, move, rest),
    ]


@cache
def homing(start):
    """The four kinds of homing [chapter 3, item 10; chapter 4, Find Home]."""
    between, rest, home = meddling(start), st.just(ToRest(1_200)), one.find_home(start)
    signal = one.proximity | one.marker | one.pressed(HOME) | one.press
    limit = one.pressed(CW_LIMIT) | one.pressed(CCW_LIMIT)
    return [
        story(home, between, rest),
        story(home, rest, one.move(start), rest),
        story(home, signal, signal, signal, signal, rest),
        story(home, one.wait, limit, rest),
        story(limit, home, signal, rest),
        story(one.long_move(start), one.stop, home, rest),
    ]


@cache
def blend_moves(start):
    """Blend programming and blend moves [chapters 4 and 5]."""
    between, rest, run = meddling(start), one.rest, one.blend_run
    programmed, good = one.blend_program(start), one.good_blend_program(start)
    return [
        story(programmed, run, between, rest),
        story(programmed, between, run, one.wait, between, rest, one.all_zero, run, rest),
        story(good, run, rest, one.idle, run, rest),
        story(good, run, one.hold, st.just(ToRest(4_000)), one.reset),
        story(good, run, one.hold, st.just(ToRest(4_000)), one.idle, run),
        story(good, run, programmed, rest, run),
        story(one.faulty_blend_program(start), one.reset, one.faulty_blend_program(start), run),
        story(one.incomplete_blend_program(start), run, rest),
        story(one.long_move(start), programmed, run),
    ]


@cache
def encoder_moves(start):
    """Moves until the encoder has counted so far [chapter 4, Encoder Move]."""
    between, move = meddling(start), one.encoder_move(start)
    return [
        story(move, one.turn, between, one.turn, one.rest),
        story(move, between, one.rest),
        story(move, one.pressed(EXTERNAL), one.turn, one.rest),
        story(one.turn, one.preset, one.turn, one.pressed(CAPTURE), one.move(start), one.rest),
    ]


@cache
def following(start):
    """Encoder follower mode [chapter 4, Encoder Follower]."""
    between, turn, both = meddling(start), one.turn, [0, bits.MANUAL_CW, bits.MANUAL_CCW]
    still, cw, ccw = one.follow([0]), one.follow([bits.MANUAL_CW]), one.follow([bits.MANUAL_CCW])
    steady = one.steady_follow(both)
    return [
        story(still, cw, turn, still, ccw, turn, one.all_zero),
        story(one.follow([0, bits.MANUAL_CW]), turn, between, one.follow(both), turn, between),
        story(steady, turn, steady, turn, one.all_zero),
        story(steady, turn, one.hostile | one.hold | one.lsw_changed | ccw),
    ]


@cache
def states(start):
    """Configuration mode, power, the PLC's mode, presets, captures, and words that nobody should write."""
    between, rest, long = meddling(start), one.rest, one.long_move(start)
    return [
        story(one.hostile, between, one.hostile),
        story(one.reconfigured, between, one.move(start), rest),
        story(long, one.reconfigured, between, rest),
        story(long, one.stopped_plc, one.wait, one.running_plc, one.wait, rest),
        story(one.long_move(start), one.power, between),
        story(one.pressed(CAPTURE), one.move(start), rest, one.press, rest),
        story(one.preset, one.idle, one.preset, between, one.absolute(start), rest),
        story(one.slip(start), one.idle, one.slip(start), one.reset, one.slip(start)),
        story(one.few_inputs, one.pressed(EXTERNAL) | one.pressed(ESTOP), one.move(start), rest),
        story(one.two_bits, one.idle, one.sloppy_reset, one.idle, one.reset, one.two_bits),
    ]


@cache
def errors(start):
    """Every error in the manual's lists, provoked on purpose [chapters 3 and 6]."""
    return list(faults(start).values())


THEMES = {
    "moves": moves,
    "manual": manual_moves,
    "registration": registration_moves,
    "homing": homing,
    "blend": blend_moves,
    "encoder": encoder_moves,
    "follower": following,
    "states": states,
    "errors": errors,
}
"""What a script may be about; each has the stories that its part of the manual calls for."""


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


WITH_ENCODER = [0x853F, 0x853F, 0x953F, 0x957B]
NEWER = {
    "registration": ["4.1", "3.1", "4.1", "2.2"],
    "follower": ["4.1", "4.1", "4.1", "3.1"],
    "errors": ["4.1", "4.1", "4.1", "2.0"],
}
"""Firmware versions for what the older ones do not have."""


@cache
def scripts(theme=None):
    """A setting and the steps to play on it; without a theme, one of them is drawn."""
    return st.sampled_from(list(THEMES)).flatmap(_script) if theme is None else _script(theme)


@st.composite
def _script(draw, theme):
    with_encoder = theme in ("encoder", "follower")
    msw = draw(st.sampled_from(WITH_ENCODER if with_encoder else one.CONFIGURATIONS))
    levels = draw(st.sampled_from([0x3F, 0x3F, 0x3F, 0x3E, 0x3B]))
    start = draw(one.starting_speeds)
    config = one.configuration_words(msw, levels, start)
    gear = 0 if theme == "follower" else draw(st.sampled_from([0, 0, 1, 4]))
    setting = Setting(
        firmware=draw(st.sampled_from(NEWER.get(theme, one.FIRMWARES))),
        switches=draw(st.sampled_from(one.MACHINES)),
        counts_per_step=gear,
        marker_every=draw(st.sampled_from([None, 400])) if gear else None,
        wired_back=bool(config[0] & bits.DIAGNOSTIC) and draw(st.booleans()),
        scan_ticks=draw(st.sampled_from([1, 1, 1, 2, 8])),
    )
    told = draw(_many(THEMES[theme](start)) if theme == "errors" else _some(THEMES[theme](start)))
    steps = [Out(config, 2), Out(NOTHING, 2)]
    for each in told:
        steps += [Recover(config), *each]
    return setting, steps


def _some(stories):
    return st.lists(st.one_of(stories), min_size=1, max_size=6)


def _many(stories):
    """No story twice, so that in not so many scripts each of them is told."""
    chosen = st.lists(st.sampled_from(stories), unique_by=id, min_size=10, max_size=20)
    return chosen.flatmap(lambda each: st.tuples(*each))
