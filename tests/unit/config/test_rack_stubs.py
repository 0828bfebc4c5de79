"""`[stubs]` of a rack file: read, refused with their line, recorded, and trusted like programs."""

import sys

import pytest
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.runtime import RackFileError
from scanrack.traces import open_trace
from typer.testing import CliRunner

RUNGS = "PROGRAM line\nTAG Go : BOOL\nTAG N : DINT\nROUTINE Main\nXIO(Go)XRP(N)ALMD(A,0,0,0,0);\nEND\n"
PLANT = "def xrp(tags, rung, count):\n    count.value += 1\n"
RACK = """program = "line.rung"
[stubs]
XRP = "plant.py:xrp"
ALMD = "false"
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    for name, text in (("line.rung", RUNGS), ("plant.py", PLANT), ("line.toml", RACK)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def scanrack(*arguments):
    """Run a command; return its exit status and all that it wrote."""
    result = CliRunner().invoke(build(), list(arguments))
    return result.exit_code, result.output


def test_the_summary_and_the_trace_name_the_stubs_in_use(folder):
    status, output = scanrack("run", "line.toml", "--scans", "5", "--record", "a.mcap")
    assert status == 0
    assert "stubs         XRP = plant.py:xrp (once)" in output
    assert "ALMD = false (once)" in output
    with open_trace("a.mcap") as trace:
        assert trace.head.metadata["stubs"] == "XRP = plant.py:xrp (once); ALMD = false (once)"
        assert "plant.py" in [each.name for each in trace.attachments()]


def test_a_rerun_of_foreign_python_needs_trust(folder, monkeypatch):
    assert scanrack("run", "line.toml", "--scans", "5", "--record", "a.mcap")[0] == 0
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    status, output = scanrack("replay", "--into", "session", "../a.mcap")
    assert status != 0
    assert "this would run Python that came with the trace" in output
    assert "plant.py" in output
    status, output = scanrack("replay", "--into", "session", "../a.mcap", "--trust")
    assert (status, "identical byte for byte" in output) == (0, True)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ('XRP = "falsch"', "line.toml:3: stubs.XRP = \"falsch\": 'falsch' is not a stub"),
        ('JMP = "false"', 'line.toml:3: stubs.JMP = "false": JMP decides what runs next'),
        ('XRP = "none.py:xrp"', "no such program file"),
        ('missing_tags = "invent"', 'stubs.missing_tags = "invent": must be "declare"'),
        ("XRP = 3", "line.toml:3: stubs.XRP = 3: must be text in quotes, or a table"),
    ],
)
def test_a_mistake_is_at_its_line(folder, given, says):
    (folder / "line.toml").write_text(RACK.replace('XRP = "plant.py:xrp"', given), encoding="utf-8")
    with pytest.raises(RackFileError) as refused:
        load_job("line.toml")
    assert says in str(refused.value)


def test_a_function_has_no_instructions_to_stub(folder):
    (folder / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (folder / "line.toml").write_text(RACK.replace("line.rung", "line.py"), encoding="utf-8")
    with pytest.raises(RackFileError, match="the program is a function, which has no instructions"):
        load_job("line.toml")
