"""SCL, HLL, SEL, SNEG, MAXC, MINC, SETD, RESD, DFF, JKFF, UPDN and RLIM [1756-RM006]; both back ends."""

import pytest
from scanrack.ladder import BuildError
from scanrack.ladder.files import parse_program


def run(kind, name, scans, *, ms=100, initial="{}"):
    """Return members Out (or Q) after scans with these parameters; the back ends must agree."""
    text = f"PROGRAM p\nTAG B : {kind} := {initial}\nROUTINE Main ST\n{name}(B);\nEND\n"
    program = parse_program(text)
    seen = []
    for engine in (program.compile(), program.interpret()):
        values = []
        for given in scans:
            for member, value in given.items():
                engine.tags[f"B.{member}"] = value
            engine.step(ms)
            values.append(engine.tags["B.Q" if kind.startswith("FLIP") else "B.Out"])
        seen.append(values)
    assert seen[0] == seen[1]
    return seen[0]


RANGE = '{"InRawMin": 0, "InRawMax": 16384, "InEUMin": 0, "InEUMax": 100}'


def test_scl_scales_and_limits():
    """Out = (In - InRawMin) x (InEUMax - InEUMin) / (InRawMax - InRawMin) + InEUMin."""
    scans = [{"In": 8192}, {"In": 20480}, {"Limiting": True}, {"In": -1}]
    assert run("SCALE", "SCL", scans, initial=RANGE) == [50.0, 125.0, 100.0, 0.0]
    assert run("SCALE", "SCL", [{"In": 5}]) == [0.0]


def test_hll_limits():
    limits = '{"HighLimit": 10, "LowLimit": -10}'
    scans = [{"In": 5}, {"In": 50}, {"In": -50}, {"SelectLimit": 1}, {"In": 50, "SelectLimit": 2}]
    assert run("HL_LIMIT", "HLL", scans, initial=limits) == [5, 10, -10, -50, 50]


def test_sel_and_sneg():
    assert run("SELECT", "SEL", [{"In1": 1, "In2": 2}, {"SelectorIn": True}]) == [1, 2]
    assert run("SELECTABLE_NEGATE", "SNEG", [{"In": 3}, {"NegateEnable": False}]) == [-3, 3]


def test_captures_until_a_reset():
    scans = [{"In": 3}, {"In": 7}, {"In": 5}, {"Reset": True, "ResetValue": 1}, {"Reset": False}]
    assert run("MAXIMUM_CAPTURE", "MAXC", scans) == [3, 7, 7, 1, 5]
    assert run("MINIMUM_CAPTURE", "MINC", scans) == [3, 3, 3, 1, 1]


@pytest.mark.parametrize(
    ("kind", "name", "both"), [("DOMINANT_SET", "SETD", 1), ("DOMINANT_RESET", "RESD", 0)]
)
def test_latches(kind, name, both):
    scans = [{"Set": True}, {"Set": False}, {"Reset": True}, {"Set": True}]
    assert run(kind, name, scans) == [1, 1, 0, both]


def test_flip_flops_on_a_rising_clock():
    """Prescan takes the clock before the first scan for true."""
    clock = [{"Clock": False}, {"Clock": True, "D": True}, {"D": False}, {"Clock": False}, {"Clock": True}]
    assert run("FLIP_FLOP_D", "DFF", clock) == [0, 1, 1, 1, 0]
    scans = [{"Clock": False}, {"Clock": True}, {"Clock": False}, {"Clock": True}, {"Clear": True}]
    assert run("FLIP_FLOP_JK", "JKFF", scans) == [0, 1, 1, 0, 0]


def test_updn_adds_at_each_call():
    scans = [
        {"Initialize": True, "InitialValue": 5},
        {"Initialize": False, "InPlus": 2},
        {"InMinus": 3},
        {"Hold": True},
    ]
    assert run("UP_DOWN_ACCUM", "UPDN", scans) == [5, 7, 6, 6]


def test_rlim_follows_at_its_rates():
    """100 ms from call to call: 10 units/s up are 1 a call, 20 down are 2."""
    scans = [{"In": 0}, {"In": 5}, {}, {"In": -5}, {"ByPass": True}]
    rates = '{"IncRate": 10, "DecRate": 20}'
    assert run("RATE_LIMITER", "RLIM", scans, initial=rates) == [0, 1, 2, 0, -5]


def test_another_structure_is_refused():
    text = "PROGRAM p\nTAG B : SCALE\nROUTINE Main ST\nHLL(B);\nEND\n"
    with pytest.raises(BuildError, match="B is a SCALE, a HL_LIMIT is needed"):
        parse_program(text).build()
