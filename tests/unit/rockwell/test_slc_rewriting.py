"""Edited rungs in an export of RSLogix 500: they read back, and every other line stays.

Broken on purpose: a comment of a deleted rung that goes to the next one, a new rung between a rung and its
description, a rung of two lines of which one stays, letters of RSLogix that are lost, a rung that takes
another one of its line with it, a division that becomes an OR.
"""

import pytest
from scanrack.ladder import LadderError, parse_rung
from scanrack.ladder.instructions.slc import SLC_SPECS
from scanrack.ladder.lowering.edited import BEFORE_FIRST, NewTag, RungEdit
from scanrack.rockwell.slc import import_text
from scanrack.rockwell.slc.rewriting import program_text, rewritten_slc

TEXT = """\
PROJECT "LINE"
SLOT 1 OTHER 3 2 2
LADDER 2 "MAIN"
% first %
% of two lines
below %
SOR XIC I:1/0 % inside %
    OTE B3/0 EOR % behind %
% RUNG DESCRIPTION: describes the first
%
% second %
SOR XIC B3:0/1 OTE B3:0/2 EOR

SOR BST XIC B3:0/3 NXB XIC T4:0/DN BND TON T4:0 1.0 5 0 EOR
LADDER 3 "SUB"
DATA N7:0 0 0 0
DATA B3:0 0 0
DATA T4:0 0 5 0
"""


def rewritten(*edits, text=TEXT, tags=()):
    data = rewritten_slc(text.encode(), edits, tags, SLC_SPECS).data
    found = import_text(data.decode(), "line", slots=[1])
    assert not found.report.refused, list(map(str, found.report.refused))
    assert found.program is not None
    return data.decode(), [(str(each), each.comment) for each in found.program.routines[0].rungs]


def lines_between(text, other):
    """Return the lines that only one of two texts has."""
    return sorted(set(text.splitlines()) ^ set(other.splitlines()))


def test_a_changed_rung_keeps_its_comments_and_all_other_lines():
    text, rungs = rewritten(RungEdit("U2", 0, ("XIO(I:1.0/1)OTE(B3:0/0);",)))
    first = "first\nof two lines\nbelow\ndescribes the first"
    assert rungs[0] == ("XIO(I:1.0/1)OTE(B3:0/0);", first)
    gone, new = (
        ["    OTE B3/0 EOR % behind %", "SOR XIC I:1/0 % inside %"],
        "SOR XIO I:1.0/1 OTE B3:0/0 EOR % behind %",
    )
    assert lines_between(TEXT, text) == sorted([*gone, new])


def test_a_deleted_rung_takes_its_comments_with_it():
    text, rungs = rewritten(RungEdit("U2", 0, ()))
    assert rungs[0] == ("XIC(B3:0/1)OTE(B3:0/2);", "second")
    assert len(rungs) == 2
    assert text == TEXT.replace(TEXT[TEXT.index("% first") : TEXT.index("% second")], "")


def test_a_description_below_an_empty_line_stays_with_its_rung():
    described = TEXT.replace("% RUNG DESCRIPTION", "\n% RUNG DESCRIPTION")
    text, rungs = rewritten(RungEdit("U2", 0, ()), text=described)
    assert rungs[0] == ("XIC(B3:0/1)OTE(B3:0/2);", "second")
    assert text == TEXT.replace(TEXT[TEXT.index("% first") : TEXT.index("% second")], "")
    _, rungs = rewritten(
        RungEdit("U2", 0, ("XIC(I:1.0/0)OTE(B3:0/0);", "XIC(B3:0/5)RES(T4:0);")), text=described
    )
    assert rungs[0][1].endswith("describes the first")
    assert rungs[1] == ("XIC(B3:0/5)RES(T4:0);", "")


def test_comments_beside_a_rung_stay_whatever_they_say():
    text = TEXT.replace("% inside %", "% up to EOR %").replace("% behind %", "% not SOR, not EOR here %")
    text, rungs = rewritten(RungEdit("U2", 0, ("XIO(I:1.0/1)OTE(B3:0/0);",)), text=text)
    assert rungs[0][0] == "XIO(I:1.0/1)OTE(B3:0/0);"
    assert "SOR XIO I:1.0/1 OTE B3:0/0 EOR % not SOR, not EOR here %\n" in text


def test_a_rung_is_added_behind_a_last_line_without_an_end():
    text = TEXT[: TEXT.index("LADDER 3")].rstrip("\n")
    written = rewritten_slc(
        text.encode(),
        [RungEdit("U2", 2, ("XIC(B3:0/3)TON(T4:0,1.0,7,0);", "XIC(B3:0/5)RES(T4:0);"))],
        (),
        SLC_SPECS,
    ).data.decode()
    assert written.endswith(" 7 0 EOR\nSOR XIC B3:0/5 RES T4:0 EOR\n")


def test_new_rungs_stand_behind_descriptions_and_before_the_first_comment():
    _, rungs = rewritten(
        RungEdit("U2", 0, ("XIC(I:1.0/0)OTE(B3:0/0);", "XIC(B3:0/5)RES(T4:0);")),
        RungEdit("U2", BEFORE_FIRST, ("MOV(5,N7:1);",)),
        RungEdit("U2", 2, ("[XIC(B3:0/3),XIC(T4:0.DN)]TON(T4:0,1.0,7,0);", "JSR(U3);")),
    )
    assert [text for text, _ in rungs] == [
        "MOV(5,N7:1);",
        "XIC(I:1.0/0)OTE(B3:0/0);",
        "XIC(B3:0/5)RES(T4:0);",
        "XIC(B3:0/1)OTE(B3:0/2);",
        "[XIC(B3:0/3),XIC(T4:0.DN)]TON(T4:0,1.0,7,0);",
        "JSR(U3);",
    ]
    assert [comment.splitlines()[-1:] for _, comment in rungs] == [
        [], ["describes the first"], [], ["second"], [], [],
    ]  # fmt: skip


def test_letters_and_line_ends_of_the_file_stay():
    data = TEXT.replace("describes", "beschr\xe4nkt \u2013").replace("\n", "\r\n").encode("cp1252")
    data = data.replace(b"second", b"\x81\x8d")  # no letters of Windows-1252
    edit = RungEdit("U2", 1, ("XIC(B3:0/9)OTE(B3:0/2);",))
    written = rewritten_slc(data, [edit], [], SLC_SPECS).data
    assert written == data.replace(b"SOR XIC B3:0/1", b"SOR XIC B3:0/9")


@pytest.mark.parametrize(
    ("text", "edit", "tags", "why"),
    [
        (TEXT, RungEdit("U2", 3, ()), (), "routine U2 has no rung 3"),
        (TEXT, RungEdit("Main", 0, ()), (), "routine Main has no rung 0"),
        (TEXT, RungEdit("U2", 0, ()), (NewTag("N9", "INT"),), "N9 is not a data file"),
        (TEXT.replace("EOR\n\nSOR", "EOR SOR"), RungEdit("U2", 1, ()), (), "its own lines"),
    ],
)
def test_what_the_file_does_not_have_is_refused(text, edit, tags, why):
    with pytest.raises(LadderError, match=why):
        rewritten_slc(text.encode(), [edit], tags, SLC_SPECS)


@pytest.mark.parametrize(
    ("typed", "wanted"),
    [
        ("XIC(B3/17)OTE(O:2/1);", "XIC(B3:1/1)OTE(O:2.0/1);"),
        ("xic(I:1/19);", "xic(I:1.1/3);"),
        ("MOV(N7:[N7:1],#N7:0);", "MOV(N7[N7:1],N7[0+S:24]);"),
        ("COP(#N7:0,#N10:2,5);", "COP(N7:0,N10:2,5);"),
        ("TON(T4:0,0.01,?,0);", "TON(T4:0,0.01,?,0);"),
        ("CPT(N7:0,(N7:0 + N7:1) | N7:2);", "CPT(N7:0,(N7:0+N7:1)/N7:2);"),
        ("[XIC(B3/0),JSR(U:3)]JSR(U3);", "[XIC(B3:0/0),JSR(U3)]JSR(U3);"),
        ("XIC(B3/DN);", "XIC(B3/DN);"),  # no address: the reader of rungs says what is wrong
    ],
)
def test_addresses_are_typed_as_in_rslogix(typed, wanted):
    assert program_text(typed, SLC_SPECS) == wanted
    if "?" not in wanted and "/DN" not in wanted:
        assert str(parse_rung(wanted, specs=SLC_SPECS)).upper() == wanted.upper()
