"""Random but plausible scripts for a 3601, by theme.

A script is a setting and a list of steps. Stories put steps into an order that makes sense (a move, a
hold, a resume); meddling comes in between. Themes see to it that each part of the manual gets its turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import oracle_bits as bits
import scripts3601 as one
from dice3601 import BYTES, Dice, any_of, pick, story
from faults3601 import faults
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME
from steps3601 import NOTHING, Out, Recover, ToRest

REST = ToRest()


@cache
def meddling(start):
    """What comes in between: mostly one thing, or two."""
    something = any_of(
        *(one.hold, one.resume(start), one.stop, one.reset, one.preset, one.idle, one.wait, one.rest),
        *(one.press, one.press, one.turn, one.marker, one.plc, one.power, one.release, one.all_zero),
        *(one.speed_changed(start), one.target_changed, one.proximity, one.lsw_changed),
        *(one.move(start), one.manual(start), one.find_home(start), one.blend_run),
        *(one.stored_minimum, one.hostile, one.slip(start), one.reconfigured, one.blend_program(start)),
    )
    nothing, twice = story(), story(something, something)
    return any_of(nothing, something, something, twice)


@cache
def moves(start):
    """Absolute and relative moves, Hold and Resume [chapter 4]."""
    between, rest, resume, long = meddling(start), REST, one.resume(start), one.long_move(start)
    held = any_of(one.hold, one.pressed(EXTERNAL))
    other = any_of(one.preset, one.stored_minimum, one.blend_program(start))
    return [
        story(one.move(start), between, rest),
        story(long, held, rest, between, resume, between, rest),
        story(long, one.hold, rest, resume, rest),
        story(long, one.hold, rest, resume, one.hold, rest, resume, rest),
        story(
            long,
            one.hold,
            rest,
            other,
            resume,
            rest,
        ),
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
    between, rest, manual, release = meddling(start), REST, one.manual(start), one.release
    limit = one.pressed(CW_LIMIT, CCW_LIMIT)
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
    between, rest, move = meddling(start), REST, one.registration(start)
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
        story(one.stored_minimum, plain, one.release, between, between, rest),
        story(outside, move, rest),
    ]


@cache
def homing(start):
    """The four kinds of homing [chapter 3, item 10; chapter 4, Find Home]."""
    between, rest, home = meddling(start), ToRest(1_200), one.find_home(start)
    signal = any_of(one.proximity, one.marker, one.pressed(HOME), one.press)
    limit = one.pressed(CW_LIMIT, CCW_LIMIT)
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
    between, rest, run = meddling(start), REST, one.blend_run
    programmed, good = one.blend_program(start), one.good_blend_program(start)
    return [
        story(programmed, run, between, rest),
        story(programmed, between, run, one.wait, between, rest, one.all_zero, run, rest),
        story(good, run, rest, one.idle, run, rest),
        story(good, run, one.hold, ToRest(4_000), one.reset),
        story(good, run, one.hold, ToRest(4_000), one.idle, run),
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
        story(move, one.turn, between, one.turn, REST),
        story(move, between, REST),
        story(move, one.pressed(EXTERNAL), one.turn, REST),
        story(one.turn, one.preset, one.turn, one.pressed(CAPTURE), one.move(start), REST),
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
        story(steady, turn, any_of(one.hostile, one.hold, one.lsw_changed, ccw)),
    ]


@cache
def states(start):
    """Configuration mode, power, the PLC's mode, presets, captures, and words that nobody should write."""
    between, rest, long = meddling(start), REST, one.long_move(start)
    return [
        story(one.hostile, between, one.hostile),
        story(one.reconfigured, between, one.move(start), rest),
        story(long, one.reconfigured, between, rest),
        story(long, one.stopped_plc, one.wait, one.running_plc, one.wait, rest),
        story(one.long_move(start), one.power, between),
        story(one.pressed(CAPTURE), one.move(start), rest, one.press, rest),
        story(one.preset, one.idle, one.preset, between, one.absolute(start), rest),
        story(one.slip(start), one.idle, one.slip(start), one.reset, one.slip(start)),
        story(one.few_inputs, one.pressed(EXTERNAL, ESTOP), one.move(start), rest),
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


STORIES = {"errors": 20}
"""How many there may be in a script, if not 6."""

SETTING_BYTES = 10


@cache
def scripts(theme=None):
    """A setting and the steps to play on it; without a theme, one of them is drawn."""
    return st.sampled_from(list(THEMES)).flatmap(_script) if theme is None else _script(theme)


@st.composite
def _script(draw, theme):
    most = STORIES.get(theme, 6)
    size = SETTING_BYTES + most * BYTES
    thrown = draw(st.binary(min_size=size, max_size=size))
    setting, config, start, position = _settings(theme)(Dice(thrown, draw))
    stories = list(THEMES[theme](start))
    steps: list[Any] = [Out(config, 2), Out(NOTHING, 2)]
    for at in range(SETTING_BYTES, size, BYTES):
        dice = Dice(thrown[at : at + BYTES], draw)
        if dice.one_of([False, True, True, True]):
            told = dice.one_of(stories)
            steps += [Recover(config, position), *story(told)(dice)]
            if theme == "errors":
                stories.remove(told)  # so that in not so many scripts each of them is told
    return setting, steps


@cache
def _settings(theme):
    """A recipe of a setting, the words that configure its module, its starting speed, and where it begins."""

    def made(msw, levels, start, position, gear, firmware, switches, marker_every, wired_back, scan_ticks):
        setting = Setting(
            firmware=firmware,
            switches=switches,
            counts_per_step=gear,
            marker_every=marker_every if gear else None,
            wired_back=wired_back and bool(msw & bits.DIAGNOSTIC),
            scan_ticks=scan_ticks,
        )
        return setting, one.configuration_words(msw, levels, start), start, position

    return pick(
        made,
        WITH_ENCODER if theme in ("encoder", "follower") else one.CONFIGURATIONS,
        [0x3F, 0x3F, 0x3F, 0x3E, 0x3B],
        one.STARTING_SPEEDS,
        [500, 500, -12_345],
        [0] if theme == "follower" else [0, 0, 1, 4],
        NEWER.get(theme, one.FIRMWARES),
        one.MACHINES,
        [None, 400],
        [False, True],
        [1, 1, 1, 2, 8],
    )


CI_EXAMPLES = 60
"""Scripts per theme that the CI profile plays against the oracle."""


@cache
def scripts_of(theme: str, examples: int = CI_EXAMPLES) -> tuple:
    """Return the scripts of a theme that the CI profile plays, in its order as far as none of them fails."""
    made = []

    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(scripts(theme))
    def collect(script):
        made.append(script)

    collect()
    return tuple(made)
