"""Motion that is merged and superimposed on ideal axes, by hand [MOTION-RM002H, February 2018].

Each row of `SEQUENCES` is a table of its own: what begins when, and where the axis is, how fast, and what its
bits and those of the instructions show. The usual jog reaches 2 units/s in 1 s, 1 unit on its way; the usual
move goes 12 units in 1 s + 2 s + 1 s, 2 + 8 + 2 units, at 4 units/s.
"""

from typing import NamedTuple

import l5x_files as files
import pytest
from ladder_bench import both
from scanrack.rockwell.l5x import import_l5x

NAMES = ("A", "B", "C", "D")
TAGS = "\n".join(
    [
        *(f"TAG {name} : AXIS_VIRTUAL" for name in ("Ax", "Master", "Other")),
        *(f"TAG Go{name} : BOOL" for name in NAMES),
        *(f"TAG {name} : MOTION_INSTRUCTION" for name in NAMES),
    ]
)
SHOWN = {
    name: f"{name}Status"
    for name in ("Move", "Jog", "Gearing", "Stopping", "Homing", "CoordinatedMotion", "Accel", "Decel")
}


def rates(speed, rate=None):
    """Return speed and rates of a trapezoid; both rates are the speed, so that a ramp takes 1 s."""
    rate = rate or speed
    return f"{speed},Units per sec,{rate},Units per sec2,{rate},Units per sec2,Trapezoidal,100,100,% of Time"


def move(way, speed=4, merge="Disabled", at="Programmed", kind=1, axis="Ax"):
    return f"MAM({axis},?,{kind},{way},{rates(speed)},{merge},{at},0,None,0,0)"


def jog(speed=2, merge="Disabled", at="Programmed", way="Forward", axis="Ax"):
    return f"MAJ({axis},?,{way},{rates(speed)},{merge},{at},0,None)"


def stop(what, rate):
    return f"MAS(Ax,?,{what},Yes,{rate},Units per sec2,No,0,% of Time)"


def change(what, speed):
    units = "Units per sec,Units per sec2,Units per sec2,Units per sec3"
    return f"MCD(Ax,?,{what},Yes,{speed},No,0,No,0,No,0,No,0,{units})"


GEAR = "MAG(Ax,Master,?,Same,1,1,1,Command,Real,Disabled,0,% of Maximum)"
MASTER = jog(axis="Master")


class At(NamedTuple):
    """What is seen at a time."""

    seconds: float
    position: float
    speed: float
    shown: str = ""  # status bits of the axis that are on, of `SHOWN`
    bits: str = ""  # instructions and the ones of IP, PC that are on: "A:IP B:PC"


class Sequence(NamedTuple):
    """Instructions with the times that begin them, and what follows."""

    page: str  # of MOTION-RM002H
    begun: tuple[tuple[float, str], ...]
    seen: tuple[At, ...]


SEQUENCES = {
    "1 a move on a jog, Merge Disabled: both as if alone": Sequence(
        "124",
        ((0, jog()), (2, move(12))),
        (
            At(2, 3, 2, "Jog Move Accel", "A:IP B:IP"),
            At(3, 5 + 2, 2 + 4, "Jog Move", "A:IP B:IP"),
            At(5, 9 + 10, 6, "Jog Move Decel"),
            At(6, 11 + 12, 2, "Jog", "A:IP B:PC"),
            At(7, 13 + 12, 2, "Jog", "A:IP B:PC"),
        ),
    ),
    "2 a jog on a move, Merge Disabled": Sequence(
        "124, reading M-1",
        ((0, move(12)), (1, jog())),
        (
            At(1, 2, 4, "Move Jog Accel", "A:IP B:IP"),
            At(2, 6 + 1, 4 + 2, "Move Jog", "A:IP B:IP"),
            At(4, 12 + 5, 2, "Jog", "A:PC B:IP"),
        ),
    ),
    "3 a move ends a jog, Merge Enabled at Programmed": Sequence(
        # 2 to 4 units/s in 0.5 s, 1.5 units; 6 units at 4; 1 s and 2 units down
        "124",
        ((0, jog()), (2, move(9.5, merge="Enabled"))),
        (
            At(2, 3, 2, "Move Accel", "B:IP"),
            At(2.5, 4.5, 4, "Move", "B:IP"),
            At(4, 10.5, 4, "Move Decel", "B:IP"),
            At(5, 12.5, 0, "", "B:PC"),
        ),
    ),
    "4 a move ends a jog, Merge Enabled at Current": Sequence(
        # 6 units at 2 units/s, 0.5 s and 0.5 units down
        "124, reading M-2",
        ((0, jog()), (2, move(6.5, merge="Enabled", at="Current"))),
        (
            At(2, 3, 2, "Move", "B:IP"),
            At(5, 9, 2, "Move Decel", "B:IP"),
            At(5.5, 9.5, 0, "", "B:PC"),
        ),
    ),
    "5 a move ends a gear, Merge Enabled": Sequence(
        "124, 129",
        ((0, MASTER), (0, GEAR), (2, move(9.5, merge="Enabled"))),
        (
            At(1, 1, 2, "Gearing", "A:IP B:IP"),
            At(2, 3, 2, "Move Accel", "A:IP C:IP"),
            At(2.5, 4.5, 4, "Move", "A:IP C:IP"),
            At(5, 12.5, 0, "", "A:IP C:PC"),
            At(6, 12.5, 0, "", "A:IP C:PC"),
        ),
    ),
    "6 a move on a gear, Merge Disabled": Sequence(
        "124, 129",
        ((0, MASTER), (0, GEAR), (2, move(12))),
        (
            At(2, 3, 2, "Gearing Move Accel", "A:IP B:IP C:IP"),
            At(3, 5 + 2, 2 + 4, "Gearing Move", "A:IP B:IP C:IP"),
            At(6, 11 + 12, 2, "Gearing", "A:IP B:IP C:PC"),
        ),
    ),
    "7 a jog ends a move, Merge Enabled": Sequence(
        # 4 to 2 units/s at 2 units/s²: 1 s, 3 units
        "124, reading M-1",
        ((0, move(12)), (2, jog(merge="Enabled"))),
        (
            At(2, 6, 4, "Jog Decel", "B:IP"),
            At(3, 9, 2, "Jog", "B:IP"),
            At(4, 11, 2, "Jog", "B:IP"),
        ),
    ),
    "8 MCD of the jog below a move": Sequence(
        # the jog: 2 to 4 units/s at 2 units/s², 3 units
        "142",
        ((0, jog()), (2, move(12)), (3, change("Jog", 4))),
        (
            At(3, 5 + 2, 6, "Jog Move Accel", "A:IP B:IP"),
            At(4, 8 + 6, 4 + 4, "Jog Move", "A:IP B:IP"),
            At(6, 16 + 12, 4, "Jog", "A:IP B:PC"),
        ),
    ),
    "9 MCD of a move on a jog": Sequence(
        # the move: 4 to 2 units/s at 4 units/s², 1.5 units; 8 units at 2; 0.5 s and 0.5 units down
        "142",
        ((0, jog()), (2, move(12)), (3, change("Move", 2))),
        (
            At(3.5, 6 + 3.5, 2 + 2, "Jog Move", "A:IP B:IP"),
            At(7.5, 14 + 11.5, 4, "Jog Move Decel", "A:IP B:IP"),
            At(8, 15 + 12, 2, "Jog", "A:IP B:PC"),
        ),
    ),
    "10 MAS of Jog lets the move go on": Sequence(
        # the jog: 2 units/s to rest in 1 s, 1 unit
        "91",
        ((0, jog()), (2, move(12)), (3, stop("Jog", 2))),
        (
            At(3, 5 + 2, 6, "Move Stopping Decel", "B:IP C:IP"),
            At(4, 6 + 6, 4, "Move", "B:IP C:PC"),
            At(6, 6 + 12, 0, "", "B:PC C:PC"),
        ),
    ),
    "11 MAS of Move lets the jog go on": Sequence(
        # the move: 4 units/s to rest in 1 s, 2 units
        "91",
        ((0, jog()), (2, move(12)), (4, stop("Move", 4))),
        (
            At(4, 7 + 6, 6, "Jog Stopping Decel", "A:IP C:IP"),
            At(5, 9 + 8, 2, "Jog", "A:IP C:PC"),
            At(6, 11 + 8, 2, "Jog", "A:IP C:PC"),
        ),
    ),
    "12 MAS of Gear lets the jog go on": Sequence(
        # the gear: 7 units at 4 s, then 2 units/s to rest in 1 s, 1 unit; the jog: 3 units at 4 s
        "91, 129",
        ((0, MASTER), (0, GEAR), (2, jog()), (4, stop("Gear", 2))),
        (
            At(4, 7 + 3, 4, "Jog Stopping Decel", "A:IP C:IP D:IP"),
            At(5, 8 + 5, 2, "Jog", "A:IP C:IP D:PC"),
            At(6, 8 + 7, 2, "Jog", "A:IP C:IP D:PC"),
        ),
    ),
    "13 MAS of All stops the sum": Sequence(
        # 6 units/s to rest in 1 s, 3 units
        "91, reading M-4",
        ((0, jog()), (2, move(12)), (4, stop("All", 6))),
        (
            At(4, 7 + 6, 6, "Stopping Decel", "C:IP"),
            At(4.5, 13 + 2.25, 3, "Stopping Decel", "C:IP"),
            At(5, 16, 0, "", "C:PC"),
        ),
    ),
    "14 a merge discards the rest of an incremental move": Sequence(
        # at 1 unit after 1.5 s; 4 further units: 3.5 at 1 unit/s, 1 s and 0.5 units down
        "124",
        ((0, move(4, speed=1)), (1.5, move(4, speed=1, merge="Enabled"))),
        (
            At(1.5, 1, 1, "Move", "B:IP"),
            At(5, 4.5, 1, "Move Decel", "B:IP"),
            At(6, 5, 0, "", "B:PC"),
        ),
    ),
    "15 a newer move takes the place of a move, the jog stays": Sequence(
        # at 4 s the moves have gone 6 units, at 4 units/s: 4 further units are 0.5 s and 2, 1 s and 2 down
        "124, reading M-3",
        ((0, jog()), (2, move(12)), (4, move(4))),
        (
            At(4, 7 + 6, 6, "Jog Move", "A:IP C:IP"),
            At(4.5, 8 + 8, 6, "Jog Move Decel", "A:IP C:IP"),
            At(5.5, 10 + 10, 2, "Jog", "A:IP C:PC"),
        ),
    ),
    "16 an absolute move on a jog: its way counts from where it begins": Sequence(
        # 15 - 3 units
        "124, reading M-3",
        ((0, jog()), (2, move(15, kind=0))),
        (
            At(3, 5 + 2, 6, "Jog Move", "A:IP B:IP"),
            At(6, 11 + 12, 2, "Jog", "A:IP B:PC"),
        ),
    ),
    "17 a jog against a move: the sum turns": Sequence(
        # the jog backwards: 1 s, 1 unit; the axis speeds up while the move alone brakes from 5 s on
        "124",
        ((0, jog(way="Reverse")), (2, move(12))),
        (
            At(2, -3, -2, "Jog Move Decel", "A:IP B:IP"),
            At(2.5, -4 + 0.5, 0, "Jog Move Accel", "A:IP B:IP"),
            At(5, -9 + 10, 2, "Jog Move Decel", "A:IP B:IP"),
            At(6, -11 + 12, -2, "Jog", "A:IP B:PC"),
        ),
    ),
    "18 a move while MAS of All brakes a jog": Sequence(
        # 2 units/s to rest at 1 unit/s²: 2 s and 2 units, 1.5 of them in the first second
        "91, reading M-5",
        ((0, jog()), (2, stop("All", 1)), (3, move(12))),
        (
            At(3, 3 + 1.5, 1, "Move Stopping Accel", "B:IP C:IP"),
            At(4, 3 + 2 + 2, 4, "Move", "B:PC C:IP"),
            At(7, 3 + 2 + 12, 0, "", "B:PC C:PC"),
        ),
    ),
    "19 a merge at Current of an axis at rest": Sequence(
        "124, reading M-2",
        ((0, move(12, merge="Enabled", at="Current")),),
        (At(1, 2, 4, "Move", "A:IP"), At(4, 12, 0, "", "A:PC")),
    ),
}


def _bits(engine):
    return {f"{name}:{bit}" for name in NAMES for bit in ("IP", "PC") if engine.tags[f"{name}.{bit}"]}


@pytest.mark.parametrize("sequence", SEQUENCES.values(), ids=SEQUENCES)
def test_a_sequence_of_merging_motion(sequence):
    rungs = [
        f"XIC(Go{name}){text.replace('?', name)};"
        for name, (_, text) in zip(NAMES, sequence.begun, strict=False)
    ]
    for engine in both(TAGS, *rungs):
        seen = {round(each.seconds * 10): each for each in sequence.seen}
        for scan in range(max(seen) + 1):
            for name, (seconds, _) in zip(NAMES, sequence.begun, strict=False):
                engine.tags[f"Go{name}"] = scan >= round(seconds * 10)
            engine.step(100 if scan else 0)
            if scan in seen:
                _compare(engine, seen[scan], scan)


def _compare(engine, at, scan):
    tags = engine.tags
    shown = {name for name, bit in SHOWN.items() if tags[f"Ax.{bit}"]}
    assert (scan, shown) == (scan, set(at.shown.split()))
    assert tags["Ax.ActualPosition"] == pytest.approx(at.position, abs=1e-5)
    assert tags["Ax.ActualVelocity"] == pytest.approx(at.speed, abs=1e-5)
    if at.bits:
        assert (scan, _bits(engine)) == (scan, set(at.bits.split()))


PATHS = {
    # from (3, 0) at 2 s: 10 units at 5 units/s in 1 s + 1 s + 1 s, 6 along X and 8 along Y
    "Disabled": (At(3.5, 3 + 3 + 3, 3 + 2, "Jog CoordinatedMotion"), At(5, 3 + 6 + 6, 2, "Jog")),
    "Coordinated Motion": (At(3.5, 9, 5, "Jog CoordinatedMotion"), At(5, 15, 2, "Jog")),
    "All Motion": (At(3.5, 3 + 3, 3, "CoordinatedMotion"), At(5, 3 + 6, 0)),
}


def systems(folder, *rungs):
    """Yield both back ends of rungs with a coordinate system XY of the axes X and Y."""
    tags = [
        *(files.tag(name, "AXIS_VIRTUAL") for name in "XY"),
        *(files.tag(f"Go{name}", "BOOL") for name in NAMES),
        *(files.tag(name, "MOTION_INSTRUCTION") for name in NAMES),
        files.tag("P", "REAL", "2"),
        files.tag("Q", "REAL", "2"),
        """<Tag Name="XY" TagType="Base" DataType="COORDINATE_SYSTEM"><Data Format="CoordinateSystem">
        <CoordinateSystemParameters Dimension="2" Axes="X Y"/></Data></Tag>""",
    ]
    (folder / "xy.L5X").write_text(files.machine(*rungs, tags=tags), encoding="utf-8")
    controller = import_l5x(folder / "xy.L5X").controller
    assert controller is not None
    for engine in (controller.compile(), controller.interpret()):
        engine.tags["P"], engine.tags["Q"] = [6.0, 8.0], [4.5, 6.0]
        yield engine


def line(ends, control, merge):
    return f"MCLM(XY,{control},1,{ends}[0],{rates(5)},0,{merge},Programmed,0,0,None,0,0)"


@pytest.mark.parametrize("merge", PATHS)
def test_a_path_and_a_jog_of_one_of_its_axes(merge, tmp_path):
    """What each Merge of MCLM leaves of a jog [p. 449]."""
    jogging = jog(axis="X").replace("?", "A")
    for engine in systems(tmp_path, f"XIC(GoA){jogging};", f"XIC(GoB){line('P', 'B', merge)};"):
        seen = {round(each.seconds * 10): each for each in PATHS[merge]}
        for scan in range(51):
            engine.tags.GoA, engine.tags.GoB = True, scan >= 20
            engine.step(100 if scan else 0)
            if scan in seen:
                at = seen[scan]
                assert {name for name, bit in SHOWN.items() if engine.tags[f"X.{bit}"]} - {"Decel"} == set(
                    at.shown.split()
                )
                assert engine.tags["X.ActualPosition"] == pytest.approx(at.position)
                assert engine.tags["X.ActualVelocity"] == pytest.approx(at.speed, abs=1e-5)
        assert engine.tags["Y.ActualPosition"] == pytest.approx(8)
        assert _bits(engine) == {"B:PC"} | ({"A:IP"} if merge != "All Motion" else set())


def test_a_path_that_waited_is_active_once_it_begins(tmp_path):
    """AC "sets when the instruction becomes active" [MOTION_INSTRUCTION]; each path takes 3 s."""
    rungs = [f"XIC(Go{name}){line('P', name, 'Disabled')};" for name in "AB"]
    for engine in systems(tmp_path, *rungs):
        seen = []
        for scan in range(62):
            engine.tags.GoA = engine.tags.GoB = True
            engine.step(100 if scan else 0)
            if scan in (5, 35, 61):
                seen.append([name for name in ("A.AC", "B.AC") if engine.tags[name]])
        assert seen == [["A.AC"], ["B.AC"], []]


ENDINGS = {
    "stop": "MAS(X,B,All,Yes,6,Units per sec2,No,0,% of Time)",
    "servo off": "MSF(X,B)",
    "jog": jog(axis="X", merge="Enabled").replace("?", "B"),
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_ends_the_path_of_one_axis_ends_that_of_the_others(ending, tmp_path):
    """10 units at 5 units/s, 1 s up: at 1.5 s 5 units are done, 3 along X and 4 along Y.

    The axes of a path stand still together; a MAS of All of Y has nothing to stop later.
    """
    rungs = (
        f"XIC(GoA){line('P', 'A', 'Disabled')};",
        f"XIC(GoB){ENDINGS[ending]};",
        "XIC(GoC)MAS(Y,C,All,Yes,1,Units per sec2,No,0,% of Time);",
    )
    for engine in systems(tmp_path, *rungs):
        for scan in range(60):
            engine.tags.GoA, engine.tags.GoB, engine.tags.GoC = True, scan >= 15, scan >= 45
            engine.step(100 if scan else 0)
            if scan >= 15:
                assert engine.tags["Y.ActualPosition"] == pytest.approx(4)
                assert engine.tags["Y.ActualVelocity"] == 0
                assert engine.tags["Y.CoordinatedMotionStatus"] is False
        assert engine.tags["XY.MoveStatus"] is False
        assert {"C:PC"} <= _bits(engine)


def test_a_path_that_merges_ends_the_one_before_and_cancels_the_pending_one(tmp_path):
    """From the middle, at 5 units/s, 7.5 units on: 5 at that speed, 1 s and 2.5 units down [p. 449]."""
    rungs = (
        f"XIC(GoA){line('P', 'A', 'Disabled')};",
        f"XIC(GoB){line('P', 'B', 'Disabled')};",
        f"XIC(GoC){line('Q', 'C', 'Coordinated Motion')};",
    )
    for engine in systems(tmp_path, *rungs):
        for scan in range(36):
            engine.tags.GoA, engine.tags.GoB, engine.tags.GoC = True, scan >= 5, scan >= 15
            engine.step(100 if scan else 0)
            if scan == 14:
                assert _bits(engine) == {"A:IP", "B:IP"}
            if scan == 15:
                assert engine.tags["X.ActualVelocity"] == pytest.approx(3)
                assert _bits(engine) == {"C:IP"}
            if scan == 25:
                assert engine.tags["X.ActualPosition"] == pytest.approx(6)
        assert (engine.tags["X.ActualPosition"], engine.tags["Y.ActualPosition"]) == pytest.approx((7.5, 10))
        assert _bits(engine) == {"C:PC"}


@pytest.mark.parametrize("what", ["Gear", "Move", "Home", "Time Cam"])
def test_mas_of_what_does_not_run_stops_nothing(what):
    """It is complete at once, and the jog goes on."""
    for engine in both(
        TAGS, f"XIC(GoA){jog().replace('?', 'A')};", f"XIC(GoB){stop(what, 2).replace('?', 'B')};"
    ):
        engine.tags.GoA = True
        for scan in range(30):
            engine.tags.GoB = scan == 20
            engine.step(100)
        assert (engine.tags["Ax.JogStatus"], engine.tags["Ax.ActualVelocity"]) == (True, 2)
        assert _bits(engine) == {"A:IP", "B:PC"}


def test_each_instruction_shows_its_own_ramp():
    """ACCEL and DECEL are of "the individual instruction that it is tied to" [MOTION_INSTRUCTION]."""
    for engine in both(TAGS, f"XIC(GoA){jog().replace('?', 'A')};", f"XIC(GoB){move(12).replace('?', 'B')};"):
        seen = []
        for scan in range(61):
            engine.tags.GoA, engine.tags.GoB = True, scan >= 20
            engine.step(100 if scan else 0)
            if scan in (5, 25, 55, 60):
                seen.append([n + b for n in "AB" for b in ("ACCEL", "DECEL") if engine.tags[f"{n}.{b}"]])
        assert seen == [["AACCEL"], ["BACCEL"], ["BDECEL"], []]
