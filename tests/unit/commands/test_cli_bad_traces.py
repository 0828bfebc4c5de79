"""Every command that reads traces, given what is none, or a damaged one: one line, and what is whole."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from made_traces import idle, record
from mcap.writer import Writer
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from scanrack.traces.write import recorder
from typer.testing import CliRunner

COMMANDS = {
    "show": ["show", "TRACE"],
    "extract": ["show", "TRACE", "--extract", "out"],
    "query": ["query", "TRACE", "slot1.in.MODULE_OK"],
    "csv": ["export", "TRACE", "--csv", "out.csv"],
    "vcd": ["export", "TRACE", "--vcd", "out.vcd"],
    "page": ["plot", "TRACE", "--out", "out.html"],
    "repair": ["repair", "TRACE"],
    "compare": ["compare", "TRACE", "good.mcap"],
    "compare with": ["compare", "good.mcap", "TRACE"],
    "replay": ["replay", "TRACE"],
    "rerun": ["replay", "--into", "session", "TRACE"],
}


def foreign(path: Path) -> None:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("", "somebody else")
        channel = writer.register_channel("/imu", "json", writer.register_schema("Imu", "jsonschema", b"{}"))
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()


def newer(path: Path, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(recorder, "FORMAT", 3)
    record(path, idle(10))


def cut_in_its_head(path: Path) -> None:
    record(path, idle(10))
    path.write_bytes(path.read_bytes()[:900])


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


BAD: dict[str, tuple[Callable[..., object], str]] = {
    "missing": (lambda path: None, "No such file or directory"),
    "directory": (lambda path: path.mkdir(), "Is a directory"),
    "pipe": (a_pipe, "it is not a file"),
    "empty": (lambda path: path.write_bytes(b""), "it is not an MCAP file"),
    "text": (
        lambda path: path.write_text("scan,position\n" * 99, encoding="utf-8"),
        "it is not an MCAP file",
    ),
    "magic only": (lambda path: path.write_bytes(b"\x89MCAP0\r\n"), "it has no header"),
    "foreign": (foreign, "it has no channel /scan; its topics are: /imu"),
    "cut in its head": (cut_in_its_head, "ends at byte"),
}


def run(folder: Path, command: str) -> tuple[int, str, str]:
    places = {"TRACE", "good.mcap", "out", "out.csv", "out.vcd", "out.html"}
    name = {"TRACE": "bad.mcap"}
    arguments = [str(folder / name.get(word, word)) if word in places else word for word in COMMANDS[command]]
    result = CliRunner().invoke(build(), arguments)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stdout, result.stderr


def refused(folder: Path, command: str, says: str) -> None:
    status, out, err = run(folder, command)
    assert (status, out) == (2, "")
    assert err.startswith(f"scanrack: {folder / 'bad.mcap'}: ")
    assert says in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_no_trace_is_refused_in_one_line(tmp_path: Path, command: str) -> None:
    record(tmp_path / "good.mcap", idle(10))
    for name, (make, says) in BAD.items():
        path = tmp_path / name
        path.mkdir()
        (path / "good.mcap").write_bytes((tmp_path / "good.mcap").read_bytes())
        make(path / "bad.mcap")
        refused(path, command, says)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_layout_newer_than_this_version_is_refused(
    tmp_path: Path, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    record(tmp_path / "good.mcap", idle(10))
    newer(tmp_path / "bad.mcap", monkeypatch)
    refused(tmp_path, command, "its layout has format 3: must be 1 or 2")


@pytest.mark.parametrize("command", COMMANDS)
def test_a_file_without_permission_is_refused(
    tmp_path: Path, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    record(tmp_path / "good.mcap", idle(10))
    record(tmp_path / "bad.mcap", idle(10))
    whole = Path.open

    def forbidden(path: Path, *arguments, **options):
        if path.name == "bad.mcap":  # chmod does not keep root from anything
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return whole(path, *arguments, **options)

    monkeypatch.setattr(Path, "open", forbidden)
    refused(tmp_path, command, "Permission denied")


@pytest.mark.parametrize("command", ["show", "query", "csv", "vcd", "page"])
def test_a_damaged_trace_gives_what_is_whole_and_says_what_is_not(tmp_path: Path, command: str) -> None:
    path = record(tmp_path / "bad.mcap", idle(90), chunk_scans=30)
    with open_trace(path) as trace:
        section = trace.sections[1]
    content = bytearray(path.read_bytes())
    content[section.span.end - 3] ^= 4
    path.write_bytes(content)
    status, out, err = run(tmp_path, command)
    assert status == 0
    note = f"note: damaged chunk at byte {section.span.offset:,}: "
    lost = "; its 30 scans from 0.060 s to 0.118 s are left out"
    (line,) = [line for line in (out + err).splitlines() if line.startswith("note: ")]
    assert line.startswith(note)
    assert line.endswith(lost)
    if command == "csv":
        rows = (tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()[1:]
        assert [int(row.partition(",")[0]) for row in rows] == [*range(30), *range(60, 90)]


FULL = """
import sys
import made_traces
made_traces.record(sys.argv[1], made_traces.idle(int(sys.argv[2])), chunk_scans=10)
"""


@pytest.mark.slow
def test_a_file_that_may_not_grow_is_whole_up_to_there(tmp_path: Path) -> None:
    """A limit on the size of files, unlike a full disk, leaves no room for the end: repair writes it."""
    path = tmp_path / "run.mcap"
    limit = 200_000

    resource = pytest.importorskip("resource")

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = subprocess.run(
        [sys.executable, "-c", FULL, str(path), "20000"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        preexec_fn=limited,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        encoding="utf-8",
    )
    last = done.stderr.splitlines()[-1]
    assert f"{path}: File too large; it was cut back to its last whole record, at byte " in last
    assert path.stat().st_size <= limit
    with open_trace(path) as trace:
        scans = len(read_columns(trace).scan)
        assert "it has no end" in trace.notes[0]
    assert scans > 2_000
    result = CliRunner().invoke(build(), ["repair", str(path)])
    assert result.exit_code == 0
    assert f"repaired, {scans:,} scans" in result.stdout


WRITING = {
    "csv": ["export", "good.mcap", "--csv", "out.csv"],
    "vcd": ["export", "good.mcap", "--vcd", "out.vcd"],
    "parquet": ["export", "good.mcap", "--parquet", "out.parquet"],
    "page": ["plot", "good.mcap", "--out", "out.html"],
    "repair": ["repair", "good.mcap", "--out", "out.mcap"],
}


EXTRAS = {"parquet": [pytest.mark.extra("parquet")]}


@pytest.mark.slow
@pytest.mark.parametrize("command", [pytest.param(each, marks=EXTRAS.get(each, [])) for each in WRITING])
def test_a_disk_that_is_full_is_told_with_the_file_that_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # what is imported now would be cut, and stay so
    path = record(tmp_path / "good.mcap", idle(3_000))
    content = path.read_bytes()
    path.write_bytes(content[:-40])
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_024, limits[1]))
    try:
        result = CliRunner().invoke(build(), [str(tmp_path / w) if "." in w else w for w in WRITING[command]])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert result.exit_code == 3
    assert result.stderr == f"scanrack: {tmp_path / WRITING[command][-1]}: File too large\n"
    assert path.read_bytes() == content[:-40]


def test_a_disk_without_any_room_is_told_in_one_line(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    rack = Path(__file__).parents[3] / "examples" / "three_stations" / "line.toml"
    result = CliRunner().invoke(build(), ["run", str(rack), "--scans", "10", "--record", "/dev/full"])
    assert result.exit_code == 3
    assert result.stderr.startswith(
        "scanrack: the trace can't be written: /dev/full: No space left on device"
    )
    assert result.stderr.count("\n") == 1
