"""Exports of RSLogix 500: read, refused rung by rung, exported again, run in a rack and by the command."""

import json
import sys

import pytest
from scanrack.commands import build
from scanrack.jobs import ProgramError, load_program
from scanrack.ladder.debug.crossref import cross_reference
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.model.stubs import Power, Stubs, parse_stub
from scanrack.rockwell.slc import SlcError, export_text, import_slc, import_text
from scanrack.rockwell.slc.document import parse_document
from typer.testing import CliRunner

MACHINE = """PROJECT "feeder"
PROCESSOR "1766-L32BXB Series C"
SLOT 0 1766-L32BXB
SLOT 1 OTHER 3 10 25
SLOT 2 1762-IQ16
LADDER 2 "MAIN"
% the pump seals in %
SOR BST XIC I:2/3 NXB BST XIC B3/17 NXB XIC N7:0/[N7:1] BND BND
    XIO I:0/1 OTE B3/17 EOR
SOR XIC B3:1/1 TON T4:0 0.01 500 0 EOR SOR XIC T4:0/DN JSR U:3 EOR
SOR XIC S:1/15 COP #N7:0 #N10:4 3 MVM N7:[N7:1] 0FF0h O:1.0 EOR
SOR CPT F8:0 (N7:0 | 2) * -1.5 EOR
SOR JMP Q2:1 EOR
SOR LBL Q2:1 ADD #N7:0 1 N7:2 EOR
SOR SQO #N12:0 FFFFh O:0.0 R6:0 4 0 EOR
SOR END EOR
LADDER 3 "FAULTS"
SOR SBR EOR
SOR RET EOR
DATA N7:0
% N7:0 % 1 2 3 -4
% N7:4 % 0FFh 16#10
DATA B3:0 0000000000000101 0
DATA T4:0 0 500 7
DATA F8:0 2.5
DATA ST9:0 "hello"
RTC something
END
"""


def made(text=MACHINE, **parts):
    return import_text(text, "machine", file="machine.SLC", **parts)


def test_everything_is_read():
    found = made()
    assert (found.report.rungs, found.report.imported, found.report.refused) == (11, 11, [])
    assert found.document.name == "feeder"
    assert [each.text for each in found.report.notes if each.name == "RTC"] == [
        "the line is not understood: RTC something"
    ]
    main, sub = found.program.routines
    assert (main.comment, sub.comment, main.rungs[0].comment) == ("MAIN", "FAULTS", "the pump seals in")
    assert str(main.rungs[0]) == ("[XIC(I:2.0/3),[XIC(B3:1/1),XIC(N7:0.[N7:1])]]XIO(I:0.0/1)OTE(B3:1/1);")


def test_data_files_have_their_values():
    tags = made().program.tags
    assert tags["N7"][:6] == [1, 2, 3, -4, 255, 16]
    assert tags["B3"] == [5, 0]
    assert (tags["T4[0].PRE"], tags["T4[0].ACC"], tags["F8[0]"], tags["ST9[0]"]) == (500, 7, 2.5, "hello")


def test_without_data_the_rung_says_pre_and_acc():
    program = import_text("SOR TON T4:2 1.0 30 4 CTU C5:0 9 0 EOR", "x").program
    assert program is not None
    assert (program.tags["T4[2].PRE"], program.tags["T4[2].ACC"]) == (30, 4)
    assert program.tags["C5[0].PRE"] == 9


def test_exporting_and_importing_keeps_the_tree():
    first = made()
    text = export_text(first.program, first.document)
    again = made(text)
    assert again.report.refused == []
    assert again.program.routines == first.program.routines
    assert export_text(again.program, again.document) == text
    types = [{each.name: each.type for each in found.program.declarations} for found in (first, again)]
    assert types[0] == types[1]


def test_it_is_a_rung_file_of_the_dialect_slc():
    program = made().program
    text = program_text(program)
    assert text.startswith("PROGRAM feeder MAIN U2\nDIALECT slc\n")
    again = parse_program(text)
    assert again.dialect == "slc"
    assert [str(rung) for rung in again.routines[0].rungs] == [
        str(rung) for rung in program.routines[0].rungs
    ]
    assert program_text(again) == text


@pytest.mark.parametrize(
    ("rung", "column", "reason"),
    [
        ("XIC B3/0 XRP N7:0 OTE B3/1", 14, "no instruction XRP"),
        ("ADD N7:0 1", 5, "ADD takes 3 operands, 2 are given"),
        ("XIC B3/0 NXB OTE B3/1", 14, "NXB is outside of a branch"),
        ("BST XIC B3/0 NXB XIC B3/1 OTE B3/2", 40, "the branch has no BND"),
        ("MOV N7:0 Q", 14, "'Q' is neither an address nor a number"),
        ("MOV N7:0/x1y:2 N7:1", 9, "is neither an address nor a number"),
        ("TON T4:0 0.5 10 0", 1, "0.5 is not a time base; write 1.0, 0.01 or 0.001"),
        ("XIC B3/0", 1, "the rung has no output"),
        ("JSR U:9", 1, "no routine U9"),
        ("OTE B3:0/16", 1, "B3 has no bit 16"),
        ("MSG MG9:0", 1, "no stub for the message MG9:0"),
        ("SVC 1", 5, "no instruction SVC"),
    ],
)
def test_a_rung_is_refused_with_its_place(rung, column, reason):
    found = import_text(f"LADDER 2\nSOR MOV 1 N7:9 EOR\nSOR {rung} EOR\n", "x", file="x.SLC")
    (refused,) = found.report.refused
    assert (refused.line, refused.routine, refused.rung, refused.column) == (3, "U2", 1, column)
    assert reason in f"{refused.reason}; {refused.remedy}"
    assert (found.report.rungs, found.report.imported) == (2, 1)
    assert found.program is not None


def test_stubs_stand_for_what_is_refused():
    stubs = Stubs({"SVC": Power(False), "MSG": parse_stub("done after 1 ms")})
    found = import_text("SOR SVC 1 OTE B3/0 EOR SOR MSG MG9:0 EOR", "x", stubs)
    assert found.report.refused == []
    assert found.report.stubs == {"SVC": "false (once)", "MSG": "done after 1 ms (once)"}


@pytest.mark.slow
def test_there_are_limits(tmp_path):
    with pytest.raises(SlcError, match="the file has more than 65,536 rungs"):
        import_text("SOR " * 70_000, "x")
    path = tmp_path / "x.SLC"
    path.write_bytes(b"SOR NOP EOR\n" * 400_000)
    with pytest.raises(SlcError, match="more than 4,194,304 bytes"):
        import_slc(path)


def test_sor_begins_a_rung_where_eor_is_missing():
    found = import_text("SOR MOV 1 N7:0\nSOR MOV 2 N7:1 EOR SOR MOV 3 N7:2 EOR", "x")
    assert [(each.line, each.rung, each.reason) for each in found.report.refused] == [
        (1, 0, "the rung has no EOR")
    ]
    assert found.report.imported == 2


def test_a_rung_without_eor_is_refused():
    found = import_text("SOR MOV 1 N7:0 EOR\nSOR MOV 2 N7:1\n", "x")
    assert [each.reason for each in found.report.refused] == ["the rung has no EOR"]


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ("T4:0 1 2", "elements of T have three words, but the line has 2 values"),
        ("N7:200 " + "1 " * 60, "a file has up to 256 elements; this one has 260"),
        ("PD9:0 1", "values of PD files are not read"),
    ],
)
def test_data_that_fits_nothing_is_noted(data, says):
    found = import_text(f"SOR MOV 1 N7:0 EOR\nDATA {data}\n", "x")
    assert any(says in each.text for each in found.report.notes)


@pytest.mark.parametrize(
    ("slot", "is_3601"),
    [("SLOT 1 OTHER 3 10 25", True), ("SLOT 1 AMCI 3601", True), ("SLOT 1 1762-IQ16", False)],
)
def test_slots(slot, is_3601):
    document = parse_document(f"{slot}\nSOR NOP EOR\n", "", "x")
    assert document.slots[1].is_3601 is is_3601


@pytest.mark.parametrize(
    ("data", "says"), [(b"", "no rung in it"), (b"\xd0\xcf\x11\xe0\0", "this is not text")]
)
def test_a_file_that_is_no_export(tmp_path, data, says):
    path = tmp_path / "x.SLC"
    path.write_bytes(data)
    with pytest.raises(SlcError, match=says):
        import_slc(path)
    with pytest.raises(ProgramError, match=says):
        load_program(str(path))


def test_a_refused_rung_keeps_the_program_from_running(tmp_path):
    (tmp_path / "x.SLC").write_text("SOR SVC 1 EOR", encoding="utf-8")
    with pytest.raises(ProgramError, match=r"x.SLC:1: x, U2, rung 0, column 5: no instruction SVC"):
        load_program("x.SLC", tmp_path)


def command(*arguments):
    result = CliRunner().invoke(build(), list(arguments))
    return result.exit_code, result.output


def test_the_command_says_what_runs(tmp_path):
    path = tmp_path / "machine.SLC"
    path.write_text(MACHINE, encoding="utf-8")
    status, output = command("l5x", str(path))
    assert status == 0
    assert "11 rungs: 11 imported, 0 refused, 11 ran" in output
    report = json.loads(command("l5x", str(path), "--json")[1])
    assert (report["rungs"], report["imported"], report["ran"], report["refused"]) == (11, 11, 11, [])
    other = tmp_path / "machine.txt"
    other.write_text("SOR SVC 1 EOR\n", encoding="utf-8")
    assert command("l5x", str(other))[0] == 1
    (tmp_path / "empty.SLC").write_text("", encoding="utf-8")
    assert command("l5x", str(tmp_path / "empty.SLC"))[0] == 2


def test_it_proposes_a_rack_that_runs_it(tmp_path):
    path = tmp_path / "machine.SLC"
    path.write_text(MACHINE, encoding="utf-8")
    status, output = command("l5x", str(path), "--print-rack")
    assert status == 0
    assert 'number = 1\nmodule = "amci3601"' in output
    assert "# slot 2: 1762-IQ16" in output
    (tmp_path / "machine.toml").write_text(output, encoding="utf-8")
    assert command("run", str(tmp_path / "machine.toml"), "--scans", "5", "--no-record")[0] == 0


def test_a_rack_runs_it(tmp_path, monkeypatch):
    """The 3601 in slot 1 is configured by O:1.0 to O:1.7, and says so in I:1.0."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    rungs = "SLOT 1 OTHER 3 10 25\nSOR COP #I:1.0 #N7:0 8 EOR\nSOR XIC S:1/15 MOV 1 N7:9 EOR\n"
    (tmp_path / "machine.SLC").write_text(rungs, encoding="utf-8")
    rack = 'program = "machine.SLC"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    (tmp_path / "machine.toml").write_text(rack, encoding="utf-8")
    status, output = command("run", "machine.toml", "--scans", "20", "--record", "a.mcap")
    assert status == 0, output
    assert command("replay", "--into", "session", "a.mcap")[0] == 0


@pytest.mark.slow
def test_pictures_and_checks_know_it(tmp_path):
    """A timer's box names its time base; values that are left out are zeros to `scanrack check`."""
    path = tmp_path / "machine.SLC"
    path.write_text(MACHINE, encoding="utf-8")
    status, output = command("ladder", str(path))
    assert status == 0
    assert "Time base 0.01" in output
    (tmp_path / "machine.toml").write_text(
        'program = "machine.SLC"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    assert command("check", str(tmp_path / "machine.toml"))[0] in (0, 1)


def test_what_times_counts_or_is_reset_is_written():
    program = import_text(
        'PROJECT "x"\nPROCESSOR "1764-LRP"\nLADDER 2 "MAIN"\n'
        "SOR TON T4:0 0.01 50 0 EOR SOR CTU C5:0 10 0 EOR SOR XIC T4:0/DN RES C5:0 EOR\n"
        "SOR SQO #N12:0 FFFFh N7:0 R6:0 4 0 EOR\nDATA N12:0 0\nEND\n",
        "x",
    ).program
    assert program is not None
    mentions = cross_reference(program.build())
    found = {(each.site.instruction.partition("(")[0], each.text): each.way for each in mentions}
    assert found["TON", "T4:0"] == found["CTU", "C5:0"] == found["SQO", "R6:0"] == "reads, writes"
    assert found["RES", "C5:0"] == "writes"
    assert found["XIC", "T4:0.DN"] == "reads"
