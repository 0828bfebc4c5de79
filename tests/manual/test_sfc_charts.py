"""Charts as a whole: order of execution, branches, options, SFR, SFP, EOT [1756-PM006, 1756-RM003]."""

import pytest
from charts import BothEngines, marks, program_of, told
from scanrack.ladder import BuildError, LadderFault
from scanrack.ladder.files import parse_program, program_text

BRANCHES = """
INITIAL_STEP A
END_STEP
STEP B
END_STEP
STEP C
END_STEP
STEP D
END_STEP
TRANSITION Both FROM A TO B, C
    Go
END_TRANSITION
TRANSITION Join FROM B, C TO D
    Ready
END_TRANSITION
TRANSITION Home FROM D TO A
    1
END_TRANSITION
"""


def test_simultaneous_branches_begin_and_end_together():
    tags = "Go : BOOL; Ready : BOOL"
    found = told(program_of(BRANCHES, tags=tags), "A.X B.X C.X D.X", 6, Go={1: True}, Ready={3: True})
    assert {name: marks(each) for name, each in found.items()} == {
        "A.X": "100010",
        "B.X": "011001",
        "C.X": "011001",
        "D.X": "000100",
    }


def test_only_the_first_true_transition_of_a_selection_is_taken():
    """By default from left to right: the transitions of a step in their order."""
    chart = """
    INITIAL_STEP A
    END_STEP
    STOP Left
    STOP Right
    TRANSITION ToLeft FROM A TO Left
        Go
    END_TRANSITION
    TRANSITION ToRight FROM A TO Right
        1
    END_TRANSITION
    """
    found = told(program_of(chart, tags="Go : BOOL := true"), "Left.X Right.X A.X", 2)
    assert (marks(found["Left.X"]), marks(found["Right.X"]), marks(found["A.X"])) == ("11", "00", "00")


LADDER = """
INITIAL_STEP A
    ACTION Count N
        N := N + 1;
    END_ACTION
END_STEP
STEP B
END_STEP
STEP C
END_STEP
TRANSITION T1 FROM A TO B
    Go
END_TRANSITION
TRANSITION T2 FROM B TO C
    1
END_TRANSITION
TRANSITION T3 FROM C TO A
    Back
END_TRANSITION
"""


def test_current_active_steps_only_takes_one_transition_a_scan():
    found = told(program_of(LADDER, tags="Go : BOOL := true; Back : BOOL; N : DINT"), "A.X B.X C.X", 3)
    assert [marks(found[name]) for name in ("A.X", "B.X", "C.X")] == ["000", "100", "011"]


def test_until_a_false_transition_goes_on_within_the_scan():
    program = program_of(
        LADDER, tags="Go : BOOL := true; Back : BOOL; N : DINT", options="UNTIL_FALSE MOST_RECENT DONT_SCAN"
    )
    found = told(program, "C.X B.Count N", 2)
    assert (marks(found["C.X"]), found["B.Count"], found["N"]) == ("11", [1, 1], [1, 1])


@pytest.mark.slow
def test_a_circle_of_true_transitions_ends_by_the_watchdog():
    """Because multiple steps can be processed in a single scan, this could lead to a watchdog timeout."""
    program = program_of(
        LADDER,
        tags="Go : BOOL := true; Back : BOOL := true; N : DINT",
        options="UNTIL_FALSE INITIAL DONT_SCAN",
    )
    for engine in (program.compile(), program.interpret()):
        with pytest.raises(LadderFault, match="watchdog") as caught:
            engine.step()
        assert caught.value.site.routine == "Seq"


def test_a_stop_ends_the_chart_and_stored_actions_stay():
    chart = """
    INITIAL_STEP A
        ACTION Lamp S;
    END_STEP
    STOP Done
    TRANSITION T FROM A TO Done
        Go
    END_TRANSITION
    """
    found = told(program_of(chart, tags="Go : BOOL"), "A.X Done.X Lamp.Q Done.Count", 5, Go={2: True})
    assert (marks(found["A.X"]), marks(found["Done.X"]), marks(found["Lamp.Q"])) == (
        "11000",
        "00111",
        "11111",
    )
    assert found["Done.Count"] == [0, 0, 1, 1, 1]


CALLED = """
ROUTINE Main
XIC(Reset)SFR(Seq,{target});
XIC(Pause)SFP(Seq,Paused);
XIC(Resume)SFP(Seq,Executing);
JSR(Seq,0);
END
"""


def called(target="A", tags="", options="", pause="", more=""):
    chart = f"""
    INITIAL_STEP A
    END_STEP
    STEP B
        {pause}
        ACTION Keep S
            N := N + 1;
        END_ACTION
    END_STEP
    TRANSITION T FROM A TO B
        Go
    END_TRANSITION
    """
    own = "Go : BOOL; Reset : BOOL; Pause : BOOL; Resume : BOOL; N : DINT" + tags
    program = program_of(chart, tags=own, options=options, more=CALLED.format(target=target) + more)
    program.main = "Main"
    return program


def test_sfr_continues_at_a_step_and_ends_stored_actions():
    found = told(
        called(),
        "A.X B.X Keep.A A.Reset N",
        6,
        Go={1: True, 2: False},
        Reset={4: True, 5: False},
    )
    assert marks(found["B.X"]) == "011100"
    assert marks(found["A.X"]) == "100011"
    assert marks(found["Keep.A"]) == "001100"
    assert marks(found["A.Reset"]) == "000000"  # the bit clears once the chart executes
    assert found["N"] == [0, 0, 1, 2, 2, 2]


def test_sfr_of_0_is_the_initial_step():
    found = told(called("0"), "A.X", 6, Go={1: True, 2: False}, Reset={4: True, 5: False})
    assert marks(found["A.X"]) == "100011"


def test_sfr_of_a_step_of_no_chart_is_refused():
    program = called("Other", "; Other : SFC_STEP")
    with pytest.raises(BuildError, match="Other is not a step of chart Seq"):
        program.build()


@pytest.mark.parametrize(("hold", "t"), [("0", [0, 10, 10, 10, 40]), ("1", [0, 10, 10, 10, 20])])
def test_sfp_pauses_a_chart(hold, t):
    """Nothing executes; after the pause the timer goes on where it was if PauseTimer is set."""
    program = called(tags="")
    both = BothEngines(program)
    at = {
        "Go": {1: True},
        "Pause": {4: True, 6: False},
        "Resume": {6: True},
        "B.PauseTimer": {0: bool(int(hold))},
    }
    times, runs = [], []
    for scan in range(7):
        engine = both.step({name: value[scan] for name, value in at.items() if scan in value})
        times.append(engine.tags["B.T"])
        runs.append(engine.tags["N"])
    assert times[2:] == t
    assert runs[2:] == [1, 2, 2, 2, 3]


@pytest.mark.parametrize(
    ("hold", "done", "on"), [(False, "00001111", "01110000"), (True, "00000011", "01111100")]
)
def test_a_pause_counts_for_dn_and_for_a_timed_action_unless_pausetimer_is_set(hold, done, on):
    """The timer "runs whenever the step is active" [1756-PM006I p. 36].

    B begins in scan 2; scans 3 and 4 are a pause. At 30 ms, in scan 5, DN comes and L ends; 20 ms later
    if the pause does not count.
    """
    both, seen = BothEngines(called(pause="ACTION Late L;")), []
    both.step({"B.PRE": 30, "B.PauseTimer": hold, "Late.PRE": 30, "Late.PauseTimer": hold})
    for scan in range(1, 9):
        tags = both.step({"Go": True, "Pause": 3 <= scan < 5, "Resume": scan == 5}).tags
        seen.append((tags["B.DN"], tags["Late.Q"]))
    assert (marks([dn for dn, _ in seen]), marks([q for _, q in seen])) == (done, on)


def test_eot_returns_the_state_of_a_transition():
    """A transition calls a subroutine, whose EOT returns a bit."""
    chart = """
    INITIAL_STEP A
    END_STEP
    STEP B
    END_STEP
    TRANSITION T FROM A TO B
        JSR(Decide)
    END_TRANSITION
    """
    more = "ROUTINE Decide\nEOT(Bit);\nEND\n"
    found = told(program_of(chart, tags="Bit : BOOL", more=more), "B.X T", 4, Bit={2: True})
    assert (marks(found["B.X"]), marks(found["T"])) == ("0011", "0011")


@pytest.mark.parametrize(("restart", "active"), [("MOST_RECENT", "B"), ("INITIAL", "A")])
def test_a_chart_restarts_after_program_mode(restart, active):
    """Restart position: the most recently executed step, or the initial step."""
    program = called(options=f"CURRENT {restart} DONT_SCAN")
    for engine in (program.compile(), program.interpret()):
        engine.tags["Go"] = True
        for _ in range(4):
            engine.step()
        engine.tags["Go"] = False
        engine._started = False  # program mode
        engine.step()
        assert [name for name in "AB" if engine.tags[f"{name}.X"]] == [active]
        assert engine.tags["B.Count"] == (1 if restart == "MOST_RECENT" else 0)


def test_a_nested_chart_goes_back_to_its_initial_step_with_automatic_reset():
    """The postscan of the action that calls it, with restart at the initial step."""
    chart = """
    INITIAL_STEP A
        ACTION Call N
            JSR(Inner);
        END_ACTION
    END_STEP
    STEP B
    END_STEP
    TRANSITION T FROM A TO B
        Go
    END_TRANSITION
    """
    more = """
    TAG I1 : SFC_STEP
    TAG I2 : SFC_STOP
    TAG T2 : BOOL
    ROUTINE Inner SFC
    INITIAL_STEP I1
    END_STEP
    STOP I2
    TRANSITION T2 FROM I1 TO I2
        1
    END_TRANSITION
    END
    """
    for restart, stopped in (("INITIAL", "1100"), ("MOST_RECENT", "1111")):
        program = program_of(chart, tags="Go : BOOL", options=f"CURRENT {restart} AUTOMATIC", more=more)
        found = told(program, "I2.X", 4, Go={2: True})
        assert marks(found["I2.X"]) == stopped


WRONG = {
    "no initial step": ("STEP A\nEND_STEP", "it must have one initial step; it has none"),
    "two initial steps": (
        "INITIAL_STEP A\nEND_STEP\nINITIAL_STEP B\nEND_STEP",
        "one initial step; it has A, B",
    ),
    "unknown step": (
        "INITIAL_STEP A\nEND_STEP\nTRANSITION T FROM A TO B\n1\nEND_TRANSITION",
        "transition T: no step B",
    ),
    "step twice": ("INITIAL_STEP A\nEND_STEP\nSTEP A\nEND_STEP", "two steps are called A"),
    "action twice": (
        "INITIAL_STEP A\nACTION X N;\nACTION X S;\nEND_STEP",
        "step A has the action X twice",
    ),
    "from a stop": (
        "INITIAL_STEP A\nEND_STEP\nSTOP B\nTRANSITION T FROM B TO A\n1\nEND_TRANSITION",
        "it leaves the stop B",
    ),
    "convergence without divergence": (
        """INITIAL_STEP A
        END_STEP
        STEP B
        END_STEP
        STEP C
        END_STEP
        TRANSITION T1 FROM A TO B
            1
        END_TRANSITION
        TRANSITION T2 FROM A TO C
            1
        END_TRANSITION
        TRANSITION T3 FROM B, C TO A
            1
        END_TRANSITION""",
        "transition T3: it converges from B, C, which are not branches of one divergence",
    ),
    "jump into a branch": (
        """INITIAL_STEP A
        END_STEP
        STEP B
        END_STEP
        STEP C
        END_STEP
        TRANSITION T1 FROM A TO B, C
            1
        END_TRANSITION
        TRANSITION T2 FROM A TO B
            1
        END_TRANSITION
        TRANSITION T3 FROM B, C TO A
            1
        END_TRANSITION""",
        "transition T2: it jumps to B, which is in another simultaneous branch",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_chart_that_can_not_be_is_refused_by_its_element(name):
    chart, says = WRONG[name]
    with pytest.raises(BuildError) as refused:
        program_of(chart).build()
    problem = refused.value.problems[0]
    assert says in str(refused.value)
    assert (problem.site.routine, problem.site.unit) == ("Seq", "element")


def test_an_online_edit_goes_on_where_the_chart_is():
    """A step and an action before the active one: what is on stays on, and ends with its step."""
    program = called()
    text = program_text(program).replace("INITIAL_STEP A\n", "INITIAL_STEP A\n    ACTION Extra N;\n")
    text = text.replace("TAG A : SFC_STEP", "TAG A : SFC_STEP\nTAG Extra : SFC_ACTION\nTAG New : SFC_STEP")
    edited = parse_program(text.replace("STEP B\n", "STEP New\nEND_STEP\nSTEP B\n"))
    program.tags["Go"] = True
    for _ in range(3):
        program.step()
    edited.take_over(program)
    edited.tags["Go"] = False
    edited.tags["Reset"] = True
    edited.step()
    assert (edited.tags["A.X"], edited.tags["B.X"], edited.tags["Keep.A"]) == (True, False, False)
