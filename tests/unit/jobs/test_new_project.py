"""`scanrack new`: what it writes runs, its test passes, and nothing is overwritten.

Broken on purpose: a file opened with "w", a folder that is not looked into, a template without its switches.
"""

import runpy
import tomllib
from contextlib import ExitStack
from pathlib import Path

import pytest
from scanrack import open_bench
from scanrack.commands import build
from scanrack.jobs.start import LOGICS, ProjectError, example_names, new_project
from typer.testing import CliRunner

pytestmark = pytest.mark.slow  # together they take seconds

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize("logic", LOGICS)
def test_a_new_program_homes_moves_and_passes_its_test(tmp_path, logic):
    folder = tmp_path / "mine"
    rack, *others = new_project(folder, logic)
    assert tomllib.loads(rack.read_text(encoding="utf-8"))["name"] == "mine"
    assert {each.name for each in folder.iterdir()} == {rack.name, *(each.name for each in others)}
    tests = runpy.run_path(str(folder / "test_line.py"))
    (test,) = (each for name, each in tests.items() if name.startswith("test_"))
    with ExitStack() as opened:
        test(lambda path: opened.enter_context(open_bench(folder / path)))  # what the fixture `rack` does


def test_a_new_program_lights_its_lamp_while_it_moves(tmp_path):
    """The same output in both languages that have more than the axis: the third slot's first one."""
    for logic in ("python", "ladder"):
        rack, *_ = new_project(tmp_path / logic, logic)
        with open_bench(rack) as line:
            line.run_until(lambda bench: bench.slot[1].moving, within="2 s")
            line.run_for("20 ms")
            assert line.slot[3].outputs[0] == 1, logic


def test_examples_are_those_of_the_repository(tmp_path):
    racks = {each.parent.name for each in EXAMPLES.glob("*/*.toml")}
    assert {*example_names()} == racks
    for name in racks:
        first, *_ = new_project(tmp_path / name, example=name)
        assert first.read_bytes() == (EXAMPLES / name / first.name).read_bytes()
        assert not list(
            (tmp_path / name).glob("*.txt")
        )  # what it is expected to print is for the project's check


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "line.py").write_text("mine", encoding="utf-8")
    with pytest.raises(ProjectError, match=r"is not empty \(line\.py\): choose a new or empty folder"):
        new_project(tmp_path)
    with pytest.raises(ProjectError, match="is a file"):
        new_project(tmp_path / "line.py")
    assert [each.name for each in tmp_path.iterdir()] == ["line.py"]
    assert (tmp_path / "line.py").read_text(encoding="utf-8") == "mine"


def test_a_folder_may_be_called_anything(tmp_path):
    rack, *_ = new_project(tmp_path / 'a "b"\\c')
    assert tomllib.loads(rack.read_text(encoding="utf-8"))["name"] == "a bc"


def test_the_command_says_what_is_there_and_how_to_go_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(build(), ["new", "line", "--from", "feeder"])
    assert done.exit_code == 0
    assert done.stdout.splitlines()[-1] == f"See it run:  scanrack watch {Path('line/feeder.toml')} --open"
    again = CliRunner().invoke(build(), ["new", "line"])
    assert (again.exit_code, "line is not empty (NEXT.md" in again.stderr) == (2, True)
    rungs = CliRunner().invoke(build(), ["new", "rungs", "--logic", "ladder"])
    assert (rungs.exit_code, str(Path("rungs/line.rung")) in rungs.stdout) == (0, True)
    unknown = CliRunner().invoke(build(), ["new", "other", "--from", "feeders"])
    assert (unknown.exit_code, "choose from feeder, first" in unknown.stderr) == (2, True)
    assert not (tmp_path / "other").exists()
