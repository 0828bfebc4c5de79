"""`scanrack fuzz` on racks whose slot holds an adapter."""

from __future__ import annotations

import json
import re

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

pytestmark = pytest.mark.slow

PROGRAM = """
from scanrack.io_images.amci3601 import Configuration, Idle, StatusView

WORDS = Configuration(inputs_used=0x3C, step_and_direction=True, starting_speed=500).to_image()

def logic(scan):
    status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
    out.load(Idle().to_image() if status.MODE_CONFIG or scan.number > 100 else WORDS)
    if scan.number > 120 and not status.MODULE_OK:
        raise RuntimeError("nobody thought of this")
"""
RACK = """program = "line.py"
run_for_s = 0.4
[[slot]]
number = 1
module = "{module}"
options = {{ {options} }}
"""
OPTIONS = {"pcl601-adapter": "", "pmc006-adapter": "home_stroke = 9000"}


def scanrack(*words):
    return CliRunner().invoke(build(), [str(word) for word in words])


def rack(folder, module):
    (folder / "line.py").write_text(PROGRAM, encoding="utf-8")
    text = RACK.format(module=module, options=OPTIONS[module])
    (folder / "line.toml").write_text(text, encoding="utf-8")
    return folder / "line.toml"


@pytest.mark.parametrize("module", OPTIONS)
def test_all_that_is_likely_happens_to_an_adapter(module, tmp_path):
    words = ("--runs", 10, "--for", "0.2 s", "--jobs", 1, "--out", tmp_path / "out", "--check", "one-motion")
    result = scanrack("fuzz", rack(tmp_path, module), *words)
    assert result.exit_code == 0, result.output
    found = re.search(r"^runs +(\d+)", result.stdout, re.MULTILINE)
    assert found is not None
    assert int(found[1]) >= 10  # and those that make a scenario smaller


def test_a_line_that_fails_breaks_a_program_and_can_be_run_again(tmp_path):
    out = tmp_path / "out"
    words = ("--runs", 20, "--jobs", 1, "--out", out, "--only", "line")
    result = scanrack("fuzz", rack(tmp_path, "pmc006-adapter"), *words)
    assert result.exit_code == 1, result.output
    assert "nobody thought of this" in result.stdout
    found = json.loads((out / "no-fault" / "scenario.json").read_text(encoding="utf-8"))
    assert len(found["incidents"]) == 1
    again = scanrack("run", out / "no-fault" / "rack.toml", "--no-record", "--quiet")
    assert again.exit_code == 1
    assert "nobody thought of this" in again.stderr
