"""Exchanges within a scan: what the program reads before and after, and the search for what that breaks."""

import json
from pathlib import Path

import pytest
from scanrack.jobs import Kind
from scanrack.jobs.fuzz import Scenario, search
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.fuzz.scenarios.parts import scenario_of
from scanrack.jobs.fuzz.scenarios.scenario import TornUpdate
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.jobs.fuzz.shrink import simpler_parts

MS = 1_000_000
RACK = """program = "program.rung"
controller = {controller}
scan_ms = 3
[[slot]]
number = 1
module = "amci3601"
"""
RULE = '''from scanrack import never
@never
def jumps(now):
    """The position never runs ahead by more than the axis can."""
    return now.tags["Ahead"] > 500
'''
PROGRAM = """PROGRAM torn_number
SLOT axis : 1
TAG Words : INT[8] := [16#843F, 16#003F, 0, 500, 0, 0, 0, 0]
TAG Jog : INT[8] := [16#0080, 0, 0, 0, 9, 0, 500, 500]
TAG Now : INT[8]
TAG Low : DINT
TAG High : DINT
TAG Seen : DINT
TAG Last : DINT
TAG Ahead : DINT
ROUTINE Main
XIC(axis.status.MODULE_OK)XIC(axis.status.CONFIG_ERROR)COP(Words,axis.O.Data[0],8);
XIO(axis.status.CONFIG_ERROR)COP(Jog,axis.O.Data[0],8);
{copied}XIO(axis.status.MODE_CONFIG)MOV({image}[3],Low);
XIO(axis.status.MODE_CONFIG)MOV({image}[2],High);
MUL(High,1000,Seen)ADD(Seen,Low,Seen)SUB(Seen,Last,Ahead)MOV(Seen,Last);
END
"""
WORD_BY_WORD = PROGRAM.format(copied="", image="axis.I.Data")
AT_ONCE = PROGRAM.format(copied="CPS(axis.I.Data[0],Now,8)", image="Now")
TORN = TornUpdate("Main", 3, 42 * 3 * MS)
"""The scan before the one that sees the first thousand: at 9,000 steps/s after some 0.12 s."""


def bench(folder: Path, program: str, controller: str = '"compactlogix"\nrpi_ms = 2', scans: int = 200):
    (folder / "rack.toml").write_text(RACK.format(controller=controller), encoding="utf-8")
    (folder / "program.rung").write_text(program, encoding="utf-8")
    (folder / "must_hold.py").write_text(RULE, encoding="utf-8")
    return bench_of(
        Setup(str(folder / "rack.toml"), (folder / "must_hold.py",), (), scans, frozenset({Kind.TORN}))
    )


def test_a_number_in_two_words_tears_between_its_rungs(tmp_path):
    made = bench(tmp_path, WORD_BY_WORD)
    assert made.run(Scenario()).broken is None
    broken = made.run(Scenario(tears=(TORN,))).broken
    assert broken is not None
    assert broken.scan == 42
    both_new = Scenario(tears=(TornUpdate("main", 2, TORN.at_ns),))
    assert made.run(both_new).broken is None


def test_a_copy_at_once_is_never_torn(tmp_path):
    made = bench(tmp_path, AT_ONCE, scans=60)
    for rung in range(5):
        for scan in range(38, 48):
            assert made.run(Scenario(tears=(TornUpdate("Main", rung, scan * 3 * MS),))).broken is None


def test_a_rung_that_does_not_run_and_a_micrologix_tear_nothing(tmp_path):
    elsewhere = Scenario(
        tears=(TornUpdate("Main", 9, TORN.at_ns), TornUpdate("Other", 3, TORN.at_ns + 3 * MS))
    )
    assert bench(tmp_path, WORD_BY_WORD, scans=60).run(elsewhere).broken is None
    micrologix = tmp_path / "micrologix"
    micrologix.mkdir()
    made = bench(micrologix, WORD_BY_WORD, '"micrologix"', scans=60)
    assert made.rungs == ()
    assert made.run(Scenario(tears=(TORN,))).broken is None


def test_rungs_that_read_inputs_are_torn_before(tmp_path):
    made = bench(tmp_path, AT_ONCE)
    assert made.rungs == (("Main", 0), ("Main", 1), ("Main", 2), ("Main", 3))


@pytest.mark.slow
def test_the_search_finds_a_torn_number(tmp_path):
    made = bench(tmp_path, WORD_BY_WORD)
    found = search(made, {Kind.TORN}, examples=100, start=1).found
    assert found
    (tear,) = found[0].scenario.tears
    assert (tear.routine, tear.rung) == ("Main", 3)
    assert found[0].after <= 100


def test_a_tear_is_written_told_and_made_simpler():
    scenario = Scenario(tears=(TORN,))
    written = json.loads(json.dumps(scenario.to_json()))
    assert written["tears"] == [{"routine": "Main", "rung": 3, "at_ns": 126 * MS}]
    assert Scenario.from_json(written) == scenario
    older = {key: each for key, each in written.items() if key != "tears"}
    assert Scenario.from_json(older) == Scenario()
    assert described(scenario) == [
        "0.126 s: new inputs are read in the middle of the scan, before rung 3 of Main",
    ]
    simpler = [scenario_of([("tears", each)]) for each in simpler_parts(TORN, {}, 3 * MS)]
    assert Scenario(tears=(TornUpdate("Main", 3, 0),)) in simpler
