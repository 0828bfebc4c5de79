"""What a run's summary says beside the errors: moves under way, starts, hints."""

import sys

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

RACK = """\
program = "line.steps"
run_for_s = 0.4

[[slot]]
number = 1
module = "amci3601"
"""
START = """\
words 843Eh 003Fh 1      until MODE_CONFIG -CONFIG_ERROR
zero                     until -MODE_CONFIG
PRESET_POSITION          until -POSITION_INVALID
zero                     for 4 ms
"""
MOVE = "ABSOLUTE_MOVE target 20 speed 1000 acceleration 100 deceleration 100    until MOVE_COMPLETE\n"
TURNED = "ABSOLUTE_MOVE target 30 speed 1000 acceleration 100 deceleration 100    for 4 ms\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Runs steps after a start; returns the lines of the summary by their titles, and the notes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))

    def go(steps, rack=""):
        (tmp_path / "line.steps").write_text(START + steps, encoding="utf-8")
        (tmp_path / "line.toml").write_text(RACK + rack, encoding="utf-8")
        done = CliRunner().invoke(build(), ["run", "line.toml", "--no-record"])
        assert done.exit_code == 0, done.output
        titles: dict[str, list[str]] = {}
        for line in done.stdout.splitlines():
            if line[:14].strip():
                title = line[:14].strip()
            titles.setdefault(title, []).append(line[14:].strip())
        return titles, done.stderr

    return go


def test_what_every_start_brings_is_no_error(run):
    summary, notes = run(MOVE + "idle\n")
    assert summary["errors"] == ["none"]
    assert [line.split()[0] for line in summary["normal start"]] == ["CONFIG_ERROR", "POSITION_INVALID"]
    assert summary["moves"] == ["1", "1 absolute: complete"]
    assert "hints" not in summary
    assert notes == ""


def test_a_second_configuration_in_a_run_is_an_error_again(run):
    again = "words 843Eh 003Fh 2   until MODE_CONFIG -CONFIG_ERROR\nzero   until -MODE_CONFIG\n"
    summary, _ = run(again)
    assert summary["errors"][0] == "1"
    assert summary["errors"][1].startswith("POSITION_INVALID")
    assert len(summary["normal start"]) == 2


def test_a_search_that_finds_nothing_is_still_under_way(run):
    summary, _ = run("FIND_HOME_CW speed 1000 acceleration 100 deceleration 100    until AT_HOME\n")
    assert summary["moves"] == ["1", "1 search for home: still under way at the end"]


def test_a_move_under_way_is_told_behind_incidents_and_adapters(run):
    incident = '[[incident]]\nat_s = 0.2\nwhat = "torn-update"\nlate_words = [1]\n'
    far = MOVE.replace("20 speed", "90000 speed")
    assert run(far, incident)[0]["moves"][1] == "1 absolute: still under way at the end"


def test_a_search_that_finds_home_says_so(run):
    home = '[slot.machine]\nswitches = [{ input = "home", first = 20, last = 60 }]\n'
    summary, _ = run("FIND_HOME_CW speed 1000 acceleration 100 deceleration 100    until AT_HOME\n", home)
    assert summary["moves"] == ["1", "1 search for home: found"]


def test_a_target_changed_while_the_bit_stays_on_is_hinted_at(run):
    summary, _ = run(MOVE + TURNED)
    (hint,) = summary["hints"]
    assert hint.startswith("slot 1: output word 3 changed in scan ")
    assert hint.endswith(
        "while ABSOLUTE_MOVE stayed on, and no move followed: a move starts when its bit goes from 0 to 1"
    )


@pytest.mark.parametrize(
    "steps",
    [
        MOVE + TURNED + "idle  for 4 ms\n" + TURNED.replace("for 4 ms", "until MOVE_COMPLETE"),
        MOVE + TURNED + "zero\n",
        "MANUAL_CW speed 1000 acceleration 100 deceleration 100  for 20 ms\n"
        "MANUAL_CW speed 2000 acceleration 100 deceleration 100  for 20 ms\n",
    ],
    ids=["an edge follows", "the bit is taken back", "a manual move takes new speeds"],
)
def test_there_is_no_hint_where_nothing_is_missed(run, steps):
    assert "hints" not in run(steps)[0]


WIRED = {
    "a switch": 'switches = [{ input = "estop", first = 900 }]',
    "a button": 'timeline = [{ at_s = 0.3, input = "estop", for_ms = 5 }]',
    "a station": 'stations = [{ position = 900, input = "estop", work_ms = 5, pulse_ms = 5 }]',
}


@pytest.mark.parametrize("part", WIRED.values(), ids=WIRED)
def test_a_wired_input_that_is_configured_needs_no_warning(run, part):
    assert run("idle\n", f"[slot.machine]\n{part}\n")[1] == ""


@pytest.mark.parametrize("part", WIRED.values(), ids=WIRED)
def test_a_wired_input_that_is_not_configured_is_warned_of(run, part, monkeypatch):
    monkeypatch.setitem(globals(), "START", START.replace("843Eh", "8436h"))  # less bit 3, the emergency stop
    _, notes = run("idle\n", f"[slot.machine]\n{part}\n")
    assert notes == (
        "scanrack: slot 1: estop is wired to the machine, but the configuration does not use it: "
        "it has no effect\n"
    )
