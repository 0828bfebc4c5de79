"""Motion instructions on ideal axes: bits, positions by arithmetic, both back ends [MOTION-RM002]."""

import pytest
from ladder_bench import both
from scanrack.ladder.files import parse_program

pytestmark = pytest.mark.slow  # together they take seconds

TAGS = """TAG Feed : AXIS_CIP_DRIVE
TAG Slave : AXIS_SERVO
TAG Master : AXIS_VIRTUAL
TAG Table : AXIS_CIP_DRIVE
TAG Both : COORDINATE_SYSTEM
TAG G : MOTION_GROUP
TAG On : MOTION_INSTRUCTION
TAG Other : MOTION_INSTRUCTION
TAG Halt : MOTION_INSTRUCTION
TAG Do : MOTION_INSTRUCTION
TAG Then : MOTION_INSTRUCTION
TAG Go : BOOL
TAG More : BOOL
TAG Live : BOOL := true
TAG P : REAL[6] := [3, 4, 0, 0, 0, 0]
TAG Q : REAL[6]
TAG R : REAL[6]
"""
SERVO = "XIC(Live)[MSO(Feed,On),MSO(Slave,Other)];"
UNITS = "Units per sec,{0},Units per sec2,{1},Units per sec2"
TAIL = "Disabled,Programmed,0,None,0,0"


def rates(speed, up, down, curve="Trapezoidal,100,100,% of Time"):
    return f"{speed},{UNITS.format(up, down)},{curve}"


def move(position, kind=0, control="Do", axis="Feed", dynamics=None):
    return f"MAM({axis},{control},{kind},{position},{dynamics or rates(5, 10, 5)},{TAIL})"


def jog(direction, control="Do", axis="Feed", speed=2):
    return f"MAJ({axis},{control},{direction},{rates(speed, 10, 10)},Disabled,Programmed,0,None)"


def bits(engine, control="Do"):
    return {name for name in ("EN", "DN", "IP", "PC", "ER", "AC") if engine.tags[f"{control}.{name}"]}


def run(engine, seconds, ms=10):
    for _ in range(round(seconds * 1000 / ms)):
        engine.step(ms)
    return engine


def benches(*rungs, tags=TAGS):
    """Yield both back ends with servos on, after a scan."""
    for engine in both(tags, SERVO, *rungs):
        engine.step()
        yield engine


def position(engine, axis="Feed"):
    return engine.tags[f"{axis}.ActualPosition"]


def test_mso_and_msf_switch_the_axis_at_once():
    for engine in benches("XIC(Go)MSF(Feed,Then);"):
        assert (bits(engine, "On"), engine.tags["Feed.DriveEnableStatus"]) == ({"EN", "DN"}, True)
        assert engine.tags["Feed.CIPAxisState"] == 4
        engine.tags.Go = True
        engine.step()
        assert (engine.tags["Feed.ServoActionStatus"], engine.tags["Feed.CIPAxisState"]) == (False, 2)


def test_a_move_follows_its_trapezoid_exactly():
    """10 units at 5/s, 10/s² up and 5/s² down: 0.5 s, 1.25 s, 1 s; 1.25 + 6.25 + 2.5 units."""
    for engine in benches(f"XIC(Go){move(10)};"):
        engine.tags.Go = True
        engine.step()
        assert bits(engine) == {"EN", "DN", "IP", "AC"}
        assert engine.tags["Feed.MoveStatus"] is True
        run(engine, 0.5)
        assert position(engine) == pytest.approx(1.25)
        assert engine.tags["Feed.ActualVelocity"] == pytest.approx(5.0)
        run(engine, 1.25)
        assert position(engine) == pytest.approx(7.5)
        run(engine, 0.5)
        assert position(engine) == pytest.approx(7.5 + 2.5 - 5 * 0.5**2 / 2)
        assert engine.tags["Feed.DecelStatus"] is True
        run(engine, 0.51)
        assert (position(engine), bits(engine)) == (10.0, {"EN", "DN", "PC"})
        assert engine.tags["Feed.ActualVelocity"] == 0


def test_an_s_curve_takes_twice_as_long_for_its_ramps():
    """100 % of time: 0.5 s becomes 1 s, half of the way at half of the time."""
    curve = rates(5, 10, 10, "S-Curve,100,100,% of Time")
    for engine in benches(f"XIC(Go){move(10, dynamics=curve)};"):
        engine.tags.Go = True
        engine.step()
        run(engine, 0.5)
        assert engine.tags["Feed.ActualVelocity"] == pytest.approx(2.5)
        run(engine, 0.5)
        assert position(engine) == pytest.approx(2.5)


def test_it_ends_without_its_rung():
    """The motion task sets the bits, whether the rung is scanned or not."""
    for engine in benches("XIC(Go)JMP(past);", f"XIC(More){move(1)};", "LBL(past)NOP();"):
        engine.tags.More = True
        engine.step()
        engine.tags.Go = True
        run(engine, 2)
        assert (bits(engine), position(engine)) == ({"EN", "DN", "PC"}, 1.0)


def test_a_newer_move_goes_on_from_the_present_speed():
    for engine in benches(f"XIC(Go)XIO(More){move(100)};", f"XIC(More){move(2, 1, 'Then')};"):
        engine.tags.Go = True
        engine.step()
        run(engine, 1)  # 1.25 + 2.5 units
        engine.tags.More = True
        engine.step()
        assert (bits(engine), bits(engine, "Then")) == ({"DN"}, {"EN", "DN", "IP", "AC"})
        assert engine.tags["Feed.ActualVelocity"] == pytest.approx(5.0)
        run(engine, 3)  # 5/s² stop in 2.5 units: too far, and back
        assert position(engine) == pytest.approx(3.75 + 0.05 + 2.0)


def test_a_jog_mcd_and_mas():
    change = "MCD(Feed,Then,Jog,Yes,4,No,0,No,0,No,0,No,0,Units per sec,Units per sec2,Units per sec2,0)"
    stop = "MAS(Feed,On,Jog,Yes,20,Units per sec2,No,0,0)"
    for engine in benches(f"XIC(Go){jog('Reverse')};", f"XIC(More){change};", f"XIO(Live){stop};"):
        engine.tags.Go = True
        run(engine, 0.51)
        assert engine.tags["Feed.ActualVelocity"] == pytest.approx(-2.0)
        engine.tags.More = True
        run(engine, 0.5)
        assert engine.tags["Feed.ActualVelocity"] == pytest.approx(-4.0)
        assert (engine.tags["Then.DN"], bits(engine)) == (True, {"EN", "DN", "IP", "AC"})
        before = position(engine)
        engine.tags.Live = False
        run(engine, 0.01)
        assert engine.tags["Feed.StoppingStatus"] is True
        run(engine, 0.3)
        assert position(engine) == pytest.approx(before - 0.04 - 0.4, abs=0.05)
        assert (bits(engine), bits(engine, "On")) == ({"EN", "DN"}, {"DN", "PC", "EN"})


def test_homing_sets_the_home_position():
    for engine in benches("XIC(Go)MAH(Feed,Do);"):
        engine.tags["Feed.HomePosition"] = 7.5
        engine.tags.Go = True
        engine.step()
        assert (engine.tags["Feed.HomingStatus"], engine.tags["Feed.AxisHomedStatus"]) == (True, False)
        engine.step()
        assert (position(engine), bits(engine)) == (7.5, {"EN", "DN", "PC"})
        assert engine.tags["Feed.AxisHomedStatus"] is True


def test_mrp_shifts_the_reference_of_a_move_under_way():
    for engine in benches(f"XIC(Go){move(10)};", "XIC(More)MRP(Feed,Then,Relative,Actual,-1);"):
        engine.tags.Go = True
        engine.step()
        engine.tags.More = True
        run(engine, 4)
        assert position(engine) == 9.0


def test_a_gear_follows_its_master():
    gear = "MAG(Slave,Master,Then,Opposite,0.5,1,1,Actual,Real,Disabled,50,% of Maximum)"
    rungs = (f"XIC(Live){gear};", f"XIC(Go){jog('Forward', axis='Master')};")
    for engine in benches(*rungs, "XIC(More)MAS(Slave,Halt,Gear,No,0,0,No,0,0);"):
        engine.tags.Go = True
        run(engine, 2)
        assert position(engine, "Slave") == pytest.approx(-position(engine, "Master") / 2)
        assert engine.tags["Slave.GearingLockStatus"] is True
        engine.tags.More = True
        run(engine, 1)
        assert (engine.tags["Slave.GearingStatus"], engine.tags["Then.IP"]) == (False, False)
        assert position(engine, "Slave") != pytest.approx(-position(engine, "Master") / 2)


@pytest.mark.parametrize("rung", ["MRP(Master,Halt,Absolute,Actual,100)", "MAH(Master,Halt)"])
def test_a_gear_does_not_follow_another_reference_of_its_master(rung):
    gear = "MAG(Slave,Master,Then,Same,1,1,1,Actual,Real,Disabled,0,0)"
    for engine in benches(f"XIC(Live){gear};", f"XIC(Go){rung};"):
        engine.tags["Master.HomePosition"] = 7
        engine.tags.Go = True
        run(engine, 0.1)
        assert (position(engine, "Master"), position(engine, "Slave")) == (100 if "MRP" in rung else 7, 0)
        assert engine.tags["Slave.GearingStatus"] is True


def test_a_watch_ends_when_the_axis_comes_by():
    for engine in benches(f"XIC(Go){jog('Forward')};", "XIC(Live)MAW(Feed,Then,Forward,1);"):
        engine.tags.Go = True
        run(engine, 0.4)
        assert engine.tags["Feed.WatchEventArmedStatus"] is True
        run(engine, 0.4)
        assert (bits(engine, "Then"), engine.tags["Feed.WatchEventStatus"]) == ({"EN", "DN", "PC"}, True)


@pytest.mark.parametrize(
    ("rungs", "error"),
    [
        ((f"XIC(Go){move(1, axis='Table')};",), 5),
        (("XIC(More)MASD(Feed,Then);", f"XIC(Go){jog(0)};"), 7),
        ((f"XIC(Go){move(1, kind=9)};",), 13),
        ((f"XIC(Go){jog(0, speed=0)};",), 13),
        (("XIC(Go)MCD(Feed,Do,Move,Yes,4,No,0,No,0,No,0,No,0,0,0,0,0);",), 23),
        (("XIC(Go)MDF(Feed,Do);",), 25),
    ],
)
def test_what_ends_with_an_error(rungs, error):
    for engine in benches(*rungs):
        engine.tags.More = True
        engine.step()
        engine.tags.Go = True
        engine.step()
        assert (bits(engine), engine.tags["Do.ERR"]) == ({"EN", "ER"}, error)


def test_the_group_stops_all_axes():
    for engine in benches(
        f"XIC(Go){jog(0)};", f"XIC(Go){jog(0, 'On', 'Master')};", "XIC(More)MGS(G,Then,0);"
    ):
        engine.tags.Go = True
        run(engine, 1)
        engine.tags.More = True
        run(engine, 1)
        assert (engine.tags["Feed.JogStatus"], engine.tags["Master.ActualVelocity"]) == (False, 0)
        assert bits(engine, "Then") == {"EN", "DN", "PC"}


def test_a_coordinate_system_goes_straight_and_queues_one_move():
    """5 units at 5/s, 10/s²: 0.5 + 0.5 + 0.5 s."""
    line = f"MCLM(Both,{{}},{{}},P[0],{rates(5, 10, 10)},0,Disabled,Programmed,0,0,None,0,0)"
    rungs = (f"XIC(Go){line.format('Do', 0)};", f"XIC(More){line.format('Then', 1)};")
    for engine in benches(*rungs):
        engine.tags.Go = True
        engine.step()
        run(engine, 0.75)
        assert engine.tags["Both.ActualPosition"][:2] == pytest.approx([1.5, 2.0])
        engine.tags.More = True
        engine.step()
        assert engine.tags["Both.MovePendingStatus"] is True
        run(engine, 0.75)
        assert (bits(engine), bits(engine, "Then")) == ({"EN", "DN", "PC"}, {"EN", "DN", "IP", "AC"})
        run(engine, 1.55)
        assert engine.tags["Both.ActualPosition"][:2] == [6.0, 8.0]
        assert bits(engine, "Then") == {"EN", "DN", "PC"}


def test_a_transform_without_frames_is_active_until_it_is_stopped():
    rungs = (
        "XIC(Go)MCTO(Both,Both,Do,0,0);",
        "XIC(Go)MCTPO(Both,Both,Then,0,0,Inverse,P[0],Q[0],0,0);",
        "XIC(More)MCS(Both,Halt,Coordinated Transform,No,0,0,No,0,0);",
    )
    for engine in benches(*rungs):
        engine.tags.Go = True
        engine.step()
        assert (bits(engine), engine.tags["Both.TransformSourceStatus"]) == ({"EN", "DN", "IP"}, True)
        assert (engine.tags["Q"][:2], bits(engine, "Then")) == ([3.0, 4.0], {"EN", "DN", "PC"})
        engine.tags.More = True
        engine.step()
        assert bits(engine) == {"EN", "DN"}


PATHS = """TYPE PathData (InterpolationType : DINT, Position : REAL[9], MoveType : DINT)
TYPE DynamicsData (Speed : REAL, Acceleration : REAL, Deceleration : REAL)
TAG Path : PathData := {"Position": [0, 0, 2]}
TAG Dyn : DynamicsData := {"Speed": 2, "Acceleration": 4, "Deceleration": 4}
"""


def test_mcpm_goes_to_the_position_of_its_path():
    """2 units at 2/s, 4/s²: 1.5 s."""
    for engine in benches("XIC(Go)MCPM(Both,Do,Path,1,Dyn,0,None);", tags=PATHS + TAGS):
        engine.tags.Go = True
        engine.step()
        run(engine, 1.4)
        assert engine.tags["Both.ActualPosition"][2] < 2
        run(engine, 0.12)
        assert (engine.tags["Both.ActualPosition"][2], bits(engine)) == (2.0, {"EN", "DN", "PC"})


ADD_ON = f"""INSTRUCTION Feeder
INOUT Ax : AXIS_CIP_DRIVE
INPUT Run : BOOL REQUIRED
LOCAL Own : MOTION_INSTRUCTION
ROUTINE Logic
XIC(Run){move(4, kind=1, control="Own").replace("Feed", "Ax")};
END
END INSTRUCTION
TAG Block : Feeder[2]
"""


def test_an_axis_and_a_control_in_an_add_on_instruction():
    for engine in benches("Feeder(Block[1],Feed,Go);", tags=ADD_ON + TAGS):
        engine.tags.Go = True
        run(engine, 4)
        assert (position(engine), engine.tags["Block"][1]["Own"]["PC"]) == (4.0, True)


def test_an_edit_that_adds_axes_keeps_a_move_and_a_jog_under_way():
    """Axes are numbered in the order of their tags: the edited program numbers them again."""
    rungs = f"XIC(Go){move(10)};\nXIC(Go){jog('Forward', 'Then')};"
    old, new = (
        parse_program(f"PROGRAM p\n{more}{TAGS}ROUTINE Main\n{SERVO}\n{rungs}\nEND\n")
        for more in ("", "TAG Before : AXIS_VIRTUAL\nTAG First : MOTION_INSTRUCTION\n")
    )
    old.tags.Go = True
    for _ in range(60):
        old.step(10)
    new.take_over(old)
    assert new.tags["Feed.MoveStatus"] is True
    for _ in range(300):
        new.step(10)
    # 359 scans after the first one: the jog's ramp of 0.2 s and 0.2 units, and 3.39 s at 2 units/s
    assert position(new) == pytest.approx(10.0 + 0.2 + 2 * 3.39)
    assert (bits(new), bits(new, "Then")) == ({"EN", "DN", "PC"}, {"EN", "DN", "IP", "AC"})
