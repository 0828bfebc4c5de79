"""A recording that another program takes away while it is written: a line and exit status 3."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import forked
import pytest
from scanrack.traces.files.presence import HEAD_BYTES
from scanrack.traces.write.output import TraceFile, open_trace_file

RECORD = b"\x0a" + bytes(range(255))


def removed(path: Path) -> None:
    path.unlink()


def renamed(path: Path) -> None:
    path.rename(path.with_suffix(".moved"))


def replaced(path: Path) -> None:
    new = path.with_suffix(".new")
    new.write_bytes(path.read_bytes())
    new.replace(path)


def emptied(path: Path) -> None:
    path.write_bytes(b"")


def shortened(path: Path) -> None:
    os.truncate(path, HEAD_BYTES + 1)


def overwritten(path: Path) -> None:
    """As `cp` does: the same file with other contents, as long as the recording."""
    path.write_bytes(b"x" * path.stat().st_size)


WAYS: dict[Callable[[Path], None], str] = {
    removed: "it was removed or renamed by another program",
    renamed: "it was removed or renamed by another program",
    replaced: "it was replaced by another program",
    emptied: "it was cut or overwritten by another program",
    shortened: "it was cut or overwritten by another program",
    overwritten: "it was cut or overwritten by another program",
}


@pytest.fixture
def trace(tmp_path: Path) -> tuple[Path, TraceFile]:
    path = tmp_path / "run.mcap"
    file = open_trace_file(path, 0)
    for _ in range(2 * HEAD_BYTES // len(RECORD)):
        file.write(RECORD)
    return path, file


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not take away an open file")
@pytest.mark.parametrize("goes_on", ["not", "with a record", "with a draft"])
@pytest.mark.parametrize("way", WAYS, ids=lambda way: way.__name__)
def test_a_recording_that_is_taken_away_is_told(
    trace: tuple[Path, TraceFile], way: Callable[[Path], None], goes_on: str
) -> None:
    path, file = trace
    way(path)
    if goes_on == "with a draft":
        file.draft(RECORD, 3 * len(RECORD))
    if goes_on != "not":
        file.write(RECORD)
    with pytest.raises(OSError, match=rf"run\.mcap: {WAYS[way]} while it was being recorded"):
        file.close()
    file.close()  # told once


def test_a_recording_that_is_left_alone_ends_without_a_word(trace: tuple[Path, TraceFile]) -> None:
    path, file = trace
    os.link(path, path.with_suffix(".other"))
    file.draft(RECORD, 3 * len(RECORD))
    file.write(RECORD)
    file.close()
    assert path.stat().st_size == (2 * HEAD_BYTES // len(RECORD) + 1) * len(RECORD)


def test_what_another_program_adds_is_told(trace: tuple[Path, TraceFile]) -> None:
    path, file = trace
    with path.open("ab") as other:
        other.write(b"more")
    with pytest.raises(OSError, match="it was cut or overwritten by another program"):
        file.close()


RACK = 'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
PROGRAM = "def logic(scan):\n    if scan.number == 20:\n        print('twenty', flush=True)\n"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not take away an open file")
@pytest.mark.parametrize("way", [removed, replaced, emptied], ids=lambda way: way.__name__)
@pytest.mark.parametrize("command", ["run", "run, not quiet", "serve"])
def test_a_command_whose_recording_is_taken_away_ends_with_3(
    command: str, way: Callable[[Path], None], tmp_path: Path
) -> None:
    (tmp_path / "line.toml").write_text(RACK, "utf-8")
    (tmp_path / "line.py").write_text(PROGRAM, "utf-8")
    words = {
        "run": ["run", "line.toml", "--realtime", "--record", "run.mcap", "-q"],
        "run, not quiet": ["run", "line.toml", "--realtime", "--record", "run.mcap"],
        "serve": ["serve", "pmc006", "--tcp", "0", "--record", "run.mcap"],
    }
    process = forked.start(
        [sys.executable, "-m", "scanrack", *words[command]],
        cwd=tmp_path,
        stdout=-1,
        stderr=-1,
        text=True,
        encoding="utf-8",
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline()
        way(tmp_path / "run.mcap")
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=120)
    told = next(line for line in err.splitlines() if WAYS[way] in line)
    assert (process.returncode, told.count(WAYS[way])) == (3, 1), err
    assert "run.mcap" in told
