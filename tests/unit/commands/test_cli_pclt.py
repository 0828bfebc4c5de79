"""Checking and listing stored programs of the PCL601 from the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner, Result

SAMPLES = sorted(Path(__file__).parents[3].glob("examples/pcl601/*.pclt"))


def pclt(command: str, *files: str | Path) -> Result:
    words = {"check": ["check"], "list": ["device", "pcl601", "program", "list"]}
    return CliRunner().invoke(build(), [*words[command], *map(str, files)])


def test_the_five_samples_can_be_stored() -> None:
    result = pclt("check", *SAMPLES)
    assert (result.exit_code, len(SAMPLES)) == (0, 5)
    assert result.stdout.count("of 2046 bytes") == 5


def test_a_listing_has_addresses_and_sizes(tmp_path: Path) -> None:
    """MOVE takes 6 bytes, TEXT 2 and its characters, END 2: the table of docs/pcl601-programs.md."""
    file = tmp_path / "a.pclt"
    file.write_text('move 4000 ; out\ntext "@1G"\nend\n', encoding="utf-8")
    lines = pclt("list", file).stdout.splitlines()
    assert lines == ["    0   6  MOVE 4000", '    6   5  TEXT "@1G"', "   11   2  END"]


@pytest.mark.parametrize("sample", SAMPLES, ids=[sample.stem for sample in SAMPLES])
def test_the_listing_of_a_sample_fills_the_memory_without_gaps(sample: Path) -> None:
    rows = [line.split()[:2] for line in pclt("list", sample).stdout.splitlines()]
    ends = [int(address) + int(size) for address, size in rows]
    assert [int(address) for address, _ in rows] == [0, *ends[:-1]]
    assert f" {ends[-1]} of 2046 bytes" in pclt("check", sample).stdout


@pytest.mark.parametrize(
    ("command", "content", "said"),
    [
        ("check", b"MOVE\nEND\n", "a.pclt: line 1, column 5: the line ends too early"),
        ("check", b"\xff", "a.pclt: the file is not text: byte 0 is not UTF-8"),
        ("list", b"MOVE 4000\n", "a.pclt: line 1: END is missing"),
    ],
)
def test_a_mistake_is_one_line_on_standard_error(
    command: str, content: bytes, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.pclt").write_bytes(content)
    result = pclt(command, "a.pclt")
    assert result.exit_code == 2
    assert result.stderr.startswith(f"scanrack: {said}")
    assert result.stderr.count("\n") == 1


def test_a_file_that_is_not_there_is_named() -> None:
    result = pclt("check", "nothing.pclt")
    assert result.exit_code == 2
    assert "nothing.pclt: No such file" in result.stderr
