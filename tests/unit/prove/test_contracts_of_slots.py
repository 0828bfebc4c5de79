"""Contracts as terms say what they say of numbers, and decide what free inputs leave open."""

from __future__ import annotations

from random import Random

import pytest
from scanrack.io_images.amci3601.contracts import CONTRACTS, contracts_of
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem
from scanrack.ladder.prove.algebra.evaluation import Evaluator
from scanrack.ladder.prove.claims import Claim, ClaimKind
from scanrack.ladder.prove.contracts import KeptBy
from scanrack.ladder.prove.induction import VerdictKind, prove
from scanrack.ladder.prove.monitors import monitored
from scanrack.ladder.prove.system import RUN_ONLY
from scanrack.ladder.prove.system.events import LOST_LINK, PROGRAM_MODE

pytestmark = pytest.mark.extra("prove")

LOST = "axis.command.ABSOLUTE_MOVE AND axis.status.POSITION_INVALID"
REMEMBERS = """
PROGRAM remembers
TAG Go : BOOL
TAG Homed : BOOL
SLOT axis : 1
ROUTINE Main
XIC(axis.status.AT_HOME)OTL(Homed);
[XIC(axis.status.STOPPED),XIC(axis.status.HOME_INVALID),XIC(axis.status.CONFIG_ERROR),XIC(axis.status.MODE_CONFIG),XIO(axis.status.MODULE_OK)]OTU(Homed);
XIC(Homed)XIC(Go)OTE(axis.command.ABSOLUTE_MOVE);
END
"""
"""Keeps Homed until one of the bits with which a position is lost: chapter 6, Position Invalid 1 to 6."""


def problem(text, contracts, happens=RUN_ONLY):
    """The program with the claim, and the place of its bit."""
    made = monitored(parse_program(text), [Claim("lost", ClaimKind.NEVER, LOST)])
    kept = [KeptBy(1, tuple(contracts))]
    return ProgramSystem(made.program, contracts=kept, happens=happens), made.properties[0].bit


def test_a_position_that_is_remembered_as_valid_is_proved_with_the_contracts_only():
    assert prove(*problem(REMEMBERS, contracts_of())).kind is VerdictKind.PROVED
    assert prove(*problem(REMEMBERS, ())).kind is VerdictKind.REFUTED


def test_a_latch_outlives_program_mode_in_which_the_position_is_lost():
    verdict = prove(*problem(REMEMBERS, contracts_of(), [PROGRAM_MODE]))
    assert verdict.kind is VerdictKind.REFUTED
    assert verdict.scans[-1].turned


def test_a_module_that_has_lost_its_link_keeps_no_contract():
    lost = [LOST_LINK]
    assert prove(*problem(REMEMBERS, contracts_of(), lost)).kind is VerdictKind.REFUTED
    without_memory = REMEMBERS.replace(
        "XIC(Homed)XIC(Go)", "XIC(Homed)XIO(axis.status.POSITION_INVALID)XIC(Go)"
    )
    assert prove(*problem(without_memory, contracts_of(), lost)).kind is VerdictKind.PROVED


@pytest.mark.parametrize("bit", ["STOPPED", "HOME_INVALID", "CONFIG_ERROR", "MODE_CONFIG"])
def test_a_program_that_forgets_one_of_the_bits_is_refuted(bit):
    """A program that looks at Input Error instead of Stopped misses Immediate Stop."""
    wrong = REMEMBERS.replace(f"XIC(axis.status.{bit})", "XIC(axis.status.INPUT_ERROR)")
    verdict = prove(*problem(wrong, contracts_of()))
    assert verdict.kind is VerdictKind.REFUTED
    images = [each.inputs.get(("LOCAL:1:I.DATA", 0), 0) for each in verdict.scans]
    assert images[-1] & 0x0400


def test_what_several_exchanges_in_a_scan_may_break_is_not_used():
    """Only one image is spoken of then: what happens in between is open."""
    assert prove(*problem(REMEMBERS, contracts_of(each_update=False))).kind is VerdictKind.REFUTED


def words(dice):
    """Eight words with few bits in the first two, in command mode mostly."""
    bits = [1 << dice.randrange(16) | 1 << dice.randrange(16) for _ in range(2)]
    near = (bits[0] | 0x4000, bits[1], *(dice.choice((0, 5, 1000)) for _ in range(6)))
    return [word - (word >> 15 << 16) for word in near]


def test_terms_and_numbers_agree():
    asked, _ = problem(REMEMBERS, ())
    terms = [KeptBy(1, (row,))(asked) for row in CONTRACTS]
    asked._settle()
    value = Evaluator(terms)
    dice, broken = Random(2), set()
    for _ in range(400):
        now, was, told = words(dice), words(dice), words(dice)
        values = {}
        for word in range(8):
            values[f"LOCAL:1:I.DATA[{word}]"] = now[word]
            values[f"LOCAL:1:O.DATA[{word}]"] = told[word]
            for bit in range(16):
                values[f"~was:LOCAL:1:I.DATA[{word}].{bit}"] = bool(was[word] >> bit & 1)
        for row, got in zip(CONTRACTS, value(values), strict=True):
            assert got == row.fact.holds(now, was, told), row.name
            broken |= set() if got else {row.name}
    assert len(broken) > len(CONTRACTS) / 2


def test_contracts_count_only_where_their_inputs_decide():
    """A claim about other tags has a cone without the module's words."""
    text = REMEMBERS.replace("\nEND", "\nXIO(Blink)OTE(Blink);\nEND").replace(
        "TAG Go", "TAG Blink : BOOL\nTAG Go"
    )
    made = monitored(parse_program(text), [Claim("blink", ClaimKind.NEVER, "Blink AND old(Blink)")])
    kept = [KeptBy(1, contracts_of())]
    asked = ProgramSystem(made.program, contracts=kept, happens=RUN_ONLY)
    assert prove(asked, made.properties[0].bit).kind is VerdictKind.PROVED
    bad = asked.after(made.properties[0].bit)
    with asked.narrowing([bad]):
        assert len(asked.cone([bad])) == 2
