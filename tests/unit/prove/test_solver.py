"""The solver: verdicts agree with z3 on random terms, models with Python's arithmetic; steps are a fuse."""

from __future__ import annotations

import gc
import math
from typing import Any
from weakref import ref

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_terms import bench
from scanrack.ladder.prove.algebra import numbers
from scanrack.ladder.prove.algebra import terms as t
from scanrack.ladder.prove.algebra.evaluation import evaluate
from scanrack.ladder.prove.algebra.meaning import BOOL, F32, F64, INT
from scanrack.ladder.prove.solving.smtlib import Script
from scanrack.ladder.prove.solving.solver import Solver
from scanrack.ladder.prove.solving.translation import declare, translate

pytestmark = pytest.mark.extra("prove")


def asked(sink: Any, roots: list[t.T]) -> dict[str, tuple[t.T, Any]]:
    """State truths; return the variables."""
    known: dict[str, tuple[t.T, Any]] = {}

    def lookup(v: t.T) -> Any:
        if v.val not in known:
            known[v.val] = v, declare(sink, v, v.val)
        return known[v.val][1]

    memo: dict[int, Any] = {}
    for root in roots:
        sink.state(translate(sink, root, lookup, memo))
    return known


def second_opinion(roots: list[t.T]) -> str:
    z3 = pytest.importorskip("z3")
    script = Script()
    asked(script, roots)
    other = z3.Solver()
    other.set("rlimit", 20_000_000)
    other.from_string(script.text())
    return str(other.check())


def question(made: Any) -> list[t.T]:
    """Return truths that some values of the variables may satisfy: some of them do, some are turned over."""
    chosen = made.rng.sample(made.truths, min(5, len(made.truths)))
    wanted = [term if value else t.not_(term) for term, value in chosen]
    (a, x), (b, _) = made.rng.choice(made.whole), made.rng.choice(made.whole)
    wanted.append(numbers.eq(a, t.const(x)))
    if made.rng.random() < 0.6:
        wanted.append(t.not_(made.rng.choice([wanted[0], numbers.eq(a, b), numbers.lt(a, b)])))
    return wanted


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32))
def test_two_solvers_agree_and_a_model_is_one(seed: int) -> None:
    roots = question(bench(seed, steps=25))
    solver = Solver()
    known = asked(solver, roots)
    verdict = solver.check()
    assert verdict in (second_opinion(roots), "unknown")
    if verdict == "sat":
        values = {name: solver.found(made, v) for name, (v, made) in known.items()}
        assert all(v.lo <= values[name] <= v.hi for name, (v, _) in known.items() if v.kind == INT)
        assert all(evaluate(roots, values))


X, Y = t.var("x", F32), t.var("y", F32)
BIG = t.var("n", INT, -(2**63), 2**63 - 1)
FINITE = [t.mk("ffin", (each,), BOOL) for each in (X, Y)]
FLOATS = {
    "a sum in single precision": [
        numbers.eq(numbers.fop("fadd", X, t.const(1.0, F32)), X),
        *FINITE,
    ],
    "a quotient by zero": [
        numbers.eq(Y, t.const(0.0, F32)),
        numbers.lt(t.const(1e30, F32), numbers.fop("fdiv", X, Y)),
        *FINITE,
    ],
    "NaN": [t.mk("fnan", (numbers.fop("fmul", X, Y),), BOOL)],
    "half to even": [
        numbers.eq(numbers.to_int(X, "rne"), t.const(4)),
        numbers.lt(X, t.const(4.0, F32)),
    ],
    "cut off": [
        numbers.eq(numbers.to_int(X, "rtz"), t.const(-4)),
        numbers.lt(X, t.const(-4.5, F32)),
    ],
    "never beyond": [
        numbers.eq(numbers.to_int(X, "rtz"), t.const(4)),
        numbers.lt(X, t.const(4.0, F32)),
    ],
    "twice rounded": [
        numbers.eq(BIG, t.const(2**60 + 2**36 + 1)),
        numbers.eq(numbers.to_float(BIG, F32), t.const(2.0**60, F32)),
    ],
    "a double of a single": [
        t.not_(numbers.eq(numbers.to_float(numbers.to_float(X, F64), F32), X)),
        *FINITE,
    ],
}


@pytest.mark.parametrize("name", FLOATS)
def test_floats_are_those_of_python(name: str) -> None:
    roots, solver = FLOATS[name], Solver()
    known = asked(solver, roots)
    verdict = solver.check()
    assert verdict == second_opinion(roots)
    assert verdict == ("unsat" if name in ("never beyond", "a double of a single") else "sat")
    if verdict == "sat":
        values = {key: solver.found(made, v) for key, (v, made) in known.items()}
        assert all(evaluate(roots, values)), values


def factors() -> list[t.T]:
    """Two factors of a product of primes: hard for a solver."""
    a, b = (t.var(name, INT, 2, 2**20) for name in "ab")
    return [
        numbers.eq(numbers.mul(a, b), t.const(1_048_573 * 1_048_571)),
        numbers.lt(a, t.const(1_048_571)),
    ]


def test_a_fuse_ends_a_question_and_steps_are_the_same_again() -> None:
    found = []
    for fuse in (0, 0, 1_600_000, 1_600_000):
        solver = Solver(fuse)
        asked(solver, factors())
        found.append((solver.check(), solver.steps))
    assert found[0] == found[1]
    assert found[0][0] == "unknown"
    assert found[2] == found[3]
    assert found[2][0] == "unsat"


def test_work_is_the_terms_of_the_session_for_each_question() -> None:
    solver = Solver()
    a, b = (solver.declare(BOOL, name) for name in "ab")
    either = solver.apply("or", [a, b])
    assert (solver.check(either), solver.work) == ("sat", 1 + 1)
    assert (solver.check(solver.apply("not", [either])), solver.work) == ("sat", 2 + 1 + 2)


@pytest.mark.slow
def test_a_solver_that_nobody_uses_is_gone() -> None:
    """Thousands of proofs in one process: bitwuzla holds no solver by what it calls."""
    solver = Solver()
    asked(solver, FLOATS["half to even"])
    assert solver.check() == "sat"
    left = ref(solver)
    del solver
    gc.collect()
    assert left() is None


def test_a_question_adds_its_truths_for_a_moment() -> None:
    solver = Solver()
    a, b = (solver.declare(BOOL, name) for name in "ab")
    solver.state(solver.apply("or", [a, b]))
    neither = [solver.apply("not", [each]) for each in (a, b)]
    assert solver.check(*neither) == "unsat"
    assert solver.check(neither[0]) == "sat"
    assert solver.found(b, t.TRUE) is True


@pytest.mark.slow
def test_a_solver_in_a_cycle_of_python_goes_in_its_order() -> None:
    """Else the collector may clear a manager before its terms: bitwuzla 0.9.1 ends the process then."""
    gc.collect()
    gc.freeze()  # else each turn searches what all tests before have left, for five seconds
    for _ in range(30):
        solver = Solver()
        asked(solver, FLOATS["half to even"])
        solver.itself = [solver, asked]  # type: ignore[attr-defined]
        left = ref(solver)
        del solver
        gc.collect()
        assert left() is None


def test_values_of_floats_survive() -> None:
    solver = Solver()
    for kind in (F32, F64):
        for value in (1.5, -0.0, math.inf, 1e-40):
            made = solver.value(kind, value)
            assert solver.check() == "sat"
            assert solver.found(made, t.var("x", kind)) == t.const(value, kind).val
