"""Data files of RSLogix 500 as it saves them: every kind, each value at its place; what is lost is told."""

import pytest
from scanrack.ladder import BuildError, Program
from scanrack.ladder.compiler import writer
from scanrack.ladder.model.errors import Problem
from scanrack.rockwell.slc import export_text, import_slc, import_text
from scanrack.rockwell.slc.trial import run_trial
from slc_files import FUNCTION_FILES, elements, export, forces, image, ladder, slot, texts, words

TIMERS = [("0XA200", 60, 60), *[("0X0200", 60 + place, 0) for place in range(1, 60)]]


def imported(*parts, **more):
    return import_text(export(*parts, **more), "machine", file="machine.SLC")


def tags(*parts, **more):
    found = imported(*parts, **more)
    assert found.report.refused == []
    assert found.program is not None
    return found.program.tags


def test_timers_have_control_preset_and_accumulated_value():
    found = tags(ladder(2, "TON T33:0 1.0 60 60"), elements("T33", TIMERS))
    assert (found["T33[0].PRE"], found["T33[0].ACC"]) == (60, 60)
    assert (found["T33[0].EN"], found["T33[0].TT"], found["T33[0].DN"]) == (True, False, True)
    assert (found["T33[59].PRE"], found["T33[59].EN"]) == (119, False)
    assert len(found["T33"]) == 60


def test_a_timer_of_the_export_is_not_done_after_one_scan():
    """PRE is that of the file: a TON of 60 s with ACC 0 takes 60 s."""
    program = imported(
        ladder(2, "XIC B3:0/0 TON T33:0 1.0 60 0"),
        words("B3", [1]),
        elements("T33", [("0X0200", 60, 0)]),
    ).program
    for _ in range(59):
        program.step(1000)
    assert (program.tags["T33[0].ACC"], program.tags["T33[0].DN"]) == (58, False)
    for _ in range(2):
        program.step(1000)
    assert program.tags["T33[0].DN"] is True


def test_counters_and_controls():
    found = tags(
        ladder(2, "CTU C5:1 -10 3"),
        elements("C5", [("0X0000", 0, 0), ("0X3000", -10, 3)]),
        elements("R6", [("0X8000", 16, 5)], ".LEN   .POS"),
    )
    assert (found["C5[1].PRE"], found["C5[1].ACC"]) == (-10, 3)
    assert (found["C5[1].DN"], found["C5[1].OV"], found["C5[1].CU"]) == (True, True, False)
    assert (found["R6[0].EN"], found["R6[0].LEN"], found["R6[0].POS"]) == (True, 16, 5)


def test_words_long_words_reals_and_texts():
    found = tags(
        ladder(2, "NOP"),
        words("N7", [*range(10), -3, "0XFFF0", "0X7FFF", -32768]),
        words("B32", [-32768, "0X0101"]),
        words("L41", [2147483647, "-2147483648", "0XFFFFFFFE", 0, 0, 7], per_line=5),
        words("F8", ["0.01666667", "-1.5e+010", "1.#INF", "-2."]),
        texts("ST9", "50 % of it", "", "b // c"),
    )
    assert found["N7"] == [*range(10), -3, -16, 32767, -32768]
    assert found["B32"] == [-32768, 257]
    assert found["L41"] == [2147483647, -2147483648, -2, 0, 0, 7]
    assert found["F8[0]"] == pytest.approx(1 / 60)
    assert found["F8"][1:] == [-15_000_000_512.0, float("inf"), -2.0]
    assert found["ST9"] == ["50 % of it", "", "b // c"]


def test_words_lie_where_their_comment_says():
    """A file may leave lines out."""
    found = tags(ladder(2, "NOP"), "\nDATA N7:0\n% N7:10 % 5 6\n% N7:2 %  7\n")
    assert (found["N7[10]"], found["N7[11]"], found["N7[2]"], found["N7[0]"]) == (5, 6, 7, 0)


@pytest.mark.parametrize(
    ("header", "first"),
    [("DATA N7:5 1 2 3 4 5 6", 0), ("DATA ...N7:5 1 2 3 4 5 6", 5), ("DATA N 7 : 5 1 2 3", 5)],
)
def test_the_older_form_has_the_last_element_in_its_header(header, first):
    """9323-PA2E, p. 5-19: the values begin at word 0, unless periods precede the address."""
    found = tags(ladder(2, "NOP"), f"\n{header}\n")
    assert found[f"N7[{first}]"] == 1
    assert found["N7"][first : first + 3] == [1, 2, 3]


def test_images_have_the_words_of_their_slot():
    found = imported(
        ladder(2, "XIC I:1/0 OTE O:3/1", "XIC I:0/9 OTE O:0/1"),
        image("O:3", "0X0002"),
        image("I:0", *["0X0000"] * 7, "0X8001"),
        slots=[slot(1, "1762-IQ16", "16-Input", 1), slot(3, "1769-OB16", "16-Output", 0, 1)],
    )
    values = found.program.tags
    assert values["O:3"] == [2]
    assert len(values["I:0"]) == 8
    assert values["I:0"][7] == -32767
    assert len(values["I:1"]) == 1
    assert (found.document.slots[0].inputs, found.document.slots[0].outputs) == (8, 6)


def test_the_status_file_goes_on_and_the_first_pass_is_set():
    program = imported(ladder(2, "XIC S:1/15 MOV 1 N7:0"), words("S", [4, 5414, 0, *[0] * 57, 17221])).program
    assert program.tags["S[60]"] == 17221
    program.step(10)
    assert program.tags["N7[0]"] == 1


def test_a_rung_says_what_the_data_leave_out():
    found = imported(
        ladder(2, "TON T4:0 1.0 5 1", "TON T4:3 1.0 30 4"), elements("T4", [("0X0000", 7, 2)])
    ).program.tags
    assert (found["T4[0].PRE"], found["T4[0].ACC"], found["T4[3].PRE"], found["T4[3].ACC"]) == (7, 2, 30, 4)


@pytest.mark.parametrize(
    ("data", "lost", "line", "says"),
    [
        ("DATA N7:0\n% N7:0 % 1 99999 3", "N7:1", 2, "99999 does not fit 16 bits"),
        ("DATA N7:0\n1 2.5", "N7:1", 2, "2.5 is not an integer"),
        (
            "DATA T4:0\n0X0000 1 % T4:0 %",
            "T4:0",
            2,
            "elements of T have three words, but the line has 2 values",
        ),
        ("DATA T4:0\n0X0000 1 x % T4:0 %", "T4", 2, "the line is not understood: 0X0000 1 x"),
        ("DATA N7:0 5 ?", "N7", 1, "the line is not understood: ?"),
        ("DATA ST9:0\n7", "ST9:0", 2, "7 is not a text in quotation marks"),
        ("DATA N7:0\n" + "1 " * 257, "N7:256", 2, "a file has up to 256 elements; this one has 257"),
    ],
)
def test_what_is_not_understood_is_lost_and_told(data, lost, line, says):
    found = imported(ladder(2, "TON T4:0 1.0 5 1", "MOV N7:0 N7:2"))
    before = len(export(ladder(2, "TON T4:0 1.0 5 1", "MOV N7:0 N7:2")).splitlines())
    found = imported(ladder(2, "TON T4:0 1.0 5 1", "MOV N7:0 N7:2"), f"{data}\n")
    assert found.report.lost == [lost]
    assert found.report.refused == []
    (note,) = (each for each in found.report.notes if says in each.text)
    assert note.line == before + line
    assert f"machine.SLC: values of the export are lost: {lost};" in found.report.warnings[0]


def test_one_value_that_is_lost_keeps_the_others():
    found = imported(
        ladder(2, "NOP"), "DATA N7:0\n1 99999 3\nDATA T4:0\n0X0000 5 99999\n0X0000 6 1\n"
    ).program.tags
    assert found["N7"] == [1, 0, 3]
    assert (found["T4[0].PRE"], found["T4[1].PRE"]) == (0, 6)


def test_function_files_are_lost_only_if_a_rung_names_them():
    told = imported(ladder(2, "NOP"), FUNCTION_FILES)
    assert told.report.lost == []
    assert [each.name for each in told.report.notes] == ["HSC0", "RTC0"]
    assert imported(ladder(2, "MOV RTC:0.MIN N7:0"), FUNCTION_FILES).report.lost == ["RTC0"]


def test_settings_of_slots_names_and_descriptions():
    found = imported(
        ladder(2, "JSR 3"),
        "% TITLE/RUNG DESCRIPTION\nTITLE: Start\nRUNG DESCRIPTION: 50 % of\nthe speed %\n",
        ladder(3, "NOP"),
        names={2: "MAIN", 3: "FEED"},
    )
    assert found.report.notes == []
    main, feed = found.program.routines
    assert (main.comment, feed.comment) == ("MAIN", "FEED")
    assert (main.rungs[0].comment, feed.rungs[0].comment) == ("Start\n50 % of\nthe speed", "")
    assert found.document.processor == "Bul.1766 MicroLogix 1400 Series B"
    assert found.document.name == "LINE"


def test_a_percent_sign_that_nothing_closes_loses_no_line_below():
    found = imported("\n% never closed\n", ladder(2, "MOV 1 N7:0"), words("N7", [1, 2]))
    assert (found.report.rungs, found.report.imported) == (1, 1)
    assert found.program.tags["N7"] == [1, 2]


def test_forces_are_noted_where_there_are_some():
    found = imported(ladder(2, "NOP"), forces("O:03", ("0X0000", "0XFFFF"), ("0X0001", "0XFFFF")))
    assert [(each.name, each.text) for each in found.report.notes] == [
        ("FORCE O:3.1", "the force is not applied: set it in the rack file")
    ]


def test_exporting_keeps_the_values():
    first = imported(
        ladder(2, "TON T33:0 1.0 60 60"), elements("T33", TIMERS), words("F8", ["1.#INF", "0.5"])
    )
    again = import_text(export_text(first.program, first.document), "machine")
    assert first.program is not None
    assert again.program is not None
    for name in ("T33", "F8"):
        assert again.program.tags[name] == first.program.tags[name]


def test_what_no_rung_is_to_blame_for_refuses_the_rungs_and_not_the_file(monkeypatch):
    problem = Problem("somewhere", "", "it does not fit", "correct it")

    def refuse(program):
        raise BuildError(program.name, [problem])

    monkeypatch.setattr(Program, "build", refuse)
    found = imported(ladder(2, "NOP", "SVC 1"))
    assert found.program is None
    assert [(each.rung, each.reason) for each in found.report.refused] == [
        (1, "no instruction SVC"),
        (0, "it does not fit"),
    ]


def test_a_file_that_compiles_to_too_much_is_no_error(monkeypatch):
    monkeypatch.setattr(writer, "MOST_LINES", 5)
    found = imported(ladder(2, *["ADD N7:0 1 N7:0"] * 9))
    run_trial(found, 2)
    assert found.report.ran == 0
    assert "compiles to more than 5 lines of Python" in found.report.faults["LINE"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_characters_of_windows_and_of_utf_8(tmp_path, encoding):
    path = tmp_path / "line.SLC"
    path.write_bytes(export(ladder(2, "NOP"), project="Größe").encode(encoding))
    assert import_slc(path).document.name == "Größe"
