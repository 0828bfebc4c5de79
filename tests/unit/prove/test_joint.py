"""Inductions of many truths at once prove what each induction alone proves, and no scan breaks it."""

from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Any

import pytest
from proofs import program_text
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.algebra.meaning import INT
from scanrack.ladder.prove.algebra.numbers import eq, mul
from scanrack.ladder.prove.algebra.terms import FALSE, TRUE, T, and_, const, not_, or_, var
from scanrack.ladder.prove.induction import Limits, VerdictKind, prove
from scanrack.ladder.prove.joint import GROUP, JointAnswers, decide_jointly, satisfiable
from scanrack.ladder.prove.questions.points import points_of
from scanrack.ladder.prove.solving.frames import Frame
from scanrack.ladder.prove.solving.runs import Runs
from scanrack.ladder.prove.solving.solver import Solver
from scanrack.ladder.prove.system import ProgramSystem, System

pytestmark = pytest.mark.extra("prove")

LIMITS = Limits(scans=4, k=2, helped=False, replays=False)


def shifted(length: int) -> tuple[System, list[T]]:
    """Return bits that follow each other, a scan apart; each continues for as long as the first one is."""
    bits = [var(f"b{number}[0]") for number in range(length)]
    follows = dict(zip([t.val for t in bits], [var("in[0]"), *bits[:-1]], strict=True))
    return System(next=follows, initial=dict.fromkeys(follows, False)), bits


def alone(system: System, truths: list[T], limits: Limits) -> dict[T, tuple[VerdictKind, int]]:
    verdicts = {t: prove(system, t, limits) for t in truths}
    return {t: (each.kind, each.k) for t, each in verdicts.items()}


def jointly(found: JointAnswers, truths: list[T]) -> dict[T, VerdictKind]:
    kinds = dict.fromkeys(truths, VerdictKind.UNKNOWN)
    kinds |= dict.fromkeys(found.broken, VerdictKind.REFUTED)
    return kinds | dict.fromkeys(found.proved, VerdictKind.PROVED)


@pytest.mark.parametrize("seed", range(3))
def test_many_at_once_are_answered_as_each_alone(seed: int) -> None:
    problem = ProgramSystem(parse_program(program_text(Random(seed))))
    truths = [t for t in dict.fromkeys(points_of(problem).values()) if t is not TRUE][:6]
    found, each = decide_jointly(problem, truths, LIMITS), alone(problem, truths, LIMITS)
    assert jointly(found, truths) == {t: kind for t, (kind, _) in each.items()}
    assert found.proved == {t: k for t, (kind, k) in each.items() if kind is VerdictKind.PROVED}


@pytest.mark.parametrize("seed", range(3))
def test_no_random_scan_breaks_what_is_proved(seed: int) -> None:
    problem = ProgramSystem(parse_program(program_text(Random(100 + seed))))
    truths = [t for t in points_of(problem).values() if t.op != "const"]
    pairs = [and_(one, not_(other)) for one in truths[:6] for other in truths[:6] if one is not other]
    proved = list(decide_jointly(problem, pairs, LIMITS).proved)
    assert proved
    runs = Runs(problem, problem.cone(proved), proved, seed=seed)
    for _ in range(30):
        watched, kept = runs.scan()
        assert not any((truth & kept).any() for truth in watched)


def test_the_least_k_is_found() -> None:
    """Once the first is off the others follow: `a2 AND NOT a1` needs a scan more than `a1 AND NOT a0`."""
    on = [var(f"a{number}[0]") for number in range(4)]
    latched = {"a0[0]": or_(on[0], var("in[0]"))} | {on[n + 1].val: and_(on[n + 1], on[n]) for n in range(3)}
    system = System(next=latched, initial=dict.fromkeys(latched, False))
    truths = [on[3], and_(on[1], on[2]), and_(on[1], not_(on[0]))]
    found = decide_jointly(system, truths, LIMITS)
    assert {t: k for t, (_, k) in alone(system, truths, LIMITS).items()} == found.proved
    assert set(found.proved) == {*truths}


def test_a_run_breaks_what_it_reaches_and_no_more() -> None:
    system, bits = shifted(6)
    found = decide_jointly(system, bits, LIMITS)
    assert found.broken == {*bits[:3]}  # the fourth scan of a run has them on
    assert not found.proved
    assert not found.gave_up


def test_nothing_is_proved_where_no_run_keeps_the_assumptions() -> None:
    system, bits = shifted(3)
    system.contract = var("never[0]")
    system.next["never[0]"], system.initial["never[0]"] = TRUE, False
    found = decide_jointly(system, [and_(bits[0], not_(system.contract)), *bits], LIMITS)
    assert not found.proved
    assert not found.broken


def test_a_blown_fuse_proves_nothing() -> None:
    a, b = (var(name, INT, 2, (1 << 31) - 1) for name in ("a[0]", "b[0]"))
    factored = [eq(mul(a, b), const(2_147_483_629 * 2_147_483_587 + gap)) for gap in (0, 1)]
    found = decide_jointly(System(), factored, replace(LIMITS, fuse=0))
    assert found.gave_up == {*factored}
    assert not found.proved
    later = System(next={"a[0]": a, "b[0]": b}, initial={"a[0]": 2, "b[0]": 2})
    assert not decide_jointly(later, factored, replace(LIMITS, fuse=0, scans=1)).proved


def test_one_question_is_about_many_truths(monkeypatch: pytest.MonkeyPatch) -> None:
    questions: list[Any] = []
    check = Solver.check

    def counted(self: Solver, *made: Any) -> Any:
        questions.append(made)
        return check(self, *made)

    monkeypatch.setattr(Solver, "check", counted)
    inputs = [var(f"i{number}[0]") for number in range(2 * GROUP)]
    solver = Solver()
    scan = Frame(System(), solver)
    terms = {t: scan.term(t) for t in inputs}
    impossible = {t: solver.apply("and", [made, solver.apply("not", [made])]) for t, made in terms.items()}
    assert satisfiable(solver, impossible) == (set(), set())
    assert len(questions) == 2
    assert satisfiable(solver, terms) == ({*inputs}, set())


def test_what_can_never_be_needs_no_scan() -> None:
    assert decide_jointly(System(), [FALSE], LIMITS).proved == {FALSE: 0}
