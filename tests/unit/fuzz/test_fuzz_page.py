"""A newcomer does what docs/fuzzing.md says, in an empty folder."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.io_images.amci3601 import StatusView
from scanrack.jobs import Kind
from typer.testing import CliRunner

DOCS = Path(__file__).parents[3] / "docs"
TEXT = (DOCS / "fuzzing.md").read_text(encoding="utf-8")
FILES = ("line.py", "line.toml", "must_hold.py")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder with the three files of the page."""
    blocks = re.findall(r"```(?:python|toml)\n(.*?)```", TEXT, flags=re.DOTALL)[: len(FILES)]
    for name, block in zip(FILES, blocks, strict=True):
        assert f"`{name}`" in TEXT
        (tmp_path / name).write_text(block, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scanrack(*words):
    return CliRunner().invoke(build(), [str(word) for word in words])


def told(output):
    """What is told of the failure, less the instants, which hang on what was drawn."""
    broken = output[output.index("broken: ") :]
    return re.sub(r"\d+(\.\d+)? (s|ms)|scan \d+", "N", broken).splitlines()


@pytest.mark.slow
def test_five_minutes_end_with_a_failure_that_can_be_looked_at_and_fixed(folder):
    command = ("fuzz", "line.toml", "--invariants", "must_hold.py", "--jobs", 1)
    first = scanrack(*command, "--runs", 40)
    assert first.exit_code == 1, first.output
    page = re.search(r"( +)broken: No COMMAND_ERROR.*?line-fuzz/command_error\n", TEXT, flags=re.DOTALL)
    assert page is not None
    assert told(first.stdout) == told(page[0].replace("\n" + page[1], "\n"))
    found = folder / "line-fuzz" / "command_error"
    table = TEXT[TEXT.index("## What comes out") : TEXT.index("The program's output is shown")]
    assert {path.name for path in found.iterdir()} == set(
        re.findall(r"^\| `([a-z0-9.-]+)`", table, re.MULTILINE)
    )
    assert scanrack("run", found / "rack.toml", "--quiet").exit_code == 0
    assert "CMD-06" in scanrack("show", found / "again.mcap").stdout
    bench = CliRunner().invoke(
        build(), ["drive", "amci3601"], input=(found / "drive-slot1.jsonl").read_text(encoding="utf-8")
    )
    assert "CMD-06" in bench.stdout

    program = (folder / "line.py").read_text(encoding="utf-8")
    branch = program.index("elif status.INPUT_ERROR:")
    fixed = program[:branch] + program[branch:].replace('step = "out"', 'step = "home"', 1)
    (folder / "line.py").write_text(fixed, encoding="utf-8")
    second = scanrack(*command, "--runs", 10)
    assert (second.exit_code, second.stdout.splitlines()[0]) == (
        0,
        "fixed: No COMMAND_ERROR ever [command_error]",
    )
    assert scanrack(*command, "--scenario", found / "scenario.json").stdout == "no invariant is broken\n"


def test_the_page_names_every_status_bit_and_every_kind():
    text = (DOCS / "fuzz-events.md").read_text(encoding="utf-8")
    bits = {name for name in vars(StatusView) if name.isupper()}
    assert {name for name in bits if f"`{name}`" not in text} == set()
    assert {kind.value for kind in Kind if f"\n| `{kind.value}` |" not in text} == set()
