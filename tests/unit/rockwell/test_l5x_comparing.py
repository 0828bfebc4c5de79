"""`scanrack l5x A --against B`: two versions, rung by rung."""

import json

import pytest
from l5x_files import (
    data_type,
    document,
    ladder,
    machine,
    member,
    program,
    rung,
    structured,
    tag,
    task,
    value,
)
from scanrack.commands import build
from scanrack.rockwell.l5x.comparing import Difference, differences
from scanrack.rockwell.l5x.xml.document import read_document
from typer.testing import CliRunner


@pytest.fixture
def compared(tmp_path):
    """Compare two documents; return kind, what and where of each difference, and the differences."""

    def compare(old, new):
        files = tmp_path / "old.L5X", tmp_path / "after.L5X"
        for file, text in zip(files, (old, new), strict=True):
            file.write_text(text, encoding="utf-8")
        found = differences(*map(read_document, files))
        return [(each.kind, each.what, each.where) for each in found], found

    return compare


RUNGS = ["XIC(A)OTE(B);", "XIC(B)OTE(C);", "XIC(C)OTE(D);"]


def test_the_same_has_no_differences(compared):
    assert compared(machine(*RUNGS), machine(*RUNGS))[0] == []


def test_spaces_between_instructions_are_no_difference(compared):
    assert compared(machine("XIC(A)OTE(B);"), machine("XIC(A) OTE( B ) ;"))[0] == []


def test_spaces_in_a_text_are_one(compared):
    assert len(compared(machine("EQU(S,'a b');"), machine("EQU(S,'ab');"))[0]) == 1


def test_a_rung_that_is_put_in_changes_no_other(compared):
    new = [RUNGS[0], "XIC(X)OTE(Y);", *RUNGS[1:]]
    listed, found = compared(machine(*RUNGS), machine(*new))
    assert listed == [("added", "rung", "Main, Main, rung 1")]
    assert (found[0].before, found[0].after) == ("", "XIC(X)OTE(Y);")


def test_a_rung_that_is_taken_out(compared):
    listed, _ = compared(machine(*RUNGS), machine(*RUNGS[:2]))
    assert listed == [("removed", "rung", "Main, Main, rung 2")]


def test_a_changed_rung_shows_both_texts(compared):
    new = [RUNGS[0], "XIC(B)XIO(E)OTE(C);", RUNGS[2]]
    listed, (found,) = compared(machine(*RUNGS), machine(*new))
    assert listed == [("changed", "rung", "Main, Main, rung 1")]
    assert list(found.lines())[1:] == ["    - XIC(B)OTE(C);", "    + XIC(B)XIO(E)OTE(C);"]


def test_a_comment(compared):
    old, new = (machine(rung(RUNGS[0], comment=text)) for text in ("slow", "fast"))
    assert compared(old, new)[0] == [("changed", "comment", "Main, Main, rung 0")]


def test_tags_by_type_and_value(compared):
    old = machine(tags=[tag("A", "DINT", data=value("DINT", 1)), tag("B", "BOOL"), tag("C", "DINT")])
    new = machine(tags=[tag("A", "DINT", data=value("DINT", 2)), tag("B", "INT"), tag("D", "DINT")])
    listed, found = compared(old, new)
    kinds = [("removed", "C"), ("changed", "A"), ("changed", "B"), ("added", "D")]
    assert listed == [(kind, "tag", name) for kind, name in kinds]
    assert (found[1].before, found[1].after) == ("value = 1", "value = 2")


def test_types_tasks_programs_and_structured_text(compared):
    def plant(dim, rate, text, *programs):
        return document(
            types=[data_type("Recipe", member("Time", "DINT", dim))],
            programs=[program("Main", structured("Main", text)), *programs],
            tasks=[task("Fast", "Main", kind="PERIODIC", rate=rate)],
        )

    old = plant(0, 10, "A := 1;\nB := 2;")
    new = plant(3, 20, "A := 1;\nB := 3;", program("More", ladder("Main")))
    assert compared(old, new)[0] == [
        ("changed", "data type", "Recipe"),
        ("added", "program", "More"),
        ("changed", "line", "Main, Main"),
        ("changed", "task", "Fast"),
    ]


def run(*words):
    return CliRunner().invoke(build(), ["l5x", *map(str, words)])


def test_the_command(tmp_path):
    old, new = tmp_path / "before.L5X", tmp_path / "after.L5X"
    old.write_text(machine(*RUNGS), encoding="utf-8")
    new.write_text(machine(*RUNGS[:2]), encoding="utf-8")
    assert run(old, "--against", old).exit_code == 0
    done = run(new, "--against", old)
    assert done.exit_code == 1
    assert "Main, Main, rung 2: rung removed" in done.stdout
    (found,) = json.loads(run(new, "--against", old, "--json").stdout)
    assert Difference(**found).before == RUNGS[2]
    assert run(new, "--against", tmp_path / "none.L5X").exit_code == 2
