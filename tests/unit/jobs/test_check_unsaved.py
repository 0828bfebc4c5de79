"""`check_texts`, which editors ask: without leave nothing in Python runs. It needs no extra."""

import pytest
from scanrack.jobs.check.texts import check_texts

MARKS = """from pathlib import Path

Path(__file__).with_suffix(".ran").touch()


def logic(scan):
    pass
"""
SLOT = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
RUNGS = "PROGRAM line\nTAG Count : DINT\nROUTINE Main\nADD(Count,1,Count);\nEND\n"
TEST = "TEST {rack} FOR 1 s\nROUTINE test_it\nNOP();\nEND\n"


@pytest.fixture
def folder(tmp_path):
    """Files of a stranger: each rack would run one of two modules in Python."""
    for name, text in {
        "own.py": MARKS,
        "stub.py": MARKS,
        "line.rung": RUNGS,
        "own.toml": f'program = "own.py"\n{SLOT}',
        "stubbed.toml": f'program = "line.rung"\n{SLOT}[stubs]\nMSG = "stub.py:logic"\n',
        "test_own.rung": TEST.format(rack="own.toml"),
        "test_stubbed.rung": TEST.format(rack="stubbed.toml"),
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


NAMES = ["own.py", "own.toml", "stubbed.toml", "line.rung", "test_own.rung", "test_stubbed.rung"]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_of_a_stranger_runs_nothing_unasked(name, folder):
    check_texts(folder / name, {}, run_python=False)
    assert list(folder.glob("*.ran")) == []


@pytest.mark.parametrize(
    ("name", "ran"), [("own.py", "own"), ("own.toml", "own"), ("test_own.rung", "own"), ("line.rung", "stub")]
)
def test_with_leave_the_same_file_runs_it(name, ran, folder):
    """Else the files above prove nothing."""
    check_texts(folder / name, {}, run_python=True)
    assert [each.name for each in folder.glob("*.ran")] == [f"{ran}.ran"]
