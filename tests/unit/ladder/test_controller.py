"""A controller: scopes of names, tasks in virtual time, fault routines, and its text."""

import pytest
from scanrack.commands import build
from scanrack.ladder import BOOL, DINT, BuildError, Controller, LadderError, LadderFault, RungTextError
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.model.schedule import Task, TaskKind
from typer.testing import CliRunner

TWO_PROGRAMS = """CONTROLLER plant
TAG Run : BOOL
TAG Count : DINT
TAG Log : DINT[16]
TAG At : DINT
TASK Cycle : CONTINUOUS PRIORITY 10 RUNS Main
TASK Fast : PERIODIC 20 ms PRIORITY 3 RUNS Filter  // every 20 ms

PROGRAM Main
TAG Lamp : BOOL
TAG Count : DINT
ALIAS Own : Count

ROUTINE Step
XIC(Run)OTE(Lamp);
ADD(Own,1,Own);
JSR(Sub);
END

ROUTINE Sub
MOV(\\Filter.Level,At);
END
END PROGRAM

PROGRAM Filter
TAG Level : DINT := 7
ALIAS Shared : Count

ROUTINE Step
ADD(Shared,10,Shared);
JSR(Sub);
END

ROUTINE Sub
ADD(Level,1,Level);
END
END PROGRAM
"""


def both(text):
    """Return the text's controller compiled and interpreted."""
    return [parse_program(text).compile(), parse_program(text).interpret()]


def scanned(engine, scans, ms=10):
    for _ in range(scans):
        engine.step(ms)
    return engine.tags


def test_names_mean_the_program_s_own_first_and_routines_may_share_a_name():
    for engine in both(TWO_PROGRAMS):
        engine.tags.Run = True
        tags = scanned(engine, 3)
        assert tags[r"\Main.Lamp"] is True
        assert tags[r"\Main.Count"] == 3  # three scans, in Main's own Count
        assert tags["Count"] == 20  # Filter has none of its own: due at 0 and 20 ms
        assert tags["At"] == tags[r"\filter.level"] == 9  # 7 and one for each run


def test_the_text_reads_as_the_same_controller():
    controller = parse_program(TWO_PROGRAMS)
    text = program_text(controller)
    again = parse_program(text)
    assert isinstance(controller, Controller)
    assert isinstance(again, Controller)
    assert program_text(again) == text
    assert [each.name for each in again.routines] == [
        r"\Main.Step",
        r"\Main.Sub",
        r"\Filter.Step",
        r"\Filter.Sub",
    ]
    assert (
        again.tasks
        == controller.tasks
        == [
            Task("Cycle", TaskKind.CONTINUOUS, ("Main",)),
            Task("Fast", TaskKind.PERIODIC, ("Filter",), 20_000_000, 3, comment="every 20 ms"),
        ]
    )
    assert [each.declarations for each in again.programs] == [
        each.declarations for each in controller.programs
    ]


LOGGED = """CONTROLLER plant
TAG Log : DINT[32]
TAG At : DINT
{tasks}
"""


def logging(name, number):
    """A program that appends its number to the log."""
    return f"PROGRAM {name}\nROUTINE Main\nMOV({number},Log[At])ADD(At,1,At);\nEND\nEND PROGRAM\n"


def order(tasks, scans, ms=10):
    """Return the numbers in the order in which programs P1, P2, P3 ran, the same in both back ends."""
    text = LOGGED.format(tasks=tasks) + "".join(logging(f"P{number}", number) for number in (1, 2, 3))
    compiled, interpreted = both(text)
    logs = []
    for engine in (compiled, interpreted):
        tags = scanned(engine, scans, ms)
        logs.append(tags["Log"][: tags["At"]])
    assert logs[0] == logs[1]
    return logs[0]


@pytest.mark.parametrize(
    ("tasks", "scans", "expected"),
    [
        # every program, in order, in one continuous task
        ("", 2, [1, 2, 3] * 2),
        ("TASK C : CONTINUOUS RUNS P3, P1\nTASK D : PERIODIC 1000 ms RUNS P2", 2, [2, 3, 1, 3, 1]),
        # 20 ms: due in the scans at 0 and 20; the lower priority number first, whatever the order
        (
            "TASK C : CONTINUOUS RUNS P1\nTASK A : PERIODIC 20 ms PRIORITY 8 RUNS P2\n"
            "TASK B : PERIODIC 20 ms PRIORITY 2 RUNS P3",
            3,
            [3, 2, 1, 1, 3, 2, 1],
        ),
        # equal priorities run in the order of the file
        (
            "TASK A : PERIODIC 10 ms RUNS P2\nTASK B : PERIODIC 20 ms RUNS P3\nTASK C : CONTINUOUS RUNS P1",
            2,
            [2, 3, 1, 2, 1],
        ),
        # without a continuous task nothing runs between
        ("TASK A : PERIODIC 30 ms RUNS P1, P2, P3", 4, [1, 2, 3, 1, 2, 3]),
    ],
    ids=["implicit", "order of programs", "priority", "order of tasks", "no continuous task"],
)
def test_due_tasks_run_before_the_continuous_one(tasks, scans, expected):
    assert order(tasks, scans) == expected


def test_a_task_that_is_due_twice_runs_once_and_counts_an_overlap():
    controller = parse_program(
        LOGGED.format(tasks="TASK C : CONTINUOUS RUNS P1\nTASK A : PERIODIC 4 ms RUNS P2")
        + logging("P1", 1)
        + logging("P2", 2)
    )
    assert isinstance(controller, Controller)
    for _ in range(3):
        controller.step(10)
    # due at 0; at 4 and 8 before the scan at 10; at 12, 16 and 20 before the scan at 20
    assert controller.tags["Log"][:6] == [2, 1, 2, 1, 2, 1]
    assert controller.overlaps == {"C": 0, "A": 1 + 2}


PREEMPTED = """CONTROLLER plant
TAG Runs : DINT
TAG Seen : DINT[4]
TASK C : CONTINUOUS RUNS Slow
TASK A : PERIODIC 4 ms PREEMPT RUNS Quick
PROGRAM Slow
ROUTINE Main
MOV(Runs,Seen[0]);
MOV(Runs,Seen[1]);
MOV(Runs,Seen[2]);
MOV(Runs,Seen[3]);
END
END PROGRAM
PROGRAM Quick
ROUTINE Main
ADD(Runs,1,Runs);
END
END PROGRAM
"""


def test_a_task_with_preempt_runs_at_the_end_of_the_rung_under_way():
    for engine in both(PREEMPTED):
        tags = scanned(engine, 1)
        assert tags["Seen"] == [1, 1, 1, 1]  # due at 0; how long the first scan takes is not known yet
        tags = scanned(engine, 1)
        # the scan from 10 to 20 ms: due at 4 and 8 before it; its rungs end at 12.5, 15, 17.5 and 20 ms,
        # and 12 and 16 have come at the end of the first and the third
        assert tags["Seen"] == [2, 3, 3, 4]
        assert tags["Runs"] == 4


def test_preemption_does_not_switch_off_an_override_of_mcr():
    text = PREEMPTED.replace("MOV(Runs,Seen[0]);", "AFI()MCR();").replace("MOV(Runs,Seen[3]);", "AFI()MCR();")
    for engine in both(text):
        assert scanned(engine, 3)["Seen"] == [0, 0, 0, 0]


def test_first_scan_is_each_program_s_own():
    text = """CONTROLLER plant
TAG Firsts : DINT
TAG Later : DINT
TASK C : CONTINUOUS RUNS Main
TASK A : PERIODIC 25 ms RUNS Rare
PROGRAM Main
ROUTINE Main
XIC(S:FS)ADD(Firsts,1,Firsts);
END
END PROGRAM
PROGRAM Rare
TAG Once : BOOL
ROUTINE Main
XIC(S:FS)ADD(Later,1,Later);
XIO(S:FS)ADD(Later,100,Later);
END
END PROGRAM
"""
    for engine in both(text):
        tags = scanned(engine, 1)
        assert (tags["Firsts"], tags["Later"]) == (1, 1)
        tags = scanned(engine, 3)
        assert (tags["Firsts"], tags["Later"]) == (1, 101)


@pytest.mark.parametrize(
    ("tasks", "text", "remedy"),
    [
        ("TASK A : CONTINUOUS RUNS P9", "no program P9", "programs are P1"),
        (
            "TASK A : CONTINUOUS RUNS P1\nTASK B : EVENT RUNS p1",
            "program p1 is in task A already",
            "one task",
        ),
        ("TASK A : CONTINUOUS RUNS P1\nTASK B : CONTINUOUS", "tasks A and B are continuous", "a rate"),
    ],
)
def test_tasks_that_do_not_fit(tasks, text, remedy):
    with pytest.raises(BuildError) as refused:
        parse_program(LOGGED.format(tasks=tasks) + logging("P1", 1)).build()
    assert str(refused.value).startswith("controller plant can't be built:")
    assert text in str(refused.value)
    assert remedy in str(refused.value)


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("TASK A : PERIODIC 0 ms RUNS P1", "rate is 0 ns"),
        ("TASK A : PERIODIC 10 ms PRIORITY 16 RUNS P1", "priority is 16; must be 1 to 15"),
        ("TASK A : CONTINUOUS PREEMPT RUNS P1", "so it can't preempt"),
    ],
)
def test_tasks_out_of_range(line, text):
    with pytest.raises(LadderError, match=text):
        parse_program(LOGGED.format(tasks=line))


def test_a_program_in_no_task_is_a_warning():
    text = LOGGED.format(tasks="TASK C : CONTINUOUS RUNS P1") + logging("P1", 1) + logging("P2", 2)
    assert list(map(str, parse_program(text).warnings)) == ["program P2: no task runs it; name it in a task"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("CONTROLLER plant\nROUTINE Main\nEND", "in a controller a routine is in a program"),
        ("CONTROLLER plant\nPROGRAM A\nROUTINE Main\nEND", "END PROGRAM"),
        ("CONTROLLER plant\nTASK A : SOMETIMES", "TASK, PROGRAM"),
    ],
)
def test_text_that_is_no_controller(text, expected):
    with pytest.raises(RungTextError) as refused:
        parse_program(text)
    assert expected in str(refused.value)


def test_tags_of_another_program_are_not_found_without_its_name():
    text = TWO_PROGRAMS.replace("MOV(\\Filter.Level,At)", "MOV(Level,At)")
    with pytest.raises(BuildError) as refused:
        parse_program(text).build()
    assert "the controller has no tag Level; did you mean \\Filter.Level?" in str(refused.value)


def test_python_routines_of_a_program_see_its_tags():
    plant = Controller("plant")
    count = plant.declare("Count", DINT)
    main = plant.program("Main")
    own = main.declare("Count", DINT)

    @main.routine
    def step(rung):
        rung("JSR(double,0);")

    @main.function
    def double(tags, jsr):
        tags.Count += 2
        jsr("Sub")

    @main.routine
    def sub(rung):
        rung("ADD(Count,10,Count);")

    plant.step()
    assert (plant.tags[str(count)], plant.tags[r"\Main.Count"]) == (0, 12)
    assert str(own) == "Count"
    with pytest.raises(LadderError, match="controller plant has been built"):
        main.declare("Late", BOOL)


def test_faults_and_questions_name_the_program():
    text = TWO_PROGRAMS.replace("ADD(Level,1,Level)", "MOV(1,Log[Level])ADD(Level,9,Level)")
    for engine in both(text):
        with pytest.raises(LadderFault) as stopped:
            scanned(engine, 3)
        assert "program Filter, routine Sub, rung 0, MOV(1,Log[Level])" in str(stopped.value)
    debugger = Debugger(parse_program(TWO_PROGRAMS))
    debugger.break_at(r"\Main.Step", 0)
    debugger.scan()
    debugger.tags["Run"] = True
    (stop,) = debugger.scan()
    assert r"\Main.Step, rung 0 is true: XIC(Run)OTE(Lamp);" in stop.text
    assert r"OTE(Lamp) in routine \Main.Step, rung 0" in debugger.why(r"\Main.Lamp")
    mentions = [str(each) for each in debugger.cross_reference.of("Count")]
    assert mentions == [
        r"\Filter.Step, rung 0: ADD(Shared,10,Shared) reads Shared",
        r"\Filter.Step, rung 0: ADD(Shared,10,Shared) writes Shared",
    ]
    assert "Lamp" in debugger.picture(r"\Main.Step")
    assert debugger.truth(r"\Main.Step")[0] == (True, True)


HIDDEN_TIMER = """CONTROLLER plant
TAG Fill : TIMER := {"PRE": 111}
PROGRAM Main
TAG Fill : TIMER := {"PRE": 50}
ROUTINE Step
TON(Fill,?,?);
END
END PROGRAM
"""


def test_pictures_show_the_timer_of_the_program():
    debugger = Debugger(parse_program(HIDDEN_TIMER))
    debugger.scan(3)
    (rung,) = debugger.routine_now(r"\Main.Step").rungs
    assert str(rung) == "TON(Fill,50,20);"
    assert debugger.tags["Fill.ACC"] == 0


def test_the_commands_take_full_names(tmp_path):
    (tmp_path / "plant.rung").write_text(TWO_PROGRAMS, encoding="utf-8")
    rack = 'scan_ms = 10\nprogram = "plant.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    (tmp_path / "plant.toml").write_text(rack, encoding="utf-8")
    file, rack_file = str(tmp_path / "plant.rung"), str(tmp_path / "plant.toml")

    def said(*words):
        result = CliRunner().invoke(build(), list(words))
        assert result.exit_code == 0, result.output
        return result.stdout

    assert said("ladder", file, "--routine", r"\filter.Sub", "--text").strip().endswith("ADD(Level,1,Level);")
    assert "def jsr__Main_Step(now, given):" in said("ladder", file, "--source")
    assert r"\Filter.Step, rung 0" in said("xref", file, "Count")
    why = said("why", rack_file, r"\Main.Count", "--at", "0.05 s")
    assert r"is 6 since 0.05 s (scan 5): \Main.Step rung 1: ADD(Own,1,Own)" in why
