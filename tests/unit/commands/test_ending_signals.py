"""SIGTERM and SIGHUP end every command as Ctrl-C does: one message, a whole trace."""

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import forked
import pytest
from mcap.reader import make_reader
from scanrack.commands import build
from scanrack.runtime.loop.pace import ending_as_interrupt, interrupted_by
from scanrack.traces.read.reader import open_trace
from typer.testing import CliRunner

ENDING = [signal.SIGTERM, signal.SIGHUP]

RACK = """\
program = "line.py"

[[slot]]
number = 1
module = "amci3601"
"""

PROGRAM = """\
def logic(scan):
    if scan.number == 20:
        print("twenty", flush=True)
"""


@contextlib.contextmanager
def started(folder: Path, *arguments: str, before: str = "pass") -> Iterator[subprocess.Popen[str]]:
    """Run a command in a process of its own."""
    code = f"import signal, sys; {before}; from scanrack.commands import main; main()"
    process = forked.start(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "line.toml").write_text(RACK, "utf-8")
    (tmp_path / "line.py").write_text(PROGRAM, "utf-8")
    return tmp_path


def stock_count(path: Path) -> int:
    """Return how many messages the stock reader finds, which needs footer and summary."""
    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())


@pytest.mark.parametrize("number", ENDING)
def test_a_simulated_run_in_real_time_keeps_every_scan(folder: Path, number: signal.Signals) -> None:
    with started(folder, "run", "line.toml", "--realtime", "--record", "run.mcap", "-q") as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "twenty\n"
        process.send_signal(number)
        _, err = process.communicate(timeout=30)
    with open_trace(folder / "run.mcap") as trace:
        scans = [scan.scan for scan in trace.scans()]
        assert trace.notes == []
    assert process.returncode == 130
    assert err == f"scanrack: stopped by {number.name} after {len(scans)} scans\n"
    assert scans == list(range(len(scans)))
    assert len(scans) > 20
    assert stock_count(folder / "run.mcap") >= len(scans)


@pytest.mark.parametrize("number", ENDING)
def test_a_served_controller_leaves_a_whole_recording(folder: Path, number: signal.Signals) -> None:
    with started(folder, "serve", "pmc006", "--tcp", "0", "--record", "line.mcap") as process:
        assert process.stdout is not None
        assert "Ctrl-C ends" in process.stdout.readline()
        process.send_signal(number)
        _, err = process.communicate(timeout=30)
    assert (process.returncode, err) == (130, "")
    assert stock_count(folder / "line.mcap") >= 1


def test_a_signal_that_is_ignored_stays_ignored(folder: Path) -> None:
    """As under nohup: the terminal may close, and the run goes on."""
    ignore = "signal.signal(signal.SIGHUP, signal.SIG_IGN)"
    with started(folder, "run", "line.toml", "--realtime", "--no-record", "-q", before=ignore) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(signal.SIGHUP)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.3)
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "stopped by SIGTERM" in err


def test_where_ctrl_c_is_ignored_sigterm_still_ends(folder: Path) -> None:
    """As in the background of a shell; `drive` reads its standard input here, and is idle."""
    ignore = "signal.signal(signal.SIGINT, signal.SIG_IGN)"
    (folder / "line.py").write_text("import time\nprint('loading', flush=True)\ntime.sleep(60)\n", "utf-8")
    with started(folder, "run", "line.toml", "--no-record", before=ignore) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)
    assert (process.returncode, err) == (130, "scanrack: stopped by SIGTERM\n")


def test_any_command_ends_with_one_message(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from scanrack.commands.recordings import repair as module

    def ended(*_arguments: object, **_options: object) -> None:
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(signal, "getsignal", lambda _number: signal.default_int_handler)
    monkeypatch.setattr(module, "repair", ended)
    result = CliRunner().invoke(build(), ["repair", str(tmp_path / "x.mcap")])
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", "scanrack: stopped by SIGTERM\n")


@pytest.mark.parametrize("number", ENDING)
def test_handlers_come_back(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with ending_as_interrupt():
        assert signal.getsignal(number) is not before
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        assert interrupted_by() == number.name
    assert signal.getsignal(number) is before
    assert interrupted_by() == "Ctrl-C"
