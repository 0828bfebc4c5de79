"""A test of pytest under the debugger: run by the adapter, and waiting for a client at a port."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from debug_client import DebugClient, RefusedError

pytestmark = pytest.mark.slow

RACK = """
name = "counting"
program = "{}"
scan_ms = 2
[[slot]]
number = 1
module = "1762-IQ8"
"""
RUNGS = """PROGRAM counting
TAG Number : DINT
ROUTINE Main
ADD(Number,1,Number);
END
"""
PYTHON = '''"""Counts."""

from adding import one_more
from scanrack import Logic


class Counting(Logic):
    """Counts the scans."""

    number = 0

    def every_scan(self) -> None:
        """Count."""
        self.number = one_more(self.number)
'''
ADDING = "def one_more(number):\n    return number + 1\n"
TEST = """
def test_counting(rack):
    bench = rack("rack.toml")
    bench.run_for("40 ms")
    assert bench["{0}"] == {1}
    second = rack("rack.toml")
    second.run_for("4 ms")
    assert second["{0}"] == 2
"""


@contextmanager
def adapter(*words: str, cwd: Path) -> Iterator[DebugClient]:
    """Connect to an adapter in its own process."""
    command = [sys.executable, "-m", "scanrack", "debug", *words]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=cwd) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        yield DebugClient(process.stdin, process.stdout)
        process.stdin.close()
        assert process.wait(60) == 0


def outputs(client: DebugClient) -> str:
    client.event("terminated")
    texts = [*client.skipped, *client.events]
    return "".join(each["body"]["output"] for each in texts if each["event"] == "output")


@pytest.mark.parametrize("language", ["rungs", "python"])
def test_the_adapter_runs_a_test_and_stops_in_it(tmp_path: Path, language: str) -> None:
    name, tag, text = ("counting.rung", "Number", RUNGS) if language == "rungs" else (
        "counting.py",
        "counting.number",
        PYTHON,
    )  # fmt: skip
    (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK.format(name), encoding="utf-8")
    (tmp_path / "test_counting.py").write_text(TEST.format(tag, 1015), encoding="utf-8")
    (tmp_path / "adding.py").write_text(ADDING, encoding="utf-8")
    line = 2  # of the module beside the program
    if language == "rungs":
        line = text[: text.index("ADD(Number")].count("\n") + 1
    with adapter(cwd=tmp_path) as client:
        client.ask("initialize", adapterID="scanrack")
        client.ask("launch", pytest="-q test_counting.py")
        client.event("initialized")
        file = tmp_path / (name if language == "rungs" else "adding.py")
        when = {"hitCondition": "% 5"} if language == "rungs" else {"condition": "number % 5 == 4"}
        client.break_at(file, line, **when)
        client.ask("configurationDone")
        assert client.stopped() == ("step", 0)
        assert client.go() == ("breakpoint", 4)
        assert client.value(tag) == "4"
        client.go("stepBack")
        if language == "python":
            client.go("stepBack")  # out of the module beside the program
        assert client.value(tag) == "3"
        with pytest.raises(RefusedError, match="this is scan 3"):
            client.go()
        client.ask("continue", threadId=1)
        assert client.stopped() == ("breakpoint", 9)
        client.value(f"set {tag} = 1005")
        if language == "python":  # scans after a value was set are run again with it
            assert client.go() == ("breakpoint", 14)
            client.go("stepBack")
            client.go("stepBack")
            assert (client.scan(), client.value(tag)) == (13, "1008")
            with pytest.raises(RefusedError, match="this is scan 13"):
                client.go()
        client.break_at(file)
        client.ask("continue", threadId=1)
        assert "1 passed" in outputs(client)


def test_a_test_waits_at_a_port_for_a_client_with_its_key(tmp_path: Path) -> None:
    (tmp_path / "counting.rung").write_text(RUNGS, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK.format("counting.rung"), encoding="utf-8")
    (tmp_path / "test_counting.py").write_text(TEST.format("Number", 20), encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-q", "--scanrack-debug", "test_counting.py"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, cwd=tmp_path, encoding="utf-8") as tests:
        assert tests.stdout is not None
        printed = next(each for each in tests.stdout if "scanrack debug: " in each)
        port, _, rest = printed.partition("scanrack debug: ")[2].partition(" key ")
        with adapter("--connect", port, "--key", rest.partition(";")[0], cwd=tmp_path) as client:
            client.ask("initialize", adapterID="scanrack")
            client.ask("attach", stopOnEntry=False)
            client.event("initialized")
            client.ask("setFunctionBreakpoints", breakpoints=[{"name": "Number == 7"}])
            client.ask("configurationDone")
            assert client.stopped() == ("function breakpoint", 6)
            client.ask("disconnect")
        assert "1 passed" in tests.stdout.read()
