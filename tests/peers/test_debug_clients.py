"""`scanrack debug` with clients of others: every announced request, forwards and backwards."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from scanrack.dap.requests import REQUESTS
from scanrack.jobs import load_job
from scanrack.jobs.run.running import JobRun, RunOptions

pytestmark = pytest.mark.slow

HOUSE = Path(__file__).parents[2]
EXAMPLES = HOUSE / "examples"
MISSING = 3
ADAPTER = "import sys\nfrom scanrack.__main__ import main\nsys.argv = ['scanrack', 'debug']\nmain()\n"

PROGRAMS = {
    "rungs": ("feeder/feeder.toml", "feeder/feeder.rung", "OTE(Feeding)", "Feeding"),
    "L5X": ("l5x/mixer.toml", "l5x/mixer.L5X", "OTE(Start", "Start"),
    "ladder in Python": ("first/rack.toml", "first/first.py", "OTE(late", "Late"),
}
"""Rack, file of the program, text in the line of a breakpoint, a tag."""

RACK = """name = "table"
program = "{}"
scan_ms = 2
[[slot]]
number = 1
module = "1762-IQ8"
"""
WRITTEN = {
    "structured text": ("table.st", "TAG Number : DINT\nNumber := Number + 1;\n", "Number :=", "Number"),
    "sequences": (
        "table.py",
        "from scanrack import Logic, dwell, sequence\n\n\n"
        "class Table(Logic):\n    number = 0\n\n"
        "    @sequence\n    async def cycle(self) -> None:\n        while True:\n"
        '            self.number += 1\n            await dwell("4 ms")\n',
        "self.number +=",
        "table.number",
    ),
    "Python": (
        "plain.py",
        "class State:\n    number: int = 0\n\n\nstate = State()\n\n\n"
        "def logic(scan):\n    state.number += 1\n",
        "state.number += 1",
        "state.number",
    ),
}
"""Programs that the test writes: file, text, text in the line of a breakpoint, a tag."""

LANGUAGES = [*PROGRAMS, *WRITTEN]


def program_of(language: str, folder: Path) -> tuple[Path, Path, str, str]:
    """Return rack, file, text in the line of a breakpoint, and a tag."""
    if language in PROGRAMS:
        rack, name, text, tag = PROGRAMS[language]
        return EXAMPLES / rack, EXAMPLES / name, text, tag
    name, source, text, tag = WRITTEN[language]
    (folder / name).write_text(source, encoding="utf-8")
    (folder / "rack.toml").write_text(RACK.format(name), encoding="utf-8")
    return folder / "rack.toml", folder / name, text, tag


@pytest.fixture
def adapter(tmp_path: Path) -> Path:
    file = tmp_path / "adapter.py"
    file.write_text(ADAPTER, encoding="utf-8")
    return file


def tried(adapter: Path, launch: dict[str, Any], file: Path, line: int, tag: str) -> dict[str, Any]:
    """Return the answer to each request of the client of the protocol's makers."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    script = str(Path(__file__).with_name("debug_requests.cjs"))
    words = [node, script, sys.executable, str(adapter), json.dumps(list(REQUESTS)), json.dumps(launch)]
    words += [str(file), str(line), tag]
    done = subprocess.run(words, capture_output=True, text=True, check=False, encoding="utf-8", timeout=120)
    if done.returncode == MISSING:
        pytest.skip("@vscode/debugadapter-testsupport is not installed where node finds it (NODE_PATH)")
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("recorded", [False, True], ids=["live", "trace"])
def test_every_request_of_the_table_with_the_protocols_own_client(
    adapter: Path, tmp_path: Path, language: str, *, recorded: bool
) -> None:
    rack, file, text, tag = program_of(language, tmp_path)
    source = file.read_text(encoding="utf-8")
    line = source[: source.index(text)].count("\n") + 1
    launch: dict[str, Any] = {"program": str(rack), "speed": "max"}
    if recorded:
        launch = {"program": str(tmp_path / "run.mcap"), "trust": True}
        with ExitStack() as ports:
            JobRun(load_job(str(rack)), ports, RunOptions(trace=tmp_path / "run.mcap")).run(600)
    answers = tried(adapter, launch, file, line, tag)
    others = {"setVariable", "setExpression", "pause"} if recorded else set()
    assert {"attach", "disconnect", *answers} >= set(REQUESTS) - others
    stops = {name.removesuffix(":stop"): each for name, each in answers.items() if name.endswith(":stop")}
    assert stops["continue"]["reason"] in ("breakpoint", "data breakpoint", "function breakpoint")
    assert stops["stepBack"]["reason"] == "step"
    assert stops["reverseContinue"]["reason"] in ("breakpoint", "entry")
    assert {"line": line} in answers["breakpointLocations"]["breakpoints"]
    assert tag in [each["label"] for each in answers["completions"]["targets"]]
    assert f"{tag} = " in answers["evaluate"]["result"]
    if not recorded:  # a function of Python keeps its values to itself
        kept = [name for name in ("setVariable", "setExpression") if "refused" in answers[name]]
        assert kept == (["setVariable", "setExpression"] if language == "Python" else [])


def test_neovim_steps_forwards_and_backwards() -> None:
    """With nvim-dap, whose folder NVIM_DAP names."""
    nvim, plugin = shutil.which("nvim"), os.environ.get("NVIM_DAP")
    if nvim is None or plugin is None:
        pytest.skip("neovim is not installed, or NVIM_DAP does not name the folder of nvim-dap")
    rack, name, text, _tag = PROGRAMS["rungs"]
    source = (EXAMPLES / name).read_text(encoding="utf-8")
    line = source[: source.index(text)].count("\n") + 1
    told = {
        "DEBUG_PYTHON": sys.executable,
        "DEBUG_FILE": str(EXAMPLES / name),
        "DEBUG_LINE": str(line),
        "DEBUG_RACK": str(EXAMPLES / rack),
    }
    script = Path(__file__).with_name("debug_steps.lua")
    words = [nvim, "--headless", "-u", "NONE", "--cmd", f"set rtp+={plugin}", "-c", f"luafile {script}"]
    done = subprocess.run(
        words, capture_output=True, encoding="utf-8", env=os.environ | told, timeout=120, check=False
    )
    rung = f"Main, rung 7|{line}"
    assert done.stdout.splitlines() == [
        "Main, rung 0|29",
        rung,
        "Main, rung 8|40",
        rung,
        rung,  # of the next scan
        rung,
        "0",
    ], done.stderr
