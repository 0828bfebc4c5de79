"""The page about queries says what happens: its commands, its table and its Python are run."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.traces import SlotInfo
from scanrack.traces.query.language import parse
from scanrack.traces.signals import Catalog
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "query.md").read_text(encoding="utf-8")
CONSOLE = re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL)
COMMAND = re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)
COMMANDS = [entry for block in CONSOLE for entry in COMMAND.findall(block)]
CATALOG = Catalog([SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "a toy")])
runner = CliRunner()


def table(heading: str) -> list[list[str]]:
    """Return the cells of the first table after a heading of the page of the language."""
    text = (ROOT / "docs" / "query-language.md").read_text(encoding="utf-8")
    rows = re.search(r"^\|.*?\n\n", text[text.index(heading) :], re.MULTILINE | re.DOTALL)
    assert rows is not None
    return [line.strip("|").split("|") for line in rows[0].strip().splitlines()[2:]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the trace of the example."""
    folder = tmp_path_factory.mktemp("doc")
    (folder / "examples").symlink_to(ROOT / "examples")  # the page's commands start at the top
    rack = ROOT / "examples" / "three_stations" / "line.toml"
    result = runner.invoke(build(), ["run", str(rack), "-q", "--record", str(folder / "three-stations.mcap")])
    assert result.exit_code == 0
    return folder


def test_there_are_commands_to_try() -> None:
    assert len(COMMANDS) >= 8


@pytest.mark.parametrize(("command", "printed"), COMMANDS)
def test_a_command_prints_what_the_page_says(
    command: str, printed: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    program, *arguments = shlex.split(command)
    assert program == "scanrack"
    result = runner.invoke(build(), arguments)
    assert words(result.output) == words(printed)


def words(text: str) -> list[list[str]]:
    return [line.split() for line in text.splitlines()]


@pytest.mark.parametrize("example", [row[2].strip().strip("`") for row in table("## The language")])
def test_an_example_of_the_language_is_understood(example: str) -> None:
    parse(example, CATALOG)


@pytest.mark.parametrize(
    "name", [name for row in table("## Signals") for name in re.findall(r"`([^`]+)`", row[0])]
)
def test_a_signal_of_the_page_exists(name: str) -> None:
    assert CATALOG[name].name == name


FRAMES = pytest.mark.extra("frames")
BLOCKS = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


@pytest.mark.slow
@pytest.mark.parametrize(
    "block", [pytest.param(each, marks=[FRAMES] if "to_pandas" in each else []) for each in BLOCKS]
)
def test_the_python_of_the_page_runs(block: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    exec(compile(block, "docs/query.md", "exec"), {})
