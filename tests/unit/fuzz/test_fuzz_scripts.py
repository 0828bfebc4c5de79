"""A scenario as a script for the bench shows the same images, whatever sits in the slot."""

from __future__ import annotations

import json
from functools import partial
from typing import Any

import pytest
from scanrack.commands import build
from scanrack.io_images.amci3601 import Configuration, Idle, InputBit, Move, MoveKind, StatusView
from scanrack.jobs import SwitchOffset
from scanrack.jobs.fuzz import Press, Scenario, TrialBench
from scanrack.jobs.fuzz.scenarios.drivescript import DriveScript, obstacle
from scanrack.runtime import FaultKind, InjectedFault, RackSpec
from typer.testing import CliRunner

MS = 1_000_000
USED = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
HIGH = 0x3F & ~InputBit.CCW_LIMIT
WORDS = Configuration(
    inputs_used=USED, active_high=HIGH, step_and_direction=True, starting_speed=500
).to_image()
LINKED = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
MOVE = Move(MoveKind.RELATIVE, 400, speed=2000, acceleration=20, deceleration=20).to_image()
OPTIONS = {"amci3601": {}, "pcl601-adapter": {}, "pmc006-adapter": {"home_stroke": 9000}}
SCANS = 700


def program(scan, words=WORDS):
    """Configure, whenever that is needed, and make a move every 300 ms."""
    status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
    if status.CONFIG_ERROR:
        out.load(words)
    else:
        out.load(MOVE if scan.number % 150 > 75 and not status.MODE_CONFIG else Idle().to_image())


class Images:
    """A listener that keeps the input images by time, ms."""

    def __init__(self, slot):
        self._slot = slot
        self.seen = {}

    def event(self, *_told):
        pass

    def scan(self, scan, now_ns, flags):
        self.seen[now_ns / MS] = list(self._slot.inputs)

    def close(self):
        pass


SWITCHES = [
    {"input": "cw_limit", "first": 1000},
    {"input": "ccw_limit", "last": -1000, "normally_closed": True},
    {"input": "home", "first": -2000, "last": -1900},
    {"input": "home", "first": -1800, "last": -1700},
]


def rack(module):
    machine = {"switches": SWITCHES if module == "amci3601" else SWITCHES[:1]}
    slot = {"number": 1, "module": module, "options": OPTIONS[module], "machine": machine}
    return RackSpec.model_validate({"program": "none.py", "slot": [slot]})


def recorded(module, scenario):
    """Run a scenario; return the images of the run, and those of its script on the bench."""
    kept: list[Any] = []

    def listeners(spec, made, _logic):
        assert obstacle(spec, spec.slot[0]) is None
        kept.extend((Images(made.slots[1]), DriveScript(spec, spec.slot[0], made.slots[1])))
        return kept

    TrialBench(
        rack(module), lambda: partial(program, words=WORDS if module == "amci3601" else LINKED), (), SCANS
    ).run(scenario, listeners=listeners)
    images, script = kept
    bench = CliRunner().invoke(build(), ["drive", module], input=script.text())
    assert bench.exit_code == 0, bench.output
    return images.seen, [json.loads(line) for line in bench.stdout.splitlines()]


PRESSED = Scenario(presses=(Press(1, InputBit.ESTOP, True, 400 * MS, 20 * MS),))
WITHOUT_POWER = Scenario(incidents=(InjectedFault(500 * MS, FaultKind.POWER_CYCLE),))
STOPPED = Scenario(incidents=(InjectedFault(480 * MS, FaultKind.PROGRAM_MODE, 0, 100 * MS),))
FAILS = Scenario(presses=(Press(1, InputBit.CW_LIMIT, True, 480 * MS, 20 * MS),))
NEARER = Scenario(shifts=(SwitchOffset(1, -200),))
OPEN = Scenario(incidents=(InjectedFault(500 * MS, FaultKind.LINE_DOWN, 1, 200 * MS),))
LOST = Scenario(incidents=(InjectedFault(480 * MS, FaultKind.REPLIES_LOST),))
DAMAGED = Scenario(incidents=(InjectedFault(480 * MS, FaultKind.REPLIES_DAMAGED),))
FORGETS = Scenario(incidents=(InjectedFault(500 * MS, FaultKind.CONTROLLER_POWER_CYCLE),))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "scenario"),
    [(module, each) for module in OPTIONS for each in (PRESSED, WITHOUT_POWER, STOPPED, NEARER, FAILS)]
    + [(module, each) for module in list(OPTIONS)[1:] for each in (OPEN, LOST, DAMAGED, FORGETS)],
)
def test_the_script_shows_the_images_of_the_run(module, scenario):
    """Not at the instant of an incident: the run shows it at once, the bench with the next reply."""
    images, replies = recorded(module, scenario)
    instants = {each.at_ns / MS for each in scenario.incidents}
    if scenario is FAILS:  # an input set by level shows a scan late that the switch itself is met, at 1.17 s
        instants |= {instant for instant in images if instant > 1100}
    compared = [reply for reply in replies if reply["t_ms"] in images.keys() - instants]
    assert len(compared) >= 3
    for reply in compared:
        assert reply["in"] == images[reply["t_ms"]], reply["t_ms"]


@pytest.mark.parametrize(
    ("incident", "says"),
    [
        (InjectedFault(0, FaultKind.LINK_LOST, 1, MS), "lost links"),
        (InjectedFault(0, FaultKind.REPLIES_LOST, 1, MS), "several lost or damaged replies in a row"),
        (InjectedFault(0, FaultKind.TORN_UPDATE, 1, 0, (1,)), "updates before the end of the scan"),
    ],
)
def test_what_the_bench_can_not_do_is_told(incident, says):
    spec = Scenario(incidents=(incident,)).laid_over(rack("pcl601-adapter"))
    assert obstacle(spec, spec.slot[0]) == says
