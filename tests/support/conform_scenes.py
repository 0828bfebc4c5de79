"""Scenes of `scanrack conform` played on a simulated module, for tests of its verdicts."""

from __future__ import annotations

from scanrack.jobs.conform.moments import PlayedScene, Timing
from scanrack.jobs.conform.plan import ScenePlan, parse_plan
from scanrack.jobs.conform.playing import play
from scanrack.runtime.modules.amci3601.altered import Alteration, Altered3601
from scanrack.runtime.modules.amci3601.module import Amci3601
from simulated_path import SimulatedPath

MS = 1_000_000
CONFIGURED = """
zero for 60 ms
words 843Ch 3Ch 0 500 for 60 ms
zero for 60 ms
"""
MOVE = "target 300 speed 2500 acceleration 20 deceleration 20"
STOPPED_MOVE = f"RELATIVE_MOVE {MOVE} for 80 ms\nIMMEDIATE_STOP {MOVE} for 60 ms\nzero for 40 ms"


def plan_of(*scenes: str, scan_ms: int = 2) -> ScenePlan:
    """Return a plan of scenes, each configured first."""
    tables = "".join(
        f"[[scene]]\nname = \"{number}\"\nsteps = '''{steps}'''\n" for number, steps in enumerate(scenes)
    )
    return parse_plan(f"scan_ms = {scan_ms}\nbegin = '''{CONFIGURED}'''\n{tables}", "test")


def played(steps: str, alteration: Alteration | None = None, seed: int = 0) -> tuple[PlayedScene, Timing]:
    """Play a scene on a module; return it with the timing of its path."""
    plan = plan_of(steps)
    module = Amci3601() if alteration is None else Altered3601(alteration)
    return play(plan.scenes[0], SimulatedPath(module, plan.timing, seed), plan), plan.timing
