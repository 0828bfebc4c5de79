"""`scanrack l5x FOLDER`: sums over exports, and the reasons of refusals without names."""

import json

import pytest
from l5x_files import block, document, ladder, program, sheets, tag, task
from scanrack.commands import build
from scanrack.commands.programs.l5x_folder import kind_of
from typer.testing import CliRunner


def run(*words):
    answer = CliRunner().invoke(build(), ["l5x", *map(str, words)])
    return answer.exit_code, answer.output


@pytest.fixture
def folder(tmp_path):
    def write(name, *rungs, target="Controller", routines=()):
        tags = [tag("Lamp", "BOOL"), tag("Secret", "DINT")]
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        main = program("Main", ladder("Main", *rungs), *routines)
        path.write_text(
            document(target=target, tags=tags, programs=[main], tasks=[task("T", "Main")]), encoding="utf-8"
        )

    diagram = sheets("Blocks", block("IMC", 0, "Loop"))
    write("good.L5X", "OTE(Lamp);", "MOV(1,Secret);")
    write("bad/lacks.l5x", "XIC(Gone)OTL(Lamp);", "MOV(Away,Secret);", "NOP();")
    write("bad/more.L5X", "ADD(Lamp,1,Secret);", "THRS(Secret,Lamp);", "Valve(Secret);", routines=[diagram])
    write("part.L5X", "XIC(Gone)OTE(Lamp);", target="Program")
    (tmp_path / "none.L5X").write_text("<x/>", encoding="utf-8")
    (tmp_path / "note.txt").write_text("no export", encoding="utf-8")
    return tmp_path


LOOP = "a loop of blocks without a feedback wire"
LACKS = "names that the file does not have: tags, members, routines, add-ons"


def test_the_sums_of_a_folder(folder):
    status, output = run(folder, "--json")
    said = json.loads(output)
    assert status == 1
    reasons = {each["reason"]: (each["files"], each["refusals"]) for each in said.pop("reasons")}
    assert said == {
        "files": 5,
        "controllers": 3,
        "complete": 1,
        "unusable": 1,
        "rungs": 9,
        "imported": 4,
        "ran": 4,
    }
    assert reasons == {
        LACKS: (2, 3),
        "an operand of ADD": (1, 1),
        "an instruction without an implementation: THRS": (1, 1),
        "blocks without an implementation: IMC": (1, 1),
    }
    assert not any(name in output for name in ("Secret", "Gone", "Away", "Valve", "Loop"))


@pytest.mark.parametrize(
    ("reason", "kind"),
    [
        ("transition Tran_001 has no step after it", "a chart"),
        ("its source is encoded, so it is not in the file", "encoded"),
        ("it is of type Q; types of rungs are N, I", "edits in progress"),
        ("sheet 1, ADD A, sheet 1, SUB B: they are a loop without the Assume Data Available indicator", LOOP),
        ("sheet 2, TONR T1: TONR(T1): T1 is a DINT, a FBD_TIMER is needed", "other"),
        ("FOO(A): A is a BOOL, a number is needed", LACKS),
        ("Simple has no member Ready", LACKS),
    ],
)
def test_the_kind_of_a_reason(reason, kind):
    assert kind_of(reason) == kind


def test_the_table_of_a_folder(folder):
    status, output = run(folder)
    lines = output.splitlines()
    assert status == 1
    assert lines[:3] == [
        "5 exports, 1 of them can't be used",
        "9 rungs: 4 imported, 4 ran (44.44%)",
        "3 whole controllers, 1 without a refusal",
    ]
    assert lines[4] == f"    2         3  {LACKS}"


def test_stand_ins_are_given_in_a_folder_too(folder):
    said = json.loads(run(folder / "bad", "--json", "--stand-in")[1])
    assert (said["files"], said["complete"]) == (2, 1)


def test_what_a_folder_does_not_take(folder, tmp_path):
    assert run(folder, "--run")[0] == 2
    (tmp_path / "empty").mkdir()
    status, output = run(tmp_path / "empty")
    assert (status, "no .L5X or .SLC file" in output) == (2, True)


def test_a_folder_without_refusals(folder):
    for name in ("bad/lacks.l5x", "bad/more.L5X", "none.L5X"):
        (folder / name).unlink()
    assert run(folder)[0] == 0
