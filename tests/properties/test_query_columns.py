"""Queries on whole columns against an evaluation scan by scan, over random traces and random queries."""

from __future__ import annotations

import operator
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_traces import A3601, PERIOD_NS, record
from scanrack.io_images.amci3601 import StatusView
from scanrack.traces import Scan, SlotInfo, open_trace
from scanrack.traces.query import query

pytestmark = pytest.mark.slow

SLOTS = (A3601, SlotInfo(4, "a toy"))
FEW = (0, 1, 2, 0x4001, 0x5000, 0x5001, -31_682)  # with and without MODE_CONFIG (bit 15)
POSITIONS = st.sampled_from([(0, 0), (0, 1), (-1, -1), (-1, 999), (12, 345)])

Value = float | bool | None
Slow = Callable[[list[Scan], int], Value]
Expression = tuple[str, Slow]


@st.composite
def traces(draw: st.DrawFn) -> np.ndarray:
    scans = draw(st.integers(1, 30))
    words = np.zeros((scans, 32), np.int16)
    words[:, 0] = draw(st.lists(st.sampled_from(FEW), min_size=scans, max_size=scans))
    words[:, 8] = draw(st.lists(st.sampled_from(FEW), min_size=scans, max_size=scans))
    words[:, 10:12] = draw(st.lists(POSITIONS, min_size=scans, max_size=scans))
    words[:, 27] = draw(st.lists(st.integers(-2, 2), min_size=scans, max_size=scans))
    return words


# -- the slow evaluation: one scan at a time, with the image classes of the modules -------------------


def command_error(scans: list[Scan], at: int) -> bool:
    return StatusView(scans[at].inputs(1)).COMMAND_ERROR


def moving(scans: list[Scan], at: int) -> bool:
    return StatusView(scans[at].inputs(1)).MOVING_CW


def absolute_move(scans: list[Scan], at: int) -> bool:
    outputs = scans[at].outputs(1)
    return outputs.bit(0, 0) and not outputs.bit(0, 15)


def numbered_bit(scans: list[Scan], at: int) -> bool:
    return scans[at].inputs(4).bit(3, 1)


def position(scans: list[Scan], at: int) -> float | None:
    view = StatusView(scans[at].inputs(1))
    return None if view.MODE_CONFIG else view.position


def word(scans: list[Scan], at: int) -> float:
    return scans[at].inputs(4)[3]


NUMBERS: tuple[Expression, ...] = (
    ("slot1.in.position", position),
    ("slot4.in.word3", word),
    ("scan", lambda scans, at: scans[at].scan),
    ("-2", lambda scans, at: -2),
    ("0x0C", lambda scans, at: 12),
    ("1.5", lambda scans, at: 1.5),
)
BITS: tuple[Expression, ...] = (
    ("slot1.in.COMMAND_ERROR", command_error),
    ("slot1.in.MOVING_CW", moving),
    ("slot1.out.ABSOLUTE_MOVE", absolute_move),
    ("slot4.in.word3.1", numbered_bit),
)
SIGNS = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
SUMS = {"+": operator.add, "-": operator.sub, "*": operator.mul}


def arithmetic(left: Expression, sign: str, right: Expression) -> Expression:
    def slow(scans: list[Scan], at: int) -> Value:
        a, b = left[1](scans, at), right[1](scans, at)
        return None if a is None or b is None else SUMS[sign](a, b)

    return f"({left[0]} {sign} {right[0]})", slow


def absolute(part: Expression) -> Expression:
    def slow(scans: list[Scan], at: int) -> Value:
        value = part[1](scans, at)
        return None if value is None else abs(value)

    return f"abs({part[0]})", slow


def compared(left: Expression, sign: str, right: Expression) -> Expression:
    def slow(scans: list[Scan], at: int) -> Value:
        a, b = left[1](scans, at), right[1](scans, at)
        return a is not None and b is not None and SIGNS[sign](a, b)

    return f"({left[0]} {sign} {right[0]})", slow


def rose(part: Expression) -> Expression:
    return f"rose({part[0]})", lambda s, at: at > 0 and bool(part[1](s, at)) and not part[1](s, at - 1)


def fell(part: Expression) -> Expression:
    return f"fell({part[0]})", lambda s, at: at > 0 and not part[1](s, at) and bool(part[1](s, at - 1))


def changed(part: Expression) -> Expression:
    return f"changed({part[0]})", lambda s, at: at > 0 and part[1](s, at) != part[1](s, at - 1)


def negated(part: Expression) -> Expression:
    return f"(not {part[0]})", lambda s, at: not part[1](s, at)


def both(left: Expression, right: Expression) -> Expression:
    return f"({left[0]} and {right[0]})", lambda s, at: bool(left[1](s, at) and right[1](s, at))


def either(left: Expression, right: Expression) -> Expression:
    return f"({left[0]} or {right[0]})", lambda s, at: bool(left[1](s, at) or right[1](s, at))


def held(part: Expression, ms: int) -> Expression:
    def slow(scans: list[Scan], at: int) -> bool:
        since = at
        while since >= 0 and part[1](scans, since):
            if scans[at].now_ns - scans[since].now_ns >= ms * 1_000_000:
                return True
            since -= 1
        return False

    return f"({part[0]} for {ms} ms)", slow


numbers = st.recursive(
    st.sampled_from(NUMBERS),
    lambda inner: (
        st.builds(arithmetic, inner, st.sampled_from(sorted(SUMS)), inner) | st.builds(absolute, inner)
    ),
    max_leaves=3,
)
comparisons = st.builds(compared, numbers, st.sampled_from(sorted(SIGNS)), numbers)
conditions = st.recursive(
    st.sampled_from(BITS) | comparisons | st.builds(changed, numbers),
    lambda inner: (
        st.builds(rose, inner)
        | st.builds(fell, inner)
        | st.builds(changed, inner)
        | st.builds(negated, inner)
        | st.builds(both, inner, inner)
        | st.builds(either, inner, inner)
        | st.builds(held, inner, st.integers(0, 9))
    ),
    max_leaves=4,
)


def ask(words: np.ndarray, text: str) -> tuple[list[tuple[int, int, int, int, bool]], list[Scan]]:
    """Return what a query finds, and the scans as the plain reader gives them."""
    with tempfile.TemporaryDirectory() as folder:
        path = record(Path(folder) / "a.mcap", words, SLOTS, chunk_scans=7)
        with open_trace(path) as trace:
            found = query(trace, text).occurrences
            scans = list(trace.scans())
    return [(one.first, one.last, one.start_ns, one.end_ns, one.open) for one in found], scans


def slow_runs(truth: list[bool], scans: list[Scan]) -> list[tuple[int, int, int, int, bool]]:
    """Return the stretches of true values, one scan at a time."""
    found, first = [], None
    for at, true in enumerate(truth):
        if true and first is None:
            first = at
        if not true and first is not None:
            found.append((first, at - 1, scans[first].now_ns, scans[at].now_ns, False))
            first = None
    if first is not None:
        found.append((first, len(truth) - 1, scans[first].now_ns, scans[-1].now_ns, True))
    return found


@given(traces(), conditions)
def test_a_condition_holds_where_the_slow_evaluation_says_so(
    words: np.ndarray, condition: Expression
) -> None:
    text, slow = condition
    found, scans = ask(words, text)
    assert found == slow_runs([bool(slow(scans, at)) for at in range(len(scans))], scans)


@given(traces(), conditions, conditions, st.integers(0, 20), st.booleans())
def test_an_answer_comes_or_not(
    words: np.ndarray, cause: Expression, effect: Expression, ms: int, answered: bool
) -> None:
    word = "then" if answered else "without"
    found, scans = ask(words, f"{cause[0]} {word} {effect[0]} within {ms} ms")
    expected = []
    for at in range(len(scans)):
        begins = cause[1](scans, at) and not (at and cause[1](scans, at - 1))
        if not begins:
            continue
        later = [b for b in range(at + 1, len(scans)) if effect[1](scans, b)]
        end = later[0] if later else len(scans) - 1
        late = (end - at) * PERIOD_NS > ms * 1_000_000
        if (bool(later) and not late) if answered else late:
            expected.append((at, end, scans[at].now_ns, scans[end].now_ns, not later))
    assert found == expected
