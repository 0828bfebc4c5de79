"""`scanrack l5x`, and a rack whose program is an L5X."""

import json

import pytest
from l5x_files import machine, tag
from scanrack.commands import build
from scanrack.jobs import ProgramError, load_program
from scanrack.ladder import LadderLogic
from typer.testing import CliRunner


def run(*arguments):
    return CliRunner().invoke(build(), ["l5x", *map(str, arguments)])


@pytest.fixture
def written(tmp_path):
    def write(*rungs):
        path = tmp_path / "machine.L5X"
        path.write_text(machine(*rungs, tags=[tag("Lamp", "BOOL")]), encoding="utf-8")
        return path

    return write


def test_json_of_a_file_that_is_imported(written):
    answer = run(written("OTE(Lamp);", "NOP();"), "--json")
    assert answer.exit_code == 0
    said = json.loads(answer.output)
    assert (said["rungs"], said["imported"], said["ran"], said["refused"]) == (2, 2, 2, [])


def test_refusals(written):
    answer = run(written("OTE(Lamp);", "FOO(Lamp);"), "--json")
    assert answer.exit_code == 1
    (refused,) = json.loads(answer.output)["refused"]
    assert (refused["program"], refused["routine"], refused["rung"], refused["column"]) == (
        "Main",
        "Main",
        1,
        1,
    )
    assert set(refused) == {
        *("file", "line", "program", "routine", "rung", "column", "text", "reason", "remedy"),
    }


def test_as_text(written):
    answer = run(written("FOO(Lamp);"))
    assert answer.exit_code == 1
    assert "1 rungs: 0 imported, 1 refused, 0 ran" in answer.output
    assert "Main, Main, rung 0, column 1: expected an instruction; FOO is unknown" in answer.output


def test_what_is_no_l5x(tmp_path):
    path = tmp_path / "machine.L5X"
    path.write_text("nothing", encoding="utf-8")
    answer = run(path)
    assert answer.exit_code == 2
    assert f"{path}:1: it is not XML" in answer.output + answer.stderr


def test_as_a_program(written):
    logic = load_program(str(written("OTE(Lamp);"))).function
    assert isinstance(logic, LadderLogic)
    logic.step()
    assert logic.tags.Lamp is True


def test_a_refused_rung_keeps_the_program_from_running(written):
    path = written("OTE(Lamp);", "FOO(Lamp);")
    with pytest.raises(ProgramError, match="rung 1, column 1: expected an instruction; FOO is unknown"):
        load_program(str(path))
