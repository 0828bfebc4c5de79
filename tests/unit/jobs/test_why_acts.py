"""What an owner could do: the planted acts, and carried out on another bench they give the value."""

from __future__ import annotations

import os

import pytest
from drive_bench import CW_LIMIT, ESTOP, HOME, drive_words
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.jobs.why.acts import acts_for, every_act
from scanrack.runtime.live.actions import Press, action_of
from scanrack.runtime.live.operator_actions import OperatorActions
from typer.testing import CliRunner
from why_questions import do, make

pytestmark = [
    pytest.mark.slow,  # together they take seconds
    pytest.mark.skipif(not hasattr(os, "fork"), reason="a rack is copied by a fork"),
]

START = "press start (slot 2) for 60 ms"
ROWS = [
    ("rungs", "1s", "Run", True, [START]),
    ("rungs", "1s drop stop 1s", "Run", True, ["close stop (slot 2)", START]),
    ("rungs", "1s press start 1s force Run=0 1s", "Run", True, ["take the force off Run", START]),
    ("rungs", "1s press start 1s", "Lamp", True, ["close guard (slot 2)"]),
    ("rungs", "1s press start 1s", "Cycle", True, ["set Auto to 1"]),
    ("rungs", "1s press start 1s", "Run", False, ["open stop (slot 2)"]),
    ("rungs", "1s press start 200ms", "Late", True, []),
    ("rungs", "1s press start 1s key program 1s", "Count", 2, ["turn the key to run", START]),
    ("python", "1s", "state.lamp", True, ["close guard (slot 2)", START]),
    ("sequence", "1s", "lamp", True, [START]),
]


@pytest.mark.parametrize(("world", "done", "tag", "wanted", "acts"), ROWS)
def test_the_acts_are_the_planted_ones_and_do_it_again(tmp_path, world, done, tag, wanted, acts):
    bench = make(tmp_path, world)
    do(bench, done)
    before = bench.scans, bench[tag]
    found = acts_for(bench, bench.chain(tag), tag, wanted)
    assert found is not None
    assert found.acts is not None, str(found)
    assert [act.text for act in found.acts] == acts
    orders = found.orders()
    assert orders is not None
    assert (bench.scans, bench[tag]) == before  # the bench itself has not gone on
    again = make(tmp_path, world)
    do(again, done)
    hands = OperatorActions(again.cpu, again.cpu.rack, None if world == "python" else again._settable)
    for order in orders:  # as those of a session
        if "wait_ns" in order:
            again.run_for(f"{order['wait_ns']} ns")
        else:
            hands.act(action_of(order), again.cpu.now_ns, again.scans)
    again.run_until(lambda rack: rack[tag] == wanted, within="5 s")
    assert "word" not in str(found)


def test_each_answer_lacks_nothing_and_none_has_another_one_in_it(tmp_path):
    bench = make(tmp_path, "rungs")
    do(bench, "1s")
    found = [
        {act.text for act in each.acts or ()} for each in every_act(bench, bench.chain("Run"), "Run", True)
    ]
    assert found == [{START}, {"close start (slot 2)"}]


def test_what_no_owner_can_do_is_said_with_the_number_of_tries(tmp_path):
    bench = make(tmp_path, "wrong configuration")
    do(bench, "2s")
    found = acts_for(bench, bench.chain("Feeding"), "Feeding", True)
    assert str(found) == "Feeding comes on: found no operator action in 1 try"


def test_what_the_rack_file_does_is_no_wait(tmp_path):
    bench = make(tmp_path, "line")
    do(bench, "400ms")  # its timeline presses start at 500 ms
    found = acts_for(bench, bench.chain("Run"), "Run", True)
    assert str(found) == "Run comes on in 0.12 s, as the rack file continues: The start input is energized."


def test_the_command_says_what_to_do(tmp_path):
    make(tmp_path, "rungs")
    words = ["why", str(tmp_path / "rack.toml"), "Run", "--at", "500 ms", "--want", "on"]
    result = CliRunner().invoke(build(), words)
    assert result.exit_code == 0, result.output
    assert result.output.splitlines()[-2:] == [
        "Cause: Start is off: slot 2 input 0 (start), never on",
        f"Run comes on 0.16 s after this: {START}",
    ]


def test_an_emergency_stop_that_a_page_has_pressed_is_let_go():
    bench = open_bench("examples/feeder/feeder.toml")
    bench.run_for("2 s")  # the rack file presses it at 8 s
    OperatorActions(bench.cpu, bench.cpu.rack, None).act(
        Press(1, "estop", True), bench.cpu.now_ns, bench.scans
    )
    bench.run_for("1 s")
    chain = bench.chain("Feeding")
    assert [each.kind for each in chain.walk()][-1] == "operator"
    assert "IN_ESTOP" in str([each.text for each in chain.walk()][-1])  # not of the bit that follows from it
    found = acts_for(bench, chain, "Feeding", True)
    assert found is not None
    assert found.acts is not None, str(found)
    assert [act.text for act in found.acts] == ["open estop (slot 1)"]
    assert found.after_ns <= 5_000_000_000


DRIVE = """
from scanrack import Axis3601, Input, Logic, Output, sequence


class Line(Logic):
    axis = Axis3601(1, {words})
    first, second = Input("slot1.status.INPUT_1"), Input("slot1.status.INPUT_2")
    home: Output = Output("Local:2:O.Data.0")
    ready: Output = Output("Local:2:O.Data.1")

    @sequence
    async def begin(self) -> None:
        await self.axis.configure()

    def every_scan(self) -> None:
        self.home = self.first
        self.ready = not self.second
"""
DRIVE_RACK = """program = "line.py"
scan_ms = 10
[[slot]]
number = 1
module = "smd23e2"
options = {{ in1 = "home", in2 = "{second}" }}
{machine}
[[slot]]
number = 2
module = "1769-OB16"
"""


@pytest.fixture
def drive(tmp_path):
    """Makes the bench of a drive whose second input has a function."""

    def make_drive(function, second, machine=""):
        words = drive_words("smd23e2", inputs=(HOME, function))
        (tmp_path / "line.py").write_text(DRIVE.format(words=words), encoding="utf-8")
        rack = DRIVE_RACK.format(second=second, machine=machine)
        (tmp_path / "rack.toml").write_text(rack, encoding="utf-8")
        bench = open_bench(tmp_path / "rack.toml")
        bench.run_for("1 s")
        return bench

    return make_drive


@pytest.mark.parametrize(("function", "name"), [(ESTOP, "estop"), (CW_LIMIT, "cw_limit")])
def test_an_input_of_a_drive_is_let_go_by_the_name_of_its_terminal(drive, function, name):
    bench = drive(function, name)
    hands = OperatorActions(bench.cpu, bench.cpu.rack, None)
    hands.act(Press(1, name, True), bench.cpu.now_ns, bench.scans)
    bench.run_for("1 s")
    assert not bench["line.ready"]
    found = acts_for(bench, bench.chain("line.ready"), "line.ready", True)
    assert found is not None
    assert found.acts is not None, str(found)
    assert [act.text for act in found.acts] == [f"open {name} (slot 1 in2)"]
    assert (found.orders() or [])[0] == {"do": "press", "slot": 1, "name": name, "on": False}


def test_an_input_of_a_drive_that_is_off_is_closed(drive):
    bench = drive(ESTOP, "estop")
    found = acts_for(bench, bench.chain("line.home"), "line.home", True)
    assert found is not None
    assert found.acts is not None, str(found)
    assert [act.text for act in found.acts] == ["close home (slot 1 in1)"]


def test_a_home_switch_of_the_machine_is_not_pressed_by_hand(drive):
    machine = "[slot.machine]\nswitches = [{ input = 'home', first = -300, last = -100 }]"
    bench = drive(ESTOP, "estop", machine)
    found = acts_for(bench, bench.chain("line.home"), "line.home", True)
    assert str(found).startswith("line.home comes on: found no operator action in ")
