"""A recording becomes the scenario that a search varies."""

from __future__ import annotations

import json

import pytest
from scanrack.commands import build
from scanrack.commands.programs.run_job import run_job
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import RunOptions, load_job
from scanrack.jobs.fuzz import Press, Scenario
from scanrack.jobs.fuzz.learning import learn, recorded_scenario
from scanrack.jobs.fuzz.scenarios.scenario import entries_of
from scanrack.jobs.run.playback import Stimulus
from scanrack.runtime import RackSpec
from scanrack.runtime.machine import MachineSpec, Station, Switch
from typer.testing import CliRunner

CAPTURE, HOME, ESTOP = InputBit.CAPTURE, InputBit.HOME, InputBit.ESTOP
PROGRAM = """
from scanrack.io_images.amci3601 import Configuration, Idle, StatusView

WORDS = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image()

def logic(scan):
    in_mode = StatusView(scan.slot[1].inputs).MODE_CONFIG
    scan.slot[1].outputs.load(Idle().to_image() if in_mode or scan.number > 5 else WORDS)
"""
RACK = """program = "line.py"
run_for_s = 0.2
trace = "line.mcap"
[[slot]]
number = 1
module = "amci3601"
[slot.machine]
timeline = [{ at_ms = 100, input = "estop", for_ms = 50 }]
"""
INVARIANT = '''
from scanrack.jobs.fuzz import never

@never
def pressed(now):
    """Nobody presses the emergency stop after the recording's time."""
    return now.slot[1].status.IN_ESTOP and now.ns >= 151_000_000
'''


def spec_of(machine):
    return RackSpec.model_validate(
        {"program": "none.py", "slot": [{"number": 1, "module": "amci3601", "machine": machine}]}
    )


def recorded(machine, *stimuli, end_ns=900):
    told = [Stimulus(at_ns, 1, bit, energized) for at_ns, bit, energized in stimuli]
    return recorded_scenario(told, spec_of(machine), end_ns).presses


def test_a_button_is_pressed_until_it_is_let_go_or_the_recording_ends():
    assert recorded(MachineSpec(), (100, ESTOP, True), (300, ESTOP, False), (400, ESTOP, True)) == (
        Press(1, ESTOP, True, 100, 200),
        Press(1, ESTOP, True, 400, 500),
    )


def test_a_sensor_that_fails_either_way_is_a_press_until_it_is_repaired():
    machine = MachineSpec(switches=(Switch(HOME, 10, 20),))
    assert recorded(machine, (100, HOME, False), (300, HOME, True), (400, HOME, None)) == (
        Press(1, HOME, False, 100, 200),
        Press(1, HOME, True, 300, 100),
    )


def test_what_a_station_signals_comes_from_the_machine_again():
    machine = MachineSpec(stations=(Station(100, CAPTURE, work_ns=5, pulse_ns=5),))
    assert recorded(machine, (100, CAPTURE, True), (105, CAPTURE, False)) == ()


def test_the_presses_of_a_recording_are_its_timeline():
    presses = recorded(MachineSpec(), (100, ESTOP, True), (300, ESTOP, False))
    entries = entries_of(presses[0], MachineSpec())
    assert [(each.at_ns, each.energized) for each in entries] == [(100, True), (300, False)]


@pytest.fixture
def trace(tmp_path):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "must.py").write_text(INVARIANT, encoding="utf-8")
    result = scanrack("run", tmp_path / "line.toml", "--quiet")
    assert result.exit_code == 0, result.output
    return tmp_path / "line.mcap"


def scanrack(*words):
    return CliRunner().invoke(build(), [str(word) for word in words])


@pytest.mark.slow
def test_a_trace_is_varied_until_something_breaks(trace, tmp_path):
    """Only the recording knows of the button: nothing else that is random here presses it."""
    out = tmp_path / "out"
    command = ["fuzz", trace, "-i", tmp_path / "must.py", "--out", out, "--jobs", "1", "--runs", 40]
    result = scanrack(*command, "--only", "firmware", "--trust")
    assert result.exit_code == 1, result.output
    assert "Nobody presses the emergency stop after the recording's time [pressed]" in result.stdout
    found = json.loads((out / "pressed" / "scenario.json").read_text(encoding="utf-8"))
    assert [each["input"] for each in found["presses"]] == ["estop"]
    assert found["presses"][0]["at_ns"] > 100_000_000
    again = scanrack("run", out / "pressed" / "rack.toml", "--no-record", "--quiet")
    assert again.exit_code == 0, again.output
    learned = json.loads((out / "recording" / "scenario.json").read_text(encoding="utf-8"))
    assert Scenario.from_json(learned).presses == (Press(1, ESTOP, True, 100_000_000, 50_000_000),)


def test_python_of_a_trace_is_run_only_if_it_is_trusted(trace, tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    result = scanrack("fuzz", trace, "--runs", 1)
    assert result.exit_code == 2
    assert "--trust" in result.stderr


LINKED = """program = "line.py"
run_for_s = 0.5
[[slot]]
number = 1
module = "pcl601-adapter"
"""


def test_of_a_real_controller_the_status_bits_tell_what_was_pressed(tmp_path):
    """The rack file is the real one's; what is recorded is made with a simulated one and its button."""
    rack, trace = tmp_path / "line.toml", tmp_path / "line.mcap"
    (tmp_path / "line.py").write_text(PROGRAM.replace("> 5", "> 60"), encoding="utf-8")
    rack.write_text(
        LINKED + '[slot.machine]\ntimeline = [{ at_ms = 250, input = "estop", for_ms = 100 }]\n',
        encoding="utf-8",
    )
    job = load_job(str(rack))
    rack.write_text(LINKED + 'port = "/dev/ttyUSB9"\n', encoding="utf-8")
    assert run_job(job, 250, RunOptions(trace=trace), quiet=True) == 0
    learned = learn(trace, tmp_path / "recording", trust=True)
    assert not load_job(str(learned.rack)).spec.slot[0].is_live
    (press,) = learned.scenario.presses
    assert (press.input, press.energized) == (ESTOP, True)
    assert 250_000_000 <= press.at_ns < 300_000_000  # inputs are read every 15 ms or so
    assert press.for_ns == pytest.approx(100_000_000, abs=40_000_000)


def test_a_file_that_is_no_trace_is_told(tmp_path):
    (tmp_path / "line.mcap").write_text("no trace", encoding="utf-8")
    result = scanrack("fuzz", tmp_path / "line.mcap", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert result.stderr == f"scanrack: {tmp_path}/line.mcap: it is not an MCAP file\n"
