"""The examples of every help text run where scanrack is installed, which has neither examples/ nor docs/."""

from __future__ import annotations

import inspect
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer
from commands_page import chain, commands
from scanrack.commands import build
from typer.testing import CliRunner

GROUP: Any = typer.main.get_command(build())
COMMANDS: list[tuple[str, Any]] = list(commands(GROUP))
EXAMPLES = re.compile(r"^Examples:\n((?: {4}scanrack .*(?:\n|\Z))+)", re.MULTILINE)


def texts(command: Any) -> list[str]:
    """Return every text of a command's help."""
    return [inspect.cleandoc(command.help or ""), *(str(each.help or "") for each in command.params)]


def examples(command: Any) -> list[str]:
    """Return the lines of the examples of a command's help."""
    return [line.strip() for lines in EXAMPLES.findall(command.help or "") for line in lines.splitlines()]


def in_project(example: str) -> bool:
    """Whether an example names a file in a folder, which an example before it has to make."""
    return re.search(r" (?!/)[\w-]+/", example) is not None


SERIES = {words: examples(command) for words, command in COMMANDS}
PROJECTS = {
    words: some
    for words, some in SERIES.items()
    if (any(map(in_project, some)) or words == "scanrack new")
    and words != "scanrack watch"  # it does not end
}


def test_no_help_names_a_folder_of_the_checkout() -> None:
    device = GROUP.get_command(typer.Context(GROUP), "device")
    within = [device.commands["pcl601"], device.commands["pmc006"]]
    groups = [
        GROUP,
        *(GROUP.get_command(typer.Context(GROUP), each) for each in ("device", "editor")),
        *within,
    ]
    shown = [(each.name, text) for each in (*groups, *(one for _, one in COMMANDS)) for text in texts(each)]
    assert len(shown) > 200
    assert [each for each in shown if re.search(r"\b(?:examples|docs|tests)/", each[1])] == []
    assert [each for each in shown if re.search(r"Examples?: *\S", each[1])] == []  # examples are lines


def test_there_are_examples_with_a_project_and_without() -> None:
    assert {"scanrack check", "scanrack ladder", "scanrack prove", "scanrack why"} <= PROJECTS.keys()
    assert sum(map(len, SERIES.values())) > 25


@pytest.mark.parametrize(("words", "command"), [each for each in COMMANDS if SERIES[each[0]]])
def test_each_example_has_options_that_there_are(words: str, command: Any) -> None:
    path = chain(GROUP, words.split()[1:])
    assert path[-1].name == command.name
    known = {name for each in path for option in each.params for name in option.opts}
    for example in SERIES[words]:
        _, name, *rest = shlex.split(example)
        if name == words.split()[1]:
            assert words.split()[-1] in (name, *rest)
            assert {each for each in rest if each.startswith("--")} - {"--"} <= known, example


@pytest.mark.slow
@pytest.mark.parametrize("words", PROJECTS)
def test_an_example_with_a_project_runs_as_printed(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if words == "scanrack prove":
        pytest.importorskip("bitwuzla", reason="the extra prove is not installed")
    monkeypatch.chdir(tmp_path)
    for example in PROJECTS[words]:
        if " new " in example or in_project(example):
            done = CliRunner().invoke(build(), shlex.split(example)[1:])
            assert done.exit_code == 0, f"{example}\n{done.output}"


@pytest.mark.parametrize("width", [40, 80])
def test_an_example_is_one_line_at_any_width(width: int) -> None:
    shown = CliRunner().invoke(build(), ["why", "--help"], env={"COLUMNS": str(width)}).output
    assert SERIES["scanrack why"]
    assert [each for each in SERIES["scanrack why"] if each not in map(str.strip, shown.splitlines())] == []


def test_arguments_are_listed_without_types() -> None:
    shown = CliRunner().invoke(build(), ["compare", "--help"]).output
    assert re.findall(r"^  [AB]  .*", shown, re.MULTILINE) == [
        "  A  Trace, an MCAP file.  [required]",
        "  B  Another trace.  [required]",
    ]
