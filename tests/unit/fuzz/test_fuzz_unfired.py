"""Why error rules never fired: the first reason that holds, after the sentences of chapter 6."""

from __future__ import annotations

import pytest
from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, ConfigMsw, Firmware, InputBit
from scanrack.jobs.fuzz.explain.unfired import NEEDS, WORDS, UnfiredReason, WordHistory, error_rules, unfired

OLDEST = Firmware(2, 0)
LIMITS = ConfigMsw.MODE_CONFIG | ConfigMsw.USE_CW_LIMIT | ConfigMsw.USE_CCW_LIMIT
HOMES = CommandMsw.MODE_CONFIG | CommandMsw.FIND_HOME_CW


def given(commands=0, second=0, configurations=(), inputs=0):
    return WordHistory(int(commands) | int(second) << 16, {int(each) for each in configurations}, int(inputs))


def reason(rule, words, oldest=OLDEST, others=()):
    """Return the kind of a rule's reason and its sentence."""
    slots = dict(enumerate((words, *others), 1))
    found = unfired((), slots, dict.fromkeys(slots, oldest))
    return next((each.reason, each.sentence) for each in found if each.rule.id == rule)


def test_every_error_rule_has_its_needs_and_every_reason_its_words():
    assert set(NEEDS) == {rule.id for rule in error_rules()}
    assert len(error_rules()) == 72
    assert set(WORDS) == set(UnfiredReason)


@pytest.mark.parametrize(
    ("rule", "words", "why", "says"),
    [
        ("HOM-01", given(), UnfiredReason.COMMAND, "the program never sends FIND_HOME_CW or FIND_HOME_CCW"),
        (
            "HOM-01",
            given(HOMES, configurations=[LIMITS]),
            UnfiredReason.APART,
            "its conditions were never met together",
        ),
        (
            "HOM-03",
            given(HOMES, configurations=[LIMITS]),
            UnfiredReason.CONFIGURATION,
            "every configuration has USE_CW_LIMIT and USE_CCW_LIMIT",
        ),
        ("HOM-03", given(HOMES, configurations=[LIMITS, ConfigMsw.MODE_CONFIG]), UnfiredReason.APART, None),
        ("HOM-04", given(HOMES), UnfiredReason.CONFIGURATION, "no configuration has USE_CW_LIMIT"),
        (
            "HOM-04",
            given(HOMES, configurations=[LIMITS], inputs=InputBit.CW_LIMIT),
            UnfiredReason.INPUTS,
            "CCW_LIMIT was never active",
        ),
        (
            "INP-02",
            given(HOMES, configurations=[LIMITS]),
            UnfiredReason.INPUTS,
            "CW_LIMIT or CCW_LIMIT was never active",
        ),
        ("PRF-03", given(HOMES), UnfiredReason.UNTESTABLE, None),
        ("CMD-10", given(HOMES), UnfiredReason.COMMAND, "the program never sends S_CURVE"),
        ("CMD-10", given(HOMES, CommandLsw.S_CURVE), UnfiredReason.APART, None),
        ("CMD-11", given(CommandMsw.PRESET_ENCODER), UnfiredReason.APART, None),
        (
            "CMD-11",
            given(CommandMsw.PRESET_ENCODER, configurations=[ConfigMsw.QUADRATURE_ENCODER]),
            UnfiredReason.CONFIGURATION,
            "every configuration has QUADRATURE_ENCODER",
        ),
    ],
)
def test_the_first_reason_that_holds(rule, words, why, says):
    assert reason(rule, words)[0] is why
    if says is not None:
        assert reason(rule, words)[1] == says


def test_a_rule_of_old_firmware_is_excluded_by_the_firmware():
    manual = given(CommandMsw.MANUAL_CW)
    assert reason("CMD-14", manual, Firmware(3, 1)) == (
        UnfiredReason.FIRMWARE,
        "no firmware from 3.1 on has this rule",
    )
    assert reason("CMD-14", manual)[0] is UnfiredReason.APART


@pytest.mark.parametrize(
    ("rule", "commands", "oldest"),
    [
        ("CMD-14", given(CommandMsw.MANUAL_CW), Firmware(2, 2)),  # up to 3.1: 2.2 is the last that has it
        ("CMD-20", given(second=CommandLsw.STORE_MIN_REG), Firmware(4, 1)),  # from 3.1 on
    ],
)
def test_the_oldest_firmware_itself_is_tried(rule, commands, oldest):
    assert reason(rule, commands, oldest)[0] is UnfiredReason.APART


def test_of_two_modules_the_one_that_came_furthest_gives_the_reason():
    here = given(HOMES, configurations=[LIMITS])
    assert reason("INP-02", given(), others=[here])[0] is UnfiredReason.INPUTS


def test_what_fired_has_no_reason_and_a_rack_without_a_3601_no_rules():
    rules = [each.rule.id for each in unfired({"CER-01"}, {1: given()}, {1: OLDEST})]
    assert "CER-01" not in rules
    assert len(rules) == 71
    assert unfired((), {}, {}) == []
