"""Scans that repeat the one before them are passed over, and nothing of a run is different."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any

import pytest
from scanrack.io_images.amci3601.bits import InputBit
from scanrack.jobs import ContactPress, Kind
from scanrack.jobs.fuzz import Invariant, Scenario, TrialBench, always, eventually, never
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.fuzz.aim.edges import Edges
from scanrack.jobs.fuzz.aim.probe import Probe
from scanrack.jobs.fuzz.invariants.standard import STANDARD
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.fuzz.program_clocks import clocks_of
from scanrack.jobs.fuzz.scenarios.scenario import OperatorAction, Press
from scanrack.ladder import Engine
from scanrack.runtime import FaultKind, InjectedFault, Write

MS = 1_000_000
SCANS = 1_000
RACK = """program = "program.rung"
scan_ms = {scan_ms}
[[slot]]
number = 1
module = "1769-IQ16"
options = {{ inputs = {{ start = 0 }} }}
"""
PROGRAM = """PROGRAM timed
TAG Start : BOOL
TAG On : TIMER
TAG Off : TIMER
TAG Kept : TIMER
TAG Late : BOOL
TAG Since : DINT
TAG Count : DINT
TAG Other : BOOL
TAG Table : DINT[800]
ROUTINE Main
XIC(Local:1:I.Data.0)OTE(Start);
{rungs}
END
"""
TON, TOF, RTO = "XIC(Start)TON(On,700,0);", "XIC(Start)TOF(Off,700,0);", "XIC(Start)RTO(Kept,700,0);"
CYCLE = "XIO(On.DN)TON(On,101,0);\nXIC(On.DN)ADD(Count,1,Count);"
EVEN = {
    "idle": "",
    "TON": TON,
    "TOF": TOF,
    "RTO": RTO,
    "all": f"{TON}\n{TOF}\n{RTO}",
    "cycle": CYCLE,
    "comparison": f"{TON}\nGRT(On.ACC,300)OTE(Late);\nEQU(On.ACC,400)ADD(Count,1,Count);",
    "copy": f"{TON}\nXIC(Other)MOV(On.ACC,Since);\nXIO(Start)OTE(Other);",
    "reset": f"{TON}\nGEQ(On.ACC,500)RES(On);",
}
UNEVEN = {
    "computed": f"{TON}\nSUB(700,On.ACC,Since);",
    "within limits": f"{TON}\nLIM(100,On.ACC,300)OTE(Late);",
    "in an expression": f"{TON}\nCMP(On.ACC>300)OTE(Late);",
    "beside a tag": f"MOV(300,Since){TON}\nGRT(On.ACC,Since)OTE(Late);",
    "copied for a while": f"{TON}\nMOV(On.ACC,Since)GRT(Since,300)OTE(Late);\nMOV(0,Since);",
    "copied whole": f"{TON}\nCOP(On,Kept,1)GRT(Kept.ACC,300)OTE(Late);\nCOP(Off,Kept,1);",
    "reset before": "RES(On);\nXIC(Start)TON(On,700,0);",
    "in a subscript": f"MOV(7,Table[400]){TON}\nEQU(Table[On.ACC],7)ADD(Count,1,Count);",
    "in a sum": f"{TON}\nCMP(On.ACC+1>300)OTE(Late);",
    "a bit of it": f"{TON}\nXIC(On.ACC.3)OTE(Late);",
}


def bench(
    folder: Path, rungs: str, invariants: Sequence[Invariant] = (), scan_ms: float = 2, rack: str = RACK
) -> TrialBench:
    (folder / "rack.toml").write_text(rack.format(scan_ms=scan_ms), encoding="utf-8")
    (folder / "program.rung").write_text(PROGRAM.format(rungs=rungs), encoding="utf-8")
    made = bench_of(Setup(str(folder / "rack.toml"), (), (), SCANS, frozenset({Kind.INPUTS})))
    return TrialBench(made.spec, made.fresh_logic, invariants, SCANS, made.rungs)


def pressed(*times_ms: int, for_ms: int = 100) -> Scenario:
    return Scenario(pushes=tuple(ContactPress(1, "start", at * MS, for_ms * MS) for at in times_ms))


SCENARIOS = [pressed(), pressed(100, for_ms=1500), pressed(100, 300, 900), pressed(7, for_ms=699)]


@pytest.fixture
def calls(monkeypatch):
    """Numbers of the scans that an engine does."""
    called: list[int] = []
    whole = Engine.__call__

    def counted(engine, scan):
        called.append(scan.number)
        whole(engine, scan)

    monkeypatch.setattr(Engine, "__call__", counted)
    return called


def both_ways(made: TrialBench, scenario: Scenario):
    """Return what a run shows, once with every scan and once without repeated ones."""
    found = []
    for every_scan in (True, False):
        edges = Edges()
        probe = Probe(edges)
        verdict = made.run(scenario, probe=probe, every_scan=every_scan)
        logic: Any = probe.logic
        memory = logic.memory.snapshot()
        found.append((verdict, list(edges.groups.items()), memory))
    return found


@pytest.mark.parametrize("rungs", EVEN.values(), ids=EVEN)
def test_a_run_is_the_same_with_a_tenth_of_the_scans(rungs, tmp_path, calls):
    made = bench(tmp_path, rungs)
    for scenario in SCENARIOS:
        calls.clear()
        every, fewer = both_ways(made, scenario)
        assert every == fewer
        scans = len(calls) - SCANS
        assert 1 < scans < SCANS // (4 if rungs == CYCLE else 10), scans


@pytest.mark.parametrize("rungs", UNEVEN.values(), ids=UNEVEN)
def test_a_count_that_shows_elsewhere_is_counted_scan_by_scan(rungs, tmp_path):
    made = bench(tmp_path, rungs)
    for scenario in SCENARIOS:
        every, fewer = both_ways(made, scenario)
        assert every == fewer


def test_what_comes_in_between_comes_in_its_scan(tmp_path):
    key = InjectedFault(500 * MS, FaultKind.PROGRAM_MODE, 0, 300 * MS)
    orders = (OperatorAction(300 * MS, Write("Other", True)), OperatorAction(1_200 * MS, Write("Count", 7)))
    made = bench(tmp_path, EVEN["copy"])
    every, fewer = both_ways(made, Scenario(incidents=(key,), orders=orders))
    assert every == fewer
    assert fewer[2]["Count"] == 7


def test_scans_of_half_a_millisecond_are_all_run(tmp_path, calls):
    made = bench(tmp_path, TON, scan_ms=0.5)
    made.run(pressed(10, for_ms=300), every_scan=False)
    assert calls == list(range(SCANS)), "a timer may count in every other one"


@pytest.mark.parametrize(
    "rungs", ["PID(Loop,Since,0,Count,0,0,0);", "GSV(WallClockTime,,LocalDateTime,Clock[0]);"]
)
def test_other_sources_of_time_are_no_clocks(rungs, tmp_path):
    text = PROGRAM.replace("TAG Late", "TAG Loop : PID\nTAG Clock : DINT[7]\nTAG Late")
    (tmp_path / "program.rung").write_text(text.format(rungs=rungs), encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK.format(scan_ms=2), encoding="utf-8")
    made = bench_of(Setup(str(tmp_path / "rack.toml"), (), (), SCANS, frozenset({Kind.INPUTS})))
    logic: Any = made.fresh_logic()
    assert clocks_of(logic.lowered) is None


def test_what_reads_the_time_is_asked_in_every_scan(tmp_path):
    at: list[int] = []

    @always
    def asked(now):
        at.append(now.scan)
        return True

    @never
    def late(now):
        return now.ns == 1_700 * MS

    made = bench(tmp_path, TON, [asked])
    made.run(Scenario(), every_scan=False)
    assert at == list(range(SCANS)), "it may keep anything"
    broken = bench(tmp_path, TON, [late]).run(Scenario(), every_scan=False).broken
    assert broken is not None
    assert broken.scan == 850


@pytest.mark.parametrize("limit_ms", [99, 100, 101, 1_234])
def test_a_limit_passes_in_the_same_scan(limit_ms, tmp_path, calls):
    @eventually(f"{limit_ms} ms", after=lambda now: now.tags["Start"])
    def comes(now):
        return now.tags["Late"]

    made = bench(tmp_path, "", [comes])
    every = made.run(pressed(500)).broken
    calls.clear()
    fewer = made.run(pressed(500), every_scan=False).broken
    assert every == fewer is not None
    assert len(calls) < 2 * 50, "once, and once more for the line that wrote last"


def test_a_count_that_an_invariant_reads_breaks_it_in_the_same_scan(tmp_path):
    @never
    def long(now):
        return now.tags["On.ACC"] > 555

    made = bench(tmp_path, TON, [long])
    every, fewer = (made.run(pressed(100, for_ms=900), every_scan=each).broken for each in (True, False))
    assert every == fewer is not None
    assert fewer.scan == 50 + 278, "558 ms after the scan of the press"


AXIS = """program = "program.rung"
scan_ms = {scan_ms}
[[slot]]
number = 1
module = "amci3601"
"""
STRUCTURED = """TAG Start : BOOL
TAG Quiet : FBD_TIMER := {"PRE": 300}
TAG Busy : FBD_TIMER := {"PRE": 200}
TAG Count : DINT
Start := Local:1:I.Data.0;
Quiet.TimerEnable := NOT Start;
TONR(Quiet);
Busy.TimerEnable := Start;
TOFR(Busy);
IF Quiet.TT AND Busy.DN THEN Count := Count + 1; END_IF;
"""


def test_timers_of_structured_text_are_even(tmp_path, calls):
    (tmp_path / "rack.toml").write_text(RACK.format(scan_ms=2).replace(".rung", ".st"), encoding="utf-8")
    (tmp_path / "program.st").write_text(STRUCTURED, encoding="utf-8")
    made = bench_of(Setup(str(tmp_path / "rack.toml"), (), (), SCANS, frozenset({Kind.INPUTS})))
    for scenario in SCENARIOS:
        calls.clear()
        every, fewer = both_ways(made, scenario)
        assert every == fewer
        assert len(calls) < 1.5 * SCANS, "Count changes while both are on"


HOMING = """PROGRAM homing
SLOT axis : 1
TAG Words : INT[8] := [16#843F, 16#003F, 0, 500, 0, 0, 0, 0]
TAG Jog : INT[8] := [16#0080, 0, 0, 0, 1, 0, 100, 100]
TAG Zero : INT[8]
TAG Rest : TIMER
TAG Moves : DINT
ROUTINE Main
XIC(axis.status.MODULE_OK)XIC(axis.status.CONFIG_ERROR)COP(Words,axis.O.Data[0],8);
XIO(axis.status.CONFIG_ERROR)XIO(axis.status.MODE_CONFIG)XIO(axis.status.MOVING_CW)TON(Rest,200,0);
XIO(axis.status.CONFIG_ERROR)XIO(Rest.DN)COP(Zero,axis.O.Data[0],8);
XIC(Rest.DN)XIC(axis.status.IN_HOME)COP(Jog,axis.O.Data[0],8)ADD(Moves,1,Moves);
END
"""


def test_drawn_scenarios_of_an_axis_run_the_same(tmp_path):
    (tmp_path / "rack.toml").write_text(AXIS.format(scan_ms=2), encoding="utf-8")
    (tmp_path / "program.rung").write_text(HOMING, encoding="utf-8")
    kinds = frozenset(Kind)
    setup = Setup(str(tmp_path / "rack.toml"), (), tuple(STANDARD), 600, kinds)
    made = bench_of(setup)
    draws = Draws(made.spec, made.scans, kinds, Random(5), made.rungs, made.settings)
    edges = Edges()
    made.run(Scenario(presses=(Press(1, InputBit.HOME, True, 0, 900 * MS),)), probe=Probe(edges))
    edges.close()
    for _ in range(25):
        every, fewer = both_ways(made, draws.scenario(edges))
        assert every == fewer
