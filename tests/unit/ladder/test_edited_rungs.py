"""Edits of rungs: checked against the running program, written into its file, with places to insert.

Broken on purpose: edits from the top down (the second one hits another rung), mistakes of shifted numbers, a
gap that is left out at the end of a leg.
"""

from pathlib import Path

import pytest
from scanrack.ladder import LadderError, parse_rung
from scanrack.ladder.draw.live import live_rung
from scanrack.ladder.files.rewriting import rewritten
from scanrack.ladder.files.rungfile import parse_program
from scanrack.ladder.lowering.edited import BEFORE_FIRST, EditedProgram, NewTag, RungEdit
from scanrack.rockwell.l5x.importer import import_l5x
from scanrack.rockwell.l5x.rewriting import rewritten_l5x

TEXT = """\
PROGRAM Line
TAG Go : BOOL  // a button
TAG N : DINT
TAG Lamp : BOOL
TAG Fill : TIMER

ROUTINE Main
// the lamp
XIC(Go)
  OTE(Lamp);  // lit
JMP(End);
  ADD(N,1,N);
// the end
LBL(End)XIC(Go)TON(Fill,1000,0);
END
ROUTINE Empty
END
"""


def checked(*edits, tags=()):
    return EditedProgram(parse_program(TEXT), [RungEdit(*each) for each in edits], tags)


def test_edits_change_their_lines_and_no_other():
    edits = [
        RungEdit("Main", 0, ("XIC(Go)OTE(Lamp);", "OTL(Lamp);")),
        RungEdit("Main", 2, ("ADD(N,2,N);",)),
        RungEdit("Main", 3, ()),
        RungEdit("MAIN", BEFORE_FIRST, ("OTU(Lamp);",)),
        RungEdit("Empty", BEFORE_FIRST, ("OTE(More);",)),
    ]
    before, after = TEXT.splitlines(), rewritten(TEXT, edits, [NewTag("More", "BOOL")]).splitlines()
    assert after[:5] == before[:5]
    assert after[5:] == [
        "TAG More : BOOL", "", "ROUTINE Main", "OTU(Lamp);", "// the lamp", "XIC(Go)OTE(Lamp);", "OTL(Lamp);",
        "JMP(End);", "  ADD(N,2,N);", "END", "ROUTINE Empty", "OTE(More);", "END",
    ]  # fmt: skip
    assert [str(each) for each in parse_program("\n".join(after)).routines[0].rungs][4] == "ADD(N,2,N);"
    with pytest.raises(LadderError, match="no rung 4"):
        rewritten(TEXT, [RungEdit("Main", 4, ())])


def test_a_controller_declares_a_tag_in_its_program():
    text = "CONTROLLER C\nTAG A : BOOL\nPROGRAM P\nROUTINE R\nOTE(A);\nEND\nEND PROGRAM\n"
    edited = rewritten(text, [RungEdit(r"\P.R", 0, ("OTE(B);",))], [NewTag("B", "BOOL", "P")])
    assert edited == text.replace("PROGRAM P\n", "PROGRAM P\nTAG B : BOOL\n").replace("OTE(A)", "OTE(B)")


def test_mistakes_stand_at_their_instruction_and_missing_tags_have_types():
    found = checked(
        ("Main", 0, ("XIC(Go)XIC(N)OTE(Lamp);", "XIC(Go")),
        ("Main", 2, ("XIC(Jog)MOV(5,Level)CTU(Parts,10,0)OTE(Lamp);",)),
        ("Main", 3, ()),
    )
    whole, unread, third = found.rungs
    assert [(each.element, each.text.partition(";")[0]) for each in whole.mistakes] == [
        (1, "XIC(N): N is a DINT, a bit is needed")
    ]
    assert unread.rung is None
    assert unread.mistakes[0].column == len("XIC(Go") + 1
    assert {each.name: each.types[:2] for each in found.missing} == {
        "Jog": ("BOOL",),
        "Level": ("DINT", "INT"),
        "Parts": ("COUNTER",),
    }
    assert third.number == 3
    assert [each.text.partition(" in ")[0] for each in third.warnings] == ["Lamp is written by a coil"]
    assert len(found.mistakes) == 1
    assert "END" in found.mistakes[0].upper()


def test_a_new_tag_settles_it_and_a_wrong_one_is_refused():
    edit = ("Main", 2, ("XIC(Jog)OTE(Go);",))
    assert checked(edit, tags=[NewTag("Jog", "BOOL")]).is_right
    assert not checked(edit, tags=[NewTag("Jog", "DINT")]).is_right
    for tag, said in (
        (("Go", "BOOL"), "Go already exists"),
        (("A B", "BOOL"), "is not a tag name"),
        (("Jog", "WHAT"), "no type"),
    ):
        with pytest.raises(LadderError, match=said):
            checked(edit, tags=[NewTag(*tag)])
    for wrong in (("Main", 9, ()), ("Other", 0, ())):
        with pytest.raises(LadderError, match="no r"):
            checked(wrong)


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("", "0"),
        ("OTE(A)", "00"),
        ("XIC(A)[XIC(B),XIO(C)[,XIC(D)]]OTE(E)", "000011122100"),
        ("[,XIC(A)][OTE(B),XIC(C)OTE(D)]", "00110001110"),
    ],
)
def test_gaps_are_in_the_order_of_the_text(text, rows):
    gaps = live_rung(parse_rung(text), "Main.0", 88).gaps
    heights = sorted({y for _, y in gaps})
    assert "".join(str(heights.index(y)) for _, y in gaps) == rows
    assert [x for x, y in gaps if y == heights[0]] == sorted(x for x, y in gaps if y == heights[0])
    broken = live_rung(parse_rung(text * 20), "Main.0", 40).gaps  # a rung of several lines
    assert len(broken) == (len(rows) - 1) * 20 + 1


def test_an_l5x_keeps_everything_but_its_edited_rungs(tmp_path):
    path = Path(__file__).parents[3] / "examples" / "l5x" / "mixer.L5X"
    data, name = path.read_bytes(), r"\MainProgram.Main"
    rungs = [str(each) for each in routine(import_l5x(path), name).rungs]
    edits = [RungEdit(name, 0, (rungs[0], "XIC(New)OTL(New);")), RungEdit(name, 3, ())]
    edited = rewritten_l5x(data, edits, [NewTag("New", "BOOL", "MainProgram")]).data
    (tmp_path / "mixer.L5X").write_bytes(edited)
    wanted = [rungs[0], "XIC(New)OTL(New);", *rungs[1:3], *rungs[4:]]
    assert [str(each) for each in routine(import_l5x(tmp_path / "mixer.L5X"), name).rungs] == wanted
    text = edited.decode("utf-8-sig")
    assert [f'<Rung Number="{each}" Type="N">' in text for each in range(len(wanted))] == [True] * len(wanted)
    assert edited.startswith(data[:3])
    after_blanks = data[:3] + b"\n " + data[3:]
    again = rewritten_l5x(after_blanks, edits, [NewTag("New", "BOOL", "MainProgram")]).data
    assert again == edited[:3] + b"\n " + edited[3:]
    with pytest.raises(LadderError, match="it is not XML"):
        rewritten_l5x(b"<RSLogix5000Content>", edits)
    assert text.count("<Module ") == data.count(b"<Module ")
    under_edit = data.replace(b'<Rung Number="0" Type="N">', b'<Rung Number="0" Type="rN">')
    with pytest.raises(LadderError, match="finalize"):
        rewritten_l5x(under_edit, edits)


def routine(imported, name):
    return next(each for each in imported.controller.routines if each.name == name)


def test_the_place_before_the_outputs_is_at_the_end_of_the_inputs():
    rail, end, before_rail = (x for x, _ in live_rung(parse_rung("XIC(A)OTE(B);"), "Main.0", 88).gaps)
    assert rail < end < before_rail / 2
