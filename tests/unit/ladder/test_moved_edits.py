"""Edits of rungs follow their rungs into a program that others have edited.

Broken on purpose: an edit that stays at its number, a rung of another's that an edit takes back, a new rung
that is lost with the rung before it, an edit that the program has already, an edit of a changed rung that
is not counted.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.ladder.files import parse_program
from scanrack.ladder.lowering.edited import BEFORE_FIRST, RungEdit
from scanrack.ladder.lowering.rebase import moved


def program(letters):
    rungs = "\n".join(f"OTL({each});" for each in letters)
    tags = "\n".join(f"TAG {each} : BOOL" for each in "ABCDEFXYZ")
    return parse_program(f"PROGRAM P\n{tags}\nROUTINE Main\n{rungs}\nEND\n")


def edits_of(changes):
    return [
        RungEdit("Main", at, tuple(f"OTL({each});" for each in letters)) for at, letters in changes.items()
    ]


def applied(letters, edits):
    """Return the letters of a program with edits."""
    by_rung = {each.rung: "".join(text[4] for text in each.texts) for each in edits}
    return "".join([by_rung.get(BEFORE_FIRST, ""), *(by_rung.get(at, own) for at, own in enumerate(letters))])


@pytest.mark.parametrize(
    ("before", "after", "changes", "wanted", "conflicts"),
    [
        ("ABC", "XABC", {1: "Y"}, "XAYC", 0),  # a rung before it
        ("ABC", "AC", {2: "Y", 0: "Z"}, "ZY", 0),  # one between them is gone
        ("ABC", "AXC", {1: "Y"}, "AYC", 1),  # both changed it
        ("ABC", "AXC", {1: "BY"}, "AXYC", 0),  # a new rung behind one that the other changed
        ("ABC", "AC", {1: "BY"}, "AYC", 1),  # behind one that is gone
        ("ABC", "AC", {1: "Y", 0: "AZ"}, "AZYC", 1),  # the changed one is gone, and stands behind both
        ("ABC", "BC", {0: "Y"}, "YBC", 1),  # the first one is gone
        ("ABC", "AC", {1: ""}, "AC", 0),  # both deleted it
        ("ABC", "AXC", {1: ""}, "AC", 1),  # deleted here, changed there
        ("ABC", "AYC", {1: "Y", 2: "Z"}, "AYZ", 0),  # the same change
        ("ABC", "XBC", {BEFORE_FIRST: "Y"}, "YXBC", 0),
        ("AB", "AXB", {0: "AX", 1: "Y"}, "AXY", 0),  # the same new rung
        ("AB", "ABXY", {1: "BXY"}, "ABXY", 0),
        ("AB", "XAB", {BEFORE_FIRST: "X"}, "XAB", 0),
        ("AB", "AXB", {0: "AXY"}, "AXYXB", 0),  # another one
    ],
)
def test_an_edit_follows_its_rung(before, after, changes, wanted, conflicts):
    found = moved(program(before), program(after), edits_of(changes))
    assert (applied(after, found.edits), found.conflicts) == (wanted, conflicts)
    assert all(each.texts != (f"OTL({after[each.rung]});",) for each in found.edits if each.rung >= 0)


@given(
    before=st.text("ABCDEF", min_size=1, max_size=6),
    after=st.text("ABCDEF", min_size=1, max_size=6),
    changes=st.dictionaries(st.integers(0, 5), st.text("XYZ", min_size=1, max_size=2)),
)
def test_no_typed_rung_is_lost(before, after, changes):
    changes = {at: letters for at, letters in changes.items() if at < len(before)}
    found = moved(program(before), program(after), edits_of(changes))
    left = sorted(each for each in applied(after, found.edits) if each in "XYZ")
    assert left == sorted("".join(changes.values()))
