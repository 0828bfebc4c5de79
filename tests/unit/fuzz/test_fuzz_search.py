"""The search finds what is planted, shrinks it, and hands it over so that it can be run again."""

import json
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from campaign_work import DiesOnce, dies
from scanrack.commands import build
from scanrack.jobs import State, read_state, write_state
from scanrack.jobs.fuzz import Counterexample, Scenario
from scanrack.jobs.fuzz.campaign.campaign import campaign
from scanrack.jobs.fuzz.campaign.state import CampaignError
from scanrack.jobs.fuzz.run import BrokenInvariant
from typer.testing import CliRunner

CONFIGURES = """
from scanrack.io_images.amci3601 import Configuration, Idle, InputBit, Move, MoveKind, StatusView

USED = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
MOVE = Move(MoveKind.RELATIVE, 400, speed=5000, acceleration=100, deceleration=100).to_image()
state = {"step": 0}

def logic(scan):
    status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
    if state["step"] == 0:
        out.load(WORDS)
        state["step"] = 1
    elif state["step"] == 1 and status.MODE_CONFIG:
        out.load(Idle().to_image())
        state["step"] = 2
    elif state["step"] == 2 and not status.MODE_CONFIG:
        go(status, out, scan)
"""
HASTY = (
    CONFIGURES
    + """
def go(status, out, scan):
    out.load(MOVE if scan.number % 100 < 50 else Idle().to_image())
    if status.IN_HOME or status.IN_CAPTURE or status.IN_CW_LIMIT:
        out[0] |= 3  # an absolute move and a relative one
"""
)
CRASHES = (
    CONFIGURES
    + """
def go(status, out, scan):
    if status.IN_ESTOP:
        raise RuntimeError("nobody thought of this")
"""
)
RACK = """program = "line.py"
run_for_s = 0.4
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def rack(tmp_path):
    def make(program):
        (tmp_path / "line.py").write_text(program, encoding="utf-8")
        file = tmp_path / "line.toml"
        file.write_text(RACK, encoding="utf-8")
        return file

    return make


def fuzz(rack, *words):
    out = rack.parent / "out"
    return CliRunner().invoke(
        build(), ["fuzz", str(rack), "--jobs", "1", "--out", str(out), *map(str, words)]
    )


@pytest.mark.slow
def test_a_fault_is_found_shrunk_and_can_be_run_again(rack, tmp_path):
    file = rack(CRASHES)
    result = fuzz(file, "--runs", 50, "--only", "inputs")
    assert result.exit_code == 1, result.output
    assert "The program does not fault the CPU [no-fault]" in result.stdout
    assert "RuntimeError: nobody thought of this" in result.stdout
    found = tmp_path / "out" / "no-fault"
    scenario = json.loads((found / "scenario.json").read_text(encoding="utf-8"))
    assert [(each["input"], each["energized"]) for each in scenario["presses"]] == [("estop", True)]
    assert [key for key, parts in scenario.items() if parts] == ["presses"]
    again = CliRunner().invoke(build(), ["run", str(found / "rack.toml"), "--no-record", "--quiet"])
    assert again.exit_code == 1
    assert "nobody thought of this" in again.stderr
    alone = fuzz(file, "--scenario", found / "scenario.json")
    assert alone.exit_code == 1


@pytest.mark.slow
def test_a_broken_rule_is_told_with_its_sentence_and_the_drive_script_shows_it(rack, tmp_path):
    result = fuzz(rack(HASTY), "--runs", 40, "--only", "inputs", "--check", "no-command-error")
    assert result.exit_code == 1, result.output
    found = tmp_path / "out" / "no-command-error"
    report = (found / "report.txt").read_text(encoding="utf-8")
    assert "[CMD-" in report
    script = (found / "drive-slot1.jsonl").read_text(encoding="utf-8")
    bench = CliRunner().invoke(build(), ["drive", "amci3601"], input=script)
    assert bench.exit_code == 0, bench.output
    replies = [json.loads(line) for line in bench.stdout.splitlines()]
    assert any("COMMAND_ERROR" in reply.get("bits", ()) for reply in replies)


def test_nothing_is_found_where_everything_holds(rack):
    result = fuzz(rack(CONFIGURES + "\ndef go(status, out, scan):\n    pass\n"), "--runs", 20)
    assert result.exit_code == 0, result.output
    assert "runs          20" in result.stdout


@pytest.mark.slow
def test_a_campaign_goes_on_where_it_left_off(rack, tmp_path):
    file = rack(CONFIGURES + "\ndef go(status, out, scan):\n    pass\n")
    fuzz(file, "--runs", 10)
    kept = len([*(tmp_path / "out" / "corpus").glob("*.json")])  # run again first, by a task of its own
    second = fuzz(file, "--runs", 10)
    assert kept > 0
    assert f"in all        {20 + kept} runs" in second.stdout
    assert read_state(tmp_path / "out" / "state.json", "../line.toml").tasks == 3


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--check", "no-smoke"), "unknown check 'no-smoke'; choose from no-command-error"),
        (("--only", "weather"), "unknown kind 'weather'; choose from inputs"),
        (("--invariants", "nowhere.py"), "nowhere.py: no such file"),
        (("--scenario", "nowhere.json"), "nowhere.json"),
        (("--budget", "5"), "'5' is not a time"),
    ],
)
def test_what_cannot_be_used_is_told(rack, words, says):
    result = fuzz(rack(HASTY), *words)
    assert result.exit_code in (2, 3)
    assert says in result.stderr
    assert "Traceback" not in result.output


# --- campaigns


def pool():
    return ProcessPoolExecutor(2, mp_context=get_context("spawn"))


@pytest.mark.slow
def test_a_task_whose_worker_dies_is_given_out_again(tmp_path):
    state = State()
    campaign(DiesOnce(tmp_path / "died"), state, pool, examples=3, tasks=4, jobs=2)
    assert (state.tasks, state.runs) == (4, 12)
    assert sorted(state.rules) == ["R0", "R1", "R2", "R3"]


@pytest.mark.slow
def test_a_task_that_kills_every_worker_ends_the_campaign():
    with pytest.raises(CampaignError, match="its worker has died 3 times"):
        campaign(dies, State(), pool, examples=1, tasks=1, jobs=1)


def test_a_state_is_written_and_read(tmp_path):
    broken = BrokenInvariant(
        "name", "It holds.", 3, 6_000_000, "it is false", ("slot 1: idle",), ("a rule [CMD-01]",)
    )
    state = State("line.toml", 2, {"CMD-01": Scenario()}, runs=10, scans=500, rules=Counter({"CMD-01": 2}))
    state.found["name"] = Counterexample(Scenario(), broken, 7)
    state.folders["name"] = "name"
    write_state(state, tmp_path / "state.json")
    assert read_state(tmp_path / "state.json", "line.toml") == state


def test_a_file_that_is_no_state_is_refused(tmp_path):
    file = tmp_path / "state.json"
    file.write_text("{}", encoding="utf-8")
    with pytest.raises(CampaignError, match="move it away to start again"):
        read_state(file, "line.toml")
