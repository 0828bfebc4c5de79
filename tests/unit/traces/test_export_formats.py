"""Formats of export are rows: their options, guards, help and pages follow; and JSON lines as one of them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import commands_page
import formats_page
import numpy as np
import pytest
from made_traces import idle, record
from scanrack.commands import application, build
from scanrack.traces import open_trace
from scanrack.traces.export import formats, write_jsonl
from scanrack.traces.export.format import ExportFormat
from scanrack.traces.files.guard import beginning
from scanrack.traces.files.newfile import new_file
from scanrack.traces.signals import Selection
from typer.testing import CliRunner


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten scans; the position counts up, and is missing in scan 4, in configuration mode."""
    words = idle(10)
    words[:, 11] = np.arange(10)
    words[4, 8] = -31_682
    return record(tmp_path_factory.mktemp("formats") / "a.mcap", words)


def run(*words: object) -> tuple[int, str]:
    done = CliRunner().invoke(build(), list(map(str, words)))
    return done.exit_code, done.output


def test_json_lines_have_each_scan(path: Path, tmp_path: Path) -> None:
    target = tmp_path / "a.jsonl"
    chosen = ["slot1.in.position", "slot1.in.MODE_CONFIG"]
    with open_trace(path) as trace:
        assert write_jsonl(trace, target, chosen, Selection(first=3, last=4)) == 2
    lines = target.read_text(encoding="utf-8").splitlines()
    assert lines[0] == ('{"scan":3,"time_ns":6000000,"slot1.in.position":3,"slot1.in.MODE_CONFIG":false}')
    assert json.loads(lines[1])["slot1.in.position"] is None
    assert json.loads(lines[1])["slot1.in.MODE_CONFIG"] is True


def test_json_lines_of_all_signals_are_json(path: Path) -> None:
    status, said = run("export", path, "--jsonl", "-", "--quiet")
    assert status == 0
    rows = [json.loads(line, parse_constant=pytest.fail) for line in said.splitlines()]
    assert [row["scan"] for row in rows] == list(range(10))


def shout(trace, target, signals=(), selection=None, *, progress=None):
    with new_file(target, LOUD.kind) as file:
        file.write(f"LOUD {list(signals)}\n")
    return 7


LOUD = ExportFormat(
    name="loud",
    kind=beginning("a shout", b"LOUD"),
    write=shout,
    help="Write it in capitals.",
    contents="capitals only",
    reader="whoever is far away",
)


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """One more format, in a command that is built with it."""
    monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, LOUD))
    application._command.cache_clear()
    yield
    application._command.cache_clear()


@pytest.mark.usefixtures("added")
def test_a_format_that_is_added_is_written_and_guarded(path: Path, tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    for _ in range(2):  # the second one replaces the first
        assert run("export", path, "--loud", target, "--signal", "slot1.*") == (
            0,
            f"{target}: 7 scans, 17 bytes\n",
        )
    assert target.read_text(encoding="utf-8") == "LOUD ['slot1.*']\n"
    assert run("export", path, "--loud", "-", "--quiet") == (0, "LOUD []\n")
    assert "is the trace itself" in run("export", path, "--loud", path)[1]
    target.write_text("mine", encoding="utf-8")
    status, said = run("export", path, "--loud", target)
    assert (status, "is not a shout" in said) == (2, True)
    assert "--mcap, --loud" in run("export", path)[1]


@pytest.mark.usefixtures("added")
def test_a_format_that_is_added_is_on_every_page() -> None:
    assert "Write it in capitals." in run("export", "--help")[1]
    assert "| `--loud OUT` | Write it in capitals. |  |" in commands_page.page()
    page = formats_page.written(formats_page.PAGE.read_text(encoding="utf-8"))
    assert "[--mcap OUT] [--loud OUT] [--signal PATTERN]" in page
    assert "| `--loud` | capitals only | whoever is far away |\n" in page
