"""Two recordings never go into one file: the second is refused, and the first loses nothing."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import forked
import pytest
from scanrack.commands import build
from scanrack.traces import ScanRecorder, SlotInfo, open_trace
from scanrack.traces.files.locking import is_being_recorded
from scanrack.traces.repair import repair
from scanrack.traces.write.line import LineRecorder, UnitColumns
from scanrack.traces.write.output import open_trace_file
from typer.testing import CliRunner

REFUSED = "is being recorded: choose another file to write to, or wait for its end"

HOLDER = """
import sys
from pathlib import Path
from scanrack.traces.write.output import open_trace_file
file = open_trace_file(Path(sys.argv[1]), 0)
file.write(b"\\x89MCAP0\\r\\nmine")
print("locked", flush=True)
sys.stdin.read()
"""


def recorder_of(path: Path) -> ScanRecorder:
    return ScanRecorder(path, bytearray(32), [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=1)


def test_a_second_recording_to_the_same_file_is_refused_and_the_first_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    first = recorder_of(path)
    for scan in range(10):
        first.scan(scan, scan, 0)
    for second in (recorder_of, lambda where: LineRecorder(where, [UnitColumns(1, ["x"])], {})):
        with pytest.raises(ValueError, match=REFUSED):
            second(path)
    assert is_being_recorded(path)
    first.close()
    assert not is_being_recorded(path)
    with open_trace(path) as trace:
        assert [scan.scan for scan in trace.scans()] == list(range(10))
    recorder_of(path).close()


@pytest.mark.parametrize("end", [subprocess.Popen.kill, subprocess.Popen.terminate])
def test_the_lock_goes_with_the_process(tmp_path: Path, end: Callable[[subprocess.Popen[str]], None]) -> None:
    path = tmp_path / "run.mcap"
    process = forked.start(
        [sys.executable, "-c", HOLDER, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        encoding="utf-8",
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "locked\n"
    with pytest.raises(ValueError, match=REFUSED):
        open_trace_file(path, 0)
    assert path.read_bytes() == b"\x89MCAP0\r\nmine"
    end(process)
    process.communicate(timeout=120)
    open_trace_file(path, 0).close()
    assert path.read_bytes() == b""


def test_the_command_run_says_so_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "line.toml").write_text(
        'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    (tmp_path / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    path = tmp_path / "run.mcap"
    first = recorder_of(path)
    result = CliRunner().invoke(build(), ["run", str(tmp_path / "line.toml"), "--record", str(path)])
    first.close()
    assert result.exit_code == 2
    assert result.stderr == f"scanrack: {path} {REFUSED}\n"


def test_a_trace_that_is_being_recorded_is_not_replaced_by_its_repair(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = recorder_of(path)
    for scan in range(10_000):
        recorder.scan(scan, scan, 0)
    with pytest.raises(ValueError, match="is being recorded"):
        repair(path)
    assert repair(path, tmp_path / "so far.mcap").scans
    with pytest.raises(ValueError, match="is being recorded"):
        repair(tmp_path / "so far.mcap", path)
    recorder.close()
    assert repair(path).scans == 10_000


def test_a_device_is_not_locked(tmp_path: Path) -> None:
    for _ in range(2):
        open_trace_file(Path("/dev/null"), 0).close()
    assert not is_being_recorded(Path("/dev/null"))
