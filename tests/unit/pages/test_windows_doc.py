"""docs/windows.md: what it says of ports, of installation and of what is missing is what the code does."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import typer
from commands_page import chain
from scanrack.commands import build
from scanrack.io_images.installing import install_line
from scanrack.runtime import load_rack_file
from scanrack.runtime.line.ports.pty import NO_PTY, PtyPort

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"
PAGE = (DOCS / "windows.md").read_text(encoding="utf-8")


def test_the_contents_name_the_page() -> None:
    contents = (DOCS / "index.md").read_text(encoding="utf-8")
    assert "\n* [On Windows](windows.md)\n" in contents
    assert "(../windows.md)" in (DOCS / "tutorial" / "1-watch.md").read_text(encoding="utf-8")


def test_it_says_that_nobody_has_run_it_there_and_where_the_result_of_a_job_is_seen() -> None:
    assert (
        "Not yet run on Windows and macOS by us." in PAGE
    )  # until a job there was green: no test can see that
    (workflow,) = re.findall(r"https://github.com/scanrack/scanrack/actions/workflows/(\w+\.yml)", PAGE)
    text = (ROOT / ".github" / "workflows" / workflow).read_text(encoding="utf-8")
    for system in ("windows-latest", "macos-latest"):
        assert system in text
        assert system in PAGE


def test_installation_is_that_of_the_other_pages() -> None:
    (block,) = re.findall(r"(?:^    .*\n)+", PAGE[PAGE.index("    py -m venv") :], re.MULTILINE)[:1]
    assert [line.strip() for line in block.splitlines()] == [
        "py -m venv .venv",
        r".venv\Scripts\Activate.ps1",
        install_line(),
    ]


def test_the_rack_of_the_page_has_the_port_that_windows_names(tmp_path: Path) -> None:
    (text,) = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    ports = {text: "\\\\.\\COM10", text.replace("'\\\\.\\COM10'", '"COM3"'): "COM3"}
    assert len(ports) == 2
    rack = tmp_path / "rack.toml"
    for each, port in ports.items():
        rack.write_text('program = "line.rung"\n' + each, encoding="utf-8")
        assert tomllib.loads(each)["slot"][0]["port"] == port
        assert load_rack_file(str(rack)).spec.slot[0].port == port


def test_a_system_without_pseudo_terminals_names_the_two_ways_of_the_page(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr("os.openpty")
    with pytest.raises(ValueError, match="no pseudo-terminals"):
        PtyPort()
    for way in ("--tcp", "--serial", "pair of virtual"):
        assert way in NO_PTY
        assert way in PAGE


def test_its_commands_and_options_exist() -> None:
    group: Any = typer.main.get_command(build())
    for words in re.findall(r"\bscanrack ([a-z]\w+(?: [^`\n;|]*)?)", re.sub(r"\]\([^)]*\)", "", PAGE)):
        if words.split()[0] in ("on", "in"):
            continue  # prose
        known = {
            name for command in chain(group, words.split()) for each in command.params for name in each.opts
        }
        assert {each for each in words.split() if each.startswith("--")} <= known, words
