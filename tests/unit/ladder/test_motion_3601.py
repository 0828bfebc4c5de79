"""Motion instructions on the simulated 3601 in a rack: bits, positions, refusals [MOTION-RM002]."""

from contextlib import ExitStack
from dataclasses import replace

import pytest
from scanrack.jobs import JobRun, load_job
from scanrack.ladder import LadderLogic
from scanrack.runtime import RackFileError

TAGS = """PROGRAM m
TAG Feed : AXIS_CIP_DRIVE
TAG On : MOTION_INSTRUCTION
TAG Do : MOTION_INSTRUCTION
TAG Next : MOTION_INSTRUCTION
TAG Then : MOTION_INSTRUCTION
TAG Go : BOOL
TAG Search : BOOL
TAG Merge : BOOL
TAG Last : MOTION_INSTRUCTION
TAG More : BOOL
TAG Awake : TIMER
ROUTINE Main
TON(Awake,100,?);
XIC(Awake.DN)MSO(Feed,On);
"""

RACK = """program = "m.rung"
scan_ms = 10
[axes.Feed]
slot = 1
counts_per_unit = 1000
max_speed = 10
max_acceleration = 50
home_speed = 3
home_acceleration = 10
home_direction = -1
configuration = [0x843C, 0x003C, 0, 500, 0, 0, 0, 0]
[[slot]]
number = 1
module = "amci3601"
[slot.machine]
switches = [
    { input = "home", first = -1500, last = -1300 },
    { input = "ccw_limit", last = -4000 },
    { input = "cw_limit", first = 30000 },
]
"""
ESTOP = 'timeline = [{ at_s = 1.0, input = "estop", for_ms = 50 }]\n'

DYNAMICS = "Units per sec,20,Units per sec2,20,Units per sec2,Trapezoidal,100,100,% of Time"
TAIL = "Disabled,Programmed,0,None"
HOME = "XIC(Search)MAH(Feed,Next);"


def move(position, kind=0, control="Do", speed=5):
    return f"MAM(Feed,{control},{kind},{position},{speed},{DYNAMICS},{TAIL},0,0)"


def jog(direction, control="Do", speed=2):
    return f"MAJ(Feed,{control},{direction},{speed},{DYNAMICS},{TAIL})"


class Rig:
    """A program on a rack."""

    def __init__(self, folder, *rungs, rack=RACK, interpreted=False, tags=TAGS):
        (folder / "m.rung").write_text("\n".join([tags, *rungs, "END\n"]), encoding="utf-8")
        (folder / "m.toml").write_text(rack, encoding="utf-8")
        job = load_job(str(folder / "m.toml"))
        assert isinstance(job.logic, LadderLogic)
        self.engine = job.logic.interpret() if interpreted else job.logic.engine
        job = replace(job, logic=self.engine) if interpreted else job
        self.stack = ExitStack()
        self.cpu = self.stack.enter_context(JobRun(job, self.stack).cpu)

    def __getitem__(self, name):
        return self.engine.tags[name]

    def __setitem__(self, name, value):
        self.engine.tags[name] = value

    def scan(self, scans=1):
        self.cpu.run(scans)
        return self

    def until(self, tag, within=1500):
        for _ in range(0, within, 10):
            if self[tag]:
                return self
            self.scan(10)
        raise AssertionError(f"{tag} does not come")

    def bits(self, control="Do"):
        return {name for name in ("EN", "DN", "IP", "PC", "ER", "AC") if self[f"{control}.{name}"]}


@pytest.fixture(params=[False, True], ids=["compiled", "interpreted"])
def rig(request, tmp_path):
    made = []

    def make(*rungs, **parts):
        made.append(Rig(tmp_path, *rungs, interpreted=request.param, **parts))
        return made[-1]

    yield make
    for each in made:
        each.stack.close()


def homed(rig, *rungs, **parts):
    """Return a rig that is enabled and at home."""
    bench = rig(HOME, *rungs, **parts).until("On.DN")
    bench["Search"] = True
    bench.until("Next.PC")
    bench["Search"] = False
    return bench.scan(20)


def test_mso_configures_the_module_and_enables_the_axis(rig):
    bench = rig("NOP();").until("On.DN")
    assert bench.bits("On") == {"EN", "DN"}
    assert (bench["Feed.ServoActionStatus"], bench["Feed.DriveEnableStatus"]) == (True, True)
    assert bench["Feed.AxisHomedStatus"] is False


@pytest.mark.slow
def test_mah_homes_and_mam_moves_there(rig):
    bench = homed(rig, f"XIC(More){move(10)};")
    assert (bench["Feed.ActualPosition"], bench["Feed.AxisHomedStatus"]) == (0.0, True)
    bench["More"] = True
    bench.scan(20)
    assert bench.bits() == {"EN", "DN", "IP", "AC"}
    assert (bench["Feed.MoveStatus"], bench["Feed.JogStatus"]) == (True, False)
    bench.until("Do.PC")
    assert bench.bits() == {"EN", "DN", "PC"}
    assert bench["Feed.ActualPosition"] == 10.0
    bench["More"] = False
    assert bench.scan().bits() == {"DN", "PC"}


@pytest.mark.slow
def test_an_incremental_move_in_percent_of_maximum(rig):
    percent = "50,% of Maximum,40,% of Maximum,40,% of Maximum,0,100,100,0"
    bench = homed(rig, f"XIC(More)MAM(Feed,Do,1,-0.75,{percent},{TAIL},0,0);")
    bench["More"] = True
    bench.until("Do.PC")
    assert bench["Feed.ActualPosition"] == -0.75


@pytest.mark.slow
def test_a_jog_runs_until_mas_stops_it(rig):
    bench = homed(rig, f"XIC(More)XIO(Go){jog('Forward')};", "XIC(Go)MAS(Feed,Then,Jog,Yes,20,0,No,0,0);")
    bench["More"] = True
    bench.scan(200)
    assert bench.bits() == {"EN", "DN", "IP", "AC"}
    assert bench["Feed.JogStatus"] is True
    assert bench["Feed.ActualVelocity"] == pytest.approx(2.0, abs=0.5)
    bench["Go"] = True
    bench.until("Then.PC")
    assert bench.bits() & {"IP", "PC"} == set()
    assert bench["Feed.JogStatus"] is False


@pytest.mark.slow
def test_mcd_changes_the_speed_of_a_jog_and_of_no_move(rig):
    change = "MCD(Feed,Then,Jog,Yes,4,No,0,No,0,No,0,No,0,Units per sec,Units per sec2,Units per sec2,0)"
    bench = homed(rig, f"XIC(More){jog('Forward')};", f"XIC(Go){change};")
    bench["Go"] = True
    bench.scan(2)
    assert (bench["Then.ER"], bench["Then.ERR"]) == (True, 23)
    bench["Go"] = False
    bench["More"] = True
    bench.scan(200)
    bench["Go"] = True
    bench.scan(200)
    assert (bench["Then.DN"], bench["Then.ER"]) == (True, False)
    assert bench["Feed.ActualVelocity"] == pytest.approx(4.0, abs=0.5)


@pytest.mark.slow
def test_mrp_sets_the_position(rig):
    bench = homed(rig, "XIC(More)MRP(Feed,Do,Absolute,Actual,2.5);")
    bench["More"] = True
    bench.until("Do.DN").scan(10)
    assert bench["Feed.ActualPosition"] == 2.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rung", "code"),
    [
        (move(99_999), 13),
        (move(1, kind=7), 13),
        (move(1, speed=0), 13),
        (f"MAM(Feed,Do,0,1,5,Units per sec,99999,Units per sec2,20,0,0,1,1,0,{TAIL},0,0)", 13),
    ],
)
def test_what_does_not_fit_into_the_words_of_the_module(rig, rung, code):
    """Parameter out of range: nothing is sent."""
    bench = homed(rig, f"XIC(More){rung};")
    ticket = bench["Feed_3601.Ticket"]
    bench["More"] = True
    bench.scan(2)
    assert (bench.bits(), bench["Do.ERR"], bench["Feed_3601.Ticket"]) == ({"EN", "ER"}, code, ticket)


def test_without_mso_an_axis_takes_no_motion(rig):
    """5: servo off."""
    bench = rig(f"XIC(Go){move(1)};", "XIC(More)MSF(Feed,Next);").until("On.DN")
    bench["More"] = True
    bench.scan(2)
    assert bench["Feed.ServoActionStatus"] is False
    bench["Go"] = True
    bench.scan(2)
    assert (bench["Do.ER"], bench["Do.ERR"]) == (True, 5)


def test_an_axis_that_is_shut_down(rig):
    """7: shutdown; MASR ends it, and MSO enables the axis again."""
    bench = rig("XIC(Go)MASD(Feed,Do);", f"XIC(More){jog(0, 'Next')};").until("On.DN")
    bench["Go"] = True
    bench.scan(2)
    bench["More"] = True
    bench.scan(2)
    assert (bench["Feed.ShutdownStatus"], bench["Next.ERR"]) == (True, 7)


@pytest.mark.slow
def test_an_emergency_stop_is_a_fault_that_mafr_resets(rig):
    bench = rig(f"XIC(Go){jog('Forward', speed=1)};", "XIC(More)MAFR(Feed,Next);", rack=RACK + ESTOP).until(
        "On.DN"
    )
    bench["Go"] = True
    bench.until("Feed.PhysicalAxisFault", 300)
    assert (bench["Do.ER"], bench["Do.ERR"], bench["Do.IP"]) == (True, 20, False)
    bench.scan(100)
    bench["More"] = True
    bench.until("Next.DN", 100)
    bench.scan(2)
    assert bench["Feed.PhysicalAxisFault"] is False


LOST = '[[incident]]\nat_s = 1.0\nwhat = "link-lost"\nfor_ms = 400\n'


@pytest.mark.slow
def test_a_link_that_is_lost_in_a_jog_is_a_fault(rig):
    """Cut by the loss, 400 ms: ER behind it, and the block knows the link."""
    bench = rig(f"XIC(Go){jog('Forward', speed=1)};", rack=RACK + LOST).until("On.DN")
    bench["Go"] = True
    bench.until("Feed_3601.LinkDown", 300)
    assert bench["Do.IP"] is True
    bench.until("Do.ER", 300)
    assert (bench["Do.ERR"], bench["Do.IP"], bench["Feed_3601.ErrorID"]) == (20, False, 1024 + 512)


@pytest.mark.slow
def test_a_newer_move_takes_the_axis(rig):
    """The first one's IP ends without PC."""
    bench = homed(rig, f"XIC(Go)XIO(More){move(8)};", f"XIC(More){move(2, control='Then')};")
    bench["Go"] = True
    bench.scan(100)
    bench["More"] = True
    bench.until("Then.PC")
    assert (bench["Do.IP"], bench["Do.PC"], bench["Feed.ActualPosition"]) == (False, False, 2.0)


def merged(text):
    return text.replace("Disabled,Programmed", "Enabled,Programmed")


@pytest.mark.slow
def test_beside_a_jog_a_3601_takes_a_move_with_merge_only(rig):
    """22: a 3601 can't superimpose; nothing is sent, and the jog goes on. Merged, the jog ends first."""
    rungs = (f"XIC(More){jog('Forward')};", f"XIC(Go){move(9, control='Then')};")
    bench = homed(rig, *rungs, f"XIC(Merge){merged(move(9, control='Last'))};")
    bench["More"] = True
    bench.scan(100)
    ticket = bench["Feed_3601.Ticket"]
    bench["Go"] = True
    bench.scan(20)
    assert (bench.bits("Then"), bench["Then.ERR"]) == ({"EN", "ER"}, 22)
    assert (bench["Feed_3601.Ticket"], bench["Feed.JogStatus"], bench["Do.IP"]) == (ticket, True, True)
    bench["Merge"] = True
    bench.scan(2)
    assert (bench["Do.IP"], bench["Do.PC"], bench["Last.IP"]) == (False, False, True)
    bench.until("Last.PC")
    assert (bench["Feed.ActualPosition"], bench["Feed.JogStatus"]) == (9.0, False)


@pytest.mark.slow
def test_beside_a_move_a_3601_takes_no_jog_and_mas_of_a_jog_stops_nothing(rig):
    rungs = (f"XIC(More){move(9)};", f"XIC(Go){jog('Forward', 'Then')};")
    bench = homed(rig, *rungs, "XIC(Merge)MAS(Feed,Last,Jog,No,0,0,No,0,0);")
    bench["More"] = True
    bench.scan(50)
    bench["Go"] = bench["Merge"] = True
    bench.scan(2)
    assert (bench.bits("Then"), bench["Then.ERR"]) == ({"EN", "ER"}, 22)
    assert bench.bits("Last") == {"EN", "DN", "PC"}
    bench.until("Do.PC")
    assert bench["Feed.ActualPosition"] == 9.0


@pytest.mark.slow
def test_a_merge_at_current_speed_takes_the_speed_of_the_jog(rig):
    """2 units/s instead of the 5 of the instruction: 2,000 steps/s in words 4 and 5."""
    merge = move(9, control="Then").replace("Disabled,Programmed", "Enabled,Current")
    bench = homed(rig, f"XIC(More){jog('Forward')};", f"XIC(Go){merge};")
    bench["More"] = True
    bench.scan(100)
    bench["Go"] = True
    bench.scan()
    assert list(bench["Feed_3601.Words"])[4:6] == [2, 0]


ADD_ON = f"""INSTRUCTION Feeder
INOUT Ax : AXIS_CIP_DRIVE
INOUT Ctl : MOTION_INSTRUCTION
INPUT Run : BOOL REQUIRED
LOCAL Own : MOTION_INSTRUCTION
LOCAL Never : MOTION_INSTRUCTION
ROUTINE Logic
XIC(Run)MSO(Ax,Ctl);
XIC(Ctl.DN){move(4, kind=1, control="Own").replace("Feed,", "Ax,")};
XIC(Ctl.DN)MDF(Ax,Never);
END
END INSTRUCTION
TAG Feed"""


def test_an_axis_that_an_add_on_instruction_gets(rig):
    """25: a 3601 can't do MDF."""
    tags = TAGS.replace("TAG Feed", ADD_ON, 1).replace("TAG On", "TAG Block : Feeder\nTAG On", 1)
    tags = tags.replace("XIC(Awake.DN)MSO(Feed,On);", "Feeder(Block,Feed,On,Awake.DN);")
    bench = rig("NOP();", tags=tags).until("Block.Own.PC")
    assert (bench["Feed.ActualPosition"], bench["Block.Never.ERR"]) == (4.0, 25)


@pytest.mark.parametrize(
    ("rung", "rack", "says"),
    [
        (
            "MAG(Feed,Feed,Do,0,1,1,1,Actual,Real,Enabled,50,0);",
            RACK,
            "Feed is a 3601, which can't do MAG; a 3601 does MSO, MSF",
        ),
        ("NOP();", RACK.replace("axes.Feed", "axes.Feeed"), "axis Feeed: no tag Feeed"),
        ("NOP();", RACK.replace("axes.Feed", "axes.Go"), "Go is not an axis; name a tag of type AXIS_"),
        ("NOP();", RACK.replace("slot = 1\ncounts", "slot = 2\ncounts"), "axes.Feed.slot = 2: this slot is"),
        (
            "NOP();",
            RACK.replace("counts_per_unit", "counts_per_uni"),
            "did you mean counts_per_unit",
        ),
        ("NOP();", RACK.replace("0x843C, ", ""), "configuration has 7 words; must be 8"),
        (
            "NOP();",
            RACK.replace("direction = -1", "direction = 3"),
            "home_direction is 3; must be 1 or -1",
        ),
    ],
)
def test_what_is_refused_before_the_first_scan(tmp_path, rung, rack, says):
    with pytest.raises(RackFileError) as refused:
        Rig(tmp_path, rung, rack=rack)
    assert says in str(refused.value)
