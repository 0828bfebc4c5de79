"""Every number that a proof holds is listed, bits of numbers included: soundness rule 4."""

from __future__ import annotations

import pytest
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem
from scanrack.ladder.prove.answers import ask
from scanrack.ladder.prove.difference import compare
from scanrack.ladder.prove.questions import ask as ask_questions

pytestmark = pytest.mark.extra("prove")

BLOCKS = """\
PROGRAM blocks
INSTRUCTION Block
INPUT Go : BOOL
OUTPUT Q : BOOL
OUTPUT R : BOOL
INOUT Mode : DINT
LOCAL Kind : DINT := 8
LOCAL Rows : DINT[2]
ROUTINE Logic
XIC(Go)XIC(Kind.3)XIC(Rows[1].2)OTE(Q);
XIC(Mode.1)OTE(R);
END
END INSTRUCTION
TAG B : Block
TAG Go : BOOL
TAG Word : DINT := 4
TAG Six : BOOL
TAG Full : BOOL
ROUTINE Main
XIC(Go)[OTE(B.Go),OTE(Word.5)];
Block(B,Word);
XIC(Word.6)OTE(Six);
EQU(Word,36)OTE(Full);
END
"""
"""Bit 5 of Word is written, bit 6 named here, bit 1 by the block only; Full looks at all of them."""


def held(condition):
    """The held numbers of a claim, by name."""
    return dict(ask(parse_program(BLOCKS), never=condition).held)


def test_numbers_and_bits_in_a_block_are_listed():
    assert held("B.Q") == {"B.Kind": 8, "B.Rows[1]": 0}


def test_a_bit_that_only_a_block_names_is_listed():
    assert held("B.R") == {"Word.1": 0}


def test_what_is_free_is_not_listed():
    assert held("Six") == {}


def test_a_number_of_which_all_bits_are_read_is_listed_once():
    assert held("Full") == {"Word": 4}


def test_no_built_in_finding_depends_on_a_held_bit():
    """Nothing turns bit 1 of Word on; a recipe may."""
    found = ask_questions(ProgramSystem(parse_program(BLOCKS))).findings
    assert [(each.rule, each.text) for each in found] == []


def test_what_a_comparison_holds_is_listed():
    """Whether Word is 36 or 37 depends on the bits that nothing writes."""
    old, new = (BLOCKS.replace("Word,36", f"Word,{number}") for number in (36, 37))
    found = compare(parse_program(old), parse_program(new))
    assert [each.name for each in found.changed] == ["FULL"]
    assert [(each.key[0], each.bit, each.value) for each in found.held] == [("WORD", None, 4)]
