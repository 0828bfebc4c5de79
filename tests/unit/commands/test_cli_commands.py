"""The list of commands: every one is there, and says what it does, without being imported for it."""

import subprocess
import sys
from pathlib import Path

import pytest
from scanrack.commands import COMMANDS, GROUPS, build
from typer.testing import CliRunner


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_of_the_list_has_help_with_words_of_its_own(name):
    result = CliRunner().invoke(build(), [name, "--help"])
    assert result.exit_code == 0, result.output
    assert f" {name} " in result.stdout.splitlines()[0]


def test_help_lists_them_in_order():
    lines = CliRunner().invoke(build(), ["--help"]).stdout.splitlines()
    listed = [line for line in lines[lines.index("Run and watch:") :] if line]
    headings = [line for line in listed if not line.startswith(" ")]
    assert headings == [f"{heading}:" for heading in GROUPS]
    named = [line for line in listed if line not in headings]
    assert [line.split()[0] for line in named] == list(COMMANDS)
    assert all(line.rstrip().endswith(".") for line in named)


def test_an_unknown_command_is_refused():
    result = CliRunner().invoke(build(), ["fix"])
    assert result.exit_code == 2
    assert "no command 'fix'; choose from new, run, watch," in result.output


EXAMPLES = Path(__file__).parents[3] / "examples"
RECORDED = ("run", str(EXAMPLES / "feeder" / "feeder.toml"), "--scans", "10", "--record", "TRACE", "--quiet")
UNNEEDED = {
    "help": (("--help",), ("hypothesis", "numpy", "mcap", "lark")),
    "run": (
        RECORDED,
        (
            *("hypothesis", "pymodbus", "asyncio", "lark", "lxml", "rich", "scanrack.ladder.draw"),
            *("scanrack.runtime.live", "scanrack.runtime.tag_servers", "scanrack.runtime.loop.realtime"),
            *("scanrack.io_images.pcl601", "scanrack.traces.read.reader"),
            *("scanrack.ladder.python.online.editing", "scanrack.jobs.run.playback"),
        ),
    ),
    "show": (("show", "TRACE"), ("hypothesis", "pymodbus", "lark", "scanrack.ladder")),
    "l5x": (
        ("l5x", str(EXAMPLES / "l5x" / "indexer.L5X")),
        ("hypothesis", "pymodbus", "scanrack.runtime.config"),
    ),
}
"""Commands, and libraries and rooms that take time to import and that they do without."""


@pytest.mark.slow
@pytest.mark.parametrize("command", UNNEEDED)
def test_a_command_does_not_wait_for_libraries_that_it_does_not_use(command, tmp_path):
    trace = str(tmp_path / "a.mcap")
    recorded = [trace if word == "TRACE" else word for word in RECORDED]
    if command == "show":
        subprocess.run([sys.executable, "-m", "scanrack", *recorded], check=True)
    arguments, unneeded = UNNEEDED[command]
    words = [trace if word == "TRACE" else word for word in arguments]
    code = (
        "import sys; from typer.testing import CliRunner; from scanrack.commands import build\n"
        f"result = CliRunner().invoke(build(), {words!r}); assert result.exit_code in (0, 1), result.output\n"
        f"print([name for name in {unneeded!r} if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, encoding="utf-8"
    )
    assert done.stdout.strip() == "[]"
