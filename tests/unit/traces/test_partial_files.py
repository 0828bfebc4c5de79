"""An export or a picture that could not be written whole is not left behind."""

import errno
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from made_traces import idle, record
from scanrack.traces import open_trace
from scanrack.traces.export.csvfile import CSV
from scanrack.traces.export.formats import FORMATS
from scanrack.traces.files.newfile import new_file

WRITERS = [
    pytest.param(
        each.write, marks=[pytest.mark.extra("parquet")] if each.name == "parquet" else [], id=each.name
    )
    for each in FORMATS
    if each.selects_signals
]


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("partial") / "run.mcap", idle(500), chunk_scans=50)


class Broken:
    """Raises when so many blocks of scans have been read: the file is being written by then."""

    def __init__(self, error: BaseException, after: int = 5) -> None:
        self.error, self.left = error, after

    def __call__(self, _scans: int) -> None:
        self.left -= 1
        if not self.left:
            raise self.error


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize(
    "error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt(), ValueError("no")]
)
def test_a_partial_export_is_removed(
    trace: Path, tmp_path: Path, write: Callable[..., Any], error: BaseException
) -> None:
    target = tmp_path / "out"
    with open_trace(trace) as opened, pytest.raises(type(error)):
        write(opened, target, progress=Broken(error))
    assert list(tmp_path.iterdir()) == []
    with open_trace(trace) as opened:
        assert write(opened, target) == 500
    assert target.stat().st_size > 0


@pytest.mark.parametrize("write", WRITERS)
def test_what_fails_before_anything_is_written_keeps_the_file_that_was_there(
    trace: Path, tmp_path: Path, write: Callable[..., Any]
) -> None:
    target = tmp_path / "out"
    with open_trace(trace) as opened:
        write(opened, target)
    before = target.read_bytes()
    with open_trace(trace) as opened, pytest.raises(ValueError, match="nothing of the kind"):
        write(opened, target, ["nothing of the kind"])
    assert target.read_bytes() == before


def test_a_file_that_fails_as_it_is_closed_is_removed() -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("this system has no /dev/full")
    with pytest.raises(OSError, match="No space left"), new_file(full, CSV) as file:
        file.write("x")
    assert full.exists()  # a device stays


def test_the_file_that_a_link_leads_to_is_replaced_and_the_link_stays(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("scan,time_ns\n", encoding="utf-8")
    (tmp_path / "link").symlink_to("real")

    def write(error: Exception | None) -> None:
        with new_file(tmp_path / "link", CSV) as file:
            file.write("scan,time_ns,x\n")
            if error is not None:
                raise error

    with pytest.raises(ValueError, match="no"):
        write(ValueError("no"))
    assert (tmp_path / "real").read_text(encoding="utf-8") == "scan,time_ns\n"
    write(None)
    assert (tmp_path / "real").read_text(encoding="utf-8") == "scan,time_ns,x\n"
    assert (tmp_path / "link").is_symlink()
