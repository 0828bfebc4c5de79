"""TONR, TOFR, RTOR, CTUD, OSRI and OSFI of structured text, on both back ends [1756-RM003N]."""

import pytest
from scanrack.ladder import BuildError
from scanrack.ladder.files import parse_program, parse_structured

TIMER = """TAG T : FBD_TIMER := {"PRE": 30}
TAG Go : BOOL
TAG Back : BOOL
TAG N : DINT
T.TimerEnable := Go;
T.Reset := Back;
"""


def both(text):
    program = parse_structured(text, "bench")
    return [program.compile(), program.interpret()]


def run(engine, steps):
    """Set tags, do a scan of 10 ms, return what the last item of each step names."""
    seen = []
    for changes, names in steps:
        for name, value in changes.items():
            engine.tags[name] = value
        engine.step(10)
        seen.append(tuple(int(engine.tags[name]) for name in names.split()))
    return seen


BITS = "T.EN T.TT T.DN T.ACC"


@pytest.mark.parametrize("engine", both(TIMER + "TONR(T);"), ids=["compiled", "interpreted"])
def test_tonr(engine):
    """EN and TT at once, DN after PRE; TimerEnable false or Reset true clears all."""
    steps = [({}, BITS), ({"Go": True}, BITS), ({}, BITS), ({}, BITS), ({}, BITS), ({}, BITS)]
    assert run(engine, steps) == [
        (0, 0, 0, 0),
        (1, 1, 0, 0),
        (1, 1, 0, 10),
        (1, 1, 0, 20),
        (1, 0, 1, 30),
        (1, 0, 1, 30),
    ]
    steps = [({"Back": True}, BITS), ({"Back": False}, BITS), ({}, BITS), ({"Go": False}, BITS)]
    assert run(engine, steps) == [(0, 0, 0, 0), (1, 1, 0, 0), (1, 1, 0, 10), (0, 0, 0, 0)]
    assert engine.tags["T.EnableOut"] is True


@pytest.mark.parametrize("engine", both(TIMER + "TOFR(T);"), ids=["compiled", "interpreted"])
def test_tofr(engine):
    """DN with TimerEnable, and PRE longer; Reset clears the bits and sets ACC to PRE."""
    steps = [({}, BITS), ({"Go": True}, BITS), ({"Go": False}, BITS), ({}, BITS), ({}, BITS), ({}, BITS)]
    assert run(engine, steps) == [
        (0, 0, 0, 30),
        (1, 0, 1, 0),
        (0, 1, 1, 0),
        (0, 1, 1, 10),
        (0, 1, 1, 20),
        (0, 0, 0, 30),
    ]
    assert run(engine, [({"Go": True}, BITS), ({"Back": True}, BITS)]) == [(1, 0, 1, 0), (0, 0, 0, 30)]


@pytest.mark.parametrize("engine", both(TIMER + "RTOR(T);"), ids=["compiled", "interpreted"])
def test_rtor(engine):
    """ACC and DN stay while TimerEnable is false; Reset clears them."""
    steps = [({"Go": True}, BITS), ({}, BITS), ({"Go": False}, BITS), ({"Go": True}, BITS), ({}, BITS)]
    assert run(engine, steps) == [(1, 1, 0, 0), (1, 1, 0, 10), (0, 0, 0, 10), (1, 1, 0, 10), (1, 1, 0, 20)]
    steps = [({}, BITS), ({"Go": False}, BITS), ({"Back": True}, BITS)]
    assert run(engine, steps) == [(1, 0, 1, 30), (0, 0, 1, 30), (0, 0, 0, 0)]


@pytest.mark.parametrize("engine", both(TIMER + "TONR(T);"), ids=["compiled", "interpreted"])
def test_a_timer_with_a_negative_preset_tells_and_does_not_run(engine):
    names = "T.InstructFault T.PresetInv T.Status T.EN"
    steps = [({"T.PRE": -1, "Go": True}, names), ({"T.PRE": 5}, names)]
    assert run(engine, steps) == [(1, 1, 3, 0), (0, 0, 0, 1)]


COUNTER = """TAG C : FBD_COUNTER := {"PRE": 2}
TAG Up : BOOL
TAG Down : BOOL
TAG Back : BOOL
C.CUEnable := Up;
C.CDEnable := Down;
C.Reset := Back;
CTUD(C);
"""


@pytest.mark.parametrize("engine", both(COUNTER), ids=["compiled", "interpreted"])
def test_ctud(engine):
    """Counts edges; those of both at once not at all; an input that is on at power-up does not count."""
    names = "C.ACC C.DN C.CU C.CD"
    steps = [
        ({"Up": True}, names),
        ({"Up": False}, names),
        ({"Up": True}, names),
        ({"Up": False}, names),
        ({"Up": True, "Down": True}, names),
        ({"Up": False, "Down": False}, names),
        ({"Up": True}, names),
        ({"Down": True}, names),
        ({"Back": True, "Up": False}, names),
        ({"Back": False, "Up": True}, names),
    ]
    assert run(engine, steps) == [
        (0, 0, 1, 0),
        (0, 0, 0, 0),
        (1, 0, 1, 0),
        (1, 0, 0, 0),
        (1, 0, 1, 1),
        (1, 0, 0, 0),
        (2, 1, 1, 0),
        (1, 0, 1, 1),
        (0, 0, 0, 0),
        (1, 0, 1, 1),
    ]


@pytest.mark.parametrize("engine", both(COUNTER), ids=["compiled", "interpreted"])
def test_ctud_beyond_its_range(engine):
    """OV and UN as of CTU and CTD: past the highest is above any PRE, and counting back clears OV."""
    names = "C.ACC C.OV C.UN C.DN"
    steps = [
        ({"C.ACC": 2147483647}, names),
        ({"Up": True}, names),
        ({"Up": False, "Down": True}, names),
        ({"Down": False, "C.ACC": -2147483648}, names),
        ({"Down": True}, names),
        ({"Up": True}, names),
    ]
    assert run(engine, steps) == [
        (2147483647, 0, 0, 1),
        (-2147483648, 1, 0, 1),
        (2147483647, 0, 0, 1),
        (-2147483648, 0, 0, 0),
        (2147483647, 0, 1, 0),
        (-2147483648, 0, 0, 0),
    ]


SHOT = "TAG S : FBD_ONESHOT\nTAG In : BOOL\nS.InputBit := In;\n"


@pytest.mark.parametrize(
    ("name", "fires"), [("OSRI", [0, 0, 1, 0, 0]), ("OSFI", [0, 1, 0, 0, 1])], ids=["OSRI", "OSFI"]
)
def test_one_shots(name, fires):
    """OSRI fires as InputBit becomes true, though not at power-up; OSFI as it becomes false."""
    for engine in both(SHOT + f"{name}(S);"):
        inputs = [True, False, True, True, False]
        assert run(engine, [({"In": on}, "S.OutputBit") for on in inputs]) == [(each,) for each in fires]


def test_rungs_do_not_have_them_and_each_takes_its_own_structure():
    with pytest.raises(BuildError, match="TONR is an instruction of structured text"):
        parse_program("PROGRAM p\nTAG T : FBD_TIMER\nROUTINE Main\nTONR(T);\nEND\n").build()
    with pytest.raises(BuildError, match="T is a TIMER, a structure of its parameters is needed"):
        parse_structured("TAG T : TIMER\nTONR(T);", "p").build()
    with pytest.raises(BuildError, match="C is a FBD_COUNTER, a FBD_TIMER is needed"):
        parse_structured("TAG C : FBD_COUNTER\nTONR(C);", "p").build()


ALARM = """TAG L : ALARM_ANALOG
TAG Value : REAL
TAG Ack : BOOL
L.HEnabled := 1; L.HLimit := 80;
ALMA(L, Value, Ack, 0, 0);
"""


@pytest.mark.parametrize("engine", both(ALARM), ids=["compiled", "interpreted"])
def test_alma(engine):
    """In alarm at the limit, unacknowledged until ProgAckAll rises, over when the value is below it."""
    bits = "L.HInAlarm L.HAcked"
    steps = [({"Value": 79}, bits), ({"Value": 80}, bits), ({"Ack": True}, bits), ({"Value": 79}, bits)]
    assert run(engine, steps) == [(0, 1), (1, 0), (1, 1), (0, 1)]
