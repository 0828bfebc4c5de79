"""`scanrack run --retain FILE`: tags from run to run, and the warnings of a ladder program."""

import json

import pytest
from scanrack.runtime.cli import build
from typer.testing import CliRunner

RACK = """scan_ms = 10
program = "line.rung"
[[slot]]
number = 1
module = "amci3601"
"""

PROGRAM = """PROGRAM line
TAG Count : DINT
TAG Lamp : BOOL
ROUTINE Main
ADD(Count,1,Count);
OTE(Lamp);
{more}
END
"""


@pytest.fixture
def line(tmp_path):
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "line.rung").write_text(PROGRAM.format(more=""), encoding="utf-8")
    return tmp_path


def run(folder, *words):
    rack = str(folder / "line.toml")
    return CliRunner().invoke(build(), ["run", rack, "--scans", "3", "--no-record", "-q", *words])


def test_the_second_run_begins_with_the_tags_of_the_first(line):
    file = line / "tags.json"
    for count in (3, 6):
        result = run(line, "--retain", str(file))
        assert (result.exit_code, result.stderr) == (0, "")
        assert json.loads(file.read_text(encoding="utf-8"))["tags"]["Count"] == ["DINT", count]
    assert [each.name for each in line.glob("*.part")] == []


def test_what_does_not_fit_is_reported(line):
    file = line / "tags.json"
    run(line, "--retain", str(file))
    text = (line / "line.rung").read_text(encoding="utf-8")
    (line / "line.rung").write_text(text.replace("Count : DINT", "Count : LINT"), encoding="utf-8")
    result = run(line, "--retain", str(file))
    assert (result.exit_code, result.stderr) == (0, f"scanrack: {file}: Count is LINT, in the file DINT\n")


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("tags.json", "no", "this is not a file of retained tags"),
        ("line.rung", None, "--retain would replace"),
    ],
)
def test_files_that_are_refused(line, name, text, says):
    if text is not None:
        (line / name).write_text(text, encoding="utf-8")
    before = (line / name).read_text(encoding="utf-8")
    result = run(line, "--retain", str(line / name))
    assert result.exit_code == 2
    assert says in result.stderr
    assert (line / name).read_text(encoding="utf-8") == before


def test_a_program_in_python_has_no_tags(line):
    (line / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (line / "line.toml").write_text(RACK.replace("line.rung", "line.py"), encoding="utf-8")
    result = run(line, "--retain", str(line / "tags.json"))
    assert result.exit_code == 2
    assert "it has no tags to retain" in result.stderr


def test_a_run_shows_the_warnings_of_its_program(line):
    (line / "line.rung").write_text(PROGRAM.format(more="XIC(Lamp)OTE(Lamp);"), encoding="utf-8")
    rack = str(line / "line.toml")
    result = CliRunner().invoke(build(), ["run", rack, "--scans", "1", "--no-record"])
    assert result.exit_code == 0
    assert "Lamp is written by a coil in " in result.stderr
    assert "join the two as branches of one rung" in result.stderr
