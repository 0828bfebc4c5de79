"""Function block diagrams of a document: refused by element, written back, compared, explained, proved."""

import json
import re
from pathlib import Path

import pytest
from l5x_files import (
    add_on,
    block,
    connector,
    document,
    ladder,
    parameter,
    program,
    reference,
    sheets,
    tag,
    task,
    wire,
)
from scanrack.commands import build
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.files.rungfile import program_text
from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.model.predefined.process_types import ARRAYS, PROCESS
from scanrack.rockwell.diff import compare_exports
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.diagrams.blocks import BLOCKS
from scanrack.rockwell.l5x.export import export_l5x
from scanrack.rockwell.l5x.xml.document import read_document
from typer.testing import CliRunner

PAGE = Path(__file__).parents[3] / "docs" / "l5x-format.md"
KINDS = {
    "BOOL": "Start Stop Motor",
    "DINT": "N",
    "FBD_TIMER": "Delay",
    "FBD_BOOLEAN_NOT": "No",
    "FBD_MATH": "Sum Difference",
}
MOTOR = (
    "<Description>\n<![CDATA[Holds itself]]>\n</Description>\n"
    + reference("IRef", 0, "Start")
    + reference("IRef", 1, "Stop")
    + block("BNOT", 2, "No", x=100)
    + block("BAND__F", 3, x=200)
    + block("TONR", 4, "Delay", x=300, pins="TimerEnable DN")
    + reference("ORef", 5, "Motor", x=400)
    + wire(0, "3.In1")
    + wire(1, "2.In")
    + wire("2.Out", "3.In2")
    + wire("3.Out", "4.TimerEnable")
    + wire("4.DN", 5)
    + '<TextBox ID="6" X="20" Y="20" Width="0">\n<Text>\n<![CDATA[Starts < late]]>\n</Text>\n</TextBox>\n'
    + '<Attachment FromID="6" ToID="4"/>\n'
)


def machine(*contents, main="JSR(Blocks,0);"):
    tags = [tag(name, kind) for kind, names in KINDS.items() for name in names.split()]
    routines = (ladder("Main", main), sheets("Blocks", *contents))
    return document(tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")])


def test_a_diagram_is_imported_runs_and_is_counted(imported):
    report = imported(machine(MOTOR)).report
    assert (report.refused, report.objects, report.faults) == ([], [], {})
    said = report.as_json()
    assert said["diagrams"] == {"total": 1, "imported": 1, "refused": 0, "ran": 1}
    assert (said["rungs"], said["ran"], said["structured_text"]["routines"]["total"]) == (1, 1, 0)
    assert "function block diagrams: 1, 1 imported, 0 refused, 1 ran" in list(report.lines())


@pytest.mark.parametrize("name", BLOCKS)
def test_each_block_runs_and_is_on_the_page(imported, name):
    """A true EnableIn makes EnableOut true, a false one makes it false."""
    form = BLOCKS[name]
    content = reference("IRef", 0, "On") + block(name, 1, "It", **{each: f"A{each}" for each in form.arrays})
    content += wire(0, "1.EnableIn")
    tags = [tag("On", "BOOL"), tag("It", form.structure.name)]
    tags += [tag(f"A{each}", "REAL", "4") for each in form.arrays]
    routines = ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", content)
    found = imported(document(tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")]))
    assert (found.report.objects, found.report.faults) == ([], {})
    for engine in (found.controller.compile(), found.controller.interpret()):
        for pin in ("Source", "SourceB"):  # 0 has no logarithm, and divides nothing
            if form.structure.member(pin):
                engine.tags[f"It.{pin}"] = 1
        for value in (True, False):
            engine.tags["On"] = value
            engine.step()
            assert engine.tags["It.EnableOut"] is value
    (section,) = re.findall(
        r"## Function block diagrams\n(.*?)\n## ", PAGE.read_text(encoding="utf-8"), re.DOTALL
    )
    assert re.search(rf"\b{name}\b", section)


ADD = block("ADD", 0, "Sum") + block("SUB", 1, "Difference", x=100)
LOOP = wire("0.Dest", "1.SourceA") + wire("1.Dest", "0.SourceA")
WRONG = {
    "an unknown block": (
        block("IMC", 0, "Loop"),
        "sheet 1, IMC Loop: scanrack has no IMC in function block diagrams",
    ),
    "two unknown blocks": (
        block("IMC", 0, "Loop")
        + block("ADD", 1, "Sum")
        + block("CC", 2, "Alarm", x=5)
        + block("IMC", 3, "Two", x=9),
        "sheet 1, IMC Loop; sheet 1, CC Alarm; sheet 1, IMC Two: "
        "scanrack has no IMC, CC in function block diagrams",
    ),
    "an unknown function": (
        block("FOO__F", 7),
        "sheet 1, FOO__F with ID 7: scanrack has no FOO__F in function block diagrams",
    ),
    "a timer as a function": (block("TONR__F", 7), "scanrack has no TONR__F in function block diagrams"),
    "a loop": (
        ADD + LOOP,
        "sheet 1, ADD Sum, sheet 1, SUB Difference: they are a loop without the Assume Data Available",
    ),
    "no pin": (
        block("BNOT", 0, "No") + wire("0.Out", "0.Inn"),
        "sheet 1, BNOT No: FBD_BOOLEAN_NOT has no member Inn",
    ),
    "a number to a bit": (
        reference("IRef", 0, "N") + block("BNOT", 1, "No") + wire(0, "1.In"),
        "sheet 1, BNOT No: N is a DINT, a bit or a condition is needed",
    ),
    "an unknown tag": (
        reference("IRef", 0, "Gone") + block("BNOT", 1, "No") + wire(0, "1.In"),
        "sheet 1, BNOT No: no tag Gone",
    ),
    "a tag of another type": (block("TONR", 0, "Sum"), "sheet 1, TONR Sum: TONR(Sum): Sum is a FBD_MATH, a"),
    "an empty reference": (
        reference("IRef", 0, "") + block("BNOT", 1, "No") + wire(0, "1.In"),
        "sheet 1, IRef with ID 0: its operand must be a tag or a number",
    ),
    "a number as an output": (
        block("BNOT", 0, "No") + reference("ORef", 1, "5") + wire("0.Out", 1),
        "sheet 1, ORef 5: its operand must be a tag",
    ),
    "two wires to a pin": (
        block("BNOT", 0, "No") + reference("IRef", 1, "Start") + wire(1, "0.In") + wire(1, "0.IN"),
        "sheet 1, BNOT No: two wires lead to its input IN",
    ),
    "a wire to nothing": (
        block("BNOT", 0, "No") + wire("0.Out", 9),
        "sheet 1: a wire leads to an element that does not",
    ),
    "a wire without a pin": (ADD + wire("0.Dest", 1), "sheet 1, SUB Difference: a wire to it names no pin"),
    "a wire from an output": (
        reference("ORef", 1, "Motor") + block("BNOT", 0, "No") + wire(1, "0.In"),
        "sheet 1, ORef Motor: a wire leaves it, and it has no output",
    ),
    "an ID twice": (
        block("BNOT", 0, "No") * 2,
        "sheet 1, BNOT No: its ID is missing, or another element has it",
    ),
    "an open connector": (
        connector("ICon", 0, "Link") + block("BNOT", 1, "No") + wire(0, "1.In"),
        "sheet 1, ICon Link: nothing is wired to its output connector",
    ),
    "a connector twice": (
        connector("OCon", 0, "Link") + connector("OCon", 1, "LINK"),
        "sheet 1, OCon LINK: another output connector has this name",
    ),
    "connectors in a circle": (
        connector("ICon", 0, "Link")
        + connector("OCon", 1, "Link")
        + wire(0, 1)
        + reference("ORef", 2, "Motor")
        + wire(0, 2),
        "sheet 1, ICon Link: nothing is wired to its output connector",
    ),
    "an open input of a function": (
        block("SUB__F", 0) + reference("IRef", 1, "N") + wire(1, "0.SourceB"),
        "sheet 1, SUB__F with ID 0: nothing is wired to its input SourceA",
    ),
    "an unknown add-on": (
        '<AddOnInstruction Name="Valve" ID="0" X="0" Y="0" Operand="V1"/>',
        "sheet 1, Valve V1: no add-on Valve in the file",
    ),
    "two sheets of one number": (
        block("BNOT", 0, "No") + '</Sheet>\n<Sheet Number="1">\n' + block("BNOT", 1, "No"),
        "it has two sheets 1",
    ),
    "an unknown element": (
        '<Coil ID="0" X="0" Y="0"/>',
        "sheet 1, Coil with ID 0: elements are Block, Function,",
    ),
}


@pytest.mark.parametrize(("content", "reason"), WRONG.values(), ids=WRONG)
def test_a_diagram_that_can_not_be_is_refused_with_its_element(imported, content, reason):
    """The rest of the program runs; the refusal has the line of the element."""
    found = imported(machine(content, main="XIC(Start)OTE(Motor);"))
    (refused,) = found.report.objects
    assert refused.reason.startswith(reason) or reason in refused.reason
    assert (refused.program, refused.routine, found.report.ran) == ("P", "Blocks", 1)
    assert found.report.drawn("FBD") == {"total": 1, "imported": 0, "refused": 1, "ran": 0}
    lines = machine(content, main="XIC(Start)OTE(Motor);").splitlines()
    assert re.match(r"<(\w+) (.*ID=|Number=)", lines[refused.line - 1])


def test_a_refused_diagram_may_do_nothing(imported, tmp_path):
    path = tmp_path / "machine.L5X"
    path.write_text(machine(block("IMC", 0, "Loop")), encoding="utf-8")
    answer = CliRunner().invoke(build(), ["l5x", str(path), "--print-rack"])
    assert 'Blocks = "false"' in answer.output


def test_a_diagram_is_written_as_it_was_read(imported, tmp_path):
    first = imported(machine(MOTOR))
    path = tmp_path / "again.L5X"
    for name in ("P", "P.Blocks"):
        path.write_bytes(export_l5x(first.controller, name))
        assert "FBD_Blocks" not in path.read_text(encoding="utf-8")
        again = import_l5x(path)
        assert (again.report.objects, again.report.lost) == ([], [])
        assert again.controller is not None
        routines = [each for each in again.controller.programs[0].routines if each.name == "Blocks"]
        assert routines == [each for each in first.controller.programs[0].routines if each.name == "Blocks"]
        assert "Starts < late" in path.read_text(encoding="utf-8")
        records = [
            read_document(each).programs[0].routines[-1].chart for each in (path, tmp_path / "machine.L5X")
        ]
        assert _without_lines(records[0]) == _without_lines(records[1])


@pytest.mark.slow
def test_all_blocks_of_process_control_are_written_back_and_as_text(imported, tmp_path):
    """As text the diagram is structured text that is read as the same statements, without its drawing."""
    parts = [
        block(name, key, f"T{key}", **{f"{each}Array": f"A{key}" for each in ARRAYS.get(name, ())})
        for key, name in enumerate(PROCESS)
    ]
    tags = [tag(f"T{key}", kind.name) for key, kind in enumerate(PROCESS.values())]
    tags += [tag(f"A{key}", "REAL", "4") for key, name in enumerate(PROCESS) if name in ARRAYS]
    routines = (ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", "".join(parts)))
    first = imported(document(tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")]))
    path = tmp_path / "again.L5X"
    path.write_bytes(export_l5x(first.controller, "P"))
    again = import_l5x(path)
    assert (again.report.objects, again.report.refused, again.report.lost) == ([], [], [])
    records = [
        read_document(each).programs[0].routines[-1].chart for each in (path, tmp_path / "machine.L5X")
    ]
    assert _without_lines(records[0]) == _without_lines(records[1])
    text = program_text(first.controller)
    read = parse_program(text)
    assert program_text(read) == text
    assert isinstance(read, Controller)
    ours, theirs = (each.programs[0].routines[-1] for each in (first.controller, read))
    assert (theirs.statements, theirs.drawing) == (ours.statements, None)


def _without_lines(record):
    return record.tag, dict(record.attributes), record.text.strip(), [*map(_without_lines, record.children)]


def test_versions_of_a_diagram_are_compared_by_element(tmp_path):
    paths = [tmp_path / name for name in ("old.L5X", "new.L5X")]
    changed = MOTOR.replace('Operand="Start"', 'Operand="Stop"', 1).replace('X="300"', 'X="320"')
    for path, content in zip(paths, (MOTOR, changed), strict=True):
        path.write_text(machine(content), encoding="utf-8")
    found = compare_exports(*paths)
    (difference,) = found.differences
    assert found.apart == ("blanks and places on the sheet of P, Blocks",)
    assert (difference.noun, difference.place) == ("element", "P, Blocks")
    assert (difference.old_text, difference.new_text) == ("IRef Operand=Start", "IRef Operand=Stop")


def test_why_leads_from_the_output_through_the_diagram_to_its_input(imported):
    controller = imported(machine(MOTOR)).controller
    assert controller is not None
    debugger = Debugger(controller)
    debugger.tags["Delay.PRE"] = 10
    debugger.tags["Start"] = True
    debugger.scan(4)
    assert debugger.tags["Motor"]
    assert "Motor := Delay.DN; in routine \\P.Blocks" in debugger.why("Motor")
    debugger.tags["Start"] = False
    debugger.scan(1)
    chain = debugger.chain("Motor")
    assert chain is not None
    names = {each.name for each in chain.walk()}
    assert names >= {"Motor", "Delay.DN", "Delay.TimerEnable", "FBD_Blocks_1_3", "Start"}


def test_xref_lists_the_wires_of_a_tag(tmp_path):
    path = tmp_path / "machine.L5X"
    path.write_text(machine(MOTOR), encoding="utf-8")
    rack = tmp_path / "machine.toml"
    rack.write_text(CliRunner().invoke(build(), ["l5x", str(path), "--print-rack"]).output, encoding="utf-8")
    answer = CliRunner().invoke(build(), ["xref", str(rack), "Start", "--json"])
    (mention,) = json.loads(answer.output)["mentions"]
    assert (mention["routine"], mention["text"]) == (r"\P.Blocks", "FBD_Blocks_1_3 := Start AND No.Out;")


LATCH = (
    "".join(reference("IRef", key, each) for key, each in enumerate(("Start", "Stop", "Motor")))
    + block("BOR__F", 3)
    + block("BNOT__F", 4)
    + block("BAND__F", 5)
    + reference("ORef", 6, "Motor")
    + wire(0, "3.In1")
    + wire(2, "3.In2")
    + wire(1, "4.In")
    + wire("3.Out", "5.In1")
    + wire("4.Out", "5.In2")
    + wire("5.Out", 6)
)


@pytest.mark.parametrize(
    ("rung", "status", "said"),
    [
        ("[XIC(Start),XIC(Motor)]XIO(Stop)OTE(Motor);", 0, "0 of 1 bits and numbers can differ"),
        ("[XIC(Start)XIO(Stop),XIC(Motor)]OTE(Motor);", 1, "1 of 1 bits and numbers can differ"),
    ],
)
def test_a_diagram_is_proved_equal_to_a_rung(tmp_path, rung, status, said):
    tags = [tag(each, "BOOL") for each in ("Start", "Stop", "Motor")]
    both = ([ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", LATCH)], [ladder("Main", rung)])
    paths = [tmp_path / "diagram.L5X", tmp_path / "rung.L5X"]
    for path, routines in zip(paths, both, strict=True):
        path.write_text(
            document(tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")]), encoding="utf-8"
        )
    words = ["prove", *map(str, paths), "-q", "--out", str(tmp_path / "proofs")]
    answer = CliRunner().invoke(build(), words)
    assert (answer.exit_code, said in answer.output) == (status, True)


@pytest.mark.parametrize(("rung", "status"), [("XIC(Start)Valve(It);", 0), ("XIO(Start)Valve(It);", 1)])
def test_an_add_on_with_a_wired_enable_in_is_proved_equal_to_its_rung(tmp_path, rung, status):
    """Logic sets Q, EnableInFalse clears it."""
    valve = add_on(
        "Valve",
        [parameter("Q", "BOOL", "Output", required=False)],
        [],
        ladder("Logic", "OTL(Q);"),
        ladder("EnableInFalse", "OTU(Q);"),
        runs='ExecuteEnableInFalse="true"',
    )
    element = '<AddOnInstruction Name="Valve" ID="1" X="9" Y="0" Operand="It"/>\n'
    diagram = sheets("Blocks", reference("IRef", 0, "Start") + element + wire(0, "1.EnableIn"))
    read = "XIC(It.Q)OTE(Motor);"
    tags = [tag("Start", "BOOL"), tag("Motor", "BOOL"), tag("It", "Valve")]
    both = ([ladder("Main", "JSR(Blocks,0);", read), diagram], [ladder("Main", rung, read)])
    paths = [tmp_path / "diagram.L5X", tmp_path / "rung.L5X"]
    for path, routines in zip(paths, both, strict=True):
        text = document(
            add_ons=[valve], tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")]
        )
        path.write_text(text, encoding="utf-8")
    words = ["prove", *map(str, paths), "-q", "--out", str(tmp_path / "proofs")]
    assert CliRunner().invoke(build(), words).exit_code == status
