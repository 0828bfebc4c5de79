"""Questions about a chart: why a step is active, who uses a tag, which steps nothing reaches."""

from charts import BATCH, program_of
from scanrack.ladder.debug import cross_reference
from scanrack.ladder.debug.debugger import Debugger
from scanrack.ladder.model.chart_checks import unreached

MORE = "STEP Spare\nEND_STEP\n"


def debugged(scans, **tags):
    debugger = Debugger(program_of(BATCH, tags="Full : BOOL; Valve : BOOL"))
    debugger.engine.tags["Fill.PRE"] = 50
    for name, value in tags.items():
        debugger.engine.tags[name] = value
    for _ in range(scans):
        debugger.scan()
    return debugger


def test_why_a_step_is_active():
    said = debugged(3, Full=True).why("Fill.X").splitlines()
    assert said[0] == (
        "Fill.X is 1 since scan 0 (0 s): transition T0 to Fill and Heat in routine Seq, element 8, "
        "with Full = 1"
    )
    assert said[1] == "  inside of transition T0 is true in element 8 [T0 = 1]"
    assert said[-2:] == [
        "  step Fill is active; what ends it:",
        "    transition T1, Fill is active and Heat is active: Fill.DN [Fill.DN = 0]",
    ]


def test_why_a_step_is_not_active():
    said = debugged(3, Full=True).why("Drain").splitlines()
    assert said[-2:] == [
        "  step Drain is not active; what begins it:",
        "    transition T1, Fill is active and Heat is active: Fill.DN [Fill.DN = 0]",
    ]


def test_why_an_action_is_on():
    said = debugged(3, Full=True).why("Stir.A")
    assert "step Fill, action Stir (S) in routine Seq, element 3" in said
    assert "inside of step Fill is active in element 1 [Fill.X = 1]" in said


def test_what_an_action_writes_names_step_and_action():
    said = debugged(3, Full=True).why("Valve")
    assert "Valve := Full AND Open.Q; in routine Seq.Fill.Open, line 1" in said


def test_uses_in_conditions_actions_and_steps_count():
    uses = [str(each) for each in cross_reference(debugged(0).engine.lowered).of("Full")]
    assert uses == [
        "Seq, element 8: T0 := Full; reads Full",
        "Seq, element 8: transition T0 to Fill and Heat reads Full",
        "Seq, element 10: T2 := Full; reads Full",
        "Seq, element 10: transition T2 to Idle reads Full",
        "Seq.Fill.Open, line 1: Valve := Full AND Open.Q; reads Full",
    ]


def test_a_step_that_no_path_reaches_is_named():
    program = program_of(BATCH + MORE, tags="Full : BOOL; Valve : BOOL")
    chart = program.routines[0].chart
    assert chart is not None
    assert [each.text for each in unreached(chart)] == ["no path leads to step Spare"]
