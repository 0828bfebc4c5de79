"""What a session says and does when something goes wrong: at once in the terminal, at its end by its status.

Broken on purpose: a fault that is said at the end only, a branch that is refused after it, a nameless port.
"""

import asyncio
import errno
import os
import shutil
import signal
import socket
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from scanrack.watch import play
from typer.testing import CliRunner
from watching import FEEDER, page_of, watched
from windows_files import users

RACK = """\
program = "program.py"
scan_ms = 2
watchdog_ms = 300
[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"
"""


@pytest.fixture
def rack(tmp_path):
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    return tmp_path / "rack.toml"


FAULTS = [
    ("    assert scan.number < 50, 'on purpose'\n", "the program raised AssertionError: on purpose", 50),
    ("    while scan.number > 50: pass\n", "it took longer than 300", 51),
]


@pytest.mark.slow
@pytest.mark.parametrize(("body", "says", "scan"), FAULTS, ids=["raises", "hangs"])
def test_a_fault_is_said_at_once_and_a_branch_is_the_way_on(rack, body, says, scan):
    (rack.parent / "program.py").write_text(f"def logic(scan):\n{body}", encoding="utf-8")

    async def work(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("mode") == "fault")
            (fault,) = page.frame["faults"]
            go, again = await page.ask("go"), await page.ask("branch", scan=scan - 10)
            await page.until(lambda seen: seen.hello and seen.frame.get("state") == "paused")
            step = await page.ask("step", scans=5)
            return fault["text"], go["refused"], again, step

    with watched("--record", rack.parent / "session.mcap", rack=rack) as session:
        text, go, again, step = asyncio.run(work(session))
        said = [session.process.stderr.readline() for _ in range(2)]
        assert session.end() == 130
    assert says in text
    assert says in said[0]
    assert "branch there from an earlier scan" in said[1]
    assert "branch from an earlier scan" in go
    assert (again["ok"], step["scan"]) == (True, scan - 10)
    with open_trace(rack.parent / f"session-{scan - 10}.mcap") as trace:
        assert len(read_columns(trace).scan) == scan - 5


@pytest.mark.slow
def test_a_session_that_faulted_ends_with_the_status_of_a_fault(rack):
    (rack.parent / "program.py").write_text(
        "def logic(scan):\n    assert scan.number < 5\n", encoding="utf-8"
    )
    with watched(rack=rack) as session:
        assert "the CPU has faulted in scan 5" in session.process.stderr.readline()
        assert session.end() == 1
    with watched("--scans", "20", rack=rack) as session:
        assert session.process.wait(120) == 1


ERROR = 4001
"""The scan in which the feeder's own emergency stop sets INPUT_ERROR."""


@pytest.mark.slow
def test_an_error_bit_is_named_to_each_page_and_stops_those_that_wish_it():
    async def work(session):
        async with page_of(session) as follows, page_of(session) as stops:
            assert (await stops.ask("stop", at_errors="stop"))["ok"]
            assert "stop or off" in (await follows.ask("stop", at_errors="say"))["refused"]
            await follows.ask("step", scans=ERROR + 100)
            for page in (follows, stops):
                await page.until(lambda seen: seen.error)
            await follows.until(lambda seen: seen.frame.get("scan") == ERROR + 99)
            await stops.until(lambda seen: seen.frame.get("state") == "past" and "scan" in seen.frame)
            return [follows.error, stops.error], stops.frame["scan"]

    with watched("--paused", "--time-scale", "max") as session:
        errors, stopped_at = asyncio.run(work(session))
    assert {(each["scan"], each["bit"]) for each in errors} == {(ERROR, "INPUT_ERROR")}
    assert [each["stopped"] for each in errors] == [False, True]
    assert stopped_at == ERROR


def test_a_port_in_use_is_named(tmp_path):
    path = tmp_path / "run.mcap"
    done = CliRunner().invoke(build(), ["run", str(FEEDER), "--scans", "5", "--record", str(path), "-q"])
    assert done.exit_code == 0
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        for what in (str(FEEDER), str(path)):
            done = CliRunner().invoke(build(), ["watch", what, "--port", port])
            assert done.exit_code == 2
            assert f"--port {port}: Address already in use; choose another port" in " ".join(
                done.stderr.split()
            )


def test_a_recording_that_cannot_be_written_is_refused_with_its_reason(tmp_path):
    done = CliRunner().invoke(build(), ["watch", str(FEEDER), "--record", str(tmp_path / "no" / "x.mcap")])
    assert done.exit_code == 3
    assert "no directory" in done.stderr


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_branch_that_cannot_be_recorded_is_refused_and_the_session_goes_on(tmp_path):
    async def work(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 50)
            tmp_path.chmod(0o500)
            refused = await page.ask("branch", scan=20)
            tmp_path.chmod(0o700)
            begun = page.frame["scan"]
            await page.until(lambda seen: seen.frame["scan"] > begun + 100)
            return refused["refused"]

    with watched("--record", tmp_path / "session.mcap") as session:
        assert "can't be written" in asyncio.run(work(session))


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="/proc tells of children on Linux only")
def test_a_monitor_that_dies_three_times_comes_back_each_time():
    async def look(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            return page.frame["scan"]

    with watched() as session:
        scans = []
        for _ in range(3):
            scans.append(asyncio.run(look(session)))
            os.kill(session.monitor, signal.SIGKILL)
        scans.append(asyncio.run(look(session)))
        assert session.end() == 130
        said = session.process.stderr.read()
    assert scans == sorted(scans)
    assert said.count("the monitor has died and is started again; the scans continue") == 3


@pytest.mark.slow
def test_a_program_that_is_gone_ends_nothing(tmp_path):
    for name in ("feeder.toml", "feeder.rung"):
        shutil.copy(FEEDER.parent / name, tmp_path / name)

    async def work(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            (tmp_path / "feeder.rung").unlink()
            (tmp_path / "feeder.toml").unlink()
            assert (await page.ask("reload"))["ok"]
            page.hello = {}
            branch = await page.ask("branch", scan=3)
            await page.until(lambda seen: seen.hello and seen.frame.get("scan", 0) > 10)
            return branch

    with watched(rack=tmp_path / "feeder.toml") as session:
        assert asyncio.run(work(session))["ok"]
        assert session.end() == 130


@pytest.mark.parametrize("options", [(), ("--spin",)], ids=["sleeps", "spins"])
def test_the_scans_of_a_session_wait_awake_if_they_are_told_to(monkeypatch, options):
    spins = []

    class Pace(play.AdjustablePace):
        def __init__(self, speed, *, spin):
            spins.append(spin)
            super().__init__(speed, spin=spin)

    def no_helper(*_):
        raise OSError(errno.EAGAIN, "no helper")

    monkeypatch.setattr(play, "AdjustablePace", Pace)
    monkeypatch.setattr(play, "MonitorSupervisor", no_helper)
    CliRunner().invoke(build(), ["watch", str(FEEDER), "--for", "20ms", *options])
    assert spins == [bool(options)]


@pytest.mark.skipif(sys.platform != "linux", reason="what is open is read from /proc")
def test_a_session_that_does_not_begin_closes_its_recording_before_the_folder_is_removed(monkeypatch):
    folders, left = [], []

    class Folder(TemporaryDirectory):
        def cleanup(self):
            folders.append([each.name for each in Path(self.name).glob("*.mcap")])
            left.extend(users(f"{self.name}/session.mcap"))
            super().cleanup()

    def no_helper(*_):
        raise OSError(errno.EAGAIN, "no helper")

    monkeypatch.setattr(play.tempfile, "TemporaryDirectory", Folder)
    monkeypatch.setattr(play, "MonitorSupervisor", no_helper)
    result = CliRunner().invoke(build(), ["watch", str(FEEDER), "--for", "20ms", "--time-scale", "max"])
    assert "no helper" in str(result.exception)
    assert (folders, left) == ([["session.mcap"]], [])
