"""`scanrack l5x A --against B`: two versions of an export, rung by rung and tag by tag."""

import json

import pytest
from l5x_files import (
    add_on,
    data_type,
    document,
    ladder,
    machine,
    member,
    module,
    parameter,
    program,
    rung,
    structured,
    tag,
    task,
    value,
)
from scanrack.commands import build
from scanrack.ladder.model.errors import LadderError
from scanrack.rockwell.diff import compare_exports, page_of, text_of_export
from scanrack.rockwell.diff.alignment import aligned
from typer.testing import CliRunner


@pytest.fixture
def compared(tmp_path):
    """Compare two documents; return kind, what and where of each difference, and the comparison."""

    def compare(old, new, suffix="L5X"):
        files = tmp_path / f"old.{suffix}", tmp_path / f"after.{suffix}"
        for file, text in zip(files, (old, new), strict=True):
            file.write_text(text, encoding="utf-8")
        found = compare_exports(*files)
        return [(each.kind, each.noun, each.place) for each in found.differences], found

    return compare


RUNGS = ["XIC(A)OTE(B);", "XIC(B)OTE(C);", "XIC(C)OTE(D);"]


def test_the_same_has_no_differences(compared):
    listed, found = compared(machine(*RUNGS), machine(*RUNGS))
    assert (listed, found.apart, found.summary) == ([], (), "no difference")


def test_spaces_between_instructions_are_no_difference(compared):
    assert compared(machine("XIC(A)OTE(B);"), machine("XIC(A) OTE( B ) ;"))[0] == []


def test_spaces_in_a_text_are_one(compared):
    assert len(compared(machine("EQU(S,'a b');"), machine("EQU(S,'ab');"))[0]) == 1


def test_a_rung_that_is_put_in_changes_no_other(compared):
    new = [RUNGS[0], "XIC(X)OTE(Y);", *RUNGS[1:]]
    listed, found = compared(machine(*RUNGS), machine(*new))
    assert listed == [("added", "rung", "Main, Main, rung 1")]
    assert (found.differences[0].old_text, found.differences[0].new_text) == ("", "XIC(X)OTE(Y);")


def test_a_rung_that_is_taken_out(compared):
    listed, _ = compared(machine(*RUNGS), machine(*RUNGS[:2]))
    assert listed == [("removed", "rung", "Main, Main, rung 2")]


def test_a_changed_rung_shows_both_texts(compared):
    new = [RUNGS[0], "XIC(B)XIO(E)OTE(C);", RUNGS[2]]
    listed, found = compared(machine(*RUNGS), machine(*new))
    assert listed == [("changed", "rung", "Main, Main, rung 1")]
    lines = list(found.differences[0].lines())[1:]
    assert lines == ["  - XIC(B)OTE(C);", "  + XIC(B)XIO(E)OTE(C);"]


def test_a_rung_in_another_place_is_moved(compared):
    listed, found = compared(machine(*RUNGS), machine(RUNGS[2], *RUNGS[:2]))
    assert listed == [("moved", "rung", "Main, Main, rung 0")]
    assert found.differences[0].old_name == "rung 2"


def test_a_rung_under_its_comment_is_changed_although_nothing_of_it_is_left(compared):
    old, new = (machine(rung(text, comment="the pump")) for text in (RUNGS[0], "GEQ(X,1)MOV(2,Y);"))
    assert compared(old, new)[0] == [("changed", "rung", "Main, Main, rung 0")]


def test_a_rung_with_nothing_in_common_is_removed_and_added(compared):
    listed, _ = compared(machine(RUNGS[0]), machine("GEQ(X,1)MOV(2,Y);"))
    assert listed == [(kind, "rung", "Main, Main, rung 0") for kind in ("removed", "added")]


def test_a_comment(compared):
    old, new = (machine(rung(RUNGS[0], comment=text)) for text in ("slow", "fast"))
    assert compared(old, new)[0] == [("changed", "comment", "Main, Main, rung 0")]


def test_an_online_edit_of_a_rung(compared):
    old, new = (machine(rung(RUNGS[0], kind=kind)) for kind in ("N", "IR"))
    assert compared(old, new)[1].differences[0].new_text == f"IR: {RUNGS[0]}"


def test_tags_by_type_and_value(compared):
    old = machine(tags=[tag("A", "DINT", data=value("DINT", 1)), tag("B", "BOOL"), tag("C", "DINT")])
    new = machine(tags=[tag("A", "DINT", data=value("DINT", 2)), tag("B", "INT"), tag("D", "DINT")])
    listed, found = compared(old, new)
    kinds = [("removed", "C"), ("changed", "A"), ("changed", "B"), ("added", "D")]
    assert listed == [(kind, "tag", name) for kind, name in kinds]
    assert (found.differences[1].old_text, found.differences[1].new_text) == ("value = 1", "value = 2")


def test_types_tasks_programs_and_structured_text(compared):
    def plant(dim, rate, text, *programs):
        return document(
            types=[data_type("Recipe", member("Time", "DINT", dim))],
            programs=[program("Main", structured("Main", text)), *programs],
            tasks=[task("Fast", "Main", kind="PERIODIC", rate=rate)],
        )

    old = plant(0, 10, "A := 1;\nB := 2;")
    new = plant(3, 20, "A := 1;\nB := 3;", program("More", ladder("Main")))
    listed, _ = compared(old, new)
    assert sorted(listed, key=lambda each: each[2]) == [
        ("changed", "task", "Fast"),
        ("changed", "line", "Main, Main, line 2"),
        ("added", "program", "More"),
        ("changed", "data type", "Recipe"),
    ]


CONTENT = {
    "a tag's constant": ('Constant="false"', 'Constant="true"', "tag"),
    "a module's port": ('Address="3"', 'Address="4"', "module"),
    "a controller's revision": ('ProcessorType="1769-L33ER"', 'ProcessorType="1769-L36ERM"', "controller"),
    "a program's main routine": ('MainRoutineName="Main"', 'MainRoutineName="More"', "program"),
    "what is unknown": ("<Future Kind='1'/>", "<Future Kind='2'/>", "controller"),
    "text inside of it": ("<Later>some</Later>", "<Later>other</Later>", "controller"),
    "raw values": ("00 01", "00 02", "tag"),
    "a watchdog": ('Watchdog="500"', 'Watchdog="100"', "task"),
    "a revision of an add-on": ('Revision="1.0" Note', 'Revision="1.1" Note', "add-on"),
}


@pytest.mark.parametrize("which", CONTENT)
def test_nothing_differs_unseen(compared, which):
    before, after, what = CONTENT[which]
    old = machine(
        *RUNGS,
        modules=[module("Inputs", 3)],
        tags=[tag("A", "DINT").replace("</Tag>", "<Data>00 01</Data></Tag>")],
        add_ons=[add_on("Valve", [], runs='Note="x"')],
    ).replace("</Controller>", "<Future Kind='1'/><Later>some</Later></Controller>")
    assert before in old
    listed, _ = compared(old, old.replace(before, after))
    assert [(kind, each) for kind, each, _ in listed] == [("changed", what)]


def test_order_and_dates_are_apart(compared):
    tags = [tag(name, "BOOL") for name in "ABC"]
    old = machine(*RUNGS, tags=tags).replace('Name="Plant"', 'Name="Plant" LastModifiedDate="Monday"')
    new = machine(*RUNGS, tags=tags[::-1]).replace('Name="Plant"', 'Name="Plant" LastModifiedDate="Tuesday"')
    listed, found = compared(old, new)
    assert listed == []
    assert found.apart == ("dates, authors and options of the file, the controller", "the order of tags")


def test_order_of_members_and_parameters_is_a_difference(compared):
    members = [member(name, "DINT") for name in ("Time", "Speed")]
    parameters = [parameter(name, "BOOL", "Input") for name in ("Open", "Shut")]
    old = machine(types=[data_type("Recipe", *members)], add_ons=[add_on("Valve", parameters)])
    new = machine(types=[data_type("Recipe", *members[::-1])], add_ons=[add_on("Valve", parameters[::-1])])
    listed, found = compared(old, new)
    assert listed == [("changed", "data type", "Recipe"), ("changed", "add-on", "Valve")]
    assert found.differences[0].old_text == "order of members = Time, Speed"


def test_a_tag_with_another_name_is_renamed_and_its_rungs_are_not_changed(compared):
    old = machine(*RUNGS, tags=[tag(name, "BOOL") for name in "ABCD"])
    texts = [each.replace("(B)", "(Pump)") for each in RUNGS]
    new = machine(*texts, tags=[tag(name, "BOOL") for name in ("A", "Pump", "C", "D")])
    listed, found = compared(old, new)
    assert listed == [("renamed", "tag", "Pump")]
    assert found.differences[0].old_name == "B"


def test_a_tag_of_another_type_is_not_renamed(compared):
    old = machine(*RUNGS, tags=[tag("B", "BOOL")])
    new = machine(*(each.replace("(B)", "(Pump)") for each in RUNGS), tags=[tag("Pump", "DINT")])
    kinds = [kind for kind, what, _ in compared(old, new)[0] if what == "tag"]
    assert kinds == ["removed", "added"]


def test_a_routine_with_another_name_is_renamed(compared):
    routines = ladder("Main", "JSR(Old,0);"), ladder("Old", *RUNGS)
    old, new = (
        document(programs=[program("P", routines[0], routines[1].replace('Name="Old"', f'Name="{name}"'))])
        for name in ("Old", "Pumps")
    )
    assert compared(old, new)[0] == [("renamed", "routine", "P, Pumps")]


def test_an_added_program_shows_its_rungs(compared):
    old, new = (document(programs=programs) for programs in ([], [program("More", ladder("Main", *RUNGS))]))
    listed, found = compared(old, new)
    assert listed == [("added", "program", "More")]
    assert all(each in found.differences[0].new_text for each in RUNGS)


def test_a_tag_in_an_add_on_and_in_a_program_with_one_name(compared):
    """What is cut out of both is still found where only one has it."""
    shared = tag("A", "BOOL")
    old = document(tags=[shared], programs=[program("P", ladder("Main", *RUNGS))])
    new = document(programs=[program("P", ladder("Main", *RUNGS), tags=[shared])])
    assert compared(old, new)[0] == [("removed", "tag", "A"), ("added", "tag", "P, A")]


SLC = """PROJECT "feeder"
PROCESSOR "Bul.1766"
SLOT 1 OTHER 3 10 25
LADDER 2 "MAIN"
SOR XIC I:0/0 OTE O:0/0 EOR
SOR XIC B3/1 TON T4:0 0.01 500 0 EOR
SOR XIC T4:0/DN MOV N7:1 N7:2 EOR
DATA N7:0 60 0 -3
DATA ...T4:0 0XA200 60 60
"""


@pytest.mark.parametrize(
    ("before", "after", "listed"),
    [
        ("MOV N7:1 N7:2", "MOV N7:1 N7:3", ("changed", "rung", "U2, rung 2")),
        ("SOR XIC I:0/0 OTE O:0/0 EOR\n", "", ("removed", "rung", "U2, rung 0")),
        ("DATA N7:0 60 0 -3", "DATA N7:0 60 5 -3", ("changed", "data file", "N7")),
        ("0XA200 60 60", "0XA200 60 61", ("changed", "data file", "T4")),
        ("OTHER 3 10 25", "OTHER 3 10 26", ("changed", "slot", "1")),
        ('"MAIN"', '"BEGIN"', ("changed", "routine", "U2")),
    ],
)
def test_versions_of_an_slc_program(compared, before, after, listed):
    found, comparison = compared(SLC, SLC.replace(before, after), "SLC")
    assert found == [listed]
    if listed[1] == "data file":
        element = "N7:1 = 5" if listed[2] == "N7" else "T4:0.ACC = 61"
        assert comparison.differences[0].new_text == element


def test_an_l5x_and_an_slc_program_are_refused(tmp_path):
    files = tmp_path / "old.SLC", tmp_path / "new.L5X"
    for file, text in zip(files, (SLC, machine(*RUNGS)), strict=True):
        file.write_text(text, encoding="utf-8")
    with pytest.raises(LadderError, match=r"new.L5X is an L5X, .*old.SLC is text of RSLogix 500"):
        compare_exports(*files)


HOSTILE = '"><script>alert(1)</script><img src=x onerror=alert(1)>\u202e'


def test_the_page_runs_and_loads_nothing(compared):
    old = machine(*RUNGS)
    new = machine(rung("XIC(A)EQU(S,'</pre><script>')OTE(B);", comment=HOSTILE), *RUNGS[1:])
    _, found = compared(old, new)
    page = page_of(found, HOSTILE, HOSTILE)
    assert "<script" not in page
    assert "<img" not in page
    assert "\u202e" not in page
    assert "default-src 'none'; style-src 'sha256-" in page
    assert page.count("<svg") == 2
    assert '<rect class="field"' in page


def test_equal_rungs_by_the_thousand_are_aligned():
    old = ["NOP();"] * 5_000
    new = [*old[:2_500], "XIC(A)OTE(B);", *old[:2_000], "XIC(C)OTE(D);", *old[:500]]
    pairs = aligned(old, new)
    assert len(pairs) == 5_000
    assert {new[k] for k in range(len(new))} - {new[k] for _, k in pairs} == {
        "XIC(A)OTE(B);",
        "XIC(C)OTE(D);",
    }


def test_a_rung_of_ten_thousand_words(compared):
    long = "".join(f"XIC(Tag{number % 50})" for number in range(2_500))
    listed, found = compared(machine(f"{long}OTE(A);"), machine(f"{long}OTE(B);"))
    assert listed == [("changed", "rung", "Main, Main, rung 0")]
    assert "<ins>" not in page_of(found, "old", "new")  # too long to be marked


def test_text_for_git_has_neither_order_nor_dates(tmp_path):
    tags = [tag(name, "BOOL") for name in "AB"]
    files = tmp_path / "one.L5X", tmp_path / "other.L5X"
    for file, listed, day in zip(files, (tags, tags[::-1]), ("Mon", "Tue"), strict=True):
        text = machine(*RUNGS, tags=listed).replace("TargetName", f'ExportDate="{day}" TargetName')
        file.write_text(text, encoding="utf-8")
    texts = [text_of_export(each) for each in files]
    assert texts[0] == texts[1]
    assert "routine Main, Main\n  Type = RLL\n  XIC(A)OTE(B);\n" in texts[0]


def run(*words):
    return CliRunner().invoke(build(), ["l5x", *map(str, words)])


def test_the_command(tmp_path):
    old, new = tmp_path / "before.L5X", tmp_path / "after.L5X"
    old.write_text(machine(*RUNGS), encoding="utf-8")
    new.write_text(machine(*RUNGS[:2]), encoding="utf-8")
    assert run(old, "--against", old).exit_code == 0
    done = run(new, "--against", old, "--html", tmp_path / "page.html")
    assert done.exit_code == 1
    assert "Main, Main\n  rung 2 removed" in done.stdout
    assert (tmp_path / "page.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    found = json.loads(run(new, "--against", old, "--json").stdout)
    assert found["differences"][0]["before"] == RUNGS[2]
    assert run(new, "--against", tmp_path / "none.L5X").exit_code == 2
    assert run(new, "--html", tmp_path / "page.html").exit_code == 2
    assert run(new, "--against", old, "--html", new).exit_code == 2
    assert run(new, "--against", old, "--html", tmp_path / "no" / "page.html").exit_code == 3
    assert "XIC(A)OTE(B);" in CliRunner().invoke(build(), ["l5x", str(new), "--text"]).stdout
