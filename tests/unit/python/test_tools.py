"""The tools on logic in Python: run, rerun, replay into the program, why, compare, fuzz; a fork."""

import os

import pytest
from scanrack.commands import build
from scanrack.jobs import ProgramError, load_job, load_program
from scanrack.jobs.fuzz.job import logic_factory
from scanrack.ladder.python.sequences import Logic
from sequence_bench import SequenceBench
from typer.testing import CliRunner

PROGRAM = """\
from scanrack import Axis3601, Configuration, Input, Logic, Output, dwell, sequence


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500))
    start = Input("Local:2:I.Data.0")
    lamp: Output = Output("Local:2:O.Data.0")
    count = 0

    def every_scan(self):
        self.lamp = self.axis.moving

    @sequence
    async def cycle(self):
        await self.axis.configure()
        await self.axis.set_position(0)
        while True:
            await self.start.rises
            for station in (0, 400, 800):
                await self.axis.move_to(station, speed=5000, acceleration=10, deceleration=10)
                await dwell("10 ms")
            self.count += 1
"""

RACK = """\
name = "line"
program = "line.py"
scan_ms = 2
run_for_s = 2
trace = "line.mcap"

[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"

[[slot]]
number = 2
module = "discrete16"

[slot.options]
inputs = { start = 0 }
timeline = [{ at_ms = 100, input = "start", for_ms = 50 }]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments):
    result = CliRunner().invoke(build(), list(arguments))
    assert result.exit_code == 0, result.output
    return result.output


def test_run_rerun_compare_replay_and_why(folder):
    assert "complete" in call("run", "line.toml")
    assert "identical byte for byte" in call("replay", "--into", "session", "line.mcap")
    (folder / "line.mcap").rename(folder / "first.mcap")
    call("run", "line.toml")
    call("compare", "first.mcap", "line.mcap")
    assert "show the same" in call("replay", "line.mcap", "--into", "program")
    assert "cycle waits at line 18" in call("why", "line.mcap")


def test_a_fuzz_trial_is_a_new_instance(folder):
    job = load_job("line.toml")
    make = logic_factory(job, "line.toml")
    first, second = make(), make()
    assert isinstance(first, Logic)
    assert type(first) is type(second)
    assert first is not second
    assert first is not job.logic


def test_a_class_an_instance_or_the_only_class_of_a_file(folder):
    names = {
        "line.py": "Line",
        "line.py:Line": "Line",
    }
    for address, name in names.items():
        program = load_program(address)
        assert (program.name, type(program.function).__name__) == (name, "Line")
    (folder / "made.py").write_text(f"{PROGRAM}\n\nlogic = Line()\nother = Line()\n", encoding="utf-8")
    assert load_program("made.py").name == "logic"
    assert load_program("made.py:other").name == "other"


def test_of_several_classes_one_has_to_be_named(folder):
    (folder / "two.py").write_text(f"{PROGRAM}\n\nclass Other(Line):\n    pass\n", encoding="utf-8")
    with pytest.raises(ProgramError, match=r"more than one class of Logic: choose one, such as two\.py:Line"):
        load_program("two.py")
    assert type(load_program("two.py:Other").function).__name__ == "Other"


def test_a_class_with_arguments_names_its_line(folder):
    text = PROGRAM + "\n    def __init__(self, speed):\n        self.speed = speed\n"
    (folder / "line.py").write_text(text, encoding="utf-8")
    with pytest.raises(ProgramError, match="missing 1 required positional argument: 'speed'"):
        load_program("line.py")


@pytest.mark.filterwarnings("ignore:.*use of fork.*:DeprecationWarning")
def test_both_sides_of_a_fork_in_mid_wait_go_on_equally(folder):
    """A coroutine can't be copied; a process can."""
    bench = SequenceBench(load_program("line.py").function).scan(60).press(0).scan(30)
    assert bench.logic.axis.moving
    reading, writing = os.pipe()
    child = os.fork()
    bench.scan(400)
    seen = repr((bench.words, list(bench.rack.slots[1].inputs), str(bench.sequences[0]))).encode()
    if not child:
        os.write(writing, seen)
        os._exit(0)
    os.waitpid(child, 0)
    assert os.read(reading, 10_000) == seen
    os.close(reading)
    os.close(writing)
