"""The rows of the instruction set: complete, in one order, and the same in Python, text and docs."""

import re
from pathlib import Path

import pytest
import scanrack.ladder
from scanrack.ladder import LadderError, instructions
from scanrack.ladder.instructions import BY_NAME, FAMILIES, SPECS
from scanrack.ladder.operand_checks import OPERAND_CHECKS
from scanrack.ladder.spec import Kind, Spec, Use
from scanrack.ladder.text import parse_rung

PAGE = Path(__file__).parents[3] / "docs" / "ladder.md"
RESOLVED_AS_NAMES = {Use.LABEL, Use.MODE, Use.PRESET}


def test_the_page_lists_the_instructions_and_their_second_names():
    section = PAGE.read_text(encoding="utf-8").split("## Instructions\n", 1)[1].split("Sources:", 1)[0]
    listed, second = section.split("The newer names (", 1)
    assert sorted(re.findall(r"\b[A-Z]{2,}\b", listed)) == sorted(each.name for each in SPECS)
    assert set(second.split(")", 1)[0].split()) == {each.other for each in SPECS if each.other}


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__.rpartition(".")[2])
def test_every_row_of_a_family_is_listed_in_it(family):
    rows = {name for name, value in vars(family).items() if isinstance(value, Spec)}
    assert rows == set(family.__all__)


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.name)
def test_a_row_is_the_python_function_of_its_name(spec):
    assert getattr(scanrack.ladder, spec.name) is spec
    assert spec.name in scanrack.ladder.__all__
    assert spec.name in instructions.__all__


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.name)
def test_the_operands_of_a_row_are_checked_or_resolved_by_the_row(spec):
    unchecked = set(spec.operands) - set(OPERAND_CHECKS) - RESOLVED_AS_NAMES
    assert not unchecked or spec.resolve is not None


def test_names_stand_once():
    assert len(BY_NAME) == len(SPECS) + sum(each.other is not None for each in SPECS)


def test_rung_text_takes_either_name_and_prints_the_first():
    for spec in SPECS:
        if spec.other:
            operands = ",".join("A" for _ in spec.operands)
            assert str(parse_rung(f"{spec.other}({operands});")) == f"{spec.name}({operands});"


def test_a_condition_and_a_coil_as_rows():
    assert scanrack.ladder.XIC.kind is Kind.INPUT
    assert scanrack.ladder.OTE.kind is Kind.BOTH
    assert repr(scanrack.ladder.TON) == "<instruction TON(TIMER, PRESET, PRESET)>"
    with pytest.raises(LadderError, match="OTE takes 1 operands, 2 are given"):
        scanrack.ladder.OTE("A", "B")
