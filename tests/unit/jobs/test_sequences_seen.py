"""A program with sequences, seen from outside: recording, bench, why; run again, replayed and compared."""

import pytest
from scanrack import open_bench, open_trace
from scanrack.commands import build
from scanrack.jobs.bench import NotReachedError
from scanrack.traces.read.sequence_steps import sequence_steps
from typer.testing import CliRunner

pytestmark = pytest.mark.slow  # together they take seconds

PROGRAM = """from enum import Enum

from scanrack import Axis3601, Configuration, Input, InputBit, Logic, sequence, until

class Mode(Enum):
    IDLE = "idle"
    BUSY = "busy"


USED = InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))
    start = Input("slot1.status.IN_CAPTURE")
    count: int = 0
    mode = Mode.IDLE

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        await self.start.rises
        await self.axis.move_to(400, speed=5000, acceleration=100, deceleration=100)
        self.count += 1

    @sequence
    async def turns(self) -> None:
        while True:
            await until(lambda: True)
"""
RACK = """program = "line.py"
run_for_s = 0.4
[[slot]]
number = 1
module = "amci3601"
[[slot.machine.timeline]]
at_s = 0.099
input = "capture"
energized = true
"""


@pytest.fixture
def rack(tmp_path):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    file = tmp_path / "rack.toml"
    file.write_text(RACK, encoding="utf-8")
    return file


@pytest.fixture
def trace(rack, tmp_path):
    path = tmp_path / "run.mcap"
    result = invoke("run", rack, "--record", path, "-q")
    assert result.exit_code == 0, result.output
    return path


def invoke(*words):
    return CliRunner().invoke(build(), list(map(str, words)))


def test_a_row_for_each_wait_and_none_while_waiting(trace):
    with open_trace(trace) as opened:
        steps = sequence_steps(opened)
    assert [step.label for step in steps["cycle"]] == [
        "line 21: axis.configure()",
        "line 22: axis.set_position(0)",
        "line 23: start rises",
        "line 24: axis.move_to(400)",
        "over",
    ]
    # the button of the timeline is in at 0.099 s; scan 50 of 2 ms each is the first to see it
    assert steps["cycle"][3].scan == 50
    # a sequence that goes on in every scan, to the same wait, is told of once
    assert [(step.scan, step.line) for step in steps["turns"]] == [(0, 30)]


def test_a_run_ends_with_where_they_stand(rack):
    result = invoke("run", rack, "--no-record", "--scans", "52")
    told = [line.removeprefix("sequences").strip() for line in result.stdout.splitlines()]
    assert "cycle waits at line 24 of line.py for axis.move_to(400) since 0.1 s" in told


def test_a_hint_names_the_line_of_the_axis(rack, tmp_path):
    rack.write_text(RACK.replace('input = "capture"', 'input = "estop"'), encoding="utf-8")
    result = invoke("run", rack, "--no-record", "--scans", "52")
    assert result.stderr.rstrip().endswith(f"it has no effect [{tmp_path / 'line.py'}:14]")


def test_show_and_query_know_it(trace):
    shown = invoke("show", trace).stdout
    assert "cycle waits at line 24 of line.py for axis.move_to(400)" in shown
    assert "cycle is over" in shown
    found = invoke("query", trace, "rose(cycle.line == 24)")
    assert found.stdout.splitlines()[1].split()[:2] == ["50", "50"]


def test_why_says_where_they_wait_and_for_which_line_the_axis_sends(rack, trace):
    answer = invoke("why", rack, "--at", "52").stdout
    assert "cycle waits at line 24 of line.py for axis.move_to(400) since 0.1 s" in answer.splitlines()
    assert "line.py:24 in cycle, sent by axis for axis.move_to(400)" in answer
    by_rack = invoke("why", rack, "slot1.command.ABSOLUTE_MOVE", "--at", "50").stdout
    assert by_rack.splitlines() == [
        "after 51 scans, 0.1 s:",
        "slot1.command.ABSOLUTE_MOVE is on since 0.1 s (scan 50): line.py:24: await self.axis.move_to(400, "
        "speed=500...",
        "  because cycle continued at 0.1 s: line.py:23: start rises is over",
        "Cause: start is on since 0.1 s: slot 1 input IN_CAPTURE: The capture input is energized.",
    ]
    by_trace = invoke("why", trace, "slot1.command.ABSOLUTE_MOVE", "--at", "50", "--trust").stdout
    assert by_trace.partition("\n")[2] == by_rack.partition("\n")[2]
    of_trace = invoke("why", trace, "--at", "52", "--trust").stdout
    assert of_trace.partition("\n")[2] == answer.partition("\n")[2]


def test_why_knows_the_names_of_the_class(rack, trace):
    cycle = invoke("why", rack, "cycle", "--at", "52").stdout.splitlines()
    assert cycle[1].startswith("cycle waits for axis.move_to(400) since 0.1 s (scan 50): line.py:24: await")
    assert cycle[2].startswith("Cause: axis: slot 1: moving CW, accelerating, at ")
    assert invoke("why", trace, "line.cycle", "--at", "52", "--trust").stdout.splitlines()[1:] == cycle[1:]
    waiting = invoke("why", rack, "cycle", "--at", "40").stdout.splitlines()
    assert waiting[2].startswith("Cause: start is off since 0.016 s")  # before, the configuration is mirrored
    assert "start is on since 0.1 s (scan 50)" in invoke("why", rack, "line.start", "--at", "52").stdout
    axis = invoke("why", rack, "axis", "--at", "52").stdout
    assert "axis: slot 1: moving CW" in axis
    assert "no tag matches 'axi'" in invoke("why", rack, "axi").stderr


def test_a_question_leaves_the_bench_as_it_is(rack):
    asked, plain = open_bench(rack), open_bench(rack)
    for bench in (asked, plain):
        bench.scan(52)
    asked.check("cycle")
    asked.why("cycle")
    asked.why("line.count")
    for bench in (asked, plain):
        bench.run_until(lambda bench: bench.sequences["cycle"].over)
    assert (asked.scans, str(asked)) == (plain.scans, str(plain))
    assert asked["line.count"] == 1


def test_the_bench_says_where_they_wait(rack):
    bench = open_bench(rack)
    bench.run_until(lambda bench: bench.sequences["cycle"].line == 24)
    with pytest.raises(NotReachedError, match=r"cycle waits at line 24 of line\.py for axis"):
        bench.run_until("slot1.status.HOLD_STATE", within="10 ms")
    bench.run_until(lambda bench: bench.sequences["cycle"].over)
    assert "cycle is over since" in str(bench)


def test_fields_of_the_class_are_recorded_like_tags(rack, tmp_path):
    path = tmp_path / "tags.mcap"
    assert invoke("run", rack, "--record", path, "--tag", "line.*", "-q").exit_code == 0
    with open_trace(path) as opened:
        assert opened.head.tags is not None
        assert [(field.tag.name, field.tag.type) for field in opened.head.tags.fields] == [
            ("line.count", "LINT"),
            ("line.mode", "ENUM"),
        ]
    found = invoke("query", path, "rose(line.count == 1)").stdout.splitlines()[1].split()[0]
    with open_trace(path) as opened:
        assert int(found) == sequence_steps(opened)["cycle"][-1].scan  # the scan in which it is over
    assert ": self.count += 1" in invoke("why", rack, "line.count").stdout.splitlines()[1]
    refused = invoke("run", rack, "--tag", "count", "--record", tmp_path / "no.mcap")
    assert (refused.exit_code, "did you mean line.count?" in refused.stderr) == (2, True)


def test_run_again_it_is_the_same_byte_for_byte(trace):
    again = invoke("replay", "--into", "session", trace, "--trust")
    assert (again.exit_code, "identical byte for byte" in again.stdout) == (0, True)


@pytest.mark.parametrize("into", ["module", "program", "rack"])
def test_replayed_it_answers_the_same(trace, into):
    result = invoke("replay", trace, "--into", into, "--trust", "-q")
    assert result.exit_code == 0, result.output


def test_compared_with_another_program_the_first_difference_is_found(rack, trace, tmp_path):
    other = tmp_path / "other.mcap"
    (tmp_path / "line.py").write_text(PROGRAM.replace("move_to(400", "move_to(500"), encoding="utf-8")
    assert invoke("run", rack, "--record", other, "-q").exit_code == 0
    result = invoke("compare", trace, other)
    assert (result.exit_code, "first in scan 50" in result.stdout) == (1, True)
    waits = "axis.move_to(400) from scan 50 on / axis.move_to(500) from scan 50 on"
    assert f"sequence cycle: {waits}" in result.stdout.splitlines()
    assert "slot1.out.target" in result.stdout


LAMP = """from scanrack import Axis3601, Configuration, Input, InputBit, Logic, Output, sequence

USED = InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))
    start = Input("slot1.status.IN_CAPTURE")
    lamp: Output = Output("lamp")

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()

    def every_scan(self) -> None:
        if self.start and not self.lamp:
            self.lamp = self.start
"""


def test_moved_lines_are_no_difference(rack, trace, tmp_path):
    other = tmp_path / "other.mcap"
    (tmp_path / "line.py").write_text(f"# a comment\n{PROGRAM}", encoding="utf-8")
    assert invoke("run", rack, "--record", other, "-q").exit_code == 0
    result = invoke("compare", trace, other)
    assert (result.exit_code, "sequence" in result.stdout) == (0, False)


CARD = """
[[slot]]
number = 2
module = "1769-OB16"
options = { outputs = { lamp = 3 } }
"""


def test_what_an_axis_reads_is_not_what_the_line_has_read(rack, tmp_path):
    (tmp_path / "line.py").write_text(LAMP, encoding="utf-8")
    rack.write_text(RACK + CARD, encoding="utf-8")
    assert invoke("why", rack, "lamp", "--at", "52").stdout.splitlines() == [
        "after 53 scans, 0.104 s:",
        "lamp is on since 0.1 s (scan 50): line.py:17: self.lamp = self.start "
        "[self.start = True, self.lamp = False,...",
        "Cause: start is on since 0.1 s: slot 1 input IN_CAPTURE: The capture input is energized.",
    ]
    trace = tmp_path / "lamp.mcap"
    assert invoke("run", rack, "--record", trace, "-q").exit_code == 0
    by_address = invoke("why", trace, "Local:2:O.Data.3", "--at", "52", "--trust").stdout
    assert "Local:2:O.Data.3 is on since 0.1 s (scan 50): line.py:17: self.lamp = self.start" in by_address
