"""Words of a command that can't be used: one line in our own style, with the way on, and status 2."""

from pathlib import Path

import pytest
from scanrack.commands import COMMANDS, build
from scanrack.commands.recordings import session_job
from scanrack.terminal import status
from typer.testing import CliRunner

LINES = {
    "run line.toml --tagz": "no such option: --tagz; did you mean --tag? ('scanrack run --help'{})",
    "run line.toml --trace t.mcap": "no such option: --trace; did you mean --record? "
    "('scanrack run --help'{})",
    "device pcl601 move -100": "-100 looks like an option; put -- before a negative number: "
    "scanrack device pcl601 move -- -100 ('scanrack device pcl601 move --help'{})",
    "serve pcl602": "DEVICE: 'pcl602' is not one of 'amci3601', 'pcl601', 'pmc006', 'smd23e2', 'smd24e2', "
    "'sd17060e2', 'ang1', 'anf2' "
    "('scanrack serve --help'{})",
    "run line.toml --scans x": "--scans: a whole number is needed ('scanrack run --help'{})",
    "watch line.toml --port -1": "--port: 0 or more is allowed ('scanrack watch --help'{})",
    "watch a.mcap --scans 4": "--scans needs a running rack; a.mcap is a trace",
    "watch nosuch --time-scale max": "nosuch: No such file or directory",
    "run press.py": 'press.py: no function rack; a program needs a rack file with program = "press.py"',
}
"""What is typed, and what is said; the page lists what there is."""

PRESS = """from scanrack import Logic


class Press(Logic):
    lamp = False
"""


def run(*words: str) -> tuple[int, str, str]:
    """Return exit status, standard output and standard error of a command."""
    done = CliRunner().invoke(build(), words, prog_name="scanrack")
    return done.exit_code, done.stdout, done.stderr


@pytest.mark.parametrize("line", LINES)
def test_what_is_wrong_is_one_line_of_ours(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("press.py").write_text(PRESS, encoding="utf-8")
    Path("a.mcap").write_bytes(b"")
    said = LINES[line].format(" lists what there is")
    assert run(*line.split()) == (2, "", f"scanrack: {said}\n")


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_h_is_help(command: str) -> None:
    words = command.split()
    short, long = run(*words, "-h"), run(*words, "--help")
    assert short == long
    assert short[0] == 0
    assert short[1].startswith(f"Usage: scanrack {command}".strip())


@pytest.mark.parametrize("command", COMMANDS)
def test_a_page_begins_as_the_list_of_commands_has_it(command: str) -> None:
    _, page, _ = run(command, "--help")
    said = " ".join(page.split("\n\n")[1].split())
    assert said.startswith(COMMANDS[command].sentence.removesuffix("."))


def test_a_command_without_words_prints_its_page() -> None:
    code, out, err = run("query")
    assert (code, out) == (2, "")
    assert err.startswith("Usage: scanrack query")


def test_a_rerun_that_is_stopped_does_not_say_that_it_differs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    Path("line.toml").write_text('program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', "utf-8")
    assert run("run", "line.toml", "--scans", "20", "--record", "a.mcap", "-q")[0] == 0
    monkeypatch.setattr(session_job, "run_job", lambda *_, **__: status.INTERRUPTED)
    assert run("replay", "--into", "session", "a.mcap") == (130, "", "")
