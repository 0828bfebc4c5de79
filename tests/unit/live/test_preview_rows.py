"""The lines of a preview: differences, marked lines, and findings that are new."""

from pathlib import Path

import pytest
from scanrack.io_images.site import Site, SiteError
from scanrack.ladder import LadderError
from scanrack.ladder.files import parse_program
from scanrack.watch.preview import mistakes_of, new_findings, rows_of

LONG = "\n".join(f"line {number}" for number in range(1, 31))


def drawn(rows):
    return [f"{row['sign']}{row['text']}" if row["text"] is not None else "..." for row in rows]


def test_three_lines_are_shown_around_a_change_and_one_around_a_mark():
    after = LONG.replace("line 10\n", "line ten\n").replace("line 30", "line 30\nline 31")
    rows = rows_of(LONG, after, [("new", 20), ("old", None)])
    assert drawn(rows) == [
        *[f" line {number}" for number in (7, 8, 9)],
        "-line 10",
        "+line ten",
        *[f" line {number}" for number in (11, 12, 13)],
        "...",
        *[f" line {number}" for number in (19, 20, 21)],
        "...",
        *[f" line {number}" for number in (28, 29, 30)],
        "+line 31",
    ]
    assert [(row["old"], row["new"]) for row in rows if row["sign"] != " "] == [
        (10, None),
        (None, 10),
        (None, 31),
    ]


def test_a_line_of_the_first_text_can_be_marked():
    assert drawn(rows_of(LONG, LONG, [("old", 5)])) == [" line 4", " line 5", " line 6"]


def test_equal_texts_have_no_rows_and_texts_without_a_common_line_all():
    assert rows_of(LONG, LONG) == rows_of("", "") == []
    assert drawn(rows_of("a\nb", "c")) == ["-a", "-b", "+c"]


def test_much_that_differs_is_shown_without_comparing_each_line():
    one, other = ("\n".join(f"{word} {n % 7}" for n in range(3000)) for word in ("a", "b"))
    assert [row["sign"] for row in rows_of(one, other)] == ["-"] * 3000 + ["+"] * 3000


def test_findings_that_were_there_before_are_left_out_whatever_their_line():
    known = [{"line": 3, "rule": "a", "text": "x"}, {"line": 4, "rule": "a", "text": "x"}]
    found = [{"line": 5, "rule": "a", "text": "x"}, *known, {"line": 9, "rule": "b", "text": "x"}]
    assert [each["line"] for each in new_findings(found, known)] == [4, 9]


def test_mistakes_come_one_by_one_with_their_lines():
    text = "PROGRAM L\nTAG Go : BOOL\nROUTINE Main\nXIC(A)OTE(Go);\nXIC(Go)OTE(B);\nEND\n"
    with pytest.raises(LadderError) as refused:
        parse_program(text, file="line.rung").build()
    found = mistakes_of(refused.value, Path("line.rung"))
    assert [(each["line"], each["text"].partition(" (")[0]) for each in found] == [
        (4, "XIC(A): no tag A"),
        (5, "OTE(B): no tag B"),
    ]


def test_a_mistake_in_another_file_has_no_line_here():
    error = SiteError.at(Site(file="other.py", line=3), "no")
    assert mistakes_of(error, Path("line.py")) == [{"text": "no", "file": "line.py", "line": None}]
    assert mistakes_of(ValueError("odd"), Path("line.py"))[0]["text"] == "odd"
