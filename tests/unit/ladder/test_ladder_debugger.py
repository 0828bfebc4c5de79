"""The debugger: breakpoints, forces, truth, cross reference, and why a tag is as it is."""

import pytest
from scanrack.ladder import LadderError
from scanrack.ladder.debug import Debugger, cross_reference
from scanrack.ladder.debug.journal import EVERY
from scanrack.ladder.files import parse_program

FILLING = """PROGRAM filling
TAG Start : BOOL
TAG Stop : BOOL
TAG Run : BOOL
TAG Fill : TIMER
TAG Lamp : BOOL
TAG W : DINT[4]
TAG I : DINT
TAG Unused : BOOL
SLOT axis : 1
ROUTINE Main
[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);
XIC(Run)TON(Fill,50,0)XIC(Fill.DN)OTE(Lamp);
XIC(Lamp)MOV(7,W[I]);
XIC(Run)JSR(Sub,0);
XIC(Stop)OTE(axis.command.HOLD_MOVE);
END
ROUTINE Sub
XIC(Lamp)OTE(axis.command.IMMEDIATE_STOP);
END
"""


@pytest.fixture
def filling():
    return Debugger(parse_program(FILLING))


def started(debugger):
    debugger.scan()
    debugger.tags.Start = True
    debugger.scan()
    debugger.tags.Start = False
    return debugger


# --- running and breakpoints


def test_a_scan_is_one_scan_and_a_run_ends_when_its_condition_holds(filling):
    started(filling)  # scan 1, at 10 ms, starts the timer; 50 ms later it is done
    assert filling.run_until("Lamp", limit=100)
    assert (filling.scans, filling.now_ns) == (7, 60_000_000)


def test_a_run_has_a_limit(filling):
    assert not filling.run_until(lambda debugger: debugger.tags.Lamp, limit=3)
    assert filling.scans == 3


def test_a_breakpoint_on_a_tag_stops_at_the_scan_of_its_change(filling):
    filling.break_on("Run")
    assert filling.scan(2) == ()
    filling.tags.Start = True
    (stop,) = filling.scan(10)
    assert str(stop) == "scan 2, 0.02 s: Run was 0 and is 1"
    filling.clear_breakpoints()
    assert filling.scan(10) == ()


def test_a_breakpoint_on_a_rung_is_met_when_it_becomes_true(filling):
    filling.break_at("main", 1)
    filling.scan()
    filling.tags.Start = True
    (stop,) = filling.scan(100)
    assert stop.scan == 6
    assert stop.text.startswith("Main, rung 1 is true: XIC(Run)TON(Fill,50,0)")
    assert filling.scan(5) == ()  # it stays true, which is not news


def test_a_breakpoint_waits_for_a_change_of_a_rung_or_for_its_execution(filling):
    for when in ("changes", "executes"):
        filling.break_at("Main", 0, when)
    (stop,) = filling.scan()  # Run has not changed: it is not known what it was before
    assert stop.text.startswith("Main, rung 0 runs: ")
    filling.clear_breakpoints()
    filling.break_at("Main", 0, "changes")
    assert filling.scan(3) == ()
    filling.tags.Start = True
    (stop,) = filling.scan(10)
    assert (stop.scan, stop.text[:21]) == (4, "Main, rung 0 is true:")
    filling.tags.Start = False
    filling.tags.Stop = True
    (stop,) = filling.scan(10)
    assert (stop.scan, stop.text[:25]) == (5, "Main, rung 0 is not true:")
    assert filling.scan(3) == ()


def test_a_removed_breakpoint_leaves_the_others_as_they_are(filling):
    for at in (("main", 0), ("main", 2), ("main", 0, "changes")):
        filling.break_at(*at)
    filling.break_on("Run")
    filling.break_on("Lamp")
    filling.tags.Start = True
    assert len(filling.scan()) == 2  # rung 0 and Run
    filling.remove_breakpoint("MAIN", 2)
    filling.remove_breakpoint("Lamp")
    assert filling.scan(20) == ()  # rung 0 stays true: set again, it would be met
    filling.tags.Start = False
    filling.tags.Stop = True
    filling.remove_breakpoint("Main", 0)
    texts = [stop.text for stop in filling.scan()]  # set again, the change would be missed
    assert [text[:25] for text in texts] == ["Main, rung 0 is not true:", "Run was 1 and is 0"]
    filling.remove_breakpoint("Main", 0, "changes")
    filling.remove_breakpoint("Run")
    filling.tags.Stop = False
    filling.tags.Start = True
    assert filling.scan(20) == ()
    with pytest.raises(KeyError):
        filling.remove_breakpoint("Main", 0)


@pytest.mark.parametrize(
    ("routine", "rung", "says"),
    [
        ("Main", 5, "routine Main has no rung 5; must be 0 to 4"),
        ("Mane", 0, "no routine Mane; choose from Main"),
    ],
)
def test_a_breakpoint_needs_a_rung(filling, routine, rung, says):
    with pytest.raises(LadderError, match=says):
        filling.break_at(routine, rung)


# --- truth


def test_truth_is_the_power_behind_each_instruction(filling):
    started(filling)
    # Start was on in this scan; the branch's second leg is Run, still off when it is reached
    assert filling.truth("Main")[:2] == [(True, False, True, True), (True, True, False, False)]
    filling.scan()
    assert filling.truth("Main")[0] == (False, True, True, True)


def test_a_routine_that_was_not_called_has_no_truth(filling):
    filling.scan()
    assert filling.truth("Sub") == [None]
    started(filling)
    assert filling.truth("Sub") == [(False, False)]


def test_the_picture_shows_the_power_of_the_latest_scan(filling):
    started(filling)
    assert "━( )━╢" in filling.picture("Main", [0], width=40)
    assert "live" in filling.svg()


def test_what_an_add_on_passes_in_and_out_is_no_instruction_of_its_rung():
    text = (
        "PROGRAM p\nINSTRUCTION Twice\nINPUT In : DINT REQUIRED\nOUTPUT Out : DINT REQUIRED\n"
        "ROUTINE Logic\nADD(In,In,Out);\nEND\nEND INSTRUCTION\n"
        "TAG Go : BOOL\nTAG T : Twice\nTAG N : DINT := 4\nTAG M : DINT\nTAG B : BOOL\n"
        "ROUTINE Main\nXIC(Go)Twice(T,N,M)OTE(B);\nXIC(B)NOP();\nEND\n"
    )
    debugger = Debugger(parse_program(text))
    debugger.scan()
    assert debugger.truth("Main") == [(False, False, False), (False, False)]
    debugger.tags.Go = True
    debugger.scan()
    assert debugger.truth("Main") == [(True, True, True), (True, True)]
    assert debugger.tags.M == 8


# --- why


def test_why_names_scan_rung_and_the_condition_that_was_false(filling):
    started(filling)
    filling.tags.Stop = True
    filling.scan(3)
    assert filling.why("Run").splitlines() == [
        "Run is 0 since scan 2 (0.02 s): OTE(Run) in routine Main, rung 0, whose rung was false:",
        "    [XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);",
        "  false was XIO(Stop) [Stop = 1]",
    ]


def test_every_leg_of_a_branch_blocks_if_none_conducts():
    text = (
        "PROGRAM p\nTAG A : BOOL\nTAG B : DINT\nTAG C : BOOL\nROUTINE Main\n[XIC(A),EQU(B,3)]OTE(C);\nEND\n"
    )
    debugger = Debugger(parse_program(text))
    debugger.tags.B = 3
    debugger.scan()
    debugger.tags.B = 2
    debugger.scan()
    assert debugger.why("C").splitlines()[2:] == [
        "  false was XIC(A) [A = 0]",
        "  false was EQU(B,3) [B = 2]",
    ]


def test_why_of_what_nobody_has_changed(filling):
    filling.scan(3)
    assert filling.why("W[2]").splitlines() == [
        "W[2] is 0 and has not changed while watched. Its writers:",
        "    Main, rung 2: MOV(7,W[I]) writes W[I]",
    ]
    assert filling.why("Unused") == "Unused is 0: no rung writes it."


def test_why_of_what_was_set_from_outside_and_of_inputs(filling):
    filling.scan()
    filling.tags.Start = True
    filling.scan(2)
    assert filling.why("Start") == "Start is 1 since scan 1 (0.01 s): it was set from outside the rungs."


def test_why_of_an_input_is_the_module():
    debugger = Debugger(parse_program(FILLING.replace("XIC(Stop)", "XIC(axis.status.AT_HOME)")))
    debugger.scan()
    assert debugger.why("axis.status.AT_HOME").endswith(
        "because the module reports it: it is an input image."
    )


def test_why_of_a_bit_of_an_output_word(filling):
    started(filling)
    filling.run_until("Lamp", limit=100)
    filling.tags.Stop = True
    filling.scan()
    answer = filling.why("axis.command.HOLD_MOVE")
    assert answer.startswith("axis.command.HOLD_MOVE is 1 since scan 7 (0.07 s): OTE(axis.command.HOLD_MOVE)")
    # another bit of the same word changed another scan: Sub was called last in scan 6
    assert "IMMEDIATE_STOP is 1 since scan 6" in filling.why("axis.command.IMMEDIATE_STOP")


def test_why_of_an_element_of_an_array_is_about_that_element():
    text = (
        "PROGRAM p\nTAG A : BOOL\nTAG B : BOOL\nTAG C : COUNTER[3]\n"
        "ROUTINE Main\nXIC(A)CTU(C[1],?,?);\nXIC(B)CTU(C[2],?,?);\nEND\n"
    )
    debugger = Debugger(parse_program(text))
    debugger.scan()
    debugger.tags.A = True
    debugger.scan(2)
    debugger.tags.B = True
    debugger.scan(2)
    assert "since scan 1 (0.01 s): CTU(C[1],?,?)" in debugger.why("C[1]")
    assert "since scan 3 (0.03 s): CTU(C[2],?,?)" in debugger.why("C[2]")
    assert "no rung writes it" in debugger.why("C[0]")
    assert "since scan 3 (0.03 s): CTU(C[2],?,?)" in debugger.why("C")
    debugger.tags.A = debugger.tags.B = False
    debugger.scan()
    assert "since scan 5 (0.05 s): CTU(C[1],?,?)" in debugger.why("C[1]")
    assert "since scan 5 (0.05 s): CTU(C[2],?,?)" in debugger.why("C[2]")


def test_why_reaches_back_beyond_the_latest_snapshots(filling):
    started(filling).scan(3 * EVERY)
    assert "Lamp is 1 since scan 6 (0.06 s)" in filling.why("Lamp")
    assert filling.last_change("Run").scan == 1


def test_an_element_is_named_with_its_subscript(filling):
    filling.tags.I = 3
    started(filling).run_until("Lamp", limit=100)
    assert filling.why("W").startswith("W[3] is 7 since scan 6")


NO_NUMBER = """PROGRAM p
TAG A : REAL := -1.0
TAG X : REAL
TAG Y : REAL
ROUTINE Main
LN(A,X);
ADD(X,1.0,Y);
END
"""


def test_what_stays_no_number_does_not_change():
    """NaN is not equal to NaN, and a logarithm of -1 is written in each scan."""
    debugger = Debugger(parse_program(NO_NUMBER))
    debugger.break_on("X")
    assert [each.scan for each in debugger.scan(10)] == [0]
    assert debugger.scan(3 * EVERY) == ()
    assert [change and change.scan for change in map(debugger.last_change, "XY")] == [0, 0]
    assert debugger.why("Y").startswith("Y is nan since scan 0")


# --- forces


def test_a_forced_tag_stays_whatever_the_program_writes(filling):
    filling.scan()
    filling.force("Run", True)
    filling.scan(10)
    assert filling.tags.Lamp
    assert filling.why("Run") == "Run is 1 because it is forced."
    assert filling.forces == {"Run": True}
    filling.tags.Stop = True
    filling.unforce("Run")
    filling.scan()
    assert not filling.tags.Run


def test_why_counts_forces_that_have_been_and_gone(filling):
    filling.tags.Stop = True
    filling.scan()
    filling.force("Run", True)  # which the first rung would reset in each scan
    filling.scan(8)  # the timer of 50 ms is done in scan 6
    assert "Lamp is 1 since scan 6 (0.06 s): OTE(Lamp)" in filling.why("Lamp")
    filling.unforce("Run")
    filling.scan(2 * EVERY)
    assert "Lamp is 0 since scan 9 (0.09 s): OTE(Lamp)" in filling.why("Lamp")
    assert filling.last_change("Fill.DN").scan == 9


def test_bits_of_a_word_are_forced_one_by_one(filling):
    filling.force("W[1].3", 1)
    filling.force("W[1].31", 1)
    filling.tags["W[1]"] = 1
    filling.scan()
    assert filling.tags["W[1]"] == 1 + 8 - 2**31
    filling.unforce("W[1].31")
    filling.tags["W[1]"] = 0
    filling.scan()
    assert filling.tags["W[1]"] == 8


@pytest.mark.parametrize(
    ("tag", "value", "says"),
    [
        ("Rum", 1, "no tag Rum"),
        ("W", 1, "W is not a single value"),
        ("W[I]", 1, r"W\[I\] is not a single value with constant subscripts"),
        ("axis.command.HOLD_MOVE", 1, "is an image; force it at the CPU"),
        ("Run", 2, "2 is not a BOOL"),
        ("I", 2**31, "out of range"),
    ],
)
def test_forces_that_are_refused(filling, tag, value, says):
    with pytest.raises(ValueError, match=says):
        filling.force(tag, value)
    with pytest.raises(ValueError, match="is not forced"):
        filling.unforce(tag)


# --- cross reference


def listed(tag, text=FILLING):
    return [str(each) for each in cross_reference(parse_program(text).build()).of(tag)]


def test_cross_reference_of_a_tag_its_members_and_subscripts():
    assert listed("Fill") == [
        "Main, rung 1: TON(Fill,50,0) reads, writes Fill",
        "Main, rung 1: XIC(Fill.DN) reads Fill.DN",
    ]
    assert listed("Fill.DN") == listed("Fill")
    assert listed("Fill.ACC") == ["Main, rung 1: TON(Fill,50,0) reads, writes Fill"]
    assert listed("I") == ["Main, rung 2: MOV(7,W[I]) reads I"]
    assert listed("Unused") == []


def test_a_computed_subscript_may_be_any_element_and_bits_are_told_apart():
    assert listed("W[2]") == ["Main, rung 2: MOV(7,W[I]) writes W[I]"]
    assert listed("axis.command.HOLD_MOVE") == [
        "Main, rung 4: OTE(axis.command.HOLD_MOVE) writes axis.command.HOLD_MOVE"
    ]
    assert len(listed("Local:1:O.Data[0]")) == 2


def test_a_copy_may_reach_beyond_the_element_it_names():
    text = FILLING.replace("XIC(Lamp)MOV(7,W[I]);", "COP(W[0],W[1],2);")
    assert listed("W[3]", text) == [
        "Main, rung 2: COP(W[0],W[1],2) reads W[0]",
        "Main, rung 2: COP(W[0],W[1],2) writes W[1]",
    ]
