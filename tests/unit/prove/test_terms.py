"""Terms: each operation against Python's arithmetic, intervals that hold, sharing that can be forgotten."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_terms import bench
from scanrack.ladder.prove.algebra import numbers
from scanrack.ladder.prove.algebra import terms as t
from scanrack.ladder.prove.algebra.batch import BatchEvaluator
from scanrack.ladder.prove.algebra.evaluation import evaluate
from scanrack.ladder.prove.algebra.meaning import F32, F64, INT


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32))
def test_a_term_is_what_python_computes_and_lies_in_its_interval(seed: int) -> None:
    made = bench(seed)
    everything = [*made.whole, *made.truths]
    assert evaluate([term for term, _ in everything], made.values) == [value for _, value in everything]
    assert all(term.lo <= value <= term.hi for term, value in made.whole)


def single(value: float) -> float:
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


FLOATS = st.floats(allow_nan=False, width=32)


@given(FLOATS, FLOATS)
def test_floats_round_after_each_operation(x: float, y: float) -> None:
    a, b = t.var("a", F32), t.var("b", F32)
    made = [
        numbers.fop("fadd", a, b),
        numbers.fop("fmul", a, b),
        numbers.fop("fsub", numbers.fop("fneg", a), b),
        numbers.to_float(a, F64),
    ]
    found = evaluate([*made, numbers.lt(a, b), numbers.le(a, b), numbers.eq(a, b)], {"a": x, "b": y})
    wanted = [single(x + y), single(x * y), single(-x - y), x, x < y, x <= y, x == y]
    assert all(u == v or (u != u and v != v) for u, v in zip(found, wanted, strict=True))


@pytest.mark.parametrize(
    ("value", "even", "cut"),
    [
        (2.5, 2, 2),
        (-2.5, -2, -2),
        (3.5, 4, 3),
        (-1.6, -2, -1),
        (math.inf, 0, 0),
        (math.nan, 0, 0),
        (2.0**62, 0, 0),
    ],
)
def test_a_float_becomes_a_whole_number(value: float, even: int, cut: int) -> None:
    a = t.var("a", F64)
    assert evaluate([numbers.to_int(a, "rne"), numbers.to_int(a, "rtz")], {"a": value}) == [even, cut]
    constant = t.const(value, F64)
    assert (numbers.to_int(constant, "rne").val, numbers.to_int(constant, "rtz").val) == (even, cut)


def test_a_large_whole_number_becomes_a_float_as_logix_has_it() -> None:
    n = t.var("n", INT, -(2**63), 2**63 - 1)
    single_of_it, double_of_it = evaluate(
        [numbers.to_float(n, F32), numbers.to_float(n, F64)], {"n": 2**60 + 2**36 + 1}
    )
    assert double_of_it == float(2**60 + 2**36)
    assert single_of_it == single(double_of_it)


def test_equal_terms_are_one_until_they_are_forgotten() -> None:
    t.forget()
    first = numbers.add(t.var("n", INT, 0, 9), t.const(1))
    assert numbers.add(t.var("n", INT, 0, 9), t.const(1)) is first
    count = len(t._table)
    t.forget()
    assert len(t._table) == 0 < count
    again = numbers.add(t.var("n", INT, 0, 9), t.const(1))
    assert again is not first
    assert again.id > first.id
    assert t.not_(t.not_(t.var("b"))) is t.var("b")
    assert t.const(True) is t.TRUE


def test_what_is_known_is_simplified_away() -> None:
    n, b = t.var("n", INT, 0, 9), t.var("b")
    assert numbers.lt(n, t.const(10)) is t.TRUE
    assert numbers.eq(n, t.const(10)) is t.FALSE
    assert numbers.wrap(n, 16) is n
    assert t.and_(b, t.not_(b)) is t.FALSE
    assert t.ite(b, t.TRUE, t.FALSE) is b
    assert numbers.eq(t.ite(b, t.const(1), t.const(2)), t.const(2)) is t.not_(b)
    word = numbers.setbit(t.var("w", INT, -128, 127), 3, b, 8)
    assert numbers.bit(word, 3) is b
    assert numbers.bit(word, 9) is numbers.bit(word, 7)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32))
def test_many_runs_at_once_compute_what_each_alone_does(seed: int) -> None:
    made = bench(seed)
    roots = [term for term, _ in (*made.whole, *made.truths)]
    batch = BatchEvaluator(roots, lanes=3)
    lanes = [made.values, bench(seed + 1).values, bench(seed + 2).values]
    values = {v.val: np.array([each[v.val] for each in lanes]) for v in t.variables(roots)}
    got = [each.tolist() for each in batch(values)]
    for number, each in enumerate(lanes):
        assert [column[number] for column in got] == evaluate(roots, each)


@given(st.lists(st.tuples(st.integers(), st.integers()), min_size=3, max_size=3), st.integers(1, 70))
def test_numbers_wider_than_a_word_of_many_runs_are_those_of_one(lanes, bits: int) -> None:
    a, b = t.var("a", INT, -(1 << 1024), 1 << 1024), t.var("b", INT, -(1 << 1024), 1 << 1024)
    low = numbers.wrap(a, bits)
    roots = [low, numbers.wrap(b, -bits), numbers.lt(a, b), numbers.eq(low, b), t.ite(numbers.lt(a, b), a, b)]
    roots += [numbers.add(a, b), numbers.mul(low, numbers.wrap(b, bits))]
    columns = {
        name: np.array(each, object) for name, each in zip("ab", zip(*lanes, strict=True), strict=True)
    }
    many = [each.tolist() for each in BatchEvaluator(roots, lanes=3)(columns)]
    for number, (x, y) in enumerate(lanes):
        assert [column[number] for column in many] == evaluate(roots, {"a": x, "b": y})


@given(FLOATS, FLOATS)
def test_floats_of_many_runs_are_those_of_one(x: float, y: float) -> None:
    a, b = t.var("a", F32), t.var("b", F32)
    roots = [numbers.fop(op, a, b) for op in ("fadd", "fmul", "fsub", "fdiv")]
    roots += [
        numbers.to_int(a, "rne"),
        numbers.to_float(numbers.to_int(b, "rtz"), F32),
        numbers.lt(a, b),
    ]
    one = evaluate(roots, {"a": x, "b": y})
    many = BatchEvaluator(roots, lanes=1)({"a": np.array([x], np.float32), "b": np.array([y], np.float32)})
    assert all(u == v or (u != u and v != v) for u, v in zip(one, (each[0] for each in many), strict=True))
