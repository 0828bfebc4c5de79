"""Every file that is replaced is the old one or the new one, whole, whichever system call fails.

Each writer runs again and again: the first call fails, then the second, and so on, until none is left.
"""

from __future__ import annotations

import builtins
import errno
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from made_traces import idle, record
from scanrack.commands import build
from scanrack.jobs import State, load_job, write_state
from scanrack.jobs.fuzz.folder_lock import write_text
from scanrack.jobs.run.retained_memory import RetainedMemory
from scanrack.traces import open_trace, repair
from scanrack.traces.export import write_csv, write_mcap, write_vcd
from scanrack.traces.export.csvfile import CSV
from scanrack.traces.files import locking, newfile, patience
from scanrack.traces.files.guard import OwnedError
from scanrack.traces.files.newfile import new_file
from scanrack.traces.format.records import MAGIC
from scanrack.traces.plot import save_page
from typer.testing import CliRunner


class Calls:
    """System calls that are counted; one of them fails."""

    def __init__(self) -> None:
        self.left = -1
        self.failed = ""

    def failing(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*arguments: Any, **options: Any) -> Any:
            self.left -= 1
            if self.left == -1:
                self.failed = name
                if name == "close":  # the descriptor is gone all the same
                    call(*arguments, **options)
                raise OSError(errno.EIO, os.strerror(errno.EIO))
            return call(*arguments, **options)

        return counted

    def open(self, *arguments: Any, **options: Any) -> Any:
        """Open a file whose writing may fail."""
        file = self.failing("open file", builtins.open)(*arguments, **options)
        return File(file, self)


class File:
    """An open file, each call of which may fail."""

    def __init__(self, file: Any, calls: Calls) -> None:
        self._file, self._calls = file, calls

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._file, name)
        return self._calls.failing(name, found) if name in ("write", "flush") else found

    def __enter__(self) -> File:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()


NAMES = ("open", "fsync", "replace", "close", "fstat", "link")


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Calls:
    counted = Calls()
    system = SimpleNamespace(
        **{**vars(os), **{name: counted.failing(name, getattr(os, name)) for name in NAMES}}
    )
    for module in (newfile, locking, repair):
        monkeypatch.setattr(module, "os", system)
    monkeypatch.setattr(newfile, "open", counted.open, raising=False)
    copy = SimpleNamespace(**{**vars(shutil), "copymode": counted.failing("chmod", shutil.copymode)})
    monkeypatch.setattr(newfile, "shutil", copy)
    return counted


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    trace = record(folder / "run.mcap", idle(40), chunk_scans=10)
    (folder / "torn.mcap").write_bytes(trace.read_bytes()[:-30])
    (folder / "line.toml").write_text(
        'program = "line.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    (folder / "line.rung").write_text(
        "PROGRAM line\nTAG A : BOOL\nROUTINE Main\nOTE(A);\nEND\n", encoding="utf-8"
    )
    return folder


def export(write: Callable[..., object]) -> Callable[[Path, Path], None]:
    def exported(made: Path, target: Path) -> None:
        with open_trace(made / "run.mcap") as trace:
            write(trace, target)

    return exported


def retain(made: Path, target: Path) -> None:
    with RetainedMemory(load_job(str(made / "line.toml")), target) as retained:
        retained.end()


def draw(made: Path, target: Path) -> None:
    words = ["ladder", str(made / "line.rung"), "--svg", str(target)]
    result = CliRunner().invoke(build(), words)
    if result.exit_code:
        assert result.exit_code == 3
        assert target.name in result.stderr
        raise OSError(result.stderr)


def repaired(made: Path, target: Path) -> None:
    target.write_bytes((made / "torn.mcap").read_bytes())
    repair.repair(target)


WRITERS: dict[str, tuple[Callable[[Path, Path], object], bytes]] = {
    "retained tags": (retain, b'{"format": "scanrack tags 1", "program": "line", "tags": {}}'),
    "state of a campaign": (
        lambda _made, target: write_state(State("line.toml"), target),
        b'{\n "rack": ""}',
    ),
    "text of a campaign": (lambda _made, target: write_text(target, "report"), b"an older report"),
    "table": (export(write_csv), b"scan,time_ns\n"),
    "value changes": (export(write_vcd), b"$version\n"),
    "copy": (export(write_mcap), MAGIC),
    "page": (export(save_page), b"<!DOCTYPE html>"),
    "rungs": (draw, b"<svg>"),
    "repair": (repaired, b""),
}


@pytest.mark.parametrize("name", WRITERS)
def test_whichever_call_fails_the_file_is_whole(made: Path, tmp_path: Path, calls: Calls, name: str) -> None:
    write, old = WRITERS[name]
    target, other = tmp_path / "target", tmp_path / "other"
    write(made, target)
    new = target.read_bytes()
    old = old or (made / "torn.mcap").read_bytes()
    other.write_text("mine", encoding="utf-8")
    seen = set()
    for failing in range(200):
        target.write_bytes(old)
        calls.left, calls.failed = failing, ""
        with may_fail() as failed:
            write(made, target)
        content = target.read_bytes()
        assert content in (old, new), (failing, calls.failed)
        assert content == new or failed, (failing, calls.failed)
        unsure = {".target.lock"} if calls.failed == "fstat" else set()  # whose it is, nobody knows then
        names = {path.name for path in tmp_path.iterdir()}
        assert names - unsure == {"target", "other"}, (failing, calls.failed)
        seen.add(calls.failed)
        if not calls.failed:
            break
    assert seen >= {"", "open", "open file", "fsync", "replace", "write", "flush", "close", "fstat"}
    assert other.read_text(encoding="utf-8") == "mine"


@contextmanager
def may_fail() -> Iterator[list[OSError]]:
    failed: list[OSError] = []
    try:
        yield failed
    except OSError as error:
        failed.append(error)


def test_no_name_beside_it_is_opened_through_a_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newfile.secrets, "token_hex", lambda _bytes: "known")
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    for name in (".a.csv.known.part", ".a.csv.lock"):
        (tmp_path / name).symlink_to("mine")
        with pytest.raises(OSError, match=r"a\.csv"), new_file(tmp_path / "a.csv", CSV):
            pass
        (tmp_path / name).unlink()
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == {"mine": "mine"}


def test_a_file_that_appears_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    def write() -> None:
        with new_file(tmp_path / "a.csv", CSV) as file:
            file.write("scan,time_ns\n")
            (tmp_path / "a.csv").write_text("notes", encoding="utf-8")

    with pytest.raises(OwnedError, match="is not a table of scans"):
        write()
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == {"a.csv": "notes"}


def test_a_file_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("scan,time_ns\n", encoding="utf-8")
    path.chmod(0o600)
    with new_file(path, CSV) as file:
        file.write("scan,time_ns,x\n")
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_long_name_has_names_beside_it(tmp_path: Path) -> None:
    path = tmp_path / ("ä" * 120 + ".csv")
    with new_file(path, CSV) as file:
        file.write("scan,time_ns\n")
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(("held", "content"), [(9, "new"), (10, "old")])
def test_a_file_that_another_program_has_open_for_a_moment_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, held: int, content: str
) -> None:
    target, waits, replace = tmp_path / "a.csv", [0.0], os.replace

    def replaced(*paths: Any) -> None:
        if len(waits) <= held:
            raise PermissionError(errno.EACCES, "Access is denied", str(target))
        replace(*paths)

    target.write_text("scan,time_ns old", encoding="utf-8")
    monkeypatch.setattr(patience, "sleep", waits.append)
    monkeypatch.setattr(os, "replace", replaced)
    with suppress(PermissionError), new_file(target, CSV) as file:
        file.write("scan,time_ns new")
    assert target.read_text(encoding="utf-8") == f"scan,time_ns {content}"
    assert sum(waits) == pytest.approx(0.9)
    assert [*tmp_path.iterdir()] == [target]
