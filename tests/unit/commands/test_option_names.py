"""An option means the same in every command, and pages of help show what it takes."""

from __future__ import annotations

import pytest
import typer
from commands_page import chain, commands
from scanrack.commands import build
from typer.testing import CliRunner


def test_an_option_means_one_thing() -> None:
    """Of the design's table: what each of these spellings means, in every command that has it."""
    meanings = {
        "--at": {"TIME|SCAN", "TIME"},
        "--range": {"A:B"},
        "--time-scale": {"FACTOR"},
        "--speed": {"V"},
        "--serial": {"DEVICE"},
        "--port": {"PORT"},
        "--scans": {"N"},
        "--rack": {"RACK"},
        "--rung": {"N"},
        "--only": {"KIND"},
        "--from": {"EXAMPLE"},
        "--budget": {"TIME"},
    }
    found: dict[str, set[str]] = {name: set() for name in meanings}
    groups = [chain(typer.main.get_command(build()), ["device", each])[-1] for each in ("pcl601", "pmc006")]
    each_command = [each for _, each in commands(typer.main.get_command(build()))]
    for parameter in (each for command in (*each_command, *groups) for each in command.params):
        for name in found.keys() & parameter.opts:
            found[name].add(parameter.metavar)
    assert found == meanings


@pytest.mark.slow
def test_words_that_stand_for_a_value_are_capitals_or_what_may_be_given() -> None:
    """`<int range>` and `{RACK}` of the library are not shown."""
    for words, command in commands(typer.main.get_command(build())):
        for parameter in command.params:
            if parameter.param_type_name == "argument" or not parameter.is_flag:
                metavar = parameter.metavar or ""
                assert metavar, (words, parameter.name)
                assert metavar == metavar.upper() or "|" in metavar
        page = CliRunner().invoke(build(), [*words.split()[1:], "--help"], prog_name="scanrack").stdout
        usage = page.split("\n\n")[0]
        assert not {*"{}<>"} & {*usage}, words
        assert "[[" not in usage, words
