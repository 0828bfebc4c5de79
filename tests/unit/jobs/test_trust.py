"""What a run does with which files of a trace, decided from the rack file in it."""

import pytest
from scanrack.jobs.trust.trust import FileUse, RunFiles, uses_of

RACK = b"""program = "line.rung"
[[slot]]
number = 1
module = "amci3601"
"""
STUBS = b'[stubs]\nMSG = "answers.py:msg"\n'


def test_rungs_and_data_are_read():
    files = {"line.toml": RACK, "line.rung": b""}
    assert uses_of(files, RunFiles("line.toml", "line.rung")) == {
        "line.toml": FileUse.READ,
        "line.rung": FileUse.READ,
    }


def test_python_of_a_stub_runs_and_reaches_the_rest():
    files = {"line.toml": RACK + STUBS, "line.rung": b"", "answers.py": b"", "else.txt": b""}
    uses = uses_of(files, RunFiles("line.toml", "line.rung"))
    assert uses["answers.py"] is FileUse.RUN
    assert uses["else.txt"] is FileUse.REACHED


def test_retained_values_are_read_by_their_name():
    files = {"line.toml": RACK, "line.rung": b"", "kept.toml": b""}
    assert uses_of(files, RunFiles("line.toml", "line.rung", "kept.toml"))["kept.toml"] is FileUse.READ
    with pytest.raises(ValueError, match=r"\.\./kept\.toml"):
        uses_of(files, RunFiles("line.toml", "line.rung", "../kept.toml"))
