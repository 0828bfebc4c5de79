"""A recording that exists is kept under a number when a new one begins, unless the new one is the same."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest
from scanrack.commands import build
from scanrack.traces.files import keeping as keeping_module
from scanrack.traces.files.guard import OwnedError
from scanrack.traces.files.keeping import RecordingKeeper
from scanrack.traces.format.records import MAGIC
from scanrack.traces.write.output import open_trace_file
from typer.testing import CliRunner


def recorded(path: Path, text: str, most: int = 3, beside: dict[Path, str] | None = None) -> None:
    """Record a text, and texts beside it."""
    file = open_trace_file(path, 0, RecordingKeeper(path, most, list(beside or {})))
    file.write(MAGIC + text.encode())
    for place, other in (beside or {}).items():
        place.write_bytes(MAGIC + other.encode())
    file.close()


def found(folder: Path) -> dict[str, str]:
    return {path.name: path.read_bytes().removeprefix(MAGIC).decode() for path in sorted(folder.iterdir())}


def test_the_latest_is_number_1_and_the_oldest_goes(tmp_path: Path) -> None:
    for text in "abcdef":
        recorded(tmp_path / "run.mcap", text)
    assert found(tmp_path) == {"run.mcap": "f", "run.1.mcap": "e", "run.2.mcap": "d", "run.3.mcap": "c"}


def test_the_same_bytes_keep_nothing(tmp_path: Path) -> None:
    for text in "abb":
        recorded(tmp_path / "run.mcap", text)
    assert found(tmp_path) == {"run.mcap": "b", "run.1.mcap": "a"}


def test_while_it_records_the_earlier_one_is_there(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorded(path, "a")
    file = open_trace_file(path, 0, RecordingKeeper(path, 3))
    assert found(tmp_path) == {"run.mcap": "", "run.1.mcap": "a"}
    file.close()


def test_what_a_killed_process_left_goes_with_the_next_one(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    for text in "abc":
        recorded(path, text, most=2)
    killed = open_trace_file(path, 0, RecordingKeeper(path, 2))
    killed.write(MAGIC + b"killed")
    killed._keeping = None  # nobody keeps anything after the end of the process
    killed.close()
    assert found(tmp_path) == {
        "run.mcap": "killed", "run.1.mcap": "c", "run.2.mcap": "b", "run.3.mcap": "a"
    }  # fmt: skip
    recorded(path, "d", most=2)
    assert found(tmp_path) == {"run.mcap": "d", "run.1.mcap": "killed", "run.2.mcap": "c"}


def test_a_gap_ends_the_numbers_that_move(tmp_path: Path) -> None:
    (tmp_path / "run.3.mcap").write_bytes(MAGIC + b"old")
    for text in "ab":
        recorded(tmp_path / "run.mcap", text)
    assert found(tmp_path) == {"run.mcap": "b", "run.1.mcap": "a", "run.3.mcap": "old"}


def test_an_empty_file_is_not_kept(tmp_path: Path) -> None:
    (tmp_path / "run.mcap").touch()
    recorded(tmp_path / "run.mcap", "a")
    assert found(tmp_path) == {"run.mcap": "a"}


def test_the_file_that_a_link_leads_to_is_kept_beside_itself(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "here.mcap").symlink_to(tmp_path / "there" / "run.mcap")
    for text in "ab":
        recorded(tmp_path / "here.mcap", text)
    assert found(tmp_path / "there") == {"run.mcap": "b", "run.1.mcap": "a"}
    assert (tmp_path / "here.mcap").is_symlink()


def test_files_of_one_recording_stay_together(tmp_path: Path) -> None:
    path, line = tmp_path / "run.mcap", tmp_path / "run.line.mcap"
    recorded(path, "a", beside={line: "said"})
    recorded(path, "b", beside={line: "said"})
    assert found(tmp_path) == {
        "run.mcap": "b", "run.line.mcap": "said", "run.1.mcap": "a", "run.1.line.mcap": "said"
    }  # fmt: skip
    recorded(path, "b", beside={line: "said"})
    assert len(found(tmp_path)) == 4


@pytest.mark.parametrize("name", ["run.1.mcap", "run.3.mcap", "run.4.mcap"])
def test_what_is_no_recording_is_not_moved(tmp_path: Path, name: str) -> None:
    path = tmp_path / "run.mcap"
    recorded(path, "a")
    (tmp_path / name).write_text("notes", encoding="utf-8")
    with pytest.raises(OwnedError, match=f"{name} is not an MCAP recording"):
        recorded(path, "b")
    assert found(tmp_path) == {"run.mcap": "a", name: "notes"}


def test_a_recording_that_is_under_way_is_not_moved(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorded(path, "a")
    under_way = open_trace_file(tmp_path / "run.1.mcap", 0)
    with pytest.raises(OwnedError, match=r"run\.1\.mcap is being recorded"):
        recorded(path, "b")
    under_way.close()
    assert (tmp_path / "run.mcap").read_bytes() == MAGIC + b"a"


@pytest.mark.parametrize("failing", range(4))
def test_whichever_renaming_fails_all_is_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    path = tmp_path / "run.mcap"
    for text in "abcd":
        recorded(path, text)
    before, calls, rename = found(tmp_path), 0, Path.rename

    def sometimes(self: Path, target: Path) -> Any:
        nonlocal calls
        calls += 1
        if calls == failing + 1:
            raise OSError(errno.EIO, os.strerror(errno.EIO), str(self))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", sometimes)
    with pytest.raises(OSError, match="Input/output error"):
        recorded(path, "e")
    assert found(tmp_path) == before


def test_a_recording_that_can_not_be_opened_moves_all_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mcap"
    for text in "ab":
        recorded(path, text)
    before = found(tmp_path)

    def full(_path: Path) -> Any:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    monkeypatch.setattr("scanrack.traces.write.output._opened_empty", full)
    with pytest.raises(OSError, match="Too many open files"):
        recorded(path, "c")
    assert found(tmp_path) == before


def test_names_that_begin_alike_are_compared_to_their_ends(tmp_path: Path) -> None:
    one, other = tmp_path / "a", tmp_path / "b"
    size = keeping_module._COMPARED_BYTES + 1
    one.write_bytes(bytes(size))
    other.write_bytes(bytes(size - 1) + b"x")
    assert keeping_module.begin_alike(one, other, size - 1)
    assert not keeping_module.begin_alike(one, other, size)


RACK = 'program = "line.py"\n{}[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
PROGRAM = "def logic(scan):\n    scan.slot[1].outputs[7] = {}\n"


@pytest.fixture
def line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "line.toml").write_text(RACK.format(""), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(line: Path, value: object, *words: str) -> list[str]:
    """Run the rack with a program of its own; return the names of the recordings."""
    (line / "line.py").write_text(PROGRAM.format(value), encoding="utf-8")
    result = CliRunner().invoke(build(), ["run", "line.toml", "--scans", "3", "-q", *words])
    assert result.exit_code == (value == "1 / 0"), result.output
    return sorted(path.name for path in line.glob("*.mcap"))


def test_a_run_keeps_the_recording_before_it(line: Path) -> None:
    assert run(line, 1) == ["line.mcap"]
    before = (line / "line.mcap").read_bytes()
    assert run(line, 1) == ["line.mcap"]
    assert run(line, "1 / 0") == ["line.1.mcap", "line.mcap"]  # it faults in scan 0
    assert (line / "line.1.mcap").read_bytes() == before
    assert run(line, 2, "--replace") == ["line.1.mcap", "line.mcap"]
    assert (line / "line.1.mcap").read_bytes() == before


def test_the_rack_file_says_how_many(line: Path) -> None:
    (line / "line.toml").write_text(RACK.format("keep_traces = 1\n"), encoding="utf-8")
    for value in range(3):
        names = run(line, value)
    assert names == ["line.1.mcap", "line.mcap"]
    (line / "line.toml").write_text(RACK.format("keep_traces = 0\n"), encoding="utf-8")
    kept = (line / "line.1.mcap").read_bytes()
    run(line, 7)
    assert (line / "line.1.mcap").read_bytes() == kept


def test_a_replay_keeps_the_recording_in_whose_place_it_writes(line: Path) -> None:
    run(line, 1)
    (line / "line.mcap").rename(line / "other.mcap")
    before = (line / "other.mcap").read_bytes()
    run(line, 2)
    words = ["replay", "line.mcap", "--record", "other.mcap", "-q"]
    assert CliRunner().invoke(build(), words).exit_code == 0
    assert (line / "other.1.mcap").read_bytes() == before
    (line / "other.1.mcap").replace(line / "other.mcap")
    assert CliRunner().invoke(build(), [*words, "--replace"]).exit_code == 0
    assert (line / "other.mcap").read_bytes() != before
    assert not (line / "other.1.mcap").exists()


def test_a_replay_moves_no_recording_that_it_reads(line: Path) -> None:
    run(line, 1)
    (line / "line.mcap").rename(line / "line.1.mcap")
    result = CliRunner().invoke(build(), ["replay", "line.1.mcap", "--record", "line.mcap"])
    assert (result.exit_code, "line.1.mcap is the trace" in result.stderr) == (2, True), result.stderr


def test_tags_are_not_retained_where_a_recording_will_be_moved(line: Path) -> None:
    (line / "line.toml").write_text(RACK.format("").replace("line.py", "line.rung"), encoding="utf-8")
    (line / "line.rung").write_text(
        "PROGRAM line\nTAG A : BOOL\nROUTINE Main\nOTE(A);\nEND\n", encoding="utf-8"
    )
    words = ["run", "line.toml", "--scans", "1", "-q", "--retain", "line.2.mcap"]
    result = CliRunner().invoke(build(), words)
    assert (result.exit_code, "line.2.mcap is the recording" in result.stderr) == (2, True)
    assert not (line / "line.mcap").exists()
