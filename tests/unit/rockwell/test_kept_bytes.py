"""What goes into an export comes out of it: a copy has the same bytes, an edit changes its element only.

Broken on purpose: a byte order mark that is lost, a rung that loses the blanks around its text, a number that
is set again, an encoding that becomes UTF-8, a routine that is only referred to and is edited, an edit of a
comment that looks like a rung.
"""

from dataclasses import replace
from html import escape
from pathlib import Path

import pytest
from l5x_files import HEAD, cdata, data_type, document, ladder, machine, member, program, rung, tag
from real_mix import real_controller
from scanrack.commands import build
from scanrack.ladder import LadderError, parse_rung
from scanrack.ladder.instructions.slc import SLC_SPECS
from scanrack.ladder.lowering.edited import BEFORE_FIRST, FileChange, NewTag, RungEdit, normalized
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.partial import partial_l5x
from scanrack.rockwell.l5x.rewriting import rewritten_l5x
from scanrack.rockwell.l5x.xml.document import parse_document
from scanrack.rockwell.slc import export_text, import_slc, import_text
from scanrack.rockwell.slc.rewriting import rewritten_slc
from slc_files import FUNCTION_FILES, elements, export, forces, texts, words
from slc_files import ladder as slc_ladder
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
FILES = sorted(
    each
    for folder in ("examples", "benchmarks", "tests")
    for each in (ROOT / folder).rglob("*")
    if each.suffix.upper() in (".L5X", ".SLC")
)
UNKNOWN = """<SafetyInfo SafetyLocked="false" SignatureRunModeProtect="false"/>
<!-- <Programs><Program Name="Main"/></Programs> --><AlarmDefinitions>
<DatatypeAlarmDefinition Name="P_PID"><MemberAlarmDefinition Name="A" Input=".Sts"/></DatatypeAlarmDefinition>
</AlarmDefinitions>
<Library><EncodedData EncodedType="Library" Name="L" EncryptionConfig="7">
QUJD+/8=
</EncodedData></Library>
<Tags HMIBC = 'a > b'><Tag Name="T" TagType="Base" DataType="HMIBC" Constant="true" Radix="Hex"/></Tags>"""
"""What this version does not know, quotes of both kinds, and a comment that looks like a program."""

TEXT = machine("XIC(A)OTE(B);", tags=[tag("A", "BOOL"), tag("B", "BOOL")]).replace(
    "<Programs>", f"{UNKNOWN}<Programs>"
)


def coded(text, encoding, *, bom=b"", newline="\n"):
    return bom + text.replace("UTF-8", encoding).replace("\n", newline).encode(encoding)


BYTES = {
    "plain": TEXT.encode(),
    "windows": coded(TEXT, "utf-8", bom=b"\xef\xbb\xbf", newline="\r\n"),
    "utf-16": coded(TEXT, "utf-16"),
    "utf-16 without a mark": coded(TEXT, "utf-16-be"),
    "latin": coded(TEXT.replace('Name="L"', 'Name="Größe"'), "iso-8859-1"),
    "blanks": b"\xef\xbb\xbf\n \t" + TEXT.encode() + b"\n\n<!-- end -->\n  ",
    "partial": document(
        target="Routine",
        programs=[program("P", ladder("R", "JSR(Out,0);XIC(A)OTE(B);", use='Use="Target" '))],
    ).encode(),
    "real": real_controller(60, 200).encode(),
}


SLC = export(
    slc_ladder(
        2, "XIC B3:0/0 OTE B3/17", "JSR U:3", "BST XIC T4:0/DN NXB XIC N7:[N7:1] BND TON T4:0 1.0 5 0"
    ),
    slc_ladder(3, "XIC B3:0/2 OTE B3:0/3", "XIC B3:0/2 JSR U:9"),
    words("B3", ["0X0001", "0XFFFF"]),
    words("F8", ["1.5e-05", "1.#QNAN", "-0"]),
    elements("T4", [("0XA200", 60, 17)]),
    texts("ST9", "it's $5 100%", ""),
    forces("O:03", ("0X0000", "0XFFFF"), ("0X0001", "0XFFFF")),
    FUNCTION_FILES,
    names={2: "MAIN", 3: "Größe"},
)


def command(*words):
    return CliRunner().invoke(build(), ["l5x", *map(str, words)])


def copied(file, data):
    """Return the bytes that `--out` writes for a file."""
    file.write_bytes(data)
    copy = file.with_stem("copy")
    done = command(file, "--out", copy)
    assert (done.exit_code, done.stdout) == (0, f"{copy}: {len(data):,} bytes, identical to {file}\n")
    return copy.read_bytes()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_a_copy_of_a_file_has_its_bytes(path, tmp_path):
    data = path.read_bytes()
    assert copied(tmp_path / path.name, data) == data


@pytest.mark.parametrize("name", BYTES)
def test_a_copy_has_its_bytes(name, tmp_path):
    assert copied(tmp_path / "machine.L5X", BYTES[name]) == BYTES[name]


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_a_copy_of_an_slc_has_its_bytes(tmp_path, encoding, newline):
    text = SLC.replace("PROJECT", "ANYTHING 1 2 3\nPROJECT", 1) + "\n \n"
    data = text.replace("\n", newline).encode(encoding)
    assert copied(tmp_path / "machine.SLC", data) == data


def edited_rungs(path, data):
    """Yield routine, number and text of each rung of an L5X, and a file of it with the rung edited."""
    path.write_bytes(data)
    imported = import_l5x(path)
    for routine in imported.controller.routines if imported.controller else ():
        for number in range(len(routine.rungs)):
            edit = RungEdit(routine.name, number, ("XIC(Edited)NOP();",))
            yield routine.name, number, rewritten_l5x(data, [edit])


@pytest.mark.slow
@pytest.mark.parametrize("name", [*BYTES, *(each.name for each in FILES if each.suffix == ".L5X")])
def test_an_edited_rung_changes_its_text_only(name, tmp_path):
    data = BYTES.get(name) or next(each for each in FILES if each.name == name).read_bytes()
    encoding = (
        "utf-16-be" if "without" in name else {"utf-16": "utf-16", "latin": "latin-1"}.get(name, "utf-8")
    )
    before = data.decode(encoding)
    count = 0
    for routine, number, (written, changes) in edited_rungs(tmp_path / "x.L5X", data):
        after = written.decode(encoding)
        begin = after.index("XIC(Edited)NOP();")
        end = begin - len(after)
        assert before[:begin] == after[:begin]
        tail = after[begin + len("XIC(Edited)NOP();") :]
        assert before.endswith(tail)
        gone = before[begin : len(before) - len(tail)]
        assert gone.endswith(";")
        assert not {"<", "]"} & set(gone.replace("]XIC", "").replace("]", "", gone.count("["))), (gone, end)
        assert f'<Rung Number="{number}"' in before[before.rindex("<Rung ", 0, begin) : begin]
        assert changes == (FileChange(f"{routine} rung {number}", "its text is edited"),)
        count += 1
    assert count or name == "partial"


MANY = document(
    tags=[tag("A", "BOOL")],
    programs=[
        program("Main", ladder("Main", "NOP();"), ladder("Step", *(f"XIC(A)OTE(A{n});" for n in range(4)))),
        program("Other", ladder("Step", "NOP();")),
    ],
)
STEP = r"\Main.Step"


def test_rungs_behind_a_new_one_have_other_numbers_and_the_changes_name_them():
    edits = [RungEdit(STEP, 1, ("XIC(A)OTE(A1);", "NOP();"), keeps=True), RungEdit(STEP, 3, ())]
    written, changes = rewritten_l5x(MANY.encode(), edits)
    new, old = rung("NOP();", number=2), [rung(f"XIC(A)OTE(A{n});", number=n) for n in range(4)]
    expected = MANY.replace(old[2] + old[3], new + old[2].replace('"2"', '"3"'))
    assert written.decode() == expected
    assert changes == (
        FileChange(rf"{STEP} rung 2", "it is new"),
        FileChange(rf"{STEP} rung 2", "it is rung 3 now"),
        FileChange(rf"{STEP} rung 3", "it is deleted"),
    )


def test_the_first_rung_and_numbers_that_do_not_begin_at_0():
    text = MANY.replace(
        '<Rung Number="0" Type="N">\n<Text>\n<![CDATA[XIC', '<Rung Type="N">\n<Text>\n<![CDATA[XIC'
    )
    for number in range(1, 4):
        text = text.replace(f'"{number}" Type', f'"{number + 10}" Type')
    edits = [RungEdit(STEP, BEFORE_FIRST, ("NOP();",)), RungEdit(STEP, 0, ()), RungEdit(STEP, 2, ())]
    written, _ = rewritten_l5x(text.encode(), edits)
    first = '<Rung Type="N">\n<Text>\n<![CDATA[XIC(A)OTE(A0);]]>\n</Text>\n</Rung>\n'
    third = rung("XIC(A)OTE(A2);", number=12)
    expected = text.replace(first, rung("NOP();")).replace(third, "").replace('"13" Type', '"12" Type')
    assert written.decode() == expected


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (
            "<RLLContent/>",
            '<RLLContent><Rung Number="0" Type="N">\n<Text>\n{}\n</Text>\n</Rung>\n</RLLContent>',
        ),
        ("", '<RLLContent>\n<Rung Number="0" Type="N">\n<Text>\n{}\n</Text>\n</Rung>\n</RLLContent>'),
    ],
)
def test_a_routine_without_rungs_gets_its_first_one(before, after):
    text = MANY.replace(ladder("Main", "NOP();"), f'<Routine Name="Main" Type="RLL">{before}</Routine>')
    written, _ = rewritten_l5x(text.encode(), [RungEdit(r"\Main.Main", BEFORE_FIRST, ("NOP();",))])
    inside = after.format(cdata("NOP();"))
    assert written.decode() == text.replace(f">{before}</Routine>", f">{inside}</Routine>", 1)


@pytest.mark.parametrize(
    ("rung_", "after"),
    [
        ('<Rung Number="0"/>', '<Rung Number="0"><Text>{}</Text></Rung>'),
        ('<Rung Number="0"><Text/></Rung>', '<Rung Number="0"><Text>{}</Text></Rung>'),
        ('<Rung Number="0"><Text> A;  </Text></Rung>', '<Rung Number="0"><Text> {}  </Text></Rung>'),
        ("<Rung\n Number = '0' ><Text></Text></Rung>", "<Rung\n Number = '0' ><Text>{}</Text></Rung>"),
    ],
)
def test_texts_of_any_shape_are_edited(rung_, after):
    text = f"{HEAD}<RSLogix5000Content><Controller><Programs><Program Name='P'><Routines><Routine Name='R'>"
    text += f"<RLLContent>{rung_}</RLLContent></Routine></Routines></Program></Programs></Controller>"
    text += "</RSLogix5000Content>"
    for new, shown in (("NOP();", cdata("NOP();")), ("CMP(A[B[0]]>1);", escape("CMP(A[B[0]]>1);"))):
        written, _ = rewritten_l5x(text.encode(), [RungEdit(r"\P.R", 0, (new,))])
        assert written.decode() == text.replace(rung_, after.format(shown))


def test_a_letter_that_the_encoding_lacks_is_written_by_its_number():
    edit = RungEdit(r"\Main.Main", 0, ("MSG(Łódź);",))
    written, _ = rewritten_l5x(BYTES["latin"], [edit])
    expected = BYTES["latin"].replace(b"<![CDATA[XIC(A)OTE(B);]]>", "MSG(&#321;ód&#378;);".encode("latin-1"))
    assert written == expected
    assert parse_document(written, "x.L5X").programs[0].routines[0].rungs[0].text == "MSG(Łódź);"


def test_new_tags_stand_behind_those_of_their_program():
    bare = MANY.replace("<Tags>\n</Tags>\n<Routines>", "<Description>d</Description>\n<Routines>")
    new = '<Tag Name="N" TagType="Base" DataType="DINT" Constant="false" ExternalAccess="Read/Write"/>\n'
    for text, old, wanted in (
        (MANY, "<Tags>\n</Tags>\n<Routines>", f"<Tags>\n{new}</Tags>\n<Routines>"),
        (bare, "</Description>\n<Routines>", f"</Description>\n<Tags>\n{new}</Tags>\n<Routines>"),
    ):
        written, changes = rewritten_l5x(text.encode(), [], [NewTag("N", "DINT", "Main")])
        assert written.decode() == text.replace(old, wanted, 1)
        assert changes == (FileChange("tag N", "it is new"),)


def line_of(begin):
    return 1 + MANY[: MANY.index(begin)].count("\n")


MAIN, OTHER = line_of('<Program Name="Main"'), line_of('<Program Name="Other"')
FIRST, SECOND = line_of('<Routine Name="Main"'), line_of('<Routine Name="Step"')


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (
            RungEdit(r"\Main.Gone", 0, ()),
            rf"x.L5X has no routine \\Main.Gone: it has Main \(line {FIRST}\), Step \(line {SECOND}\)",
        ),
        (
            RungEdit(r"\Gone.Step", 0, ()),
            rf"x.L5X has no program Gone: it has Main \(line {MAIN}\), Other \(line {OTHER}\)",
        ),
        (RungEdit(STEP, 4, ()), rf"x.L5X:{SECOND}: routine \\Main.Step has 4 rungs, none is 4"),
    ],
)
def test_an_edit_without_a_place_names_the_places_that_are_there(edit, says):
    with pytest.raises(LadderError, match=says):
        rewritten_l5x(MANY.encode(), [edit], file="x.L5X")


def test_a_routine_that_is_only_referred_to_is_not_edited():
    referred = '<Routine Use="Reference" Name="Step"/>'
    text = MANY.replace('<Routine Name="Step"', f'{referred}<Routine Name="Step"', 1)
    written, _ = rewritten_l5x(text.encode(), [RungEdit(STEP, 0, ("NOP();",))])
    assert written.decode() == text.replace("XIC(A)OTE(A0);", "NOP();", 1)
    only = MANY.replace(MANY[MANY.index('<Routine Name="Step"') : MANY.index("</Routines>")], referred)
    with pytest.raises(LadderError, match="no routine"):
        rewritten_l5x(only.encode(), [RungEdit(STEP, 0, ("NOP();",))])


def test_an_unchanged_first_text_keeps_the_notation_of_the_file(tmp_path):
    path = tmp_path / "x.L5X"
    text = machine("XIC( A )\n TON(T[N],500,0);", "NOP();", tags=[tag("A", "BOOL"), tag("T", "TIMER", "3")])
    path.write_text(
        text.replace("<Programs>", f"<Tags>{tag('N', 'DINT')}</Tags><Programs>"), encoding="utf-8"
    )
    logic = import_l5x(path).controller
    assert logic is not None
    routine = next(each for each in logic.routines if each.rungs)
    edit = normalized(RungEdit(routine.name.lower(), 0, (str(routine.rungs[0]), "nop();")), logic)
    assert edit.keeps
    assert edit.texts[1] == "NOP();"
    written, _ = rewritten_l5x(path.read_bytes(), [edit])
    assert b"XIC( A )\n TON(T[N],500,0);" in written
    other = normalized(RungEdit(routine.name, 1, ("XIC(A)NOP();",)), logic)
    assert not other.keeps


def test_one_rung_of_an_slc_changes_its_line(tmp_path):
    path = tmp_path / "x.SLC"
    data = SLC.encode()
    path.write_bytes(data)
    program_ = import_slc(path).program
    assert program_ is not None
    lines = data.splitlines(keepends=True)
    for routine in program_.routines:
        for number in range(len(routine.rungs)):
            edit = RungEdit(routine.name, number, ("XIC(B3:0/0)OTE(B3:0/1);",))
            written, changes = rewritten_slc(data, [edit], (), SLC_SPECS)
            assert len(set(written.splitlines(keepends=True)) - set(lines)) <= 1
            assert changes == (FileChange(f"{routine.name} rung {number}", "its text is edited"),)


# --- parts of a file


def attributes(text, begin):
    """Return the start tag that begins so."""
    at = text.index(begin)
    return text[at : text.index(">", at) + 1]


def test_a_program_is_exported_with_the_bytes_of_the_file(tmp_path):
    types = [data_type("U", member("V", "REAL"))]
    text = TEXT.replace("<DataTypes>\n", "<DataTypes>\n" + types[0]).replace(
        "<RSLogix5000Content ",
        '<RSLogix5000Content ExportOptions="NoRawData AllProjDocTrans" TargetRevision="1" ',
    )
    shown = partial_l5x(text.encode(), "Main").decode()
    head = attributes(shown, "<RSLogix5000Content")
    for each in (
        'TargetName="Main"',
        'TargetType="Program"',
        'ContainsContext="true"',
        "References NoRawData Context",
    ):
        assert each in head
    assert "TargetRevision" not in head
    assert "SafetyInfo" not in shown
    assert "Library" not in shown
    assert '<Tag Name="T" TagType="Base" DataType="HMIBC" Constant="true" Radix="Hex"/>' in shown
    assert types[0] in shown
    assert "<Tasks" not in shown
    at = text.index("<Routines>")
    assert text[at : text.index("</Program>")] in shown
    path = tmp_path / "part.L5X"
    path.write_text(shown, encoding="utf-8")
    again = import_l5x(path, trial=True)
    assert (again.report.target, again.report.complete) == ("Program", True)
    assert partial_l5x(shown.encode(), "main") == shown.encode()


def test_a_routine_is_exported_without_the_others():
    text = MANY.replace(
        '<Routine Name="Main"', '<Routine Use="Reference" Name="Out"/>\n<Routine Name="Main"', 1
    )
    shown = partial_l5x(text.encode(), "Main.Step").decode()
    step = text[text.index('<Routine Name="Step"') : text.index("</Routines>")]
    assert step.replace("<Routine ", '<Routine Use="Target" ', 1) in shown
    assert shown.count("<Routine ") == 2
    assert '<Routine Use="Reference" Name="Out"/>' in shown
    assert shown.count("<Program ") == 1
    assert '<Program Use="Context" Name="Main"' in shown
    assert partial_l5x(shown.encode(), "Main.Step") == shown.encode()
    whole = partial_l5x(shown.encode(), "Main").decode()
    assert step in whole
    assert 'TargetSubType="RLL"' in shown
    assert "TargetSubType" not in whole


def test_the_target_of_a_partial_export_is_the_file():
    data = BYTES["partial"]
    assert partial_l5x(data, "P.R") == data
    assert b"JSR(Out,0);" in partial_l5x(data, "P")


@pytest.mark.parametrize(
    ("words", "status", "says"),
    [
        (("--export", "Nope"), 2, "no program 'Nope'; choose from Main"),
        (("--out", "machine.L5X"), 2, "export that is read"),
        (("--out", "notes.txt"), 2, "notes.txt"),
        (("--out", "none/copy.L5X"), 3, "none"),
    ],
)
def test_what_can_not_be_written(tmp_path, monkeypatch, words, status, says):
    monkeypatch.chdir(tmp_path)
    Path("machine.L5X").write_text(TEXT, encoding="utf-8")
    Path("notes.txt").write_text("mine", encoding="utf-8")
    done = command("machine.L5X", *words)
    assert (done.exit_code, says in done.stderr) == (status, True), done.stderr
    assert Path("machine.L5X").read_text(encoding="utf-8") == TEXT
    assert Path("notes.txt").read_text(encoding="utf-8") == "mine"


def test_a_part_is_written_to_a_file_or_printed_with_the_same_bytes(tmp_path):
    file, out = tmp_path / "machine.L5X", tmp_path / "part.L5X"
    file.write_bytes(BYTES["windows"])
    assert command(file, "--export", "Main", "-o", out).exit_code == 0
    assert out.read_bytes() == command(file, "--export", "Main").stdout_bytes
    assert out.read_bytes() == partial_l5x(BYTES["windows"], "Main")
    assert command(file, "--out", out).exit_code == 0  # an export replaces an export
    assert out.read_bytes() == BYTES["windows"]


def test_a_program_made_here_has_no_file_to_copy(tmp_path):
    file = tmp_path / "line.rung"
    file.write_text("PROGRAM line\nROUTINE Main\nNOP();\nEND\n", encoding="utf-8")
    done = command(file, "--out", tmp_path / "x.L5X")
    assert (done.exit_code, "--export" in done.stderr) == (2, True)
    assert command(file, "--export", "line", "--out", tmp_path / "x.L5X").exit_code == 0
    assert import_l5x(tmp_path / "x.L5X").report.imported == 1


def test_what_no_export_has_is_refused_here_too():
    for data in (b"<a>" * 300, b"<!DOCTYPE a><RSLogix5000Content/>", b"\xff", b"<RSLogix5000Content>&b;"):
        with pytest.raises(LadderError):
            rewritten_l5x(data, [])
        with pytest.raises(LadderError):
            partial_l5x(data, "Main")
    deep = b"<RSLogix5000Content>" + b"<a>" * 300 + b"</a>" * 300 + b"</RSLogix5000Content>"
    with pytest.raises(LadderError, match="deep"):
        rewritten_l5x(deep, [])


# --- what this version does not know


def test_what_is_not_read_is_named_and_stops_nothing(tmp_path):
    encoded = '<EncodedData EncodedType="{0}" Name="{1}" EncryptionConfig="7">QUJD</EncodedData>'
    inside = f'<Routine Name="Enc" Type="RLL">{encoded.format("Routine", "Enc")}</Routine>'
    text = (
        TEXT.replace("</Routines>", f"{inside}{encoded.format('Routine', 'Other')}</Routines>", 1)
        .replace(
            "<DataTypes>", f"{encoded.format('Library', 'Lib')}<DataTypes>{encoded.format('DataType', 'D')}"
        )
        .replace("XIC(A)OTE(B);", "XIC(A)OTE(B)ADD(N,1,N);", 1)
        .replace("<Tasks>", f"<Tags>{tag('N', 'ULINT')}</Tags><Tasks>", 1)
        .replace('<Tag Name="A"', '<Tag NewAttribute="1" Name="A"', 1)
    )
    path = tmp_path / "x.L5X"
    path.write_text(text, encoding="utf-8")
    report = import_l5x(path, trial=True).report
    named = {each.name for each in report.notes if "kept, but not read" in each.text}
    assert named == {
        *("SafetyInfo", "AlarmDefinitions", "Library", "EncodedData Library Lib", "EncodedData DataType D"),
        *("HMIBC", "NewAttribute"),
    }
    assert {each.routine for each in report.objects} == {"Enc", "Other"}
    assert (report.rungs, report.imported) == (1, 1)
    assert copied(path, path.read_bytes()) == text.encode()


def test_a_whole_file_of_today_has_nothing_that_is_not_read():
    for path in (each for each in FILES if each.suffix == ".L5X"):
        assert parse_document(path.read_bytes(), path.name).others == ()


# --- SLC


def test_the_text_of_an_imported_slc_is_the_file_with_the_rungs_that_differ(tmp_path):
    path = tmp_path / "x.SLC"
    path.write_text(SLC, encoding="cp1252")
    found = import_slc(path)
    program_ = found.program
    assert program_ is not None
    assert export_text(program_, found.document) == SLC  # the rung that calls file 9 is refused, and stays
    first, second = program_.routines
    edited = parse_rung("XIC(B3:0/5)OTE(B3:1/1);", specs=SLC_SPECS)
    new = parse_rung("XIC(B3:0/6)OTE(B3:1/2);", specs=SLC_SPECS)
    program_.routines[0] = replace(first, rungs=(edited, *first.rungs[1:], new))
    program_.routines[1] = replace(second, rungs=second.rungs[1:])
    again = import_text(export_text(program_, found.document), "x").program
    assert again is not None
    assert [[str(rung_) for rung_ in each.rungs] for each in again.routines] == [
        [str(rung_) for rung_ in each.rungs] for each in program_.routines
    ]
