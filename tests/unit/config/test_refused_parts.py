"""`refused = "empty"` in `[stubs]`: an export runs without its refused rungs, routines and add-ons."""

import pytest
from l5x_files import diagram, document, ladder, program, tag
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.ladder import LadderLogic
from scanrack.runtime import RackFileError
from typer.testing import CliRunner

RACK = 'program = "line.L5X"\n[stubs]\n{}[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
EMPTY = 'refused = "empty"\n'
HIDDEN = '<EncodedData EncodedType="AddOnInstructionDefinition" Name="Hidden">eJw=</EncodedData>'
RUNGS = ("JSR(Nowhere,0);", "ADD(1,Count,Count);", "XIC(?)OTE(Lamp);", "JSR(Blocks,0);", "ADD(1,Text,Text);")
LEFT_OUT = "Hidden, Main.Main rung 0, Main.Main rung 2, Main.Main rung 4, Main.Blocks"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = document(
        add_ons=[HIDDEN],
        tags=[tag("Count", "DINT"), tag("Lamp", "BOOL"), tag("Text", "STRING")],
        programs=[program("Main", ladder("Main", *RUNGS), diagram("Blocks", "FBD"))],
    )
    (tmp_path / "line.L5X").write_text(text, encoding="utf-8")
    return tmp_path


def scanrack(*arguments):
    """Run a command; return its exit status and all that it wrote."""
    result = CliRunner().invoke(build(), list(arguments))
    return result.exit_code, result.output


def test_what_is_not_refused_runs(folder):
    (folder / "line.toml").write_text(RACK.format(EMPTY), encoding="utf-8")
    job = load_job("line.toml")
    assert isinstance(job.logic, LadderLogic)
    job.logic.step()
    assert job.logic.tags.Count == 1  # once: rungs that add texts and call what is not there are empty
    assert job.stubs == (f"refused = empty: {LEFT_OUT}",)


def test_without_it_the_rack_is_refused(folder):
    (folder / "line.toml").write_text(RACK.format(""), encoding="utf-8")
    with pytest.raises(RackFileError, match="rung 0, column 1: no routine"):
        load_job("line.toml")


def test_a_printed_rack_runs(folder):
    status, rack = scanrack("l5x", "line.L5X", "--print-rack")
    (folder / "line.toml").write_text(rack, encoding="utf-8")
    assert 'Blocks = "false"' in rack
    assert "ADD" not in rack  # a stub of ADD would replace the ADD that works
    status, output = scanrack("run", "line.toml", "--scans", "5")
    assert (status, "refused = empty: Hidden, Main.Main rung 0" in output) == (0, True)


@pytest.mark.parametrize(
    ("program_name", "given", "says"),
    [
        ("line.L5X", 'refused = "skip"\n', 'line.toml:3: stubs.refused = "skip": must be "empty"'),
        ("line.rung", EMPTY, 'line.toml:3: stubs.refused = "empty": only an export'),
    ],
)
def test_a_mistake_is_at_its_line(folder, program_name, given, says):
    (folder / "line.rung").write_text(
        "PROGRAM line\nTAG A : BOOL\nROUTINE Main\nOTE(A);\nEND\n", encoding="utf-8"
    )
    (folder / "line.toml").write_text(RACK.format(given).replace("line.L5X", program_name), encoding="utf-8")
    with pytest.raises(RackFileError) as refused:
        load_job("line.toml")
    assert says in str(refused.value)
