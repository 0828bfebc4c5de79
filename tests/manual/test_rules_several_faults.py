"""Several faults in one command: each row of chapter 6 sets its bit, and none hides another (reading A-110).

Every command is given with every pair of its faults. What has to show is the union of the bits that the
rule table gives for each of the two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import combinations_with_replacement

import pytest
from bench3601 import (
    ABSOLUTE,
    BLEND_CW,
    ENCODER,
    HOLD,
    HOME_CCW,
    HOME_CW,
    MANUAL_CCW,
    MANUAL_CW,
    PRESET,
    PRESET_ENCODER,
    RELATIVE,
    RESET,
    RESUME,
    Bench,
    configuration,
)
from blends3601 import program
from refusals3601 import ERRORS
from scanrack.io_images.amci3601 import RULES
from scanrack.io_images.amci3601.rules.rule import bit_names
from scanrack.runtime.modules.amci3601 import refusals
from scanrack.runtime.modules.amci3601.refusals import RefusalRule, Refusals

CW_LIMIT_USED = 0x0010
ENCODER_MOVE, FOLLOW, STORE = 0x0004, 0x0080, 0x0400
MOVE = (0, 0, 5, 0, 20, 10)
REGISTRATION = (3, 0, 5, 0, 20, 10)
NONE = (0,) * 6


@dataclass(frozen=True)
class Way:
    """How a rule is broken.

    Attributes:
        words: output words that are given another value, by number.
        set_bits: bits added to output words, by number.
        scene: what has to be so when the command comes.
    """

    words: dict[int, int] = field(default_factory=dict)
    set_bits: dict[int, int] = field(default_factory=dict)
    scene: str = ""


NO_RATE = Way({6: 0})
TARGET = Way({3: 1})
LSW_SET = Way(set_bits={1: 1})
WAYS: dict[Callable[..., bool], Way] = {
    refusals.busy: Way(scene="busy"),
    refusals.external_still_on: Way(scene="still held"),
    refusals.parameters_out_of_range: NO_RATE,
    refusals.speed_or_rates_out_of_range: NO_RATE,
    refusals.manual_parameters_illegal: NO_RATE,
    refusals.registration_parameters_illegal: NO_RATE,
    refusals.slower_than_start: Way({4: 0, 5: 999}),
    refusals.position_invalid: Way(scene="position invalid"),
    refusals.no_encoder: Way(scene="no encoder"),
    refusals.estop_active: Way(scene="estop"),
    refusals.any_limit_active: Way(scene="cw_limit"),
    refusals.same_limit_active: Way(scene="cw_limit"),
    refusals.target_not_zero: TARGET,
    refusals.direction_without_limit: Way(scene="no limit"),
    refusals.s_curve_selected: LSW_SET,
    refusals.target_given_to_old_firmware: Way({3: 1}, scene="old firmware"),
    refusals.target_negative: Way({2: -3}),
    refusals.too_short_to_stop: Way({2: 0, 3: 7}),
    refusals.external_active: Way(scene="external"),
    refusals.lsw_not_zero: LSW_SET,
    refusals.data_given: TARGET,
    refusals.not_programmed: Way(scene="no profile"),
    refusals.profile_words_given: Way({6: 1}),
    refusals.target_illegal: Way({2: 8388, 3: 608}),
    refusals.not_held: Way(scene="not held"),
    refusals.command_or_rates_given: Way({6: 1}),
    refusals.distance_illegal: Way({2: -1}),
    refusals.other_than_manual: Way(set_bits={0: HOLD}),
    refusals.several_commands: Way(set_bits={0: MANUAL_CW | MANUAL_CCW}),
    refusals.ratio_illegal: Way({2: 0}),
    refusals.speed_words_given: Way({5: 1}),
    refusals.follower_rates_illegal: Way({6: 2001}),
}
SEVERAL = RefusalRule("CMD-02", lambda layer, order: order.many_bits)
"""Any other command bit beside the command's own; Hold's own rule sets Command Error, too."""

COMMANDS: dict[str, tuple[int, int, tuple[int, ...], Refusals]] = {
    "absolute": (ABSOLUTE, 0, MOVE, refusals.ABSOLUTE),
    "relative": (RELATIVE, 0, MOVE, refusals.RELATIVE),
    "absolute encoder": (ABSOLUTE, ENCODER_MOVE, MOVE, refusals.ENCODER_ABSOLUTE),
    "relative encoder": (RELATIVE, ENCODER_MOVE, MOVE, refusals.ENCODER_RELATIVE),
    "resume": (RESUME, 0, MOVE, refusals.RESUME),
    "home": (HOME_CW, 0, MOVE, refusals.FIND_HOME),
    "manual": (MANUAL_CW, 0, MOVE, refusals.MANUAL),
    "registration": (MANUAL_CW, 0, REGISTRATION, refusals.REGISTRATION),
    "blend": (BLEND_CW, 0, NONE, refusals.RUN_BLEND),
    "preset": (PRESET, 0, NONE, refusals.PRESET_POSITION),
    "preset encoder": (PRESET_ENCODER, 0, NONE, refusals.PRESET_ENCODER),
    "reset": (RESET, 0, NONE, refusals.RESET_ERRORS),
    "minimum": (0, STORE, NONE, refusals.STORE_MINIMUM),
    "follower": (0, FOLLOW, (1, 1, 0, 0, 0, 0), refusals.FOLLOWER),
}
IMPOSSIBLE = [
    {"busy", "estop"},  # it ends any motion
    {"busy", "still held"},
    {"busy", "not held"},  # a Resume without a hold, as it is anyway
    {"still held", "not held"},
    {"still held", "cw_limit"},  # each ends what is held
    {"still held", "estop"},
]


def ways_of(name: str, row: RefusalRule) -> Way:
    return Way(set_bits={0: HOLD}) if row is SEVERAL else WAYS[row.broken]


def agree(name: str, one: RefusalRule, other: RefusalRule) -> bool:
    """Whether both rules can be broken at once."""
    ways = ways_of(name, one), ways_of(name, other)
    scenes = {way.scene for way in ways}
    if scenes in IMPOSSIBLE or any(ways[0].words.get(at, word) != word for at, word in ways[1].words.items()):
        return False
    if scenes == {"busy", "cw_limit"}:
        return name in ("manual", "registration")  # otherwise what a limit does is the running move's matter
    return True


def pairs() -> Iterator[object]:
    for name, (*_, rows) in COMMANDS.items():
        several = () if name in ("minimum", "follower") else (SEVERAL,)
        for one, other in combinations_with_replacement((*rows, *several), 2):
            if agree(name, one, other):
                yield pytest.param(name, one, other, id=f"{name}: {one.rule} {other.rule}")


def scene(name: str, scenes: set[str]) -> Bench:
    """Return a bench on which the command is right but for what the scenes say."""
    config = configuration(
        add=0 if "no encoder" in scenes else ENCODER, drop=CW_LIMIT_USED if "no limit" in scenes else 0
    )
    options = {"one_step_under_external": False} if "still held" in scenes else {}
    bench = Bench.configured("2.2" if "old firmware" in scenes else "4.1", config=config, **options)
    if name == "blend" and "no profile" not in scenes:
        program(bench)
    if "position invalid" not in scenes:
        bench.out(PRESET).run(1).idle()
    if "still held" in scenes:
        bench.relative(20_000, ms=300).inputs(external=1).until("HOLD_STATE")
    elif name == "resume" and "not held" not in scenes:
        bench.relative(20_000, ms=300).out(HOLD).until("HOLD_STATE")
    inputs = {each: 1 for each in ("estop", "cw_limit", "external") if each in scenes}
    if name == "resume":
        return bench.idle().inputs(**inputs)  # an input that comes before it ends what is held
    bench.idle().inputs(**inputs).run(1)
    if "estop" in scenes:
        bench.reset_errors()
    if "busy" in scenes:  # a search in the other direction, which the limit behind does not concern
        bench.command(HOME_CCW).run(5).idle()
        assert "MOVING_CCW" in bench.bits
    return bench


def bits_of(row: RefusalRule) -> set[str]:
    """Bits that the rule table gives for a row and those that share its cause."""
    rules = (row.rule,) if row.alone else (row.rule, *RULES[row.rule].together_with)
    return {name for rule in rules for name in bit_names(RULES[rule].if_broken or RULES[rule].sets)}


@pytest.mark.rules("CMD-02", "CMD-03", "CMD-04", "CMD-05", "CMD-06", "PRF-01", "PRF-02", "HOM-01", "HOM-02")
@pytest.mark.rules("HOM-03", "INP-01", "INP-02", "INP-03", "CMD-08", "CMD-10", "CMD-12", "CMD-17", "CMD-23")
@pytest.mark.parametrize(("name", "one", "other"), list(pairs()))
def test_both_faults_show(name, one, other):
    msw, lsw, given, _ = COMMANDS[name]
    words = [msw, lsw, *given]
    ways = ways_of(name, one), ways_of(name, other)
    bench = scene(name, {way.scene for way in ways})
    before = bench.bits & ERRORS
    for way in ways:
        for at, word in way.words.items():
            words[at] = word
        for at, added in way.set_bits.items():
            words[at] |= added
    bench.out(*words).scan()
    assert bench.bits & ERRORS == before | bits_of(one) | bits_of(other)
    assert "MOVING_CW" not in bench.bits


def test_every_row_of_every_command_is_broken_here():
    rows = {row.broken for *_, table in COMMANDS.values() for row in table}
    assert rows == set(WAYS)
    tables = {
        value
        for name, value in vars(refusals).items()
        if name.isupper() and isinstance(value, tuple) and value and isinstance(value[0], RefusalRule)
    }
    assert {row.broken for table in tables for row in table} == rows


@pytest.mark.rules("HOM-01", "CMD-05", "PRF-01", "HOM-02", "CMD-10")
@pytest.mark.parametrize(
    ("words", "bits"),
    [
        pytest.param(
            (32, 0, 0, 5, 0, 999, 20, 10),
            {"HOME_INVALID", "COMMAND_ERROR", "INVALID_PROFILE"},
            id="target 5, speed 999",
        ),
        pytest.param(
            (32, 1, 0, 0, 0, 999, 20, 10),
            {"HOME_INVALID", "COMMAND_ERROR", "INVALID_PROFILE"},
            id="S-curve, speed 999",
        ),
        pytest.param((32, 1, 0, 5, 5, 0, 20, 10), {"HOME_INVALID", "COMMAND_ERROR"}, id="S-curve, target 5"),
        pytest.param(
            (0x0021, 0, 0, 5, 5, 0, 20, 10),
            {"HOME_INVALID", "COMMAND_ERROR"},
            id="Absolute beside it, target 5",
        ),
    ],
)
def test_two_faults_in_one_find_home(words, bits):
    assert Bench.ready().out(*words).run(5).bits == {"MODULE_OK", *bits}


@pytest.mark.rules("BLD-21", "BLD-18", "CMD-05", "PRF-01", "PRF-06")
@pytest.mark.parametrize(
    "wrong",
    [
        pytest.param({2: -1}, id="negative length"),
        pytest.param({3: 1000}, id="length LSW 1000"),
        pytest.param({6: 0}, id="no rate"),
    ],
)
def test_a_blend_segment_that_is_too_slow_and_wrong_otherwise(wrong):
    """Too slow is a command error, too, which the other fault does not hide."""
    bench = Bench.ready()
    bench.out(0, 0x0300, 2, 0, 0, 10).run(1).out(0, 0x0100).run(1)
    words = [0, 0x0300, 3, 0, 0, 999, 20, 0]
    for at, word in wrong.items():
        words[at] = word
    bench.out(*words).run(1)
    assert bench.bits == {"MODULE_OK", "BLEND_ACK", "COMMAND_ERROR", "INVALID_PROFILE"}


@pytest.mark.rules("CMD-03", "INP-02")
def test_limits_while_a_search_runs_are_no_matter_of_a_refused_move():
    """What a limit does to a search is the search's matter; the refused move would not have begun."""
    bench = scene("relative", {"busy", "cw_limit"}).relative(5).run(5)
    assert bench.bits & ERRORS == {"COMMAND_ERROR"}
