"""SIGTERM and SIGHUP end every command as Ctrl-C does: one message, a whole trace."""

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import forked
import pytest
from mcap.reader import make_reader
from scanrack import __main__
from scanrack.commands import build
from scanrack.runtime.loop.pace import ending_as_interrupt, interrupted_by
from scanrack.traces import open_trace
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
def started(
    folder: Path, *arguments: str, before: str = "pass", main: str = "main()"
) -> Iterator[subprocess.Popen[str]]:
    """Run a command in a process of its own."""
    code = f"import signal, sys\n{before}\nfrom scanrack.__main__ import main\n{main}"
    process = forked.start(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
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
        _, err = process.communicate(timeout=120)
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
        _, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (130, "")
    assert stock_count(folder / "line.mcap") >= 1


SLOW = """\
import time

def logic(scan):
    if scan.number == 20:
        print("twenty", flush=True)
    if scan.number > 20:
        time.sleep(SECONDS)
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", [*ENDING, signal.SIGINT])
@pytest.mark.parametrize("command", ["replay", "rerun"])
def test_a_replay_that_is_stopped_has_no_answer(folder: Path, command: str, number: signal.Signals) -> None:
    """What was compared so far is no difference: it was exit status 1, which means one."""
    (folder / "line.py").write_text(SLOW.replace("SECONDS", "0"), "utf-8")
    run = CliRunner().invoke(
        build(),
        ["run", str(folder / "line.toml"), "--scans", "5000", "--record", str(folder / "run.mcap"), "-q"],
    )
    assert run.exit_code == 0, run.output
    (folder / "line.py").write_text(SLOW.replace("SECONDS", "0.01"), "utf-8")
    words = {
        "replay": ("replay", "run.mcap", "--into", "program", "--program", "line.py", "-q"),
        "rerun": ("replay", "--into", "session", "run.mcap", "--trust", "-q"),
    }
    with started(folder, *words[command]) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "twenty\n"
        process.send_signal(number)
        out, err = process.communicate(timeout=120)
    who = "Ctrl-C" if number is signal.SIGINT else number.name
    assert (process.returncode, out) == (130, "")
    assert f"stopped by {who}" in err


IN_TERMINALS = {
    "run": ("run", "line.toml", "--realtime", "--record", "run.mcap"),
    "run with a server": (
        "run",
        "served.toml",
        "--realtime",
        "--record",
        "run.mcap",
        "--server",
        "ethernet-ip:0",
    ),
    "serve": ("serve", "pmc006", "--tcp", "0"),
    "watch": ("watch", "line.toml", "--record", "run.mcap"),
}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals")
@pytest.mark.parametrize("command", IN_TERMINALS)
def test_a_terminal_that_is_closed_ends_a_command_with_130(folder: Path, command: str) -> None:
    """Progress and state are written to it all the time: these writes fail before the signal is handled."""
    (folder / "served.toml").write_text(RACK.replace("line.py", "line.rung"), "utf-8")
    (folder / "line.rung").write_text("PROGRAM p\nTAG Run : BOOL\nROUTINE Main\nOTE(Run);\nEND\n", "utf-8")
    import pty  # where there are some

    pid, terminal = pty.fork()
    if not pid:
        os.chdir(folder)
        words = [sys.executable, "-P", "-m", "scanrack", *IN_TERMINALS[command]]
        os.execve(sys.executable, words, {**os.environ, "TERM": "xterm", "COLUMNS": "120"})
    shown = b""
    while not re.search(rb"Ctrl-C ends|\d\d/\?", shown):
        shown += os.read(terminal, 4096)
    os.close(terminal)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 130, shown


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
        _, err = process.communicate(timeout=120)
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
        _, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (130, "scanrack: stopped by SIGTERM\n")


@pytest.fixture
def _own_handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in ENDING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("_own_handlers")
@pytest.mark.parametrize("number", [*ENDING, signal.SIGINT])
def test_a_signal_while_the_commands_are_imported(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    module = ModuleType("scanrack.commands")
    module.__getattr__ = lambda _: signal.raise_signal(number)  # type: ignore[method-assign]
    monkeypatch.setitem(sys.modules, "scanrack.commands", module)
    with pytest.raises(SystemExit) as caught:
        __main__.main()
    assert caught.value.code == 130
    who = "Ctrl-C" if number is signal.SIGINT else number.name
    assert capsys.readouterr().err == f"scanrack: stopped by {who}\n"


@pytest.mark.parametrize("number", ENDING)
def test_a_signal_after_a_command_changes_no_status(folder: Path, number: signal.Signals) -> None:
    """A shell and the kernel each send SIGHUP: the second one killed what the first had ended with 130."""
    late = f"try: main()\nfinally: signal.raise_signal({int(number)})"
    with started(folder, "rules", "amci3601", main=late) as process:
        out, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (0, "")
    assert "IOM-02" in out


def test_a_second_sighup_breaks_nothing_off() -> None:
    with ending_as_interrupt():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGHUP)
        signal.raise_signal(signal.SIGHUP)
        assert interrupted_by() == "SIGHUP"


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
