"""Rungs drawn with box characters and as SVG; the expected pictures were drawn by hand."""

from dataclasses import replace
from xml.etree import ElementTree

import pytest
from scanrack.commands import build
from scanrack.jobs import load_program
from scanrack.ladder import Program, parse_rung
from scanrack.ladder.draw import captions_of, routine_text, routines_svg, rung_text
from scanrack.ladder.model.routine import Routine
from typer.testing import CliRunner

SEAL_IN = "[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);"
SVG = "{http://www.w3.org/2000/svg}"


def drawn(text, width, truth=None):
    return "\n".join(rung_text(parse_rung(text), width, truth))


def expected(picture):
    return "\n".join(line.strip() for line in picture.strip().splitlines())


def test_seal_in_has_its_contacts_left_and_its_coil_at_the_right_rail():
    assert drawn(SEAL_IN, 32) == expected("""
        ║  Start   Stop              Run ║
        ╟┬──┤ ├──┬─┤/├───────────────( )─╢
        ║│ Run   │                       ║
        ║└─┤ ├───┘                       ║
    """)


def test_a_box_names_its_operands_as_the_editor_does():
    assert drawn("XIC(A)TON(Fill,5000,0)OTE(B);", 32) == expected("""
        ║  A        ┌─────TON─────┐   B  ║
        ╟─┤ ├───────┤ Timer  Fill ├──( )─╢
        ║           │ Preset 5000 │      ║
        ║           │ Accum     0 │      ║
        ║           └─────────────┘      ║
    """)


def test_legs_may_be_empty_and_branches_stand_in_branches():
    assert drawn("[[XIC(A),XIC(B)]XIC(C),,XIO(D)]OTE(E);", 25) == expected("""
        ║    A     C           E  ║
        ╟┬┬─┤ ├─┬─┤ ├─┬───────( )─╢
        ║││  B  │     │           ║
        ║│└─┤ ├─┘     │           ║
        ║├────────────┤           ║
        ║│  D         │           ║
        ║└─┤/├────────┘           ║
    """)


def test_a_wide_rung_goes_on_below_where_the_marks_show():
    assert drawn("XIC(A)XIC(B)XIC(C)OTE(D);", 12) == expected("""
        ║  A    B    ║
        ╟─┤ ├──┤ ├──»║
        ║   C     D  ║
        ║»─┤ ├───( )─╢
    """)


def test_a_branch_that_is_too_wide_goes_on_below_in_its_legs():
    assert drawn("[XIC(A)XIC(B)XIC(C),XIC(D)]OTE(E);", 18) == expected("""
        ║   A    B         ║
        ╟┬─┤ ├──┤ ├─»┌────»║
        ║│   C       │     ║
        ║│»─┤ ├──────┤     ║
        ║│  D        │     ║
        ║└─┤ ├───────┘     ║
        ║               E  ║
        ║»─────────────( )─╢
    """)


def test_a_long_operand_takes_several_lines_of_its_box():
    lines = drawn("CPT(Total,Left*1000+Middle*100+Right);", 32).splitlines()
    assert {len(line) for line in lines} == {34}
    text = "".join(lines)
    for piece in ("Expression", "Left*1000", "Middle*100+", "Right"):
        assert piece in text


def test_long_comments_wrap():
    said = "Whenever the position is not known, look for home"
    routine = Routine("Main", (replace(parse_rung("OTE(A);"), comment=f"{said}\n\nshort"),))
    lines = [line.strip() for line in routine_text(routine, 24).splitlines()]
    assert lines[:4] == ["Whenever the position is", "not known, look for home", "", "short"]
    root = ElementTree.fromstring(routines_svg([(routine, [0])], 24))
    texts = {each.text for each in root.iter(f"{SVG}text")}
    assert texts >= {"Whenever the position is", "not known, look for home", "short"}


def test_power_makes_wires_heavy_up_to_the_first_contact_that_is_open():
    # Start is out, the seal contact holds, Stop is not pressed: everything but the wire behind Start.
    assert drawn(SEAL_IN, 32, [False, True, True, True]) == expected("""
        ║  Start   Stop              Run ║
        ╟┳━━┤ ├──┳━┨/┠━━━━━━━━━━━━━━━( )━╢
        ║┃ Run   ┃                       ║
        ║┗━┨ ┠━━━┛                       ║
    """)
    assert drawn("XIC(A)XIC(B)OTE(C);", 20, [False, False, False]) == expected("""
        ║  A    B         C  ║
        ╟━┤ ├──┤ ├───────( )─╢
    """)


def test_more_truths_than_instructions_are_refused():
    with pytest.raises(ValueError, match="5 truths; must be at most 4"):
        drawn(SEAL_IN, 32, [True] * 5)


def test_a_rung_that_a_fault_has_ended_is_without_power_from_there_on():
    assert drawn("XIC(A)XIC(B)OTE(C);", 20, [True]) == expected("""
        ║  A    B         C  ║
        ╟━┨ ┠━━┤ ├───────( )─╢
    """)


def test_an_add_on_instruction_shows_its_parameters_names():
    program = load_program("examples/feeder/feeder.rung").function
    assert isinstance(program, Program)
    rung = next(each for each in program.routines[0].rungs if "MC_Reset(" in str(each))
    picture = "\n".join(rung_text(rung, 80, captions=captions_of(program)))
    for line in ("Instance    Reset", "Axis         Axis", "Execute  Quiet.DN"):
        assert line in picture


def test_a_routine_carries_numbers_and_comments():
    routine = Routine("Main", (parse_rung("OTE(A);"), parse_rung(SEAL_IN)))
    lines = routine_text(routine, 32).splitlines()
    assert [line[:3] for line in lines if line[3:4] == "╟"] == [" 0 ", " 1 "]


def svg_of(text, truth=None):
    routine = Routine("Main", (parse_rung(text),))
    return ElementTree.fromstring(routines_svg([(routine, [0])], 32, {"Main": [truth]} if truth else None))


def test_svg_shows_every_name_and_the_rung_text_as_its_title():
    root = svg_of(SEAL_IN)
    texts = [each.text for each in root.iter(f"{SVG}text")]
    assert {"Routine Main", "0", "Start", "Stop"} <= set(texts)
    assert texts.count("Run") == 2
    assert root.find(f"{SVG}g/{SVG}title").text == SEAL_IN


def test_svg_escapes_what_markup_would_take_for_its_own():
    texts = [each.text for each in svg_of("CMP(A<B AND C>0)OTE(D);").iter(f"{SVG}text")]
    assert any("<" in each for each in texts)


def test_svg_marks_what_has_power():
    def live(truth):
        return sum("live" in each.get("class", "").split() for each in svg_of(SEAL_IN, truth).iter())

    dark, part, whole = live(None), live([False, True, True, True]), live([True] * 4)
    assert dark == 0 < part < whole


def invoke(*words):
    return CliRunner().invoke(build(), ["ladder", *map(str, words)])


@pytest.fixture
def line(tmp_path):
    file = tmp_path / "line.rung"
    file.write_text(
        f"PROGRAM Line\nTAG Start : BOOL\nTAG Stop : BOOL\nTAG Run : BOOL\nROUTINE Main\n{SEAL_IN}\nEND\n",
        encoding="utf-8",
    )
    return file


def test_the_command_draws_prints_and_writes(line, tmp_path):
    assert "╟┬──┤ ├──┬─┤/├───" in invoke(line, "--width", 40).stdout
    assert invoke(line, "--text").stdout == f"{SEAL_IN}\n"
    assert "def " in invoke(line, "--source").stdout
    picture = tmp_path / "line.svg"
    assert invoke(line, "--svg", picture).exit_code == 0
    assert ElementTree.parse(picture).getroot().tag == f"{SVG}svg"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--routine", "Nowhere"), "no routine Nowhere in program Line; choose from Main"),
        (("--rung", 7), "no rung 7; they are numbered from 0 to 0"),
    ],
)
def test_the_command_refuses_what_is_not_there(line, words, says):
    result = invoke(line, *words)
    assert (result.exit_code, result.stderr) == (2, f"scanrack: {says}\n")


def test_the_command_refuses_a_plain_function(tmp_path):
    file = tmp_path / "plain.py"
    file.write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    result = invoke(file)
    assert result.exit_code == 2
    assert "which has no rungs" in result.stderr
