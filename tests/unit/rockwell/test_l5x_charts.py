"""Sequential function charts of a document: read, run, written back, or refused by element."""

import re
from pathlib import Path

import pytest
from l5x_files import cdata, document, ladder, program, tag, task
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.model.chart import ExecutionControl, LastScan, RestartPosition
from scanrack.rockwell.diff import compare_exports
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.export import export_l5x

MIXER = Path(__file__).parents[3] / "examples" / "l5x" / "mixer.L5X"
STEPS = ["Idle", "Filling", "Heating", "Stirring", "Stopping", "Emptying", "Finished"]


def st(text):
    lines = "".join(
        f'<Line Number="{n}">\n{cdata(each)}\n</Line>\n' for n, each in enumerate(text.splitlines())
    )
    return f"<STContent>{lines}</STContent>"


def step(number, name, *inside, x=240, more=""):
    return f'<Step ID="{number}" X="{x}" Y="60" Operand="{name}" {more}>{"".join(inside)}</Step>'


def action(number, name, qualifier="NonStored", body="", boolean="false"):
    text = f"<Body>{st(body)}</Body>" if body else ""
    head = f'<Action ID="{number}" Operand="{name}" Qualifier="{qualifier}" IsBoolean="{boolean}">'
    return f"{head}{text}</Action>"


def transition(number, name, condition, x=240):
    head = f'<Transition ID="{number}" X="{x}" Y="160" Operand="{name}">'
    return f"{head}<Condition>{st(condition)}</Condition></Transition>"


def branch(number, kind, flow, *legs, more=""):
    inside = "".join(f'<Leg ID="{each}"/>' for each in legs)
    return f'<Branch ID="{number}" Y="200" BranchType="{kind}" BranchFlow="{flow}" {more}>{inside}</Branch>'


def links(*pairs):
    return "".join(f'<DirectedLink FromID="{a}" ToID="{b}" Show="true"/>' for a, b in pairs)


def chart(*parts):
    inside = f'<SFCContent SheetSize="Letter">{"".join(parts)}</SFCContent>'
    return f'<Routine Name="Seq" Type="SFC">{inside}</Routine>'


MACHINE = (
    step(0, "Idle", more='InitialStep="true"'),
    step(
        1,
        "Fill",
        f"<Preset>{st('100 + Extra')}</Preset>",
        action(2, "Open", body="Valve := Open.Q;"),
        action(3, "Stir", "Stored", boolean="true"),
        more='PresetUsesExpr="true"',
    ),
    step(4, "Heat", x=440),
    step(5, "Drain", action(6, "Stir", "Reset")),
    transition(7, "T0", "Start"),
    transition(8, "T1", "Fill.DN AND\nHot;"),
    transition(9, "T2", "Empty AND Again", x=440),
    transition(10, "T3", "Empty"),
    branch(11, "Simultaneous", "Diverge", 12, 13),
    branch(14, "Simultaneous", "Converge", 15, 16),
    branch(17, "Selection", "Diverge", 18, 19, more='Priority="Default"'),
    '<Stop ID="20" X="240" Y="660" Operand="Done"/>',
    f'<TextBox ID="21" X="20" Y="20"><Text>{cdata("Fill and heat")}</Text></TextBox>',
    links((0, 7), (7, 11), (12, 1), (13, 4), (1, 15), (4, 16), (14, 8), (8, 5)),
    links((5, 17), (18, 9), (19, 10), (9, 0), (10, 20)),
)

TAGS = [
    *(tag(name, "SFC_STEP") for name in ("Idle", "Fill", "Heat", "Drain")),
    *(tag(name, "SFC_ACTION") for name in ("Open", "Stir")),
    *(tag(name, "BOOL") for name in ("T0", "T1", "T2", "T3", "Start", "Hot", "Empty", "Again", "Valve")),
    tag("Extra", "DINT"),
    tag("Done", "SFC_STOP"),
]


def machine(*parts, tags=TAGS):
    routines = (ladder("Main", "JSR(Seq,0);"), chart(*parts))
    return document(programs=[program("P", *routines, tags=tags)], tasks=[task("T", "P")])


def test_a_chart_is_imported_runs_and_is_counted(imported):
    found = imported(machine(*MACHINE))
    report = found.report
    assert (report.refused, report.objects, report.faults) == ([], [], {})
    assert report.as_json()["charts"] == {"total": 1, "imported": 1, "refused": 0, "ran": 1}
    assert report.structured()["statements"]["ran"] == 6
    assert "sequential function charts: 1, 1 imported, 0 refused, 1 ran" in list(report.lines())


def test_its_branches_become_sources_and_targets(imported):
    """Legs from left to right by X: T3 stands left of T2, so that it is evaluated first."""
    tree = imported(machine(*MACHINE)).controller.routines[1].chart
    assert [each.name for each in tree.steps] == ["Idle", "Fill", "Heat", "Drain", "Done"]
    assert [(each.name, each.sources, each.targets) for each in tree.transitions] == [
        ("T0", ("Idle",), ("Fill", "Heat")),
        ("T1", ("Fill", "Heat"), ("Drain",)),
        ("T3", ("Drain",), ("Done",)),
        ("T2", ("Drain",), ("Idle",)),
    ]


def test_without_a_flow_the_links_of_its_legs_decide_it(imported):
    parts = [re.sub(r' BranchFlow="\w+"', "", each) for each in MACHINE]
    expected = imported(machine(*MACHINE)).controller.routines[1].chart
    assert imported(machine(*parts)).controller.routines[1].chart == expected


def test_a_priority_of_its_own_is_the_order_of_the_legs(imported):
    parts = [each.replace('Priority="Default"', 'Priority="UserDefined"') for each in MACHINE]
    tree = imported(machine(*parts)).controller.routines[1].chart
    assert [each.name for each in tree.transitions] == ["T0", "T1", "T2", "T3"]


def test_it_runs_as_drawn(imported):
    engine = imported(machine(*MACHINE)).controller.compile()
    engine.tags[r"\P.Start"] = engine.tags[r"\P.Hot"] = True
    for _ in range(14):
        engine.step(10)
    assert [each for each in ("Idle", "Fill", "Heat", "Drain") if engine.tags[rf"\P.{each}.X"]] == ["Drain"]
    assert engine.tags[r"\P.Fill.PRE"] == 100
    assert engine.tags[r"\P.Stir.Q"] is False


def test_a_chart_is_written_back_as_it_was_read(imported):
    """As program text and as an L5X for partial import."""
    controller = imported(machine(*MACHINE)).controller
    text = program_text(controller)
    assert program_text(parse_program(text)) == text
    again = imported(export_l5x(parse_program(text), "P"), trial=False).controller
    read = next(each for each in again.routines if each.name.endswith("Seq"))
    assert read.chart == controller.routines[1].chart


def test_the_controllers_options_are_those_of_its_charts(imported):
    text = machine(*MACHINE).replace(
        '<Controller Use="Target"',
        '<Controller Use="Target" SFCExecutionControl="UntilFalse" SFCRestartPosition="InitialStep" '
        'SFCLastScan="AutomaticReset"',
    )
    options = imported(text).controller.chart_options
    assert (options.control, options.restart, options.last_scan) == (
        ExecutionControl.UNTIL_FALSE,
        RestartPosition.INITIAL,
        LastScan.AUTOMATIC,
    )


def test_calls_of_routines_in_actions_and_transitions(imported):
    parts = (
        step(0, "Idle", action(2, "Open", body="JSR(Sub);"), more='InitialStep="true"'),
        step(1, "Fill"),
        transition(7, "T0", "JSR(Ready)"),
        links((0, 7), (7, 1)),
    )
    routines = (
        ladder("Main", "JSR(Seq,0);"),
        chart(*parts),
        ladder("Sub", "OTE(Valve);"),
        ladder("Ready", "EOT(Valve);"),
    )
    found = imported(document(programs=[program("P", *routines, tags=TAGS)], tasks=[task("T", "P")]))
    assert found.report.complete
    engine = found.controller.compile()
    engine.step()
    assert (engine.tags[r"\P.Valve"], engine.tags[r"\P.Fill.X"]) == (True, True)


A, B, T = step(0, "Idle", more='InitialStep="true"'), step(1, "Fill"), transition(7, "T0", "Start")

REFUSED = {
    "no content": ((), "one initial step"),
    "an ID twice": ((A, step(0, "Fill")), "step Fill has the ID 0 of another element"),
    "no ID": ((A, step("", "Fill")), "step Fill has ID '', a number is needed"),
    "no Operand": ((A, '<Step ID="1"/>'), "step 1 has no Operand"),
    "a link to nothing": ((A, B, T, links((0, 7), (7, 9))), "link has ToID 9, which does not exist"),
    "step to step": ((A, B, links((0, 1))), "step Idle and step Fill have no transition between them"),
    "transition to transition": (
        (A, B, T, transition(8, "T1", "1"), links((0, 7), (7, 8), (8, 1))),
        "transition T0 and transition T1 have no step between them",
    ),
    "to nowhere": ((A, T, links((0, 7))), "transition T0 has no step after it"),
    "two targets": (
        (A, B, step(2, "Heat"), T, links((0, 7), (7, 1), (7, 2))),
        "transition T0 is linked to 2 steps that no simultaneous branch diverges",
    ),
    "a qualifier": ((step(0, "Idle", action(2, "Open", "Later")),), "action Open has the qualifier 'Later'"),
    "no condition": (
        (A, B, transition(7, "T0", ""), links((0, 7), (7, 1))),
        "transition T0 has no condition",
    ),
    "a circle of branches": (
        (A, B, T, branch(20, "Selection", "Converge", 21), branch(22, "Selection", "Converge", 23)),
        "transition T0 has no step before it",
    ),
    "a condition that is none": ((A, B, transition(7, "T0", "Start Hot"), links((0, 7), (7, 1))), "expected"),
    "an unknown tag": (
        (A, B, transition(7, "T0", "Missing"), links((0, 7), (7, 1))),
        "no tag Missing",
    ),
    "an unknown tag in an action": (
        (step(0, "Idle", action(2, "Open", body=";\nMissing := 1;"), more='InitialStep="true"'),),
        "Idle, action Open, line 2",
    ),
    "too many elements": (
        (A, *(step(number, f"S{number}") for number in range(1, 10_000))),
        "it has more than 2,000 elements",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_chart_that_can_not_be_is_refused_with_its_element(imported, name):
    """The rest of the controller runs."""
    parts, says = REFUSED[name]
    report = imported(machine(*parts)).report
    assert len(report.objects) == 1
    refused = report.objects[0]
    assert says in refused.reason, refused.reason
    assert (refused.program, refused.routine, report.ran) == ("P", "Seq", 1)
    assert refused.line > 0
    assert report.drawn("SFC")["refused"] == 1


def test_branches_in_a_circle_end(imported):
    parts = (A, B, T, branch(20, "Selection", "Converge", 21), branch(22, "Selection", "Converge", 23))
    report = imported(machine(*parts, links((0, 7), (7, 21), (20, 23), (22, 21)))).report
    assert "transition T0 has no step after it" in report.objects[0].reason


def test_a_function_block_diagram_without_content_is_refused(imported):
    text = machine(*MACHINE).replace('Type="SFC"', 'Type="FBD"')
    text = re.sub(r"</?SFCContent[^>]*>", "", text)
    (refused,) = imported(text).report.objects
    assert "the diagram is not in the file" in refused.reason


def test_the_mixer_of_the_examples_makes_its_first_batch():
    """Recipes, strings and a produced tag in a chart; its stirrer is an ideal axis."""
    controller = import_l5x(MIXER).controller
    assert controller is not None
    engine = controller.compile()
    seen = []
    for scan in range(1070):
        engine.tags["Local:1:I.Data"] = 3 if 60 <= scan < 100 else 2
        engine.step(5)
        seen.append(" ".join(each for each in STEPS if engine.tags[rf"\MainProgram.{each}.X"]))
    order = [name for name, before in zip(seen, ["", *seen], strict=False) if name != before]
    assert order == ["Idle", "Filling Heating", "Stirring", "Stopping", "Emptying", "Idle"]
    assert engine.tags["ToLine"]["Name"] == "blue "
    assert engine.tags["ToLine"]["Number"] == 1
    assert engine.tags[r"\MainProgram.Status"] == "waiting for start"


def test_versions_of_a_chart_are_compared_element_by_element(tmp_path):
    """A moved step is no difference; another qualifier, a link and a line are."""
    files = [tmp_path / "old.L5X", tmp_path / "new.L5X"]
    text = machine(*MACHINE)
    files[0].write_text(text, encoding="utf-8")
    changed = text.replace('Qualifier="Stored"', 'Qualifier="NonStored"').replace('X="440"', 'X="460"')
    changed = changed.replace("Empty AND Again", "Empty OR Again").replace(
        'FromID="9" ToID="0"', 'FromID="9" ToID="1"'
    )
    files[1].write_text(changed, encoding="utf-8")
    found = compare_exports(*files).differences
    assert sorted((each.kind, each.noun, each.new_text) for each in found) == [
        ("changed", "element", "Action Operand=Stir Qualifier=NonStored IsBoolean=true"),
        ("changed", "element", "DirectedLink FromID=T2 ToID=Fill"),
        ("changed", "element", "Empty OR Again"),
    ]
