"""Fault routines that may clear a major fault, event tasks, and the attributes of GSV and SSV."""

import pytest
from scanrack.ladder import BuildError, LadderFault
from scanrack.ladder.files import parse_program, program_text

FAULTY = """{head}
TYPE Record (TimeLow : DINT, TimeHigh : DINT, Type : INT, Code : INT, Info : DINT[8])
TAG Table : DINT[4]
TAG At : DINT := 9
TAG Seen : Record
TAG Before : DINT
TAG Behind : DINT
{tasks}
PROGRAM Main FAULT Trouble
ROUTINE Main
ADD(Before,1,Before);
MOV(1,Table[At]);
ADD(Behind,1,Behind);
END
ROUTINE Trouble
GSV(Program,THIS,MajorFaultRecord,Seen.TimeLow);
{clear}
END
{end}
"""

CLEAR = "MOV(0,Seen.Type)MOV(0,Seen.Code)SSV(Program,THIS,MajorFaultRecord,Seen.TimeLow);"
OTHER = "PROGRAM Other\nTAG Runs : DINT\nROUTINE Main\nADD(Runs,1,Runs);\nEND\nEND PROGRAM\n"


def controller(clear=CLEAR):
    return FAULTY.format(
        head="CONTROLLER plant",
        tasks="TASK C : CONTINUOUS RUNS Main, Other",
        clear=clear,
        end=f"END PROGRAM\n{OTHER}",
    )


def both(text):
    return [parse_program(text).compile(), parse_program(text).interpret()]


def test_a_fault_routine_clears_a_fault_and_the_rest_of_its_program_is_left_out():
    for engine in both(controller()):
        for _ in range(3):
            engine.step()
        tags = engine.tags
        assert (tags["Before"], tags["Behind"]) == (3, 0)
        assert tags[r"\Other.Runs"] == 3
        engine.tags["At"] = 1
        engine.step()
        assert (tags["Before"], tags["Behind"], tags["Table[1]"]) == (4, 1, 1)


def test_a_fault_that_is_not_cleared_stops_the_scan():
    for engine in both(controller(clear="NOP();")):
        with pytest.raises(LadderFault) as stopped:
            engine.step()
        assert "program Main, routine Main, rung 1, MOV(1,Table[At])" in str(stopped.value)
        assert (engine.tags["Seen.Type"], engine.tags["Seen.Code"]) == (4, 20)
        assert engine.tags[r"\Other.Runs"] == 0


def test_a_fault_in_the_fault_routine_is_the_one_that_stops():
    for engine in both(controller(clear="MOV(2,Table[At]);")):
        with pytest.raises(LadderFault) as stopped:
            engine.step()
        assert "routine Trouble" in str(stopped.value)


def test_a_program_without_a_controller_may_have_a_fault_routine():
    flat = FAULTY.format(head="", tasks="", clear=CLEAR, end="").replace("PROGRAM Main FAULT Trouble", "")
    text = f"PROGRAM Main FAULT Trouble\n{flat.strip()}\n"
    assert program_text(parse_program(text)).startswith("PROGRAM Main FAULT Trouble\n")
    for engine in both(text):
        engine.step()
        engine.step()
        assert (engine.tags["Before"], engine.tags["Behind"], engine.tags["Seen.Code"]) == (2, 0, 0)


@pytest.mark.slow
def test_a_watchdog_fault_is_not_for_the_fault_routine():
    text = controller().replace("MOV(1,Table[At]);", "LBL(Again);\nJMP(Again);")
    for engine in both(text):
        with pytest.raises(LadderFault, match="watchdog"):
            engine.step()


EVENTS = """CONTROLLER plant
TAG Go : BOOL
TAG Rang : DINT
TAG Seen : DINT[3]
TASK C : CONTINUOUS RUNS Main
TASK Bell : EVENT PRIORITY 1{preempt} RUNS Ring
PROGRAM Main
ROUTINE Main
XIC(Go)EVENT(Bell);
MOV(Rang,Seen[0]);
XIC(Go)EVENT(Bell);
MOV(Rang,Seen[1]);
GSV(Task,Bell,OverlapCount,Seen[2]);
END
END PROGRAM
PROGRAM Ring
ROUTINE Main
ADD(Rang,1,Rang);
END
END PROGRAM
"""


def test_an_event_task_runs_before_the_next_scan_of_the_continuous_one():
    for engine in both(EVENTS.format(preempt="")):
        engine.tags["Go"] = True
        engine.step()
        assert (engine.tags["Rang"], engine.tags["Seen"]) == (0, [0, 0, 1])  # the second trigger overlaps
        engine.tags["Go"] = False
        engine.step()
        engine.step()
        assert (engine.tags["Rang"], engine.tags["Seen"][:2]) == (1, [1, 1])


def test_with_preempt_it_runs_at_the_end_of_the_rung():
    for engine in both(EVENTS.format(preempt=" PREEMPT")):
        engine.tags["Go"] = True
        engine.step()
        assert (engine.tags["Rang"], engine.tags["Seen"]) == (2, [1, 2, 0])


@pytest.mark.parametrize(
    ("rung", "says"),
    [
        ("EVENT(C);", "no event task C; event tasks are Bell"),
        ("GSV(Axis,A,Position,Seen);", "A has no attribute Position"),
        (
            "SSV(Task,C,Rate,Seen);",
            "no attribute RATE of TASK; choose from OVERLAPCOUNT, DISABLEUPDATEOUTPUTS",
        ),
        ("GSV(Task,C,Rate,Go);", "Go is a BOOL, a tag with bytes is needed"),
    ],
)
def test_what_there_is_not(rung, says):
    with pytest.raises(BuildError) as refused:
        parse_program(EVENTS.format(preempt="").replace("XIC(Go)EVENT(Bell);", rung)).build()
    assert says in str(refused.value)


def test_attributes_of_tasks_and_the_clock():
    text = """CONTROLLER plant
TAG Rate : DINT
TAG Priority : INT
TAG Late : DINT
TAG Now : DINT[7]
TAG Micro : LINT
TASK Fast : PERIODIC 4 ms PRIORITY 3 RUNS Main
PROGRAM Main
ROUTINE Main
GSV(Task,Fast,Rate,Rate)GSV(Task,Fast,Priority,Priority)GSV(Task,Fast,OverlapCount,Late);
GSV(WallClockTime,,DateTime,Now[0]);
GSV(WallClockTime,,CurrentValue,Micro);
GRT(Late,2)MOV(0,Late)SSV(Task,Fast,OverlapCount,Late);
END
END PROGRAM
"""
    assert "GSV(WallClockTime,,DateTime,Now[0]);" in program_text(parse_program(text))
    for engine in both(text):
        engine.step()
        engine.step(10)
        tags = engine.tags
        assert (tags["Rate"], tags["Priority"], tags["Late"]) == (
            4_000,
            3,
            1,
        )  # due at 4 and 8 ms: one overlap
        assert (tags["Now"], tags["Micro"]) == ([1970, 1, 1, 0, 0, 0, 10_000], 10_000)
        engine.step(20)  # due at 12, 16, 20, 24 and 28 ms: four more overlaps
        assert tags["Late"] == 0
        engine.step(4)
        assert tags["Late"] == 0


def test_a_data_log_is_memory_and_the_hardware_has_no_fans():
    """HardwareStatus: the first SINT of an array is the number of fans; DataLog: any name is a DINT."""
    text = """CONTROLLER plant
TAG Fans : SINT[9] := [7, 7]
TAG Ups : SINT := 5
TAG Enabled : DINT := 3
TAG Read : DINT
PROGRAM Main
ROUTINE Main
GSV(HardwareStatus,,FanSpeeds,Fans[0])GSV(HardwareStatus,,UPSSupported,Ups);
SSV(DataLog,Batch,Enable,Enabled)GSV(DataLog,Batch,Enable,Read);
END
END PROGRAM
"""
    for engine in both(text):
        engine.step()
        tags = engine.tags
        assert (tags["Fans[0]"], tags["Fans[1]"], tags["Ups"], tags["Read"]) == (0, 7, 0, 3)
    wrong = text.replace("FanSpeeds", "Fans")
    with pytest.raises(BuildError, match="no attribute FANS of HARDWARESTATUS; choose from FANSPEEDS"):
        parse_program(wrong).build()


def test_this_task_is_the_task_of_the_program_whatever_another_task_is_called():
    text = """CONTROLLER plant
TAG Own : STRING
TAG Named : STRING
TAG Rate : DINT
TAG Unknown : DINT := 5
TASK Main : PERIODIC 20 ms RUNS Other
TASK Fast : PERIODIC 10 ms RUNS Main
PROGRAM Main
ROUTINE Main
GSV(Task,THIS,Name,Own)GSV(Task,Main,Name,Named);
GSV(Task,THIS,Rate,Rate)GSV(Task,Other,Rate,Unknown);
END
END PROGRAM
PROGRAM Other
ROUTINE Main
NOP();
END
END PROGRAM
"""
    for engine in both(text):
        engine.step(20)
        engine.step(20)
        tags = engine.tags
        assert (tags["Own"], tags["Named"]) == ("FAST", "MAIN")
        assert (tags["Rate"], tags["Unknown"]) == (10_000, 0)  # us; no task is called Other


def test_attributes_that_are_memory_and_a_clock_that_is_set():
    text = """CONTROLLER plant
TAG Entry : INT
TAG Mode : INT
TAG Back : INT
TAG Time : DINT[7]
TAG Micro : LINT
TAG Own : STRING
TAG Set : BOOL := true
PROGRAM Main
ROUTINE Main
GSV(Module,Drive,EntryStatus,Entry)GSV(Program,THIS,Name,Own);
XIC(Set)MOV(4,Mode)SSV(Module,Drive,Mode,Mode);
XIC(Set)MOV(2024,Time[0])MOV(2,Time[1])MOV(29,Time[2])SSV(WallClockTime,,DateTime,Time[0])OTU(Set);
GSV(Module,Drive,Mode,Back)GSV(Module,Other,Mode,Mode);
GSV(WallClockTime,,DateTime,Time[0]);
END
END PROGRAM
"""
    for engine in both(text):
        engine.step()
        engine.step(1_500)
        tags = engine.tags
        assert (tags["Entry"], tags["Own"]) == (0x4000, "MAIN")  # 4 in the upper bits: running
        assert (tags["Back"], tags["Mode"]) == (4, 0)
        assert tags["Time"] == [2024, 2, 29, 0, 0, 1, 500_000]
