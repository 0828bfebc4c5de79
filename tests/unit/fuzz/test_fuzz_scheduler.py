"""A campaign on a Dask scheduler that has no worker, whose worker has two threads, and that stops."""

from __future__ import annotations

import subprocess
import sys
import time
from typing import Any

import pytest
from scanrack.jobs import read_state

pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
pytestmark = pytest.mark.extra("cluster")

PATIENCE_S = 120
HELPED = """
import helper

def logic(scan):
    helper.count += 1
    if helper.count > 60:
        raise RuntimeError("another run has counted here")
"""
"""A program that fails if two runs share the module that it imports."""

RACK = """program = "line.py"
run_for_s = 0.1
[[slot]]
number = 1
module = "amci3601"
"""
HEARD = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
SILENT = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def wait_until(asks):
    until = time.monotonic() + PATIENCE_S
    while not asks():
        assert time.monotonic() < until
        time.sleep(0.1)


@pytest.fixture
def processes(tmp_path):
    """Start processes, of which none outlives the test."""
    started = []

    def start(*words):
        streams: dict[str, Any] = SILENT if "distributed" in words[1] else HEARD
        started.append(subprocess.Popen([sys.executable, *map(str, words)], cwd=tmp_path, **streams))
        return started[-1]

    yield start
    for process in reversed(started):
        process.kill()
        process.communicate()


@pytest.fixture
def scheduler(processes, tmp_path):
    file = tmp_path / "scheduler.json"
    words = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", file)
    process = processes("-m", "distributed.cli.dask_scheduler", *words)
    wait_until(lambda: file.exists() and '"address"' in file.read_text(encoding="utf-8"))
    process.address = file.read_text(encoding="utf-8").split('"address": "')[1].split('"')[0]
    return process


@pytest.fixture
def campaign(processes, scheduler, tmp_path):
    (tmp_path / "line.py").write_text(HELPED, encoding="utf-8")
    (tmp_path / "helper.py").write_text("count = 0\n", encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    words = ("--dask", scheduler.address, "--only", "power", "--jobs", "2", "--out", "out")
    return lambda *more: processes("-m", "scanrack", "fuzz", "line.toml", *words, *more)


@pytest.mark.long
@pytest.mark.slow
def test_a_worker_with_two_threads_does_every_task_in_a_process_of_its_own(
    campaign, scheduler, processes, tmp_path
):
    search = campaign("--runs", "100")
    assert search.stderr.readline() == (
        f"scanrack: the Dask scheduler at {scheduler.address} has had no worker for 5 s; "
        f"to start one: dask worker {scheduler.address}\n"
    )
    worker = ("-m", "distributed.cli.dask_worker", scheduler.address, "--nthreads", "2", "--no-dashboard")
    processes(*worker)
    stdout, stderr = search.communicate(timeout=PATIENCE_S)
    assert (search.returncode, stderr) == (0, ""), stdout
    assert read_state(tmp_path / "out" / "state.json", "../line.toml").tasks == 2


@pytest.mark.slow
def test_a_scheduler_that_stops_ends_the_campaign_with_a_word(campaign, scheduler, tmp_path):
    search = campaign("--budget", "1 h")
    search.stderr.readline()  # there is no worker
    scheduler.terminate()
    stdout, stderr = search.communicate(timeout=PATIENCE_S)
    assert search.returncode == 2, stdout + stderr
    assert stderr.startswith(
        f"scanrack: lost the connection to the Dask scheduler at {scheduler.address}; the results so far"
    )
    assert stderr.count("\n") == 1
