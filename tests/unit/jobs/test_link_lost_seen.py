"""A link that is lost in a move, seen from outside: recorded, shown, asked for, run again and replayed.

Scans of 2 ms: the link is lost at 0.3 s for 40 ms; the axis rests then, and the move has ended after two
round trips of 10 ms.
"""

import pytest
from scanrack import open_trace
from scanrack.commands import build
from scanrack.traces.read.sequence_steps import sequence_steps
from typer.testing import CliRunner

PROGRAM = """from scanrack import Axis3601, AxisError, Configuration, InputBit, Logic, dwell, sequence

USED = InputBit.HOME | InputBit.CW_LIMIT
RATES = {"speed": 5000, "acceleration": 100, "deceleration": 100}


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))
    said = ""

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        try:
            await self.axis.move_to(9_000, **RATES)
        except AxisError as error:
            self.said = str(error)
        await self.axis.reset()
        await self.axis.set_position(0)
        await self.axis.move_to(400, **RATES)
        await dwell("1 h")
"""
RACK = """program = "line.py"
run_for_s = 0.8
[[slot]]
number = 1
module = "amci3601"
[[incident]]
at_s = 0.3
what = "link-lost"
for_ms = 40
"""


def invoke(*words):
    return CliRunner().invoke(build(), [str(each) for each in words])


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lost")
    (folder / "line.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "rack.toml").write_text(RACK, encoding="utf-8")
    recorded = invoke("run", folder / "rack.toml", "--record", folder / "line.mcap", "-q")
    assert recorded.exit_code == 0, recorded.output
    return folder / "line.mcap"


def test_the_recorded_wait_names_the_link_while_it_is_lost(trace):
    with open_trace(trace) as opened:
        steps = sequence_steps(opened)["cycle"]
    waits = [(each.scan, each.wait) for each in steps if "9000" in each.wait]
    assert waits[1:] == [
        (150, "axis.move_to(9000) (the link to slot 1 was lost at 0.3 s)"),
        (170, "axis.move_to(9000)"),
    ]
    reset = next(each for each in steps if each.wait == "axis.reset()")
    assert reset.now_ns == 360_000_000
    assert steps[-1].wait == "dwell 1 h"


def test_why_says_so_of_the_module(trace):
    said = invoke("why", trace, "--trust", "--at", "0.32 s")
    wait = "axis.move_to(9000) (the link to slot 1 was lost at 0.3 s)"
    assert f"cycle waits at line 16 of line.py for {wait}" in said.stdout
    assert "slot 1: the link to it is lost since scan 150 (0.3 s)" in said.stdout, said.output


@pytest.mark.parametrize("into", ["module", "program"])
def test_replayed_it_answers_the_same(trace, into):
    """The link is in the recording, as the light on the module's front."""
    result = invoke("replay", trace, "--into", into, "--trust", "-q", "--to-the-end")
    assert result.exit_code == 0, result.output


def test_run_again_it_is_the_same_byte_for_byte(trace):
    again = invoke("replay", "--into", "session", trace, "--trust")
    assert (again.exit_code, "identical byte for byte" in again.stdout) == (0, True)
