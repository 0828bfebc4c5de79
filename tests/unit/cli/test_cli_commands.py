"""The list of commands: every one is there, and says what it does, without being imported for it."""

import subprocess
import sys

import pytest
from scanrack.runtime.cli import COMMANDS, build
from typer.testing import CliRunner


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_of_the_list_has_help_with_words_of_its_own(name):
    result = CliRunner().invoke(build(), [name, "--help"])
    assert result.exit_code == 0, result.output
    assert f" {name} " in result.stdout.splitlines()[0]


def test_help_lists_them_in_order():
    lines = CliRunner().invoke(build(), ["--help"]).stdout.splitlines()
    listed = lines[lines.index("Commands:") + 1 :]
    assert [line.split()[0] for line in listed] == list(COMMANDS)
    assert all(line.rstrip().endswith(".") for line in listed)


def test_an_unknown_command_is_refused():
    result = CliRunner().invoke(build(), ["fix"])
    assert result.exit_code == 2
    assert "there is no command 'fix': there are run, watch, show," in result.output


def test_help_does_not_wait_for_the_libraries_of_the_commands():
    code = (
        "import sys; from typer.testing import CliRunner; from scanrack.runtime.cli import build\n"
        "CliRunner().invoke(build(), ['--help'])\n"
        "print([name for name in ('hypothesis', 'numpy', 'mcap', 'lark') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
