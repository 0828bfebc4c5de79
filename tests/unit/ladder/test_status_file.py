"""The status file S of the dialect slc, declared or not."""

import re

import pytest
from scanrack.ladder import INT, LadderError, Program
from scanrack.ladder.files import parse_program

HEAD = "PROGRAM p\nDIALECT slc\nTAG N7 : INT[3] := [32767, 0, 0]\n"


def scanned(rung, tags=""):
    """Return the engines of both back ends after a scan of a rung."""
    program = parse_program(f"{HEAD}{tags}ROUTINE Main\n{rung}\nEND\n")
    engines = program.compile(), program.interpret()
    for engine in engines:
        engine.step()
    return engines


@pytest.mark.parametrize("tags", ["", "TAG S : INT[84]\n", "TAG s : INT[163]\n"])
def test_it_is_there_declared_or_not(tags):
    """1747-RM001: S:2/14 selects the low bits, S:0 has the flags, S:5/0 the trap."""
    for engine in scanned("OTL(S:2/14)ADD(N7:0,1,N7:1)MOV(S:0,N7:2)OTU(S:5/0);", tags):
        assert engine.tags["N7"] == [32767, -32768, 0b1010]  # sign and overflow


def test_without_a_tag_the_first_pass_is_seen():
    for engine in scanned("XIC(S:1/15)ADD(N7:1,1,N7:1);"):
        engine.step()
        assert engine.tags["N7"][1] == 1


def test_what_is_not_declared_is_not_written_into_the_file():
    program = parse_program(f"{HEAD}ROUTINE Main\nMOV(1,N7:0);\nEND\n")
    program.build()
    assert [each.name for each in program.declarations] == ["N7"]


@pytest.mark.parametrize("kind", ["INT", "INT[83]", "DINT[84]", "BOOL", "TIMER", "INT[9,10]"])
def test_a_tag_of_other_words_is_refused(kind):
    with pytest.raises(LadderError, match=rf"^tag S : {re.escape(kind)}: .* S : INT\[84\] or longer"):
        parse_program(f"{HEAD}TAG S : {kind}\nROUTINE Main\nNOP();\nEND\n")


def test_an_alias_of_its_name_is_refused():
    program = Program("p", dialect="slc")
    program.declare("N9", INT, 84)
    with pytest.raises(LadderError, match=r"S is not a tag; .*S : INT\[84\]"):
        program.alias("S", "N9")


def test_in_logix_s_is_a_tag_as_any_other():
    program = Program("p")
    program.declare("S", INT)
    assert program.layout_of(program.declarations).tags().keys() == {"S"}
