"""What commands may not import: a page of help waits for no library, a program in Python for no rungs."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from scanrack import open_bench

pytestmark = pytest.mark.slow  # together they take seconds

FOLDER = Path(__file__).parents[3]
LINE = FOLDER / "examples/three_stations/line.toml"

ALWAYS = {"asyncio", "hypothesis", "lark", "lxml", "pymodbus", "rich", "serial", "ssl", "websockets"}
HELP = ALWAYS | {"mcap", "numpy", "pydantic", "zstandard"}
"""Libraries that no page of help needs."""

HELP_ROOMS = {
    "scanrack.jobs.load",
    "scanrack.ladder",
    "scanrack.rockwell",
    "scanrack.runtime.config",
    "scanrack.watch.play",
}
RUNGS = {
    "scanrack.ladder.lowering",
    "scanrack.ladder.compiler",
    "scanrack.ladder.debug",
    "scanrack.ladder.instructions",
    "scanrack.ladder.interpreter",
    "scanrack.rockwell",
    "scanrack.watch",
}
"""What a program in Python does without."""

RUN = {"email", "importlib.metadata", "numpy", "rich", "typer"}
"""Libraries that a run of a rack file does without, if its words are plain."""

WHY = {
    "scanrack.jobs.replay",
    "scanrack.jobs.run",
    "scanrack.runtime.live",
    "scanrack.traces.compare",
    "scanrack.traces.signals",
    "typer",
}
"""What a question about a recording of rungs does without."""

LIGHT = (
    "check",
    "compare",
    "doctor",
    "l5x",
    "new",
    "replay",
    "replay --into session",
    "run",
    "watch",
    "why",
)
"""Commands whose help is held to it."""

SCRIPT = """
import json, os, sys
sys.argv = ["scanrack", *sys.argv[1:]]
from scanrack.__main__ import main
sys.stdout = open(os.devnull, "w")
try:
    main()
except SystemExit as end:
    status = end.code
sys.__stdout__.write(json.dumps([status, sorted(sys.modules)]))
sys.__stdout__.flush()
"""


def imported(*words: str) -> set[str]:
    """Return the modules that a command imports."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *words], capture_output=True, text=True, check=True, encoding="utf-8"
    )
    status, modules = json.loads(done.stdout)
    assert not status, done.stderr
    return {".".join(parts[:count]) for each in modules for parts in [each.split(".")] for count in (1, 2, 3)}


@pytest.mark.parametrize("command", LIGHT)
def test_a_page_of_help_imports_no_library(command: str) -> None:
    assert not imported(*command.split(), "--help") & (HELP | HELP_ROOMS)


def test_a_run_of_a_rack_file_imports_what_it_needs(tmp_path: Path) -> None:
    assert not imported("run", str(LINE), "--scans", "2", "--record", str(tmp_path / "a.mcap")) & RUN


def test_a_program_in_python_imports_no_rungs() -> None:
    assert not imported("run", str(LINE), "--no-record", "--scans", "2") & (ALWAYS | RUNGS)


def test_a_question_about_a_recording_of_rungs_imports_what_it_needs(tmp_path: Path) -> None:
    with open_bench(FOLDER / "examples/feeder/feeder.toml", record=tmp_path / "a.mcap") as bench:
        bench.scan(300)
    assert not imported("why", str(tmp_path / "a.mcap"), "Configure.Done") & (ALWAYS | WHY)
