"""The rows of the instruction set: complete, in one order, and the same in Python, text and docs."""

import ast
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import scanrack.ladder
from instructions_page import PAGE, REMEDY, missing, written
from ladder_programs import without_strategy
from scanrack.ladder import (
    BOOL,
    COUNTER,
    DINT,
    TIMER,
    BuildError,
    LadderError,
    LadderFault,
    Program,
    instructions,
    parse_rung,
)
from scanrack.ladder.draw import rung_text
from scanrack.ladder.instructions import BY_NAME, FAMILIES, SPECS
from scanrack.ladder.model.operand_checks import OPERAND_CHECKS
from scanrack.ladder.model.spec import InstructionKind, Spec, Use
from scanrack.ladder.model.statements import Invocation
from scanrack.ladder.st import parse_statements

TESTS = Path(__file__).parents[2]
AS_THEIR_NEIGHBORS = set(
    re.findall(
        "[A-Z]+",
        "MASR MDO MDS MCSV MDAC MGSD MGSR MGSP MDW MAOC MDOC MAAT MRAT MAHD MRHD MCCD MCSD MCSR MCT MCTP "
        "MDCC MDSC",
    )
)
"""Motion instructions read and answered as those in `test_motion_rows` and `test_motion_ideal`."""

WITHOUT_CAPTIONS = {"ISINF", "ISNAN", "RES"}
NO_CALLS = {"MOD", "AND", "OR", "XOR", "NOT", "FOR", "SBR", "SWPB"}
"""Words of structured text's grammar, the head of a routine, and one with a keyword."""

RESOLVED_AS_NAMES = {Use.LABEL, Use.MODE, Use.PASSES, Use.PRESET, Use.KEYWORD}


def test_the_page_has_every_instruction_and_every_missing_one():
    page = PAGE.read_text(encoding="utf-8")
    assert not missing(page), REMEDY
    assert written(page) == page, REMEDY


def test_an_instruction_that_the_page_lacks_is_named():
    page = written(PAGE.read_text(encoding="utf-8"))
    added = replace(BY_NAME["TON"], name="IMC", other="PIE")
    assert missing(page, [*SPECS, added]) == [
        "missing: IMC of no family",
        "missing: PIE of newer names",
        "missing: IMC of newer names",
        "in no file: IMC of missing",
    ]


def names_in_tests() -> set[str]:
    """Return the names of instructions that rungs or parameters of tests have."""
    strings = {
        node.value
        for folder in ("manual", "unit/ladder")
        for path in (TESTS / folder).glob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    return strings | {name for text in strings for name in re.findall(r"\b([A-Z][A-Z0-9_]+)\(", text)}


@pytest.mark.slow
def test_every_instruction_has_a_row_of_its_semantics():
    """Instructions that share their functions share a row."""
    named = names_in_tests()
    proved = {spec.run for spec in SPECS if {spec.name, spec.other} & named}
    rest = {spec.name for spec in SPECS if spec.run not in proved}
    assert rest - AS_THEIR_NEIGHBORS == set(), "add a row to tests/manual/test_ladder_semantics_*.py"
    assert rest >= AS_THEIR_NEIGHBORS


def sample(spec: Spec) -> str:
    """Return rung text of an instruction, with a tag for each operand."""
    return f"{spec.name}({','.join(f'Tag{number}' for number, _ in enumerate(spec.operands))});"


@pytest.mark.parametrize("spec", [spec for spec in SPECS if spec.in_rungs], ids=lambda spec: spec.name)
def test_a_picture_has_the_name_and_the_captions_of_a_row(spec):
    lines = rung_text(parse_rung(sample(spec)), 80)
    if spec.symbol:
        assert spec.symbol in lines[1]
        return
    assert len(spec.captions) <= len(spec.operands)
    assert spec.name in lines[0]
    captions = [*spec.captions, *[""] * (len(spec.operands) - len(spec.captions))]
    for number, (caption, line) in enumerate(zip(captions, lines[1:], strict=False)):
        assert f"{caption} " in line
        assert f"Tag{number} " in line


@pytest.mark.parametrize("name", ["bits", "timing", "compare", "compute", "move", "files"])
def test_every_operand_of_a_box_has_a_caption(name):
    """In the families whose captions are known."""
    rows = [row for row in vars(getattr(instructions, name)).values() if isinstance(row, Spec)]
    boxes = [row for row in rows if not row.symbol and row.name not in WITHOUT_CAPTIONS]
    assert {row.name: len(row.captions) for row in boxes} == {row.name: len(row.operands) for row in boxes}


@pytest.mark.parametrize(
    "spec", [spec for spec in SPECS if spec.name not in NO_CALLS], ids=lambda spec: spec.name
)
def test_structured_text_has_an_instruction_or_says_what_to_write_instead(spec):
    (statement,) = parse_statements(sample(spec))
    assert isinstance(statement, Invocation)
    assert str(statement) == sample(spec)
    program = Program("one")
    program.statements("Main", sample(spec))
    try:
        program.build()
        says = ""
    except BuildError as refused:
        says = str(refused)
    instead = f"{spec.name} is not an instruction of structured text; {spec.instead}"
    assert (instead in says) is ("not an instruction of structured text" in says) is bool(spec.instead)


def test_random_programs_have_every_instruction_whose_operands_they_know():
    assert without_strategy() == set(), "add the use to BY_USE, or the name to OUT with the reason"


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__.rpartition(".")[2])
def test_a_row_has_the_name_of_its_variable(family):
    rows = {name: value.name for name, value in vars(family).items() if isinstance(value, Spec)}
    assert rows == {name: name for name in rows}


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.name)
def test_a_row_is_the_python_function_of_its_name(spec):
    assert getattr(scanrack.ladder, spec.name) is spec
    assert spec.name in scanrack.ladder.__all__
    assert spec.name in instructions.NAMES


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
    assert scanrack.ladder.XIC.kind is InstructionKind.INPUT
    assert scanrack.ladder.OTE.kind is InstructionKind.BOTH
    assert repr(scanrack.ladder.TON) == "<instruction TON(TIMER, PRESET, PRESET)>"
    with pytest.raises(LadderError, match="OTE: 2 operands; must be 1"):
        scanrack.ladder.OTE("A", "B")


MIXED = (
    "XIC(A)[XIC(B),GRT(N,3)]ONS(S)OTE(C)ADD(N,1,N);",
    "XIO(C)[EQU(N,2),LIM(4,N,6)]TON(T,30,0)XIC(T.DN)OTL(D)COP(N,M[0],2);",
    "MUL(N,70000,M[1])DIV(M[1],N,M[N])CTU(K,2,0);",
)
TAGS: dict[str, Any] = {
    "A": BOOL,
    "B": BOOL,
    "C": BOOL,
    "D": BOOL,
    "S": BOOL,
    "N": DINT,
    "T": TIMER,
    "K": COUNTER,
}


def _mixed():
    program = Program("mixed")
    for name, kind in TAGS.items():
        program.declare(name, kind)
    program.declare("M", DINT, 4)

    @program.routine
    def main(rung):
        for each in MIXED:
            rung(each)

    return program


def test_an_instruction_without_text_of_its_own_is_interpreted_in_the_compiled_program(monkeypatch):
    """Every instruction of the rungs loses its writer; `TON` shows that the time is handed over."""
    plain = _mixed().compile()
    for name, spec in list(BY_NAME.items()):
        monkeypatch.setitem(BY_NAME, name, replace(spec, write=None))
    program = _mixed()
    assert "interpret(" in program.source()
    assert "+ 1" not in program.source()
    interpreted = program.compile()
    for number in range(24):
        for engine in (plain, interpreted):
            engine.tags["A"] = number % 3 != 0
            engine.tags["B"] = number % 4 == 1
            try:
                engine.step(10)
            except LadderFault:
                assert engine.tags["N"] > 3  # M has four elements
        assert plain.memory.snapshot() == interpreted.memory.snapshot(), number
        assert list(map(str, plain.minor_faults)) == list(map(str, interpreted.minor_faults))
    assert plain.minor_faults
    assert plain.tags["D"]
    assert plain.tags["N"] > 3  # the subscript has gone out of range
