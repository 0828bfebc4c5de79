"""Verdicts are the project's own: each version of the solver within the bounds gives the recorded ones.

`.ci/lowest` runs this file with the lowest version, after the README's command, which leaves out slow tests;
`.ci/run` runs it with the newest. Record a verdict again if the prover changes it rightly. A verdict that
changes with the solver's version is a defect, unless it names the fuse.
"""

from __future__ import annotations

from random import Random

import pytest
from proofs import LIMITS, claims, program_text
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.induction import prove
from scanrack.ladder.prove.monitors import monitored

pytestmark = pytest.mark.extra("prove")

RECORDED = """
rprr rrrr rrpr rrrr prpr rrpr pprr pppp rrrp prrp rrpr rrrr rppr rprr rrrp rppp pppr rprp rprr rrrp
prrr rrrr rrpr pprr rppp rrrr rprr rprr rrrr rprr prpr prpr pprp prpp rrrp rrpp rrpp prpr rprr rrrr
rrpr rrrp rprp rrrr rrpr prrr rrpr rppp rrrr prrr pprr pppr rrrr rrpp pprr prrr rrrr prrr prrp rprr
rprr rppr pprr prrp rrrr prrr rprr rrrr rrpp rrpp prpr rrrr rrrr prpp prrr rrrr rprr rprp rrrr rrrr
rrrr pppr rrpr prrr pprr prrp pppp rrrr rrpr rrpr pprp rprr rrrr pppp rprp rrrr pprp rprp rrrr rrrr
rppr rppr rrpr rrpr rrrp rrrr prrr pprp rrrr prpp rrrr rppp prrr rprp prpr rrrp rrrp rrrr rrrp prrr
"""
"""Of random programs by their seed: p proved, r refuted, u unknown, one letter for each of four claims."""


@pytest.mark.slow
def test_each_version_of_the_solver_says_the_same() -> None:
    differing = []
    for seed, recorded in enumerate(RECORDED.split()):
        rng = Random(seed)
        checked = monitored(parse_program(program_text(rng)), claims(rng))
        problem = ProgramSystem(checked.program, ScanBounds(1, 100))
        for number, (watched, letter) in enumerate(zip(checked.properties, recorded, strict=True)):
            verdict = prove(problem, watched.bit, LIMITS)
            if verdict.kind[0] != letter and "the solver's fuse" not in str(verdict.blame):
                differing.append((seed, number, letter, verdict.kind, verdict.blame))
    assert not differing
