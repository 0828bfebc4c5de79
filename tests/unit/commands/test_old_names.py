"""Commands and options of the release before: each still works, and names what replaces it."""

from __future__ import annotations

from typing import Any

import pytest
import typer
from commands_page import chain, commands
from scanrack.commands import COMMANDS, build
from scanrack.commands import renamed as table
from scanrack.commands.renamed import OPTIONS, OldOption, renewed
from typer.testing import CliRunner

DROPPED = "; the next release drops the old name\n"


def run(*words: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(build(), words, prog_name="scanrack")
    return done.exit_code, done.stdout, done.stderr


def options_of(row: OldOption) -> dict[str, Any]:
    command = chain(typer.main.get_command(build()), row.command.split())[-1]
    return {name: each for each in command.params for name in each.opts}


@pytest.mark.parametrize("old", table.COMMANDS, ids=" ".join)
def test_an_old_command_works_and_names_the_new_one(old: tuple[str, ...]) -> None:
    new = table.COMMANDS[old]
    said = f"scanrack: 'scanrack {' '.join(old)}' is now 'scanrack {' '.join(new)}'{DROPPED}"
    assert run(*old, "--help") == (0, run(*new, "--help")[1], "" if old in table.KEPT else said)
    assert old[0] not in COMMANDS


@pytest.mark.parametrize("row", OPTIONS, ids=lambda row: f"{row.command} {row.old}")
def test_an_old_option_works_and_names_the_new_one(row: OldOption) -> None:
    known = options_of(row)
    value = [] if known[row.new].is_flag else ["1"]
    said = f"scanrack: '{row.old}' is now '{row.new}'{DROPPED}"
    status, page, note = run(*row.command.split(), row.old, *value, "--help")
    assert (status, note) == (0, said)
    assert f"{row.new} " in page
    assert row.old not in known


def test_values_and_spellings() -> None:
    cases = {
        "show a.mcap --time=1s:2s": "show a.mcap --range=1s:2s",
        "why line.toml Run --scans 30": "why line.toml Run --at 29",
        "why line.toml Run --scans x": "why line.toml Run --at x",
        "run line.toml --scans 30": "run line.toml --scans 30",
        "device pcl601 --port COM3 --unit 2 move 1": "device pcl601 --serial COM3 --address 2 move 1",
        "device pcl601 move -- --port": "device pcl601 move -- --port",
        "pcl601 --port COM3 status": "device pcl601 --serial COM3 status",
        "pclt check a.pclt b.pclt": "check a.pclt b.pclt",
        "rerun a.mcap --record b.mcap": "replay --into session a.mcap --record b.mcap",
        "--max-records 9 rerun a.mcap": "--max-records 9 replay --into session a.mcap",
        "--version": "--version",
        "": "",
    }
    assert {old: " ".join(renewed(old.split(), tuple(COMMANDS))[0]) for old in cases} == cases


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
        usage = run(*words.split()[1:], "--help")[1].split("\n\n")[0]
        assert not {*"{}<>"} & {*usage}, words
        assert "[[" not in usage, words
