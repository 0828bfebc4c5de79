"""Another solver confirms what is proved, and refuses a certificate that claims too much."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import pytest
from amounts import amount
from proofs import LIMITS, claims, program_text
from scanrack.commands.programs.prove import status_of
from scanrack.jobs.prove import checking
from scanrack.jobs.prove.checking import Opinion, Solver, check, questions, solvers
from scanrack.jobs.prove.proving import Questions, Result
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.algebra.terms import FALSE, not_
from scanrack.ladder.prove.answers import ask
from scanrack.ladder.prove.certificate import Certificate, written
from scanrack.ladder.prove.induction import prove
from scanrack.ladder.prove.monitors import monitored
from scanrack.ladder.prove.solving.invariants import Invariant

pytestmark = pytest.mark.extra("prove")

SOLVERS = solvers()
needs_one = pytest.mark.skipif(not SOLVERS, reason="neither z3 nor cvc5 is there")
each_solver = pytest.mark.parametrize("solver", SOLVERS, ids=lambda each: each.name)

BOXES = """PROGRAM boxes
TAG Sensor : BOOL
TAG Seen : BOOL
TAG Boxes : DINT
TAG Full : BOOL
TAG T : TIMER
TAG Slow : BOOL
ROUTINE Main
XIC(Full)MOV(0,Boxes);
XIC(Sensor)ONS(Seen)ADD(Boxes,1,Boxes);
GEQ(Boxes,3)OTE(Full);
XIC(Sensor)TON(T,500,0)XIC(T.DN)OTE(Slow);
END
"""


def certificate_of(claim: str) -> Certificate:
    found = ask(parse_program(BOXES), never=claim)
    assert found.word == "proved", found
    (only,) = found.verdict.certificates
    return only


def said(folder: Path, solver: Solver, *certificates: Certificate) -> Opinion:
    relation, roles = written(certificates)
    (folder / "proof.smt2").write_text(relation, encoding="utf-8")
    (folder / "proof.json").write_text(json.dumps(roles), encoding="utf-8")
    return check(folder, solver)


@needs_one
@each_solver
@pytest.mark.parametrize("claim", ["Boxes > 3", "Slow AND T.ACC < 500", "Boxes < 0"])
def test_a_proof_is_confirmed(claim: str, solver: Solver, tmp_path: Path) -> None:
    assert said(tmp_path, solver, certificate_of(claim)).confirmed


@needs_one
@each_solver
def test_a_certificate_that_claims_too_much_is_refused(solver: Solver, tmp_path: Path) -> None:
    good = certificate_of("Boxes > 3")
    wrong = replace(good, bad=not_(good.bad))
    assert said(tmp_path, solver, wrong).why.startswith("base of")
    false = replace(good, invariants=(Invariant(FALSE, "false"),))
    assert said(tmp_path, solver, false).refused
    ahead = replace(good, bad=good.next["FULL[0]"], k=0, invariants=())
    assert said(tmp_path, solver, ahead).refused
    initial = {**good.initial, "BOXES[0]": 7}
    assert said(tmp_path, solver, replace(good, initial=initial)).refused


@needs_one
@pytest.mark.slow
def test_proofs_of_random_programs_are_confirmed(tmp_path: Path) -> None:
    refused, proofs = [], 0
    for seed in range(amount(12)):
        rng = Random(seed)
        checked = monitored(parse_program(program_text(rng)), claims(rng))
        problem = ProgramSystem(checked.program, ScanBounds(1, 100))
        for watched in checked.properties:
            verdict = prove(problem, watched.bit, LIMITS)
            for solver in SOLVERS if verdict else ():
                proofs += 1
                opinion = said(tmp_path, solver, *verdict.certificates)
                refused += [] if opinion.confirmed else [(seed, watched.claim.text, opinion)]
    assert proofs > 10
    assert refused == []


def test_the_questions_of_a_certificate() -> None:
    relation, roles = written([certificate_of("Boxes > 3")])
    asked = [name for name, _ in questions(relation.splitlines(), json.loads(json.dumps(roles)))]
    assert {"base of what is asked", "step of what is asked"} <= set(asked)
    for _, script in questions(relation.splitlines(), roles):
        assert script.count("(check-sat)") == 1
        assert script.startswith("(set-logic")


def test_the_checker_uses_nothing_of_the_prover() -> None:
    text = Path(checking.__file__).read_text(encoding="utf-8")
    assert "from ." not in text
    imported = [line for line in text.splitlines() if "import" in line and "scanrack" in line]
    assert imported == ["from scanrack.io_images.versions import distribution_version"]
    assert len(text.splitlines()) < 220


def test_what_another_solver_refuses_is_unknown() -> None:
    answer = ask(parse_program(BOXES), never="Boxes > 3")
    opinions: Any = (Opinion("z9 1.0", False, True, "step of what is asked: sat"),)
    result = Result(answer, 1, opinions=opinions)
    assert result.word == "unknown"
    assert status_of([result], Questions((), {}, {})) == 3
    gave_up: Any = (Opinion("z9 1.0", False, False, "step of what is asked: unknown"),)
    assert Result(answer, 1, opinions=gave_up).word == "proved"
