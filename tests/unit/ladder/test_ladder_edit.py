"""Values that outlive a program: in an edited one, and in the next run."""

import json

import pytest
from scanrack.ladder import Controller, LadderError
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.run.edit import planned, retain, retained_text

BEFORE = """PROGRAM line
TYPE Step (Time : DINT, Open : BOOL)
TAG Run : BOOL
TAG Count : DINT
TAG Gone : DINT
TAG Size : INT
TAG Fill : TIMER
TAG Name : STRING
TAG Share : REAL
TAG Steps : Step[2]
ROUTINE Main
XIC(Run)ADD(Count,1,Count);
XIC(Run)TON(Fill,1000,0);
END
"""

AFTER = """PROGRAM line
TYPE Step (Time : DINT, Open : BOOL)
TAG Run : BOOL
TAG Count : DINT
TAG Size : DINT
TAG Fill : TIMER
TAG Fresh : DINT := 5
TAG Firsts : DINT
TAG Steps : Step[2]
ROUTINE Main
XIC(S:FS)ADD(Firsts,1,Firsts);
XIC(Run)ADD(Count,10,Count);
XIC(Run)TON(Fill,?,?);
END
"""


def test_an_edited_program_goes_on_with_its_values():
    old, new = parse_program(BEFORE), parse_program(AFTER)
    old.tags.Run = True
    for _ in range(4):
        old.step(100)
    edit = new.take_over(old)
    assert (edit.new, edit.changed, edit.dropped) == (
        ("Fresh", "Firsts"),
        ("Size",),
        ("Gone", "Name", "Share"),
    )
    assert edit.kept == ("Run", "Count", "Fill", "Steps")
    assert "edited at 0.3 s, 4 tags keep their values; new: Fresh, Firsts" in str(edit)
    assert new.tags["Fill.ACC"] == 300
    new.step(100)
    assert (new.tags.Count, new.tags.Fresh, new.tags.Firsts) == (14, 5, 0)  # no prescan, no first scan
    assert new.tags["Fill.ACC"] == 400
    assert old.tags.Count == 4
    with pytest.raises(LadderError, match="runs already"):
        new.take_over(old)


def test_the_debugger_takes_an_edit_between_two_scans():
    debugger = Debugger(parse_program(BEFORE))
    debugger.force("Run", True)
    debugger.scan(4)
    debugger.edit(parse_program(AFTER))
    debugger.scan(2)
    assert debugger.tags.Count == 24
    assert [scan for scan, _edit in debugger.edits] == [4]
    assert debugger.forces == {"Run": True}
    assert debugger.scans == 6
    assert "scan 5" in debugger.why("Count")
    assert debugger.why("Fresh") == "Fresh is 5: no rung writes it."


CONTROLLER = """CONTROLLER plant
TAG Count : DINT
TASK Cycle : CONTINUOUS RUNS Main
TASK Fast : PERIODIC {rate} ms RUNS Quick
PROGRAM Main
ROUTINE Main
;
END
END PROGRAM
PROGRAM Quick
TAG Own : DINT
ROUTINE Main
ADD(Own,1,Own);
XIC(S:FS)ADD(Count,1,Count);
END
END PROGRAM
"""


def test_tasks_go_on_too():
    old = parse_program(CONTROLLER.format(rate=20))
    for _ in range(4):
        old.step(10)
    new = parse_program(CONTROLLER.format(rate=20).replace("ADD(Own,1,Own)", "ADD(Own,100,Own)"))
    new.take_over(old)
    for _ in range(3):
        new.step(10)
    assert new.tags[r"\Quick.Own"] == 2 + 200  # due at 0 and 20; then at 40 and 60
    assert new.tags.Count == 1  # its first scan was before the edit
    assert isinstance(new, Controller)
    assert new.overlaps == {"Cycle": 0, "Fast": 0}


def test_the_next_run_begins_with_the_tags_of_this_one():
    first = parse_program(BEFORE)
    first.tags["Name"] = "it's \x00 \xff"
    first.tags["Share"] = float("inf")
    first.tags["Steps"] = [{"Time": 7, "Open": True}, {"Time": -8}]
    first.tags.Run = True
    first.step()
    text = retained_text(first.engine)
    second = parse_program(BEFORE)
    assert retain(second.engine, text) == []
    for name in second.tags:
        assert second.tags[name] == first.tags[name]
    second.step()
    assert second.tags.Count == 2
    assert retained_text(first.engine) == text


def test_what_does_not_fit_is_told_and_keeps_its_initial_value():
    first = parse_program(BEFORE)
    first.tags.Size = 9
    program = parse_program(AFTER)
    assert retain(program.engine, retained_text(first.engine)) == [
        "Gone is no longer a tag of the program",
        "Name is no longer a tag of the program",
        "Share is no longer a tag of the program",
        "Size is DINT, in the file INT",
        "Fresh is not in the file",
        "Firsts is not in the file",
    ]
    assert (program.tags.Size, program.tags.Fresh) == (0, 5)


def test_values_out_of_range_are_refused_tag_by_tag():
    program = parse_program(BEFORE)
    text = retained_text(program.engine).replace('"Size": ["INT", 0]', '"Size": ["INT", 40000]')
    text = text.replace('"Steps": ["Step[2]", [{"Time": 0', '"Steps": ["Step[2]", [{"Time": 3')
    text = text.replace('"Open": false}]]', '"Open": 7}]]')
    said = retain(program.engine, text)
    assert [each.split(":")[0] for each in said] == ["Size", "Steps.Open"]
    assert program.tags["Steps"][0]["Time"] == 0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        "no",
        '{"format": "scanrack tags 1"}',
        "[" * 65,
        '{"format": "scanrack tags 1", "tags": {"A": 1}}',
    ],
)
def test_another_file_is_refused(text):
    with pytest.raises(LadderError):
        retain(parse_program(BEFORE).engine, text)


ARRAYS = """PROGRAM line
TYPE Pair (A : DINT, B : DINT[3])
TAG One : DINT[5]
TAG Two : DINT[2,3]
TAG Both : Pair[2]
ROUTINE Main
;
END
"""

WHOLE = {"A": 1, "B": [1, 2, 3]}


@pytest.mark.parametrize(
    ("tag", "value", "said"),
    [
        ("One", [1, 2], "One has 5 elements, in the file 2"),
        ("One", [], "One has 5 elements, in the file 0"),
        ("Two", [[1, 2, 3]], "Two has 2 elements, in the file 1"),
        ("Two", [[1, 2, 3], [4]], "Two[1] has 3 elements, in the file 1"),
        ("Both", [WHOLE, {"A": 1}], "Both[1].B is not in the file"),
        ("Both", [WHOLE, {"A": 1, "B": [1]}], "Both[1].B has 3 elements, in the file 1"),
    ],
)
def test_a_retained_value_that_is_too_short_is_told_and_not_taken(tag, value, said):
    """Once the rest was filled with zeros without a word."""
    program = parse_program(ARRAYS)
    stored = json.loads(retained_text(program.engine))
    stored["tags"][tag][1] = value
    before = program.engine.tags[tag]
    assert retain(program.engine, json.dumps(stored)) == [said]
    assert program.engine.tags[tag] == before


def test_an_edit_names_values_that_stay_though_the_text_gives_others():
    program = "PROGRAM p\nTAG Fill : TIMER\nTAG N : DINT := {}\nTAG Run : BOOL\nROUTINE Main\n{}\nEND\n"
    old = parse_program(program.format(5, "XIC(Run)TON(Fill,1000,0);"))
    old.step()
    new = parse_program(program.format(7, "XIC(Run)TON(Fill,2000,0);"))
    plan = planned(old.engine, new.build())
    assert plan.restated == ("Fill.PRE 1000, not 2000", "N 5, not 7")
    assert old.tags["Fill.PRE"] == 1000
    assert new.take_over(old) == plan
    assert (new.tags["Fill.PRE"], new.tags.N) == (1000, 5)
    same = parse_program(program.format(5, "XIC(Run)XIC(Run)TON(Fill,1000,0);"))
    assert planned(new.engine, same.build()).restated == ()
