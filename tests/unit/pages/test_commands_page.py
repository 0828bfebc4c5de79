"""The page of commands, docs/commands.md, and what each option needs: words of its own, and a test."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache
from importlib.util import resolve_name
from pathlib import Path

import typer
from commands_page import PAGE, REMEDY, commands, missing, page
from scanrack.commands import COMMANDS, build

TESTS = Path(__file__).parents[2]
OPTIONS = [
    (words.removeprefix("scanrack "), option)
    for words, command in commands(typer.main.get_command(build()))
    for option in command.params
    if option.param_type_name == "option"
]

COMMAND_NAMES = {words.split()[-1] for words, _ in OPTIONS}
OPTION = re.compile(r"(?<![\w-])--[a-z][\w-]*")
QUOTED = re.compile(r"""["'](?:scanrack )?([a-z]\w*)\b""")
MODULES = {"pcl601": ".wire.pcl601", "pmc006": ".wire.pmc006", "list": ".wire.discovery"}
"""Where a group within a group stands."""

SHARED = {"--json", "--quiet", "--replace"}
"""Options declared once for many commands."""

UNTRIED = {
    "compare --tolerance-counts",
    "device pcl601 home --type",
    "device pmc006 set --save",
    "serve --ascii",
    "serve --pin",
    "serve --start",
    "watch --open",
    "watch --text",
}
"""Options whose functions are tested in their place."""


def test_the_page_has_every_command_and_option() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert missing(text) == [], REMEDY
    assert text == page(), REMEDY


def test_an_option_that_the_page_lacks_is_named() -> None:
    row = "| `--limit N` | Maximum rows and events. | all |"
    assert missing(page().replace(f"{row}\n", "", 1)) == [f"missing: scanrack show TRACE: {row}"]


def test_every_option_says_what_it_does() -> None:
    assert [(words, option.opts[0]) for words, option in OPTIONS if not option.help] == []


@cache
def given_in_tests() -> list[tuple[set[str], set[str]]]:
    """Return options and commands that stand together: in a test, or in a file that is mainly about one."""
    found = []
    for path in set(TESTS.rglob("test_*.py")) - {Path(__file__)}:
        text = path.read_text(encoding="utf-8")
        if "--" in text:
            named = Counter(command for command in QUOTED.findall(text) if command in COMMAND_NAMES)
            mainly = [name for name, count in named.most_common(1) if 2 * count >= named.total()]
            imported = re.findall(r"from (scanrack\.(?:commands|watch)[\w.]*) import", text)
            found.append((set(OPTION.findall(text)), {*mainly, *imported}))
            found += [(set(OPTION.findall(part)), set(QUOTED.findall(part))) for part in text.split("\n\n\n")]
    return found


def tried(words: str, option: str) -> bool:
    """Whether a test gives an option to its command."""
    first, *within = words.split()
    module = COMMANDS[first].module if not within else MODULES.get(within[0], COMMANDS[first].module)
    command = {words.split()[-1], resolve_name(module, "scanrack.commands")}
    return any(option in options and command & commands for options, commands in given_in_tests())


def test_every_option_is_tried() -> None:
    every = {(words, name) for words, option in OPTIONS for name in option.opts[:1] if name not in SHARED}
    untried = {f"{words} {name}" for words, name in every if not tried(words, name)}
    assert untried - UNTRIED == set(), "add a test that gives the option to its command"
    assert untried >= UNTRIED
