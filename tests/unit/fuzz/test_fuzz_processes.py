"""Campaigns as processes: the same wherever they run, broken off by Ctrl-C or killed, and gone on with."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import forked
import pytest
from scanrack.commands import build
from scanrack.commands.programs.fuzz_session import noting_ctrl_c
from scanrack.jobs import State, read_state
from typer.testing import CliRunner

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes in /proc")

PATIENCE_S = 300
PROGRAM = """
from scanrack.io_images.amci3601 import Configuration, Idle, StatusView

WORDS = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image()

def logic(scan):
    status = StatusView(scan.slot[1].inputs)
    scan.slot[1].outputs.load(Idle().to_image() if status.MODE_CONFIG or scan.number > 5 else WORDS)
    if status.IN_ESTOP:
        raise RuntimeError("nobody thought of this")
"""
RACK = """program = "line.py"
run_for_s = 0.1
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    return tmp_path


def started(folder, *words, cwd=None):
    """Start a campaign in a process of its own."""
    command = [sys.executable, "-m", "scanrack", "fuzz", str(folder / "line.toml"), *words]
    return forked.start(
        command,
        cwd=cwd or folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
    )


def finished(process):
    stdout, stderr = process.communicate(timeout=PATIENCE_S)
    return process.returncode, stdout, stderr


def state_in(folder) -> State:
    return read_state(folder / "state.json", "../line.toml")


def wait_until(condition):
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "it takes too long"
        time.sleep(0.05)


def has_tasks(folder, tasks):
    return (folder / "state.json").exists() and state_in(folder).tasks >= tasks


def children(process):
    return [
        int(child)
        for child in Path(f"/proc/{process.pid}/task/{process.pid}/children")
        .read_text(encoding="utf-8")
        .split()
    ]


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.slow
def test_the_same_command_finds_the_same_from_any_folder(folder):
    (folder / "elsewhere" / ".hypothesis").mkdir(parents=True)
    words = ("--runs", "20", "--only", "inputs")
    here = started(folder, *words, "--jobs", "2", "--out", str(folder / "one"))
    there = started(folder, *words, "--jobs", "2", "--out", str(folder / "two"), cwd=folder / "elsewhere")
    assert finished(here)[0] == finished(there)[0] == 1
    first, second = (folder / name / "state.json" for name in ("one", "two"))
    assert first.read_bytes() == second.read_bytes()
    assert sorted(state_in(folder / "one").found) == ["no-fault line.py:10"]
    assert not list((folder / "elsewhere" / ".hypothesis").iterdir())  # nothing is left where one stands
    assert not (folder / ".hypothesis").exists()


def test_ctrl_c_that_somebody_swallows_is_known_nevertheless():
    before = signal.getsignal(signal.SIGINT)
    with noting_ctrl_c() as pressed:
        assert not pressed()
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        assert pressed()
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.slow
@pytest.mark.parametrize(("number", "name"), [(signal.SIGINT, "Ctrl-C"), (signal.SIGTERM, "SIGTERM")])
def test_ctrl_c_ends_a_campaign_and_the_same_command_goes_on(folder, number, name, monkeypatch):
    out = folder / "out"
    words = ("--out", str(out), "--jobs", "2", "--only", "power")
    campaign = started(folder, *words, "--budget", "1 h")
    wait_until(lambda: has_tasks(out, 1))
    workers = children(campaign)
    campaign.send_signal(number)
    status, _stdout, stderr = finished(campaign)
    assert (status, stderr) == (130, f"scanrack: stopped by {name}; run the same command to continue\n")
    wait_until(lambda: not any(map(is_alive, workers)))
    before, kept = state_in(out), len(list((out / "corpus").iterdir()))
    monkeypatch.chdir(folder)
    again = CliRunner().invoke(
        build(), ["fuzz", str(folder / "line.toml"), *words, "--runs", "5", "--jobs", "1"]
    )
    assert again.exit_code == 0
    assert f"in all        {before.runs + kept + 5:,} runs" in again.stdout
    assert state_in(out).tasks == before.tasks + 1 + -(-kept // 5)


@pytest.mark.slow
def test_a_campaign_that_is_killed_leaves_its_state_and_no_workers(folder):
    out = folder / "out"
    campaign = started(folder, "--out", str(out), "--jobs", "2", "--budget", "1 h", "--only", "power")
    wait_until(lambda: has_tasks(out, 1))
    workers = children(campaign)
    assert len(workers) >= 2
    os.kill(campaign.pid, signal.SIGKILL)
    assert finished(campaign)[0] == -signal.SIGKILL
    wait_until(lambda: not any(map(is_alive, workers)))
    assert state_in(out).tasks >= 1
