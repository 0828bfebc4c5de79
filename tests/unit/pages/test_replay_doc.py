"""The page about comparing and replaying says what happens: its commands and its Python are run."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "replay.md").read_text(encoding="utf-8")
CONSOLE = re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL)
COMMAND = re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)
COMMANDS = [entry for block in CONSOLE for entry in COMMAND.findall(block)]
runner = CliRunner()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the example, the other line, the other program, and both recordings."""
    folder = tmp_path_factory.mktemp("doc")
    for name in ("line.toml", "line.py"):
        shutil.copy(ROOT / "examples" / "three_stations" / name, folder)
    changed(folder / "line.toml", folder / "slower.toml", "work_s = 2.0", "work_s = 2.004")
    changed(folder / "line.py", folder / "new.py", "speed=5000", "speed=4900")
    for rack, trace in (("line.toml", "simulated.mcap"), ("slower.toml", "machine.mcap")):
        result = runner.invoke(build(), ["run", str(folder / rack), "-q", "--record", str(folder / trace)])
        assert result.exit_code == 0
    return folder


def changed(source: Path, target: Path, old: str, new: str) -> None:
    text = source.read_text("utf-8")
    assert old in text
    target.write_text(text.replace(old, new), "utf-8")


def test_there_are_commands_to_try() -> None:
    assert len(COMMANDS) == 7


@pytest.mark.slow
@pytest.mark.parametrize(("command", "printed"), COMMANDS)
def test_a_command_prints_what_the_page_says(
    command: str, printed: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    program, *arguments = shlex.split(command)
    assert program == "scanrack"
    result = runner.invoke(build(), arguments)
    assert sorted(lines(result.output)) == sorted(lines(printed))


def lines(text: str) -> list[str]:
    """Return the lines; notes on standard error come anywhere among them, hashes are what they are."""
    return [re.sub(r"[0-9a-f]{12}\.\.\.", "#", line) for line in text.splitlines() if line]


@pytest.mark.parametrize("block", re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL))
def test_the_python_of_the_page_runs(
    block: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    exec(compile(block, "docs/replay.md", "exec"), {})
    printed = capsys.readouterr().out
    if "Follower" in block:
        assert printed == "None\n"
    else:
        # 4 ms late is allowed; the second time around the station is 8 ms late
        assert printed.startswith("11060 ['status_lsw', 'captured', 'command_msw', 'target']\n")
