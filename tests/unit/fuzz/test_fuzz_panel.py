"""A search writes what an operator's panel writes, with values near those that the program compares.

Broken on purpose: a distance left out, a tag of the program written, too, an order that is not cut off.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
from scanrack.jobs import Kind, Scenario, load_job
from scanrack.jobs.fuzz import search
from scanrack.jobs.fuzz.aim.corpus import cut
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.fuzz.job import Setup, bench_of, replay, write_failure
from scanrack.jobs.fuzz.scenarios.scenario import OperatorAction
from scanrack.runtime import Write
from scanrack.traces import open_trace
from scanrack.traces.query import query

LINE = """\
PROGRAM line
TAG Recipe_Size : INT
TAG Mode : DINT
TAG HMI_Start : BOOL
TAG Own : DINT
TAG Bad : BOOL
ROUTINE Main
EQU(Recipe_Size,731)XIC(HMI_Start)OTE(Bad);
GRT(Own,5)CLR(Own);
EQU(Mode,-3)ADD(Own,1,Own);
END
"""
RACK = """\
program = "line.rung"
run_for_s = 1
[[slot]]
number = 1
module = "1769-IQ16"
[slot.options]
inputs = { key = 0 }
[server]
writable = ["Mode"]
"""
NEVER = "from scanrack import never\n@never\ndef bad(now):\n    return now.tags['Bad']\n"


@pytest.fixture
def setup(tmp_path):
    for name, text in (("line.rung", LINE), ("rack.toml", RACK), ("must.py", NEVER)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return Setup(str(tmp_path / "rack.toml"), (tmp_path / "must.py",), (), 100, frozenset({Kind.INPUTS}))


def test_what_a_panel_writes_gets_values_near_those_that_are_compared_and_other_tags_none(setup):
    found = {each.tag: set(each.values) for each in bench_of(setup).settings}
    assert found == {
        "Recipe_Size": {-1, 0, 1, 730, 731, 732},
        "Mode": {-1, 0, 1, -4, -3, -2},
        "HMI_Start": {False, True},
    }


def test_a_recipe_that_is_met_by_one_number_alone_is_found_and_told(setup):
    (found,) = search(bench_of(setup), setup.kinds, examples=100, start=2).found
    assert {each.order for each in found.scenario.orders} == {
        Write("Recipe_Size", 731),
        Write("HMI_Start", True),
    }


def test_orders_behind_a_scan_are_cut_off_with_all_other_events(setup):
    scenario = Scenario(
        orders=tuple(OperatorAction(at * 1_000_000, Write("Mode", at)) for at in (10, 20, 30))
    )
    assert cut(scenario, 10, 2_000_000).orders == scenario.orders[:2]


def test_values_of_draws_are_those_of_their_tags(setup):
    bench = bench_of(setup)
    draws = Draws(bench.spec, 100, setup.kinds, Random(3), settings=bench.settings)
    values = {each.tag: each.values for each in bench.settings}
    drawn = [each.order for _ in range(100) for each in draws.scenario().orders]
    assert drawn
    assert all(isinstance(each, Write) and each.value in values[each.tag] for each in drawn)


def test_the_trace_of_a_failure_has_what_the_panel_writes(setup):
    rack = Path(setup.rack)
    rack.write_text(f'tags = ["*"]\n{RACK}', encoding="utf-8")
    bench = bench_of(setup)
    orders = tuple(
        OperatorAction(20_000_000, Write(tag, value))
        for tag, value in (("Recipe_Size", 731), ("HMI_Start", True))
    )
    (found,) = replay(bench, Scenario(orders=orders))
    write_failure(load_job(setup.rack), setup, bench, found, rack.with_name("failure"))
    with open_trace(rack.with_name("failure") / "trace.mcap") as trace:
        (bad,) = query(trace, "Bad").occurrences
    assert bad.first == found.broken.scan
    assert "without tags that an operator writes" in rack.with_name("failure").joinpath(
        "report.txt"
    ).read_text(encoding="utf-8")
