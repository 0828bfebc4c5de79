"""Control characters of files do not reach the terminal; every command prints through `say`.

Broken on purpose: `visible` that lets ESC through, a table whose cells are printed as they are.
"""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path

import made_traces
import numpy as np
import pytest
from rich.console import Console
from scanrack import commands as cli
from scanrack.commands import build
from scanrack.commands.recordings import show
from scanrack.commands.wire.link_commands import show_state
from scanrack.io_images.visible_text import LAYOUT, visible
from scanrack.terminal.terminal import on_a_line
from scanrack.traces import SlotInfo
from typer.testing import CliRunner, Result

ATTACK = "\x1b[2J\x1b]0;owned\x07\x9b31m\r\x7f\u202e\u2066\u2028"
BAD = {each for each in ATTACK if not each.isprintable()}


def scanrack(*arguments: object) -> Result:
    return CliRunner().invoke(build(), [str(argument) for argument in arguments], color=True)


def clean(result: Result) -> bool:
    return BAD.isdisjoint(result.output) and "\\x1b" in result.output


@pytest.mark.parametrize("number", [*range(0x20), *range(0x7F, 0xA0), 0x200B, 0x202E, 0x2028, 0xD800, 0xFEFF])
def test_a_character_without_a_picture_is_shown_as_python_writes_it(number: int) -> None:
    shown = visible(chr(number))
    assert shown == (chr(number) if chr(number) in LAYOUT else repr(chr(number))[1:-1])
    assert on_a_line(chr(number)) == repr(chr(number))[1:-1]


@pytest.mark.parametrize("text", ["", "line 7", "µs × ±", "┤├ ─", "a\tb\nc", "Vorschub größer", "\u00a0"])
def test_text_stays_as_it_is(text: str) -> None:
    assert visible(text) == text


@pytest.fixture
def trace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A trace whose metadata, slots, events and files are full of escape sequences."""
    monkeypatch.chdir(tmp_path)
    words = np.repeat(made_traces.idle(1), 5, axis=0)
    events = {2: ("/stimuli", {"name": ATTACK, "slot": 1, "energized": ATTACK})}
    metadata = {
        "name": f"{ATTACK}\nnote: all is well",
        ATTACK: "x",
        "rack_file": ATTACK,
        "program_file": ATTACK,
    }
    slots = [SlotInfo(1, f"amci3601{ATTACK}", ATTACK)]
    return made_traces.record(tmp_path / "bad.mcap", words, slots, events=events, metadata=metadata)


def test_show_makes_them_visible(trace: Path) -> None:
    result = scanrack("show", trace)
    assert result.exit_code == 0
    assert clean(result)
    assert "\nnote: all is well" not in result.output, "a name can't begin a line of ours"


def test_show_does_so_on_a_terminal_too(trace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def terminal(**options: object) -> Console:
        return Console(force_terminal=True, color_system=None, width=200, file=sys.stdout, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(show, "Console", terminal)
    assert clean(scanrack("show", trace))


def test_compare_makes_them_visible(trace: Path, tmp_path: Path) -> None:
    words = np.repeat(made_traces.idle(1), 5, axis=0)
    words[3:, 3] = 7
    events = {3: ("/stimuli", {"name": ATTACK, "slot": 1})}
    slots = [SlotInfo(1, f"amci3601{ATTACK}", ATTACK)]
    other = made_traces.record(tmp_path / "other.mcap", words, slots, events=events)
    result = scanrack("compare", trace, other)
    assert result.exit_code == 1
    assert BAD.isdisjoint(result.output)
    names = json.loads(scanrack("compare", trace, other, "--json").output)["names"]
    assert names == ["bad.mcap", "other.mcap"]


def test_a_cell_is_no_markup(capsys: pytest.CaptureFixture[str]) -> None:
    """`[/]` ended the command with an error of rich; `[link=...]` made a link."""
    show_state([("[/]", "[link=https://x]y[/link] :smile:")])
    assert capsys.readouterr().out.split() == ["[/]", "[link=https://x]y[/link]", ":smile:"]


@pytest.mark.parametrize("command", ["replay --into session", "replay", "fuzz"])
def test_messages_make_them_visible(trace: Path, command: str) -> None:
    result = scanrack(*command.split(), trace)
    assert result.exit_code == 2
    assert clean(result)


def test_mistakes_in_files_make_them_visible(tmp_path: Path) -> None:
    rack = tmp_path / "rack.toml"
    rack.write_text(
        'program = "line.py"\n"\\u001b[2J" = 1\n[[slot]]\nnumber = 1\nmodule = "\\u001b[2J"\n',
        encoding="utf-8",
    )
    for command in (["run", rack], ["why", rack, "T"], ["fuzz", rack], ["ladder", rack]):
        result = scanrack(*command)
        assert result.exit_code == 2
        assert clean(result), command
    rungs = tmp_path / "bad.rung"
    rungs.write_text("PROGRAM p\nROUTINE Main\n// \x1b[2J\nXIC(\x1b[2J)NOP();\nEND\n", encoding="utf-8")
    assert clean(scanrack("xref", rungs, "\x1b[2J"))


def test_nothing_is_printed_past_say() -> None:
    """The linter bans typer.echo and print; writing to the streams is left, for data."""
    streams = {
        path.name
        for path in Path(str(cli.__file__)).parent.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("sys.stdout.write", "sys.stderr.write")
    }
    assert streams <= {"drive.py"}
