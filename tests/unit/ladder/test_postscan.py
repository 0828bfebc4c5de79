"""Postscan: the last scan of an SFC action with automatic reset [1756-PM006, 1756-RM003N, 1756-PM010]."""

import pytest
from scanrack.ladder import LadderFault, Program
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.debug.why import explain_cause
from scanrack.ladder.files import parse_program

TAGS = """\
TAG Go : BOOL
TAG Bit : BOOL[8]
TAG T : TIMER[3] := [{"PRE": 50}, {"PRE": 50}, {"PRE": 50}]
TAG C : COUNTER := {"PRE": 5}
TAG N : DINT[4]
TAG At : DINT
"""


def engines(rungs, more="", tags=TAGS):
    program = parse_program(f"PROGRAM p\n{more}{tags}ROUTINE Main\nJSR(Act);\nEND\nROUTINE Act{rungs}\nEND\n")
    for engine in (program.interpret(), program.compile()):
        engine.tags.Go = True
        yield engine


def ran(engine, *, scans=2):
    """Scan each 10 ms; then the action is postscanned."""
    for _ in range(scans):
        engine.step(10)
    engine.interpreter.postscan("ACT")
    return engine.tags


def test_a_coil_is_cleared_and_latches_stay():
    """OTE p. 96: the data bit is cleared; OTL, OTU p. 100: not modified."""
    for engine in engines("\nXIC(Go)OTE(Bit[0])OTL(Bit[1]);\n[XIC(Go),XIC(Bit[1])]OTE(Bit[2]);"):
        tags = ran(engine)
        assert [tags[f"Bit[{each}]"] for each in range(3)] == [0, 1, 0]


def test_timers_are_reset_and_a_retentive_one_keeps_its_time():
    for engine in engines("\nXIC(Go)[TON(T[0],?,?),TOF(T[1],?,?),RTO(T[2],?,?)];"):
        tags = ran(engine, scans=3)
        assert [(tags[f"T[{each}].EN"], tags[f"T[{each}].DN"]) for each in range(3)] == [(0, 0)] * 3
        assert [tags[f"T[{each}].ACC"] for each in range(3)] == [0, 50, 20]


def test_one_shots_and_counters():
    """ONS p. 103: the storage bit is cleared, so that the action fires again; others: N/A."""
    for engine in engines("\nXIC(Go)ONS(Bit[0])CTU(C,?,?);\nXIC(Go)OSR(Bit[1],Bit[2])OSF(Bit[3],Bit[4]);"):
        engine.step(10)
        engine.tags.Go = False
        engine.step(10)
        engine.tags.Go = True
        tags = ran(engine, scans=1)
        assert [tags[f"Bit[{each}]"] for each in range(5)] == [0, 1, 1, 1, 0]
        assert (tags["C.CU"], tags["C.ACC"]) == (1, 1)


def test_inputs_outputs_and_jumps_do_nothing():
    """Rungs that a jump leaves out are postscanned too, and what acts on true rungs only does not act."""
    rungs = "\nXIC(Go)JMP(end);\nADD(N[0],1,N[0])OTE(Bit[0]);\nLBL(end)ADD(N[1],1,N[1]);"
    for engine in engines(rungs):
        engine.step()
        engine.tags["Bit[0]"] = True
        before = engine.tags["N[1]"]
        tags = ran(engine, scans=0)
        assert (tags["Bit[0]"], tags["N[0]"], tags["N[1]"]) == (0, 0, before)


def test_what_the_action_calls_is_postscanned_whether_its_rung_is_true_or_not():
    called = "\nXIC(Bit[7])JSR(Sub);\nMCR();\nEND\nROUTINE Sub\nXIC(Go)OTE(Bit[0]);\nJSR(Sub);"
    for engine in engines(called):
        engine.step()
        engine.tags["Bit[0]"] = True
        assert ran(engine, scans=0)["Bit[0]"] == 0


def test_structured_text_clears_the_targets_of_its_own_assignments_and_nothing_else():
    """[:=] is reset, wherever it stands; := stays; TONR p. 131: no action."""
    text = " ST\nIF Go THEN Bit[0] [:=] 1; N[0] [:=] 5; N[1] := 6; END_IF;\nF.TimerEnable := 1; TONR(F);"
    for engine in engines(text, tags=TAGS + 'TAG F : FBD_TIMER := {"PRE": 500}\n'):
        tags = ran(engine, scans=3)
        assert (tags["Bit[0]"], tags["N[0]"], tags["N[1]"], tags["F.ACC"], tags["F.EN"]) == (0, 0, 6, 20, 1)


ADD_ON = """\
INSTRUCTION Block
INPUT A : DINT REQUIRED
OUTPUT Z : DINT REQUIRED
LOCAL Bit : BOOL
LOCAL Inner : DINT
ROUTINE Logic
MOV(A,Z);
OTE(Bit);
END
ROUTINE EnableInFalse
MOV(-1,Z);
END
{}END INSTRUCTION
TAG B : Block
"""
POSTSCAN = "ROUTINE Postscan\nADD(A,30,Z);\nADD(Inner,1,Inner);\nEND\n"


@pytest.mark.parametrize(("routine", "result", "inner"), [(POSTSCAN, 33, 1), ("", 2, 0)])
def test_an_add_on_passes_inputs_postscans_logic_runs_postscan_and_passes_outputs(routine, result, inner):
    """[1756-PM010 p. 53] Its arguments: 2 in the scan, 3 when postscanned; EnableInFalse does not run."""
    for engine in engines("\nXIC(Go)Block(B,N[0],N[1]);", ADD_ON.format(routine)):
        engine.tags["N[0]"] = 2
        engine.step()
        engine.tags["N[0]"] = 3
        tags = ran(engine, scans=0)
        assert (tags["B.A"], tags["N[1]"], tags["B.Bit"], tags["B.Inner"]) == (3, result, 0, inner)
        assert (tags["B.EnableIn"], tags["B.EnableOut"]) == (0, 0)


def test_a_subscript_out_of_range_faults_as_in_a_scan():
    """IgnoreArrayFaultsDuringPostScan is 0 unless the program sets it: then the instruction is left alone."""
    rungs = (
        "\nXIC(Go)OTE(Bit[At])OTE(Bit[0]);\nXIC(N[1].0)SSV(Controller,,IgnoreArrayFaultsDuringPostScan,F[0]);"
    )
    for engine in engines(rungs, tags=f"{TAGS}TAG F : SINT[2] := [1]\n"):
        engine.step()
        engine.tags.At = 8
        with pytest.raises(LadderFault, match="At"):
            ran(engine, scans=0)
        engine.tags.At, engine.tags["N[1]"] = 0, 1
        engine.step()
        engine.tags.At = 8
        assert ran(engine, scans=0)["Bit[0]"] == 0


def test_a_change_in_postscan_tells_its_mode_and_its_instruction():
    text = f"PROGRAM p\n{TAGS}ROUTINE Main\nJSR(Act);\nJSR(leave);\nEND\nROUTINE Act\nOTE(Bit[0]);\nEND\n"
    program = parse_program(text)
    assert isinstance(program, Program)

    @program.function
    def leave(_tags):
        engine.interpreter.postscan("ACT")

    engine = WatchedEngine(program.build(), program.scanner)
    engine.watching = True
    engine.do(0, first=False)
    assert [(change.after, change.mode) for change in engine.history] == [(True, ""), (False, "postscan")]
    assert (
        explain_cause(engine.lowered, engine.history[-1]) == "postscan of OTE(Bit[0]) in routine Act, rung 0."
    )
