"""What no export has is refused with an error of the import's own."""

from itertools import pairwise
from pathlib import Path

import pytest
from l5x_files import (
    HEAD,
    alias,
    data_type,
    document,
    ladder,
    machine,
    member,
    module,
    program,
    structured,
    tag,
    task,
)
from scanrack.ladder import LadderError
from scanrack.ladder.model.tree import LEVELS
from scanrack.rockwell.l5x import L5xError, import_l5x
from scanrack.rockwell.l5x.importer import Importer
from scanrack.rockwell.l5x.trial import run_trial
from scanrack.rockwell.l5x.xml.document import parse_document
from scanrack.rockwell.l5x.xml.parsing import MOST_BYTES, MOST_MARKS

DOCTYPE = "<!DOCTYPE RSLogix5000Content>"


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "not XML"),
        (b"SOR XIC B3/0 EOR", "not XML"),
        (b"\xff\xff\xff", "not UTF-8"),
        (HEAD.encode() + b"<RSLogix5000Content>", "not XML"),
        (HEAD.encode() + b"<Project/>", "its root is Project"),
        (HEAD.encode() + b"<RSLogix5000Content/>", "it has no Controller"),
        ((HEAD + DOCTYPE + "<RSLogix5000Content/>").encode(), "DOCTYPE"),
        ((HEAD + "<!-- --> " + DOCTYPE + "<RSLogix5000Content/>").encode(), "DOCTYPE"),
        ((HEAD + DOCTYPE + "<RSLogix5000Content/>").encode("utf-16"), "DOCTYPE"),
        (b"<a>" * 257, "not XML"),
        (b" " * (MOST_BYTES + 1), "bytes"),
        (b"<RSLogix5000Content>" + b"<a/>" * (MOST_MARKS + 1), "tags, attributes and texts"),
    ],
)
def test_refused(data, says):
    with pytest.raises(L5xError, match=says) as caught:
        parse_document(data, "machine.L5X")
    assert str(caught.value).startswith("machine.L5X")


def test_the_line_is_named():
    text = machine("NOP();").replace("</Programs>", "</Program>")
    with pytest.raises(L5xError) as caught:
        parse_document(text.encode(), "machine.L5X")
    assert caught.value.site.line == 1 + text[: text.index("</Program>\n<Tasks>")].count("\n")


def test_missing_file(tmp_path):
    with pytest.raises(L5xError, match="can't be read"):
        import_l5x(tmp_path / "none.L5X")


@pytest.mark.parametrize(
    "rung",
    [
        "XIC(" + "A[" * (LEVELS + 1) + "0" + "]" * (LEVELS + 1) + ")OTE(B);",
        "[" * (LEVELS + 1) + "NOP()" + "]" * (LEVELS + 1) + ";",
        "CPT(A," + "(" * (LEVELS + 1) + "1" + ")" * (LEVELS + 1) + ");",
    ],
)
def test_nesting_is_refused_in_its_rung(tmp_path, rung):
    path = tmp_path / "deep.L5X"
    path.write_text(machine(rung, "NOP();"), encoding="utf-8")
    report = import_l5x(path, trial=True).report
    assert [each.rung for each in report.refused] == [0]


def test_empty_and_strange_parts(tmp_path):
    path = tmp_path / "strange.L5X"
    odd = """<Routine Name="No name" Type="RLL"/><Routine/>
<Routine Name="X" Type="RLL"><RLLContent><Rung/></RLLContent></Routine>"""
    path.write_text(
        document(programs=[program("A", odd), program("A", odd), program("", odd)], tags=["<Tag/>"]),
        encoding="utf-8",
    )
    report = import_l5x(path, trial=True).report
    assert report.imported + len(report.refused) == report.rungs == 3


def imported(tmp_path, text):
    path = tmp_path / "large.L5X"
    path.write_text(text, encoding="utf-8")
    return import_l5x(path, trial=True)


def test_types_that_double_at_each_level(tmp_path):
    names = [f"T{number}" for number in range(18)]
    types = [data_type("T0", member("A", "DINT"), member("B", "DINT"))]
    for inner, outer in pairwise(names):
        types.append(data_type(outer, member("A", inner), member("B", inner)))
    report = imported(tmp_path, machine("NOP();", types=types, tags=[tag("X", "T17"), tag("Y", "T9")])).report
    assert [each.name for each in report.notes] == ["X"]
    assert "data type T16 takes 176 MiB; 128 MiB are allowed" in report.notes[0].text  # 2 ** 17 paths


def test_types_that_stand_in_one_another(tmp_path):
    types = [data_type("T0", member("A", "DINT"))]
    types += [data_type(f"T{number}", member("A", f"T{number - 1}")) for number in range(1, 67)]
    report = imported(tmp_path, machine("NOP();", types=types, tags=[tag("X", "T66")])).report
    assert "is nested in 64 others" in report.notes[0].text


MIB = 1 << 20


@pytest.mark.parametrize(
    ("count", "says"),
    [
        (MIB // 8 - 351, ""),  # 8 bytes a value, and 1,400 for a name: C[] and A
        (MIB // 8, "it takes 2 MiB; 1 MiB are allowed (--memory)"),
    ],
)
def test_a_tag_one_step_beyond_the_memory_is_the_reason_of_its_rungs(tmp_path, count, says):
    path = tmp_path / "large.L5X"
    tags = [tag("C", "DINT", str(count)), tag("A", "DINT")]
    path.write_text(machine("MOV(C[1],A);", "MOV(1,A);", tags=tags), encoding="utf-8")
    report = import_l5x(path, memory_mib=1).report
    assert [each.text for each in report.notes] == ([f"it is not declared: {says}"] if says else [])
    assert [each.reason for each in report.refused] == ([f"tag C is not declared: {says}"] if says else [])


def test_tags_that_take_more_memory_together_than_is_allowed(tmp_path):
    path = tmp_path / "large.L5X"
    tags = [tag(f"X{number}", "BOOL", "60000") for number in range(3)]
    path.write_text(machine("NOP();", tags=tags), encoding="utf-8")
    (note,) = import_l5x(path, memory_mib=1).report.notes
    assert (note.name, note.text) == (
        "X2",
        "it is not declared: the tags of the file take more than the 1 MiB that are allowed (--memory)",
    )


def test_strings_of_64000_characters(tmp_path):
    """Two real controllers have them."""
    long = data_type("Long", member("LEN", "DINT"), member("DATA", "SINT", 64_000), family="StringFamily")
    both = data_type("Both", member("A", "Long"), member("B", "Long"))
    text = machine("COP(T.A,T.B,1);", types=[long, both], tags=[tag("T", "Both")])
    assert (imported(tmp_path, text).report.refused, imported(tmp_path, text).report.notes) == ([], [])


def test_parts_of_one_name_are_one_note_with_their_number(tmp_path: Path) -> None:
    path = tmp_path / "x.L5X"
    parts = "<a/>\n" * 1000
    path.write_text(
        f'<RSLogix5000Content><Controller Name="x">{parts}</Controller></RSLogix5000Content>',
        encoding="utf-8",
    )
    (note,) = import_l5x(path).report.notes
    assert str(note) == "a: this part of the controller is kept, but not read (line 1, 1000 times)"


@pytest.mark.parametrize("number", ["²", "9" * 10, "", "-1", "1e3"])
def test_what_is_no_number_is_none(number):
    """`"²".isdigit()` holds, and int() refuses it; a number has nine digits at most."""
    shown = (
        '<InputTag><Data Format="Decorated"><Structure DataType="AB:x:I:0"><ArrayMember Name="Data" '
        f'DataType="DINT" Dimensions="{number}"/></Structure></Data></InputTag>'
    )
    text = document(
        modules=[module("M", 1, shown).replace('Address="1"', f'Address="{number}"')],
        programs=[program("P", ladder("Main", "NOP();"))],
        tasks=[task("T", "P").replace('Priority="10"', f'Priority="{number}"')],
        tags=[
            f'<Tag Name="S" DataType="STRING"><Data Format="L5K">[{number},\'a\']</Data></Tag>',
        ],
    )
    report = Importer(parse_document(text.encode(), "machine.L5X")).run(trial=True).report
    assert (report.rungs, report.refused) == (1, [])


def test_a_tag_may_be_called_underscore():
    """Its identifier in the compiled program was empty."""
    text = machine("XIC(_)OTE(_);", "XIO(__)OTE(__);", tags=[tag("_", "BOOL"), tag("__", "BOOL")])
    imported = Importer(parse_document(text.encode(), "machine.L5X")).run(trial=True)
    run_trial(imported, scans=2)
    assert (imported.report.ran, imported.report.faults) == (2, {})


@pytest.mark.parametrize(("first", "second"), [("B[A]", "B[0]"), ("B[C]", "B[A]"), ("B[A.1]", "B[0]")])
def test_an_alias_that_is_its_own_subscript_is_refused_in_its_rung(first, second):
    tags = [alias("A", first), alias("C", second), tag("B", "DINT", "5")]
    text = machine("MOV(1,A);", "NOP();", tags=tags)
    report = Importer(parse_document(text.encode(), "machine.L5X")).run(trial=True).report
    assert report.imported >= 1
    assert report.imported + len(report.refused) == report.rungs


@pytest.mark.slow
def test_more_branches_than_python_compiles_are_an_error_of_ours():
    choices = "".join(f"{number}: N := {number};\n" for number in range(7000))
    text = document(
        tags=[tag("N", "DINT")],
        programs=[program("P", structured("Main", f"CASE N OF\n{choices}END_CASE;"))],
        tasks=[task("T", "P")],
    )
    imported = Importer(parse_document(text.encode(), "machine.L5X")).run(trial=True)
    with pytest.raises(LadderError, match="too many branches"):
        run_trial(imported, scans=1)
