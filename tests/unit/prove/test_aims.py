"""What a search asks of proofs: dead contacts and coils, and scenarios that make one on."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack import LoadedRack
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import load_job
from scanrack.jobs.prove.serving.aims import dead, scenario_to
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.questions.points import PointState, RungPoint, run_to
from scanrack.runtime import Write

pytestmark = pytest.mark.extra("prove")

DOORS = """\
PROGRAM doors
TAG A : BOOL
TAG B : BOOL
TAG Dwell : TIMER
TAG Ready : BOOL
TAG Open : BOOL
TAG Never : BOOL
SLOT axis : 1
ROUTINE Main
XIC(A)XIO(B)TON(Dwell,100,0);
XIC(Dwell.DN)OTL(Ready);
XIC(Ready)XIC(axis.status.IN_ESTOP)OTE(Open);
XIC(Dwell.DN)XIO(Dwell.EN)OTE(Never);
END
"""


@pytest.fixture
def job(tmp_path: Path) -> LoadedRack:
    (tmp_path / "doors.rung").write_text(DOORS, encoding="utf-8")
    slot = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    (tmp_path / "doors.toml").write_text(f'program = "doors.rung"\nscan_ms = 10\n{slot}', encoding="utf-8")
    return load_job(str(tmp_path / "doors.toml"))


def number_of(sites, instruction):
    """The number of an instruction."""
    return next(number for number, site in enumerate(sites) if site.instruction == instruction)


def test_what_never_is_on_is_dead_and_nothing_else(job):
    found = [(site.rung, site.instruction, point.state) for point, site in dead(job).items()]
    assert found == [(3, "XIO(Dwell.EN)", PointState.ON), (3, "OTE(Never)", PointState.ON)]


def test_what_is_not_asked_within_the_budget_is_not_dead(job):
    assert dead(job, budget=0) == {}


def test_a_scenario_from_power_up_writes_tags_and_presses_inputs(job):
    """100 ms of dwell in scans of 10 ms: scan 10 at the earliest, from scan 0 on."""
    coil = number_of(job.logic.build().sites, "OTE(Open)")
    found = scenario_to(job, RungPoint(coil, PointState.ON))
    assert found is not None
    (press,) = found.presses
    assert (press.slot, press.input, press.energized) == (1, InputBit.ESTOP, True)
    assert Write("A", True) in [each.order for each in found.orders]
    assert press.at_ns < 100_000_000 < press.at_ns + press.for_ns


def test_a_scenario_begins_with_the_state_of_a_run(job):
    """After the dwell one scan is enough, and times go on from those of the run."""
    coil = number_of(job.logic.build().sites, "OTE(Open)")
    engine = job.logic.compile()
    engine.tags["A"] = True
    for _ in range(12):
        engine.step(10)
    assert engine.tags["Ready"]
    found = scenario_to(job, RungPoint(coil, PointState.ON), engine, at_ns=120_000_000)
    assert found is not None
    assert [(each.at_ns, each.for_ns) for each in found.presses] == [(120_000_000, 10_000_000)]


def test_a_run_from_a_state_does_it_on_the_compiled_program():
    """The dwell has 60 of 100 ms in the state: two scans of 20 ms are left."""
    text = DOORS.replace("SLOT axis : 1", "TAG Stop : BOOL").replace("axis.status.IN_ESTOP", "Stop")
    program = parse_program(text)
    problem = ProgramSystem(program, ScanBounds(10, 20))
    coil = RungPoint(number_of(problem.lowered.sites, "OTE(Open)"), PointState.ON)
    engine = program.compile()
    engine.tags["A"] = True
    for _ in range(7):
        engine.step(10)
    assert engine.tags["Dwell.ACC"] == 60
    scans = run_to(problem, coil, engine)
    assert len(scans) == 2
    for number, each in enumerate(scans):
        for (path, index), value in each.inputs.items():
            engine.memory.write(engine.lowered.layout.leaf(path), index, value)
        engine.step(20 if number == 0 else each.ms)
    assert engine.tags["Open"]


def test_what_can_not_be_has_no_scenario(job):
    coil = number_of(job.logic.build().sites, "OTE(Never)")
    assert scenario_to(job, RungPoint(coil, PointState.ON)) is None
