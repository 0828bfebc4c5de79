"""What is reported has happened twice; what a program uses that may differ from run to run is named."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from scanrack.commands import build
from scanrack.jobs.fuzz.nondeterminism import CHANCE, CLOCK, PROCESS, THREADS, NondeterminismSources
from typer.testing import CliRunner

RACK = """program = "line.py"
run_for_s = 0.05
[[slot]]
number = 1
module = "amci3601"
"""
IDLE = "\n\ndef logic(scan):\n    pass\n"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("import random\nrandom.random()", CHANCE),
        ("from random import randint\nrandint(1, 6)", CHANCE),
        ("import random\nrandom.Random().random()", CHANCE),
        ("import secrets\nsecrets.token_hex()", CHANCE),
        ("import uuid\nuuid.uuid4()", CHANCE),
        ("import os\nos.urandom(4)", CHANCE),
        ("import time\ntime.monotonic()", CLOCK),
        ("from time import time\ntime()", CLOCK),
        ("from datetime import datetime\ndatetime.now()", CLOCK),
        ("from datetime import date\ndate.today()", CLOCK),
        ("import threading\nthreading.Thread(target=int).start()", THREADS),
        ("import os\nos.environ.get('HOME')", PROCESS),
        ("import os\nos.getpid()", PROCESS),
        ("hash('text')", PROCESS),
        ("id(object())", PROCESS),
        ("open(__file__, 'rb').close()", PROCESS),
        ("from pathlib import Path\nPath(__file__).exists()", PROCESS),
        ("import os\nos.path.exists(__file__)", PROCESS),
        ("import random\nrandom.Random(7).random()", None),
        ("import random\nrandom.seed(7)\nrandom.random()", None),
        ("import math, json, re\nmath.sqrt(2)\njson.dumps([1])\nre.findall('a', 'aa')", None),
        ("from datetime import datetime\ndatetime(2020, 1, 1)", None),
        ("from pathlib import Path\nPath('a').with_suffix('.b').name", None),
        ("print('x', flush=True)", None),
        ("class A:\n    x = sorted({1, 2})\nA()", None),
    ],
)
def test_what_is_used_is_named_with_its_line(tmp_path, text, what):
    file = tmp_path / "line.py"
    code = compile(text, str(file), "exec")
    file.write_text(text, encoding="utf-8")
    uses = NondeterminismSources()
    with uses.recording():
        exec(code, {"__name__": "line", "__file__": str(file)})
    assert list(uses.seen) == ([what] if what else [])
    if what:
        assert uses.seen[what] == f"line.py:{text.count(chr(10)) + 1}"


def test_a_profile_function_is_given_back():
    before = sys.getprofile()
    with NondeterminismSources().recording():
        pass
    assert sys.getprofile() is before


@pytest.fixture
def rack(tmp_path):
    def make(program):
        (tmp_path / "line.py").write_text(program, encoding="utf-8")
        (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
        return tmp_path / "line.toml"

    return make


def words(rack, *more):
    out = rack.parent / "out"
    return ["fuzz", str(rack), "--jobs", "1", "--runs", "3", "--only", "inputs", "--out", str(out), *more]


def fuzz(rack, *more):
    return CliRunner().invoke(build(), words(rack, *more))


def test_a_program_that_uses_chance_and_the_clock_is_named_though_it_breaks_nothing(rack):
    result = fuzz(rack("import random, time\nSTART = time.time()\nOFFSET = random.random()" + IDLE))
    assert result.exit_code == 0
    assert result.stderr == (
        "scanrack: the program uses chance (line.py:3) and the clock (line.py:2): "
        "results may differ between identical runs\n"
    )


NAMES = """
names = set()
for name in ("gate", "door", "belt", "lift", "lamp", "horn", "ramp", "cart"):
    names.add(name)
"""
SETS = f"""{NAMES}
def logic(scan):
    if ORDER == list(names):
        raise RuntimeError("this order was not thought of")
"""
"""It depends on the order of a set of texts, which the hash seed decides."""


@pytest.mark.slow
def test_what_only_one_hash_seed_breaks_is_no_failure_but_said(rack):
    environment = os.environ | {"PYTHONHASHSEED": "7"}
    asked = [sys.executable, "-c", f"{NAMES}print(list(names))"]
    order = subprocess.run(
        asked, env=environment, capture_output=True, text=True, check=True, encoding="utf-8"
    ).stdout
    file = rack(f"ORDER = {order}{SETS}")
    command = [sys.executable, "-m", "scanrack", *words(file)]
    result = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False, encoding="utf-8"
    )
    assert result.returncode == 2, result.stdout
    assert "it broke no-fault in one run and not in another" in result.stderr
    assert "the order of a set of texts" in result.stderr
    assert not (file.parent / "out" / "no-fault").exists()


PROCESS_STATE = """
import sys

def logic(scan):
    if hasattr(sys, "ps1_of_the_bench"):
        raise RuntimeError("it was set by another program of this process")
"""


@pytest.mark.slow
def test_what_only_this_process_breaks_is_no_failure_but_said(rack, monkeypatch):
    monkeypatch.setattr(sys, "ps1_of_the_bench", True, raising=False)
    result = fuzz(rack(PROCESS_STATE))
    assert result.exit_code == 2
    assert "depends on its process" in result.stderr


def test_what_a_program_prints_is_counted_and_shown_with_a_scenario_only(rack, tmp_path):
    noisy = rack("import sys\n\ndef logic(scan):\n    print('scan')\n    print('late', file=sys.stderr)\n")
    result = fuzz(noisy)
    assert result.exit_code == 0
    assert "\nscan\n" not in result.stdout
    assert result.stderr == ""
    assert "printed       150 lines by the program, not shown" in result.stdout  # 3 runs, 25 scans, 2 lines
    (tmp_path / "none.json").write_text("{}", encoding="utf-8")
    alone = fuzz(noisy, "--scenario", str(tmp_path / "none.json"))
    assert alone.stdout.count("scan\n") == 25
