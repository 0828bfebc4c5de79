"""Comparisons in CPT are 1 or 0; CMP compares strings; && and || are AND and OR."""

import pytest
from ladder_bench import Named
from scanrack.ladder import parse_rung
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.errors import BuildError

TAGS = "TAG A : DINT\nTAG B : DINT\nTAG X : REAL\nTAG Text : STRING\nTAG Names : STRING[3]\nTAG Out : BOOL\n"


def engines(rung):
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\n{rung}\nEND\n")
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


@pytest.mark.parametrize(
    ("rung", "before", "after"),
    [
        ("CPT(A,(B MOD 100)<>0);", {"B": 101}, {"A": 1}),
        ("CPT(A,(B MOD 100)<>0);", {"A": 7, "B": 200}, {"A": 0}),
        ("CPT(X,X>1.5);", {"X": 2.0}, {"X": 1.0}),
        ("CPT(A,(B>3)*5+(X<=0.5)*7);", {"B": 4, "X": 1.0}, {"A": 5}),
        ("CPT(A,(B>3) AND NOT (B>5));", {"B": 4}, {"A": 1}),
        ("CPT(A,Text='on');", {"Text": "on"}, {"A": 1}),
        ("CMP(A>=(B-10)&&(A<=(B+10)))OTE(Out);", {"A": 5, "B": 12}, {"Out": True}),
        ("CMP(A>=(B-10)&&(A<=(B+10)))OTE(Out);", {"A": 5, "B": 20}, {"Out": False}),
        ("CMP(A=1||A=B)OTE(Out);", {"A": 5, "B": 5}, {"Out": True}),
        ("CPT(A,B&6|1);", {"B": 14}, {"A": 7}),
        ("CMP(Names[A]=Text)OTE(Out);", {"Names[1]": "a", "Text": "a", "A": 1}, {"Out": True}),
        ("CMP('b'<>Text)OTE(Out);", {"Text": "b"}, {"Out": False}),
    ],
)
def test_values(rung, before, after):
    for engine in engines(rung):
        for name, value in before.items():
            engine.tags[name] = value
        engine.step()
        assert {name: engine.tags[name] for name in after} == after, engine


def test_signs_print_as_words():
    assert str(parse_rung("CMP(A=1&&B=2||C=3)OTE(Out);")) == "CMP(A=1 AND B=2 OR C=3)OTE(Out);"


@pytest.mark.parametrize("rung", ["CPT(A,Out=1);", "CMP(Text=A)OTE(Out);", "CMP(A)OTE(Out);"])
def test_what_is_no_number_and_no_comparison(rung):
    with pytest.raises(BuildError):
        engines(rung)
