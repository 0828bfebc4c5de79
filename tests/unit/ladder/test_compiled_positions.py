"""Line numbers of compiled programs, and programs that are too long to compile."""

from types import CodeType

import pytest
from scanrack.ladder import ADD, BOOL, DINT, LadderError, Program
from scanrack.ladder.compiler import writer
from scanrack.ladder.compiler.positions import relocated


def _function(text: str) -> CodeType:
    module = compile(text, "made", "exec")
    return next(each for each in module.co_consts if isinstance(each, CodeType))


def _lines(code: CodeType) -> list[int | None]:
    """The line of each byte."""
    return [line for start, end, line in code.co_lines() for _ in range(start, end)]


TEXT = """def made(x):
    y = x + 1
    if y:
        y = [each for each in range(y)]
    return 1 / x
"""


@pytest.mark.parametrize("lines", [[10, 20, 30, 40, 50], [900, 20, 700, 1, 4], [7] * 5])
def test_every_byte_has_the_line_that_the_old_line_stands_for(lines):
    before = _function(TEXT)
    after = relocated(before, lines)
    assert _lines(after) == [None if line is None else lines[line - 1] for line in _lines(before)]
    assert after.co_firstlineno == lines[0]


def test_a_long_line_of_more_than_eight_units():
    long = _function("def made(x):\n    return " + "+".join(["x"] * 60) + "\n")
    assert set(_lines(relocated(long, [5, 80]))) == {5, 80}


def test_a_routine_that_compiles_to_too_many_lines_is_refused_by_name(monkeypatch):
    monkeypatch.setattr(writer, "MOST_LINES", 20)
    program = Program("long")
    a, n = program.declare("a", BOOL), program.declare("n", DINT)

    @program.routine
    def main(rung):
        for _ in range(20):
            rung(a, ADD(n, 1, n))

    with pytest.raises(LadderError, match="routine main compiles to more than 20 lines"):
        program.compile()
