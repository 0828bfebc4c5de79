"""MOV of strings, the newer instructions for what is not a number, and the newer names of TOD and FRD."""

import math

import pytest
from ladder_bench import Named
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.errors import BuildError

TAGS = """\
TAG Text : STRING
TAG Copy : STRING
TAG Names : STRING[3]
TAG I : DINT
TAG N : DINT
TAG R : REAL
TAG X : REAL
TAG Out : BOOL
"""


def engines(rungs):
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\n{rungs}\nEND\n")
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


@pytest.mark.parametrize(
    ("rung", "before", "after"),
    [
        ("MOV('one',Text);", {"Text": "before"}, {"Text": "one"}),
        ("MOVE(Text,Copy);", {"Text": "one"}, {"Copy": "one"}),
        ("MOV(Names[I],Names[2]);", {"Names[1]": "one", "I": 1}, {"Names[2]": "one"}),
        ("MOV('A',N);", {}, {"N": 65}),
        ("TO_BCD(N,N);", {"N": 1254}, {"N": 0x1254}),
        ("BCD_TO(N,N);", {"N": 0x1254}, {"N": 1254}),
        ("ISINF(R)OTE(Out);", {"R": -math.inf}, {"Out": True}),
        ("ISINF(R)OTE(Out);", {"R": math.nan}, {"Out": False}),
        ("ISNAN(R)OTE(Out);", {"R": math.nan}, {"Out": True}),
        ("ISNAN(N)OTE(Out);", {"N": 5}, {"Out": False}),
    ],
)
def test_a_scan(rung, before, after):
    for engine in engines(rung):
        for name, value in before.items():
            engine.tags[name] = value
        engine.step()
        assert {name: engine.tags[name] for name in after} == after, engine


@pytest.mark.parametrize(("y", "x"), [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (0.0, -2.0), (3.0, 0.0)])
def test_atan2_knows_the_quadrant(y, x):
    for engine in engines("ATAN2(R,X,R);"):
        engine.tags["R"], engine.tags["X"] = y, x
        engine.step()
        assert engine.tags["R"] == pytest.approx(math.atan2(y, x), rel=1e-6)


@pytest.mark.parametrize(
    ("rung", "text"),
    [
        ("MOV(Text,N);", "a STRING can't be moved to a DINT"),
        ("MOV(N,Text);", "a DINT can't be moved to a STRING"),
        ("MOV(Out,Text);", "Out is a BOOL, a number or a STRING is needed"),
    ],
)
def test_a_string_is_moved_to_strings_only(rung, text):
    with pytest.raises(BuildError, match=text):
        engines(rung)
