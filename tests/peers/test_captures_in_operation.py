"""A plant captured by tshark in the middle of its operation, and replayed from its first rest on."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from logix_clients import pycomm3_client
from scanrack.commands import build
from typer.testing import CliRunner

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pycomm3 = pytest.importorskip("pycomm3", reason="pycomm3 is not installed")

pytestmark = pytest.mark.slow
WAIT_S = 60

PROGRAM = """
CONFIGURATION = [-31684, 60, 0, 500, 0, 0, 0, 0]
THERE, BACK = [2, 0, 2, 0, 5, 0, 50, 50], [2, 0, -2, 0, 5, 0, 50, 50]

def logic(scan):
    turn, place = divmod(scan.number - 50, 500)  # a move each second, its bit for 0.2 s
    words = CONFIGURATION if turn < 0 else THERE if turn % 2 else BACK
    if turn >= 0 and not 100 <= place < 200:
        words = [0, *words[1:]]
    for number, word in enumerate(words):
        scan.slot[1].outputs[number] = word
"""
RACK = """name = "running"
program = "running.py"
scan_ms = 2
[[slot]]
number = 1
module = "amci3601"
[[slot]]
number = 2
module = "1769-IQ16"
"""


CAPTURE_S, READS_S = 6, 3.5


@contextmanager
def running(words: list[str], said: Path, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program until the end of the block; its messages go to a file, which never blocks it."""
    with said.open("wb") as messages:
        process = subprocess.Popen(words, cwd=folder, stdout=messages, stderr=messages)
        try:
            yield process
        finally:
            process.kill()
            process.wait(WAIT_S)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int]:
    """Return the folder of a rack and of a capture that begins three seconds after it, and its port."""
    program = shutil.which("tshark")
    if program is None:
        pytest.skip("tshark is not installed")
    folder = tmp_path_factory.mktemp("running")
    (folder / "running.py").write_text(PROGRAM, "utf-8")
    (folder / "running.toml").write_text(RACK, "utf-8")
    rack = [sys.executable, "-m", "scanrack", "run", "running.toml", "--realtime", "--for", "30s"]
    with running([*rack, "--no-record", "--server", "ethernet-ip:0"], folder / "said.txt", folder):
        port = port_of(folder / "said.txt")
        words = [program, "-q", "-i", "lo", "-f", f"tcp port {port}", "-a", f"duration:{CAPTURE_S}"]
        with running([*words, "-w", str(folder / "late.pcapng")], folder / "tshark.txt", folder) as tshark:
            begun = time.monotonic()
            while "Capturing on" not in (folder / "tshark.txt").read_text("utf-8") and tshark.poll() is None:
                assert time.monotonic() < begun + WAIT_S, "tshark does not begin"
                time.sleep(0.1)
            time.sleep(1)  # the names that the client asks for first must be in the capture
            with pycomm3_client(pycomm3.LogixDriver, port) as plc:
                end = time.monotonic() + READS_S
                while time.monotonic() < end:
                    plc.read("Local:1:I", "Local:1:O")
                    time.sleep(0.005)
            tshark.wait(WAIT_S)
    if not (folder / "late.pcapng").exists():
        pytest.skip(f"tshark can't capture here: {(folder / 'tshark.txt').read_text('utf-8')}")
    return folder, port


def port_of(said: Path) -> int:
    """Return the port that a rack says it serves, in time."""
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        found = re.search(r"server on 127\.0\.0\.1:(\d+)", said.read_text("utf-8"))
        if found is not None:
            return int(found[1])
        time.sleep(0.1)
    raise AssertionError(said.read_text("utf-8"))


def test_the_plant_is_replayed_from_its_first_rest_on(
    capture: tuple[Path, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, port = capture
    monkeypatch.chdir(folder)
    words = ["import", "late.pcapng", "--as", "compactlogix", "--port", str(port), "--out", "late.mcap"]
    done = CliRunner().invoke(build(), words)
    assert done.exit_code == 0, done.output
    replay = ["replay", "late.mcap", "--rack", "running.toml", "--configuration"]
    allowed = ["--tolerance-time", "250ms", "--tolerance-counts", "600"]  # a busy machine reads late
    done = CliRunner().invoke(build(), [*replay, "843Ch 003Ch 0 500", *allowed])
    assert done.exit_code == 0, done.output
    assert "the rack's slot 2 is not in the trace and is left out" in done.stderr
    assert "it is compared from the next scan on" in done.stderr
    left_out = re.search(r"slot 1: (\d+) of (\d+) scans are not compared", done.stderr)
    assert left_out is not None
    assert int(left_out[1]) < int(left_out[2]) / 2
