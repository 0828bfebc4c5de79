"""Ideal axes and their positions: where moves end, and what MAW sees of them, linear and rotary."""

import pytest
from scanrack.ladder.files import parse_program
from scanrack.ladder.instructions.motion.axes import MotionData

TAGS = """PROGRAM p
TAG Ax : AXIS_VIRTUAL
TAG Master : AXIS_VIRTUAL
TAG A : MOTION_INSTRUCTION
TAG B : MOTION_INSTRUCTION
TAG C : MOTION_INSTRUCTION
TAG GoA : BOOL
TAG GoB : BOOL
TAG GoC : BOOL
ROUTINE Main
"""
RATES = "{},Units per sec,9000,Units per sec2,9000,Units per sec2,Trapezoidal,100,100,% of Time"
POSITIVE, NEGATIVE = 3, 4
"""Move types of a rotary axis."""


def move(position, kind=0, control="A", merge="Disabled"):
    return f"MAM(Ax,{control},{kind},{position},{RATES.format(900)},{merge},Programmed,0,None,0,0)"


def jog(control="B", way="Forward", speed=10):
    return f"MAJ(Ax,{control},{way},{RATES.format(speed)},Disabled,Programmed,0,None)"


def after(*rungs, unwind=0.0, ms=100, scans=20):
    """Begin each instruction when the ones before have had some scans; return the engine at the end."""
    text = "".join(f"XIC(Go{name}){rung};\n" for name, rung in zip("ABC", rungs, strict=False))
    program = parse_program(f"{TAGS}{text}END\n")
    program.motion = MotionData(unwinds={"AX": unwind} if unwind else {})
    engine = program.interpret()
    for name, _ in zip("ABC", rungs, strict=False):
        engine.tags[f"Go{name}"] = True
        for _ in range(scans):
            engine.step(ms)
    return engine


def exactly(engine):
    """Return the position in double precision."""
    return engine.memory.read(engine.lowered.layout.leaf("Ax.~position"), 0)


ENDS = {
    "forward": ((move(33.7), move(200.4, control="B")), 200.4),
    "back": ((move(281.8), move(28.4, control="B")), 28.4),
    "changed on its way": (
        (
            move(33.7),
            move(200.4, control="B"),
            "MCD(Ax,C,Move,Yes,70,No,0,No,0,No,0,No,0,Units per sec,Units per sec2,Units per sec2,0)",
        ),
        200.4,
    ),
    "another reference": ((move(33.7), "MRP(Ax,B,Relative,Actual,1)", move(200.4, control="C")), 200.4),
    "a merge of a jog": ((jog("A"), move(200.4, control="B", merge="Enabled")), 200.4),
}


@pytest.mark.parametrize(("rungs", "end"), ENDS.values(), ids=ENDS)
def test_an_absolute_move_ends_exactly_at_its_position(rungs, end):
    engine = after(*rungs, scans=1 if "MCD" in rungs[-1] else 20)
    for _ in range(80):
        engine.step(100)
    assert (exactly(engine), engine.tags["Ax.MoveStatus"]) == (end, False)


def test_the_end_of_a_move_has_what_was_superimposed_meanwhile():
    """A jog of 20 ms at 10 units/s; what its ramp up lacks, its ramp down adds."""
    stop = "MAS(Ax,C,Jog,Yes,9000,Units per sec2,No,0,% of Time)"
    engine = after(move(100), jog(), stop, scans=1, ms=20)
    assert engine.tags["A.IP"] is True
    for _ in range(20):
        engine.step(20)
    assert engine.tags["A.PC"] is True
    assert exactly(engine) == pytest.approx(100.2)


def test_a_reference_that_moves_under_way_moves_the_end_of_a_move():
    engine = after(move(100), "MRP(Ax,B,Relative,Actual,-0.5)", scans=1, ms=50)
    for _ in range(10):
        engine.step(50)
    assert (exactly(engine), engine.tags["A.PC"]) == (99.5, True)


@pytest.mark.parametrize("kind", [POSITIVE, NEGATIVE])
def test_a_rotary_move_to_where_the_axis_is_makes_no_turn(kind):
    """The axis stands where rounding left it, a hair beside 28.4."""
    hair = 1e-13 if kind == POSITIVE else -1e-13
    engine = after(move(28.4 + hair), move(28.4, kind, "B"), unwind=360.0)
    assert (exactly(engine), engine.tags["B.PC"]) == (28.4, True)


WATCHES = {
    # the jog goes 300 * 0.6 units in the first scan, less 5 of its ramp of 1/30 s, and 180 in the second
    "forward through 0": (350, "Forward", 20, [True, True]),
    "forward, not yet": (350, "Forward", 200, [False, True]),
    "back through 0": (10, "Reverse", 340, [True, True]),
    "back, not yet": (10, "Reverse", 160, [False, True]),
    "where it stands": (10, "Forward", 10, [False, False]),
}


@pytest.mark.parametrize(("start", "way", "where", "fires"), WATCHES.values(), ids=WATCHES)
def test_a_watch_of_a_rotary_axis(start, way, where, fires):
    rungs = (move(start), f"MAW(Ax,B,{way},{where})", jog("C", way, speed=300))
    engine = after(*rungs[:2], unwind=360.0, scans=2, ms=600)
    assert engine.tags["B.IP"] is True
    engine = after(*rungs, unwind=360.0, scans=2, ms=600)
    seen = [engine.tags["B.PC"]]
    engine.step(600)
    assert [*seen, engine.tags["B.PC"]] == fires


def test_a_watch_of_a_linear_axis_sees_the_end_of_a_move():
    engine = after(move(33.7), "MAW(Ax,B,Forward,200.4)", move(200.4, control="C"))
    assert (engine.tags["C.PC"], engine.tags["B.PC"]) == (True, True)


def test_a_watch_of_a_rotary_axis_sees_the_end_of_a_move_after_turns():
    """520.3 less the position before is a hair less than 160.3 less that position, in one turn."""
    engine = after(move(350.1), "MAW(Ax,B,Forward,160.3)", move(160.3, POSITIVE, "C"), unwind=360.0)
    assert (engine.tags["C.PC"], engine.tags["B.PC"]) == (True, True)


@pytest.mark.parametrize(("units", "where", "way"), [(100, 50, "Forward"), (-100, -50, "Reverse")])
def test_another_reference_is_no_way(units, where, way):
    engine = after(move(1), f"MAW(Ax,B,{way},{where})", f"MRP(Ax,C,Absolute,Actual,{units})")
    assert engine.tags["Ax.ActualPosition"] == units
    assert (engine.tags["B.IP"], engine.tags["B.PC"]) == (True, False)


def test_an_axis_is_not_its_own_master():
    engine = after("MAG(Ax,Ax,A,Same,1,1,1,Actual,Real,Disabled,50,% of Maximum)", jog())
    assert (engine.tags["A.ER"], engine.tags["A.ERR"]) == (True, 13)
    assert engine.tags["Ax.GearingStatus"] is False
