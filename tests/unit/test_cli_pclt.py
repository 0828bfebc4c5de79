"""`scanrack pclt`: checking, assembling and disassembling stored programs from the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.runtime.cli import build
from typer.testing import CliRunner, Result

SAMPLES = sorted(Path(__file__).parents[2].glob("examples/pcl601/*.pclt"))


def pclt(*arguments: str | Path) -> Result:
    return CliRunner().invoke(build(), ["pclt", *map(str, arguments)])


def test_the_five_samples_can_be_stored() -> None:
    result = pclt("check", *SAMPLES)
    assert (result.exit_code, len(SAMPLES)) == (0, 5)
    assert result.stdout.count("of 2046 bytes") == 5


@pytest.mark.parametrize("sample", SAMPLES, ids=[sample.stem for sample in SAMPLES])
def test_a_sample_survives_assembling_and_disassembling(sample: Path, tmp_path: Path) -> None:
    memory, text, again = tmp_path / "a.bin", tmp_path / "b.pclt", tmp_path / "c.bin"
    assert pclt("assemble", sample, "-o", memory).exit_code == 0
    assert pclt("disassemble", memory, "-o", text).exit_code == 0
    assert pclt("assemble", text, "-o", again).exit_code == 0
    assert again.read_bytes() == memory.read_bytes()


def test_a_listing_has_addresses_and_bytes(tmp_path: Path) -> None:
    """MOVE is row 9 of the table, 4000 is 0FA0h; END is row 18."""
    file = tmp_path / "a.pclt"
    file.write_text("move 4000 ; out\nend\n")
    lines = pclt("assemble", file).stdout.splitlines()
    assert [line.split() for line in lines] == [
        ["0", "09", "00", "00", "00", "0f", "a0", "MOVE", "4000"],
        ["6", "12", "00", "END"],
    ]


@pytest.mark.parametrize(
    ("command", "content", "said"),
    [
        ("check", b"MOVE\nEND\n", "a: line 1, column 5: the line ends too early"),
        ("check", b"\xff", "a: it is no text: byte 0 is not UTF-8"),
        ("disassemble", b"\xee\x00", "a: address 0: 0xee is no instruction"),
    ],
)
def test_a_mistake_is_one_line_on_standard_error(
    command: str, content: bytes, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a").write_bytes(content)
    result = pclt(command, "a")
    assert result.exit_code == 2
    assert result.stderr.startswith(f"scanrack: {said}")
    assert result.stderr.count("\n") == 1


def test_a_file_that_is_not_there_is_named() -> None:
    result = pclt("check", "nothing.pclt")
    assert result.exit_code == 2
    assert "nothing.pclt: No such file" in result.stderr
