"""A bit that nothing writes may change between scans, also if it lies in a number: a push button in B3."""

from __future__ import annotations

import pytest
from scanrack.commands import build
from scanrack.ladder import Program
from scanrack.ladder.files import parse_program
from typer.testing import CliRunner


def made(*rungs: str) -> Program:
    lines = ["PROGRAM p", "TAG W : DINT", "TAG V : INT", "TAG A : BOOL", "ROUTINE Main", *rungs, "END"]
    program = parse_program("\n".join(lines))
    assert isinstance(program, Program)
    return program


def test_a_bit_that_nothing_writes_is_free_though_another_of_its_number_is_written() -> None:
    refuted = made("XIC(W.5)OTE(W.1);", "XIC(W.6)OTE(W.2);").prove(never="W.1 AND W.2")
    assert refuted.word == "refuted"
    assert refuted.scans[-1].inputs == {("W", 0): 0b1100000}  # bits 5 and 6, before the second scan


def test_a_written_bit_is_not_free() -> None:
    assert made("XIC(A)OTE(W.5);", "XIC(W.5)OTE(W.1);").prove(never="W.1 AND NOT A")
    assert made("MOV(0,W);", "XIC(W.5)OTE(A);").prove(never="A")  # all of it is written


def test_a_number_that_is_not_read_as_bits_is_held() -> None:
    found = made("EQU(V,3)OTE(A);").prove(never="A")
    assert found
    assert found.held == (("V", 0),)


def test_a_number_that_is_only_copied_is_held_though_bits_of_its_copy_are_read() -> None:
    found = made("MOV(V,W);", "XIC(W.3)OTE(A);").prove(never="A")
    assert found
    assert found.held == (("V", 0),)


@pytest.mark.parametrize("bit", [0, 15])
def test_a_bit_of_a_number_that_nothing_writes_is_free(bit: int) -> None:
    refuted = made(f"XIC(V.{bit})OTE(A);").prove(never="A")
    assert refuted.word == "refuted"
    assert refuted.scans[-1].inputs == {("V", 0): -0x8000 if bit == 15 else 1}


CONSUMER = """\
PROGRAM consumer
TYPE FromTwo (Status : CONNECTION_STATUS, Count : DINT)
TAG In : FromTwo
TAG Lamp : BOOL
ROUTINE Main
EQU(In.Count,5)OTE(Lamp);
CLR(In.Count);
END
ROUTINE NEVER
XIC(Lamp)NOP();
END
"""


def test_a_consumed_tag_that_a_rung_clears_comes_anew(tmp_path, monkeypatch):
    """What a producer sends before each scan is not what the last one has left."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.rung").write_text(CONSUMER, encoding="utf-8")
    (tmp_path / "line.toml").write_text(
        'program = "line.rung"\n[stubs]\nIn = { value = { Count = 5 } }\n'
        '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n',
        encoding="utf-8",
    )
    result = CliRunner().invoke(build(), ["prove", "line.toml"])
    assert "proved" not in result.stdout.splitlines()[0], result.stdout
