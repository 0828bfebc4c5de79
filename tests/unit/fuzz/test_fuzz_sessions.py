"""One session of `scanrack fuzz` after the other: what is known, what is fixed, what can't be searched."""

from __future__ import annotations

import json

import pytest
from scanrack.commands import build
from scanrack.jobs import read_state
from typer.testing import CliRunner

WATCHES = """
from scanrack.io_images.amci3601 import Configuration, Idle, StatusView

WORDS = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image()

def logic(scan):
    status = StatusView(scan.slot[1].inputs)
    scan.slot[1].outputs.load(Idle().to_image() if status.MODE_CONFIG or scan.number > 5 else WORDS)
    if status.{bit}:
        raise RuntimeError("nobody thought of this")
"""
"""A program that configures its module, and faults when a status bit is set."""

RACK = """program = "line.py"
run_for_s = 0.1
[[slot]]
number = 1
module = "{module}"
"""


@pytest.fixture
def line(tmp_path):
    def make(program, module="amci3601"):
        (tmp_path / "line.py").write_text(program, encoding="utf-8")
        (tmp_path / "line.toml").write_text(RACK.format(module=module), encoding="utf-8")
        return tmp_path / "line.toml"

    return make


def fuzz(rack, *words):
    out = rack.parent / "out"
    command = ["fuzz", str(rack), "--jobs", "1", "--out", str(out), *map(str, words)]
    return CliRunner().invoke(build(), command)


def state_of(rack):
    return read_state(rack.parent / "out" / "state.json", "../line.toml")


@pytest.mark.slow
def test_what_is_fixed_is_reported_once_and_becomes_a_seed(line):
    rack = line(WATCHES.format(bit="IN_ESTOP"))
    assert fuzz(rack, "--runs", 40, "--only", "inputs").exit_code == 1
    (key, broken), *_none = state_of(rack).found.items()
    assert key == "no-fault line.py:10"
    line(WATCHES.format(bit="STOPPED"))
    second = fuzz(rack, "--runs", 5, "--only", "inputs")
    assert (second.exit_code, second.stdout.splitlines()[0]) == (
        0,
        "fixed: The program does not fault the CPU [no-fault]",
    )
    assert state_of(rack).corpus[key] == broken.scenario
    assert "held          commands-end, no-command-error, no-fault," in second.stdout
    report = rack.parent / "out" / "no-fault" / "report.txt"
    assert report.read_text(encoding="utf-8").startswith("Fixed: ")
    assert "fixed:" not in fuzz(rack, "--runs", 5, "--only", "inputs").stdout


@pytest.mark.slow
def test_what_is_not_fixed_is_reported_again_without_a_search_for_it(line):
    rack = line(WATCHES.format(bit="IN_ESTOP"))
    first = fuzz(rack, "--runs", 40, "--only", "inputs")
    second = fuzz(rack, "--runs", 5, "--only", "inputs")
    assert second.exit_code == 1
    assert first.stdout.split("\nbroken: ")[1] == second.stdout.split("\nbroken: ")[1]


@pytest.mark.long
@pytest.mark.slow
def test_faults_are_told_apart_by_their_lines_which_may_move(line):
    two = (
        WATCHES.format(bit="IN_ESTOP") + "    if status.IN_HOME:\n        raise RuntimeError('nor of this')\n"
    )
    rack = line(two)
    words = ("--runs", 60, "--only", "inputs")
    assert fuzz(rack, *words).stdout.count("\nbroken: The program does not fault the CPU") == 2
    before = state_of(rack)
    assert sorted(before.found) == ["no-fault line.py:10", "no-fault line.py:12"]
    assert sorted(before.folders.values()) == ["no-fault", "no-fault-2"]
    line("# a line more\n" + two)
    moved = fuzz(rack, "--runs", 1, "--only", "inputs")
    assert moved.exit_code == 1
    assert "fixed" not in moved.stdout
    after = state_of(rack)
    assert sorted(after.found) == ["no-fault line.py:11", "no-fault line.py:13"]
    assert after.folders["no-fault line.py:11"] == before.folders["no-fault line.py:10"]


@pytest.mark.slow
def test_a_failure_is_told_in_words(line):
    result = fuzz(line(WATCHES.format(bit="IN_ESTOP")), "--runs", 40, "--only", "inputs", "--quiet")
    lines = result.stdout.splitlines()
    assert lines[0].startswith("broken: The program does not fault the CPU [no-fault]: scan ")
    assert lines[1] == "  0 s: input estop of slot 1 is on for 4 ms"  # scan 1 leaves configuration
    assert lines[2].startswith("  slot 1: commands none; status POSITION_INVALID MODULE_OK IN_ESTOP")


@pytest.mark.slow
def test_the_report_tells_how_to_see_it_again_and_how_to_look_after_a_change(line):
    rack = line(WATCHES.format(bit="IN_ESTOP"))
    fuzz(rack, "--runs", 40, "--only", "inputs", "--check", "one-motion")
    found = rack.parent / "out" / "no-fault"
    report = (found / "report.txt").read_text(encoding="utf-8")
    assert (
        f"    scanrack run {found}/rack.toml\n    scanrack drive amci3601 < {found}/drive-slot1.jsonl"
        in report
    )
    chart = (found / "chart.html").read_text(encoding="utf-8")
    assert '"kind":"broken","label":"no-fault is broken"' in chart
    assert f"    {found}/chart.html\n    file://{found}/chart.html#from=0.000&to=0.2" in report
    check = f"    scanrack fuzz {rack} --check one-motion --scenario {found}/scenario.json"
    assert report.splitlines()[-1] == check
    assert CliRunner().invoke(build(), check.split()[1:]).exit_code == 1


@pytest.mark.slow
def test_a_program_that_faults_by_itself_is_not_searched(line):
    rack = line(WATCHES.format(bit="MODULE_OK"))
    result = fuzz(rack, "--runs", 1000)
    assert result.exit_code == 1
    assert "the program faults without random disturbances" in result.stderr
    assert "no events other than in the rack file" in result.stdout
    assert "runs          0\n" in result.stdout


def test_a_state_of_another_rack_is_not_gone_on_with(line, tmp_path):
    rack = line(WATCHES.format(bit="STOPPED"))
    fuzz(rack, "--runs", 1)
    other = tmp_path / "other.toml"
    other.write_bytes(rack.read_bytes())
    result = fuzz(other, "--runs", 1)
    assert result.exit_code == 2
    assert "is for ../line.toml, not for ../other.toml: use another folder with --out" in result.stderr


def test_two_files_with_an_invariant_of_one_name_are_refused(line, tmp_path):
    for name in ("a.py", "b.py"):
        (tmp_path / name).write_text(
            "from scanrack.jobs.fuzz import never\n\n@never\ndef f(now):\n    pass\n", encoding="utf-8"
        )
    result = fuzz(line(WATCHES.format(bit="STOPPED")), "-i", tmp_path / "a.py", "-i", tmp_path / "b.py")
    assert result.exit_code == 2
    assert result.stderr == (f"scanrack: {tmp_path}/b.py: f is also in {tmp_path}/a.py; rename one of them\n")


@pytest.mark.slow
def test_an_invariant_that_was_never_put_to_the_test_is_told(line, tmp_path):
    text = (
        "from scanrack.jobs.fuzz import eventually\n\n"
        "@eventually('10 ms', after=lambda now: now.slot[1].status.IN_CAPTURE)\n"
        "def asks_for_capture(now):\n    return True\n\n"
        "@eventually('10 ms', after=lambda now: now.slot[1].status.IN_ESTOP)\n"
        "def asks_for_estop(now):\n    return True\n"
    )
    (tmp_path / "must.py").write_text(text, encoding="utf-8")
    result = fuzz(
        line(WATCHES.format(bit="STOPPED")), "-i", tmp_path / "must.py", "--runs", 60, "--only", "inputs"
    )
    assert result.exit_code == 0, result.output
    # the program uses all inputs but the capture input
    assert (
        "held          asks_for_capture (its clock never started), asks_for_estop, no-fault" in result.stdout
    )


@pytest.mark.slow
def test_as_many_scenarios_are_tried_as_asked_for(line):
    result = fuzz(line(WATCHES.format(bit="STOPPED")), "--runs", 60, "--only", "inputs")
    assert result.stdout.startswith("runs          60 ")


CLOCK = """
import counted

def logic(scan):
    counted.count += 1
    if counted.count > 60:
        raise RuntimeError("too many scans")
"""


def test_modules_that_a_program_imports_are_made_anew_for_every_run(line, tmp_path):
    rack = line(CLOCK)
    (tmp_path / "counted.py").write_text("count = 0\n", encoding="utf-8")
    assert fuzz(rack, "--runs", 5).exit_code == 0


CHANCE = """
from pathlib import Path

runs = Path(__file__).with_suffix(".runs")
runs.write_text(runs.read_text() + "." if runs.exists() else "")
number = len(runs.read_text())

def logic(scan):
    if number == 3:
        raise RuntimeError("now and then")
"""


def test_a_program_that_does_not_do_the_same_twice_is_told(line):
    result = fuzz(line(CHANCE), "--runs", 20)
    assert result.exit_code == 2
    first, second = result.stderr.splitlines()
    uses = "uses state of the process (line.py:5)"  # it asks whether a file exists
    assert first == (f"scanrack: the program {uses}: results may differ between identical runs")
    assert "results differ between identical runs" in second
    assert second.endswith(f"It {uses}.")


SLEEPS = """
import time
from pathlib import Path

flag = Path(__file__).with_suffix(".slept")

def logic(scan):
    if scan.number == 5 and {when}:
        flag.touch()
        end = time.thread_time() + 0.5  # the watchdog counts processor time
        while time.thread_time() < end:
            pass
"""


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("when", "status"), [("not flag.exists() and runs == 3", 0), ("scan.slot[1].inputs[0] == 0", 1)]
)
def test_a_program_that_was_late_once_is_not_broken_one_that_always_is(line, when, status):
    """In the third run, a moment in which the machine was busy; or whenever the module is taken out."""
    count = CHANCE[: CHANCE.index("def logic")].replace("number = ", "runs = ")
    rack = line(count + SLEEPS.format(when=when))
    rack.write_text("watchdog_ms = 150\n" + rack.read_text(encoding="utf-8"), encoding="utf-8")
    result = fuzz(rack, "--runs", 20, "--for", "20 ms", "--only", "link")
    assert result.exit_code == status, result.output
    assert ("[no-fault]" in result.stdout) is bool(status)


@pytest.mark.parametrize(
    ("scenario", "says"),
    [
        (
            {"presses": [{"slot": 9, "input": "home", "energized": True, "at_ns": 0, "for_ns": 1}]},
            "no slot 9",
        ),
        (
            {"presses": [{"slot": 1, "input": "nix"}]},
            "presses.0.input = 'nix': choose from capture",
        ),
        ({"presses": [{"slot": 1}]}, "key presses.0.input is missing"),
        ([1], "an object with firmware, presses"),
        ({"firmware": {"4": "3.1"}}, "no slot 4"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused_with_its_file(line, tmp_path, scenario, says):
    file = tmp_path / "scenario.json"
    file.write_text(json.dumps(scenario), encoding="utf-8")
    result = fuzz(line(WATCHES.format(bit="STOPPED")), "--scenario", file)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"scanrack: {file}: ")
    assert says in result.stderr


@pytest.mark.parametrize(
    ("module", "words", "says"),
    [
        (
            "amci3601",
            ("--only", "line"),
            "--only line: not applicable to this rack; choose from ",
        ),
        ("pcl601-adapter", ("--only", "firmware"), "choose from inputs, machine, power, mode, torn, line"),
        (
            "amci3601",
            ("--only", "link", "--without", "link"),
            "--without link: nothing random remains",
        ),
    ],
)
def test_kinds_that_are_impossible_are_refused(line, module, words, says):
    result = fuzz(line(WATCHES.format(bit="STOPPED"), module), *words)
    assert result.exit_code == 2
    assert says in result.stderr
