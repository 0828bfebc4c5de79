"""Export for partial import: importing it again gives the same tree."""

import re
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.ladder import LadderError, read_program
from scanrack.ladder.files import parse_program
from scanrack.ladder.lowering.controller import Controller
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.export import export_l5x
from typer.testing import CliRunner

EXAMPLES = Path(__file__).parents[3] / "examples"

PLANT = """
CONTROLLER plant
INSTRUCTION Tenfold  // by ten
INPUT In : DINT REQUIRED
OUTPUT Out : DINT REQUIRED
LOCAL Factor : DINT := 10
ROUTINE Logic
MUL(In,Factor,Out);
END
END INSTRUCTION
TYPE Flags (Host : SINT HIDDEN, Ready : BOOL AT Host.0, Late : BOOL AT Host.1)
TYPE Recipe (Name : STRING, Times : DINT[3], Flags : Flags)
TAG Book : Recipe[2] := [{"Name": "it's $5", "Times": [1, 2, 3], "Flags": {"Host": 2}}]
TAG Level : REAL := 2.5
TAG Grid : INT[2,2] := [[1, 2], [3, 4]]
ALIAS Go : Book[0].Flags.Ready  // a bit
TASK Cycle : CONTINUOUS RUNS Main
PROGRAM Main MAIN Start
TAG Step : DINT := 7  // where it is
TAG Times10 : Tenfold
TAG Wait : TIMER := {"PRE": 500}
ROUTINE Start
// two lines
// of comment
[XIC(Go),XIO(Wait.DN)]TON(Wait,500,0);
Tenfold(Times10,Step,Grid[0,1]);
JSR(Sums,0);
END
ROUTINE Sums ST
IF Step > 3 THEN
    Level := Level * 2.0;
END_IF;
END
END PROGRAM
"""


def plant_of_text():
    plant = parse_program(PLANT)
    assert isinstance(plant, Controller)
    return plant


def again(tmp_path, logic, name):
    """Export and import."""
    file = tmp_path / "export.L5X"
    file.write_bytes(export_l5x(logic, name))
    found = import_l5x(file, trial=True)
    assert found.report.complete, list(found.report.lines())
    assert found.controller is not None
    return found


def tree(routine):
    """What a routine is, without where it came from."""
    return (
        routine.name,
        routine.comment,
        [(str(each), each.comment) for each in routine.rungs],
        routine.statements,
    )


def test_a_program_comes_back(tmp_path):
    plant = plant_of_text()
    back = again(tmp_path, plant, "main").controller
    old, new = plant.programs[0], back.programs[0]
    assert list(map(tree, new.routines)) == list(map(tree, old.routines))
    assert new.declarations == old.declarations
    assert (new.name, new.main) == ("Main", "Start")
    names = {each.name: each for each in back.declarations}
    assert [names[each.name] for each in plant.declarations if each.name != "Book"] == [
        each for each in plant.declarations if each.name != "Book"
    ]
    assert back.add_ons["TENFOLD"].parameters == plant.add_ons["TENFOLD"].parameters


def test_numbers_that_are_whole_are_decimal():
    text = export_l5x(plant_of_text(), "main").decode()
    shown = set(re.findall(r'DataType="(DINT|REAL|BIT)"[^>]*Radix="(\w+)"', text))
    assert shown == {("DINT", "Decimal"), ("BIT", "Decimal"), ("REAL", "Float")}


def test_texts_arrays_and_packed_bits_keep_their_values(tmp_path):
    plant = plant_of_text()
    back = again(tmp_path, plant, "Main").controller
    for name in ("Book[0].Name", "Book[0].Times[2]", "Book[0].Flags.Late", "Book[1].Times[0]"):
        assert back.compile().tags[name] == plant.compile().tags[name]


def test_a_routine_comes_back(tmp_path):
    plant = plant_of_text()
    back = again(tmp_path, plant, "Main.Start")
    assert back.report.target == "Routine"
    (routine,) = back.controller.programs[0].routines
    assert tree(routine) == tree(plant.programs[0].routines[0])


def test_the_example_comes_back(tmp_path):
    first = import_l5x(EXAMPLES / "l5x" / "indexer.L5X").controller
    assert first is not None
    second = again(tmp_path, first, "MainProgram").controller
    assert list(map(tree, second.programs[0].routines)) == list(map(tree, first.programs[0].routines))
    assert second.programs[0].declarations == first.programs[0].declarations


def test_what_has_no_form_is_refused():
    with pytest.raises(LadderError, match=r"no program 'Nope'; choose from Main"):
        export_l5x(parse_program(PLANT), "Nope")
    with pytest.raises(LadderError, match="card is an alias of module data"):
        export_l5x(
            parse_program("PROGRAM p\nSLOT card : 1\nROUTINE Main\nXIC(card.status.STOPPED)OTE(S:FS);\nEND"),
            "p",
        )


def test_the_command(tmp_path):
    done = CliRunner().invoke(
        build(), ["l5x", str(EXAMPLES / "l5x" / "indexer.L5X"), "--export", "MainProgram.Panel"]
    )
    assert done.exit_code == 0
    assert 'TargetType="Routine"' in done.stdout
    assert "[XIC(Start),XIC(Run)]XIC(Stop)OTE(Run);" in done.stdout
    (tmp_path / "plant.rung").write_text(PLANT, encoding="utf-8")
    assert (
        CliRunner().invoke(build(), ["l5x", str(tmp_path / "plant.rung"), "--export", "Main"]).exit_code == 0
    )
    assert read_program(tmp_path / "plant.rung").name == "plant"


@pytest.mark.parametrize(
    "routine",
    ["ROUTINE Main\nXIC(Go)ASSERT(Go);\nEND", "ROUTINE Main ST\nIF Go THEN\n  ASSERT(Go);\nEND_IF;\nEND"],
)
def test_an_instruction_that_no_controller_has_is_refused(routine):
    program = parse_program(f"PROGRAM one\nTAG Go : BOOL\n{routine}\n")
    with pytest.raises(LadderError, match="routine Main has ASSERT, which no controller has"):
        export_l5x(program, "one")
