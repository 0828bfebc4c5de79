"""Properties of the rack file in a search, and a scenario with an operator's orders."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.jobs import Scenario
from scanrack.jobs.fuzz.scenarios.scenario import OperatorAction
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.runtime import Force, Write
from typer.testing import CliRunner

LINE = """\
PROGRAM line
TAG A : BOOL
TAG B : BOOL
TAG Fwd : BOOL
TAG Rev : BOOL
TAG Dwell : TIMER
SLOT axis : 1
ROUTINE Main
XIC(A)TON(Dwell,500,0);
XIC(Dwell.DN)OTE(Fwd);
XIC(B)XIC(axis.status.IN_ESTOP)OTE(Rev);
END
"""
RACK = """\
program = "line.rung"
scan_ms = 10
[[prove.property]]
name = "one direction"
never = "Fwd AND Rev"
{more}
[[slot]]
number = 1
module = "amci3601"
"""
ACTIONS = (
    OperatorAction(0, Write("A", True)),
    OperatorAction(20_000_000, Write("B", True)),
    OperatorAction(0, Force("I:1.1/3", 1)),
)


def replayed(folder: Path, orders: tuple[OperatorAction, ...], more: str = "") -> tuple[int, str]:
    (folder / "line.rung").write_text(LINE, encoding="utf-8")
    (folder / "line.toml").write_text(RACK.format(more=more), encoding="utf-8")
    (folder / "s.json").write_text(json.dumps(Scenario(orders=orders).to_json()), encoding="utf-8")
    words = [
        "fuzz",
        str(folder / "line.toml"),
        "--out",
        str(folder / "out"),
        "--scenario",
        str(folder / "s.json"),
    ]
    done = CliRunner().invoke(build(), words)
    return done.exit_code, done.output


def test_a_scenario_of_orders_breaks_a_property_of_the_rack(tmp_path: Path) -> None:
    status, said = replayed(tmp_path, ACTIONS)
    assert status == 1
    # the dwell of 500 ms is over in scan 50, 0.5 s after the first one
    assert "broken: never Fwd AND Rev [one direction]: scan 50, 0.5 s" in said


def test_a_run_without_what_is_assumed_breaks_nothing(tmp_path: Path) -> None:
    assert replayed(tmp_path, ACTIONS, 'assume = ["NOT B"]') == (0, "no invariant is broken\n")


def test_orders_survive_json_and_are_told_in_words() -> None:
    scenario = Scenario(orders=ACTIONS)
    assert Scenario.from_json(json.loads(json.dumps(scenario.to_json()))) == scenario
    assert described(scenario) == [
        "0 s: A is set to True",
        "0 s: I:1.1/3 is forced to 1",
        "0.02 s: B is set to True",
    ]


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ({"at_ns": -1, "do": "write", "tag": "A", "value": 1}, "at_ns, a whole number from 0"),
        ({"at_ns": 0, "do": "pause"}, "no action 'pause'; choose from write, force, unforce"),
        ({"at_ns": 0, "do": "write", "tag": "A"}, "write needs value"),
    ],
)
def test_an_order_that_is_none_is_refused(row: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        Scenario.from_json({"orders": [row]})


def test_an_order_that_can_not_be_carried_out_is_a_mistake(tmp_path: Path) -> None:
    status, said = replayed(tmp_path, (OperatorAction(0, Write("Q", 1)),))
    assert status == 2
    assert "no tag Q" in said
