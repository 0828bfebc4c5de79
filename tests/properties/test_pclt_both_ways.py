"""Stored programs: text to program to text, and nothing but ProgramError."""

from __future__ import annotations

import re

import hypothesis.strategies as st
import pytest
from hypothesis import given
from scanrack.io_images.pcl601.program import (
    INSTRUCTIONS,
    Program,
    ProgramError,
    Step,
    format_program,
    parse_program,
)
from scanrack.io_images.pcl601.program.operands import Choice, Digits, Label, Number, Operand, Text

PRINTABLE = st.characters(min_codepoint=32, max_codepoint=126)
TEXT = st.text(st.one_of(PRINTABLE, st.sampled_from("\r\n")), max_size=20)
NAMES = ["A", "LOOP", "STATION_2", "MOVE", "X" * 16]
PLAIN = [row for row in INSTRUCTIONS if not any(isinstance(o, Label) for o in row.operands)]


def values(operand: Operand) -> st.SearchStrategy[int | str]:
    match operand:
        case Number():
            return st.integers(operand.low, operand.high)
        case Choice():
            return st.integers(0, 1)
        case Digits():
            return st.integers(0, 2**operand.count - 1)
        case Text():
            return TEXT
        case _:
            raise AssertionError(operand)


def plain_step() -> st.SearchStrategy[Step]:
    return st.sampled_from(PLAIN).flatmap(
        lambda row: st.builds(Step, st.just(row.name), st.tuples(*map(values, row.operands)))
    )


@st.composite
def programs(draw: st.DrawFn) -> Program:
    """Programs with labels, gotos anywhere and loops that do not nest, each back to the label just above."""
    steps: list[Step] = []
    names = draw(st.lists(st.sampled_from(NAMES), unique=True, max_size=5))
    for name in names:
        steps.append(Step("LABEL", (name,)))
        steps += draw(st.lists(plain_step(), max_size=4))
        steps += draw(st.lists(st.builds(lambda n: Step("GOTO", (n,)), st.sampled_from(names)), max_size=2))
        kind = draw(st.sampled_from(["", "LOOP OUTER", "LOOP INNER"]))
        if kind:
            steps.append(Step(kind, (draw(st.integers(1, 65_535)), name)))
    steps += [*draw(st.lists(plain_step(), max_size=4)), Step("END")]
    title = draw(st.none() | TEXT)
    axis = draw(st.none() | st.integers(0, 99))
    return Program(tuple(steps), title, axis, draw(st.none() | st.booleans()))


@pytest.mark.slow
@given(programs())
def test_text_holds_the_whole_program(program: Program) -> None:
    text = format_program(program)
    assert parse_program(text) == program
    assert format_program(parse_program(text)) == text


@pytest.mark.slow
@given(programs())
def test_case_spaces_and_comments_do_not_matter(program: Program) -> None:
    bare = Program(tuple(step for step in program.steps if step.name != "TEXT"), axis=program.axis)
    text = re.sub(r" ", "\t ", format_program(bare).lower()).replace("\n", ' ; "comment"\r\n\n')
    assert parse_program(text) == bare


@pytest.mark.slow
@given(st.text(max_size=60) | st.text('ABELOP \n0123"\\;.', max_size=60))
def test_any_text_is_a_program_or_an_error_with_its_line(text: str) -> None:
    try:
        parse_program(text)
    except ProgramError as error:
        line = error.line
    else:
        return
    assert line is None or 1 <= line <= text.count("\n") + 1
