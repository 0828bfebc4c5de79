"""The query language: what it finds in a small trace, and what it says about mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_traces import PERIOD_NS, idle, record
from scanrack.traces import open_trace
from scanrack.traces.query import Occurrence, QueryError, query

ABSOLUTE_MOVE, COMMAND_ERROR, MOVING_CW = 0x0001, 0x1000, 0x0001
SCANS = 100


def story() -> np.ndarray:
    """Two moves, answered after 1 and 3 scans; an error in scans 50 to 54; then a move without an answer."""
    words = idle(SCANS)
    for command, moving, end in ((10, 11, 20), (30, 33, 45)):
        words[command, 0] = ABSOLUTE_MOVE
        words[moving:end, 8] |= MOVING_CW
    words[50:55, 8] |= COMMAND_ERROR
    words[60, 0] = ABSOLUTE_MOVE
    words[:, 11] = np.repeat([0, 500], 50)  # position 500 from scan 50 on
    return words


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("query") / "story.mcap", story())


def found(path: Path, text: str) -> list[tuple[int, int]]:
    with open_trace(path) as trace:
        return [(one.first, one.last) for one in query(trace, text).occurrences]


@pytest.mark.parametrize(
    ("text", "scans"),
    [
        ("rose(slot1.in.COMMAND_ERROR)", [(50, 50)]),
        ("fell(slot1.in.COMMAND_ERROR)", [(55, 55)]),
        ("slot1.in.COMMAND_ERROR", [(50, 54)]),
        ("slot1.in.status_msw.12", [(50, 54)]),
        ("slot1.in.MOVING_CW", [(11, 19), (33, 44)]),
        ("slot1.in.MOVING_CW for 20 ms", [(43, 44)]),  # since scan 33, 2 ms each: from scan 43 on
        ("changed(slot1.in.position)", [(50, 50)]),
        ("slot1.in.position >= 500 and scan < 52", [(50, 51)]),
        ("time >= 196 ms", [(98, 99)]),
        ("scan == 3 or scan == 5", [(3, 3), (5, 5)]),
        ("not scan > 1", [(0, 1)]),
        ("rose(slot1.out.ABSOLUTE_MOVE) then slot1.in.MOVING_CW", [(10, 11), (30, 33)]),
        ("slot1.out.ABSOLUTE_MOVE then slot1.in.MOVING_CW within 2 ms", [(10, 11)]),
        ("slot1.out.ABSOLUTE_MOVE without slot1.in.MOVING_CW within 2 ms", [(30, 33), (60, 99)]),
        ("longest(slot1.out.ABSOLUTE_MOVE then slot1.in.MOVING_CW)", [(30, 33)]),
        ("shortest(slot1.out.ABSOLUTE_MOVE then slot1.in.MOVING_CW)", [(10, 11)]),
        ("first(slot1.in.MOVING_CW)", [(11, 19)]),
        ("last(slot1.in.MOVING_CW)", [(33, 44)]),
        ("longest(slot1.in.INPUT_ERROR)", []),
        ("abs(slot1.in.position - 1_000) < 0x258", [(50, 99)]),  # 600
        ("slot1.in.COMMAND_ERROR == slot1.in.MOVING_CW and scan < 12", [(0, 10)]),
    ],
)
def test_what_a_query_finds(path: Path, text: str, scans: list[tuple[int, int]]) -> None:
    assert found(path, text) == scans


def test_count_gives_no_occurrence(path: Path) -> None:
    with open_trace(path) as trace:
        answer = query(trace, "count(slot1.in.MOVING_CW)")
    assert (answer.aggregate, answer.count, answer.occurrences) == ("count", 2, ())


def test_an_occurrence_has_its_time_and_what_was_to_be_shown(path: Path) -> None:
    with open_trace(path) as trace:
        answer = query(trace, "slot1.in.COMMAND_ERROR", show=["slot1.in.position", "slot1.in.MOVING_CW"])
    shown = {"slot1.in.position": 500.0, "slot1.in.MOVING_CW": False}
    assert answer.occurrences == (Occurrence(50, 54, 50 * PERIOD_NS, 55 * PERIOD_NS, False, shown),)
    assert answer.occurrences[0].duration_ns == 5 * PERIOD_NS


def test_what_is_not_over_at_the_end_is_open(path: Path) -> None:
    with open_trace(path) as trace:
        (one,) = query(trace, "slot1.in.position == 500").occurrences
    assert one.open
    assert one.duration_ns == 49 * PERIOD_NS  # up to the last scan, 99


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "rose(slot1.in.COMAND_ERROR)",
            "column 6: no signal 'slot1.in.COMAND_ERROR': did you mean slot1.in.COMMAND_ERROR",
        ),
        (
            "COMMAND_ERROR",
            "column 1: no signal 'COMMAND_ERROR': did you mean slot1.in.COMMAND_ERROR?",
        ),
        ("slot7.out.zzz", "column 1: no signal 'slot7.out.zzz'"),
        (
            "rose(slot1.in.position)",
            "column 6: rose() needs a condition here, but slot1.in.position is a number; "
            "compare it, as in slot1.in.position > 0",
        ),
        (
            "time > 5",
            "column 6: > has a time on its left and a number on its right; a time has a unit, as in 20 ms",
        ),
        (
            "slot1.in.MOVING_CW > slot1.in.AT_HOME",
            "column 20: > does not compare conditions; use == or !=",
        ),
        ("slot1.in.MOVING_CW + 1 > 0", "column 1: + needs a number here, but slot1.in.MOVING_CW is"),
        ("time * time > 1 s", "column 8: * needs a number here, but time is a time"),
        (
            "slot1.in.MOVING_CW and",
            "column 23: the query ends too early; allowed here: rose, fell or changed",
        ),
        ("slot1.in.MOVING_CW $", "column 20: '$' is unexpected"),
        ("scan = 5", "column 6: '=' is unexpected; allowed here: a comparison"),
        ("longest(longest(slot1.in.MOVING_CW))", "column 16: '(' is unexpected"),
        ("slot1.in.MOVING_CW for 20", "column 24: '20' is unexpected; allowed here: a time such as 20 ms"),
        ("slot1.in.MOVING_CW without slot1.in.AT_HOME", "column 44: the query ends too early"),
        ("", "column 1: the query ends too early"),
        ("time > 99999999 h", "column 8: '99999999 h' is longer than 146 years, the longest time"),
        (f"scan > 0x{300 * 'F'}", "FFF is too large"),
        (3000 * "not " + "scan > 1", "the query is nested too deeply"),
    ],
)
def test_a_mistake_is_told_with_its_column(path: Path, text: str, says: str) -> None:
    with open_trace(path) as trace, pytest.raises(QueryError) as error:
        query(trace, text)
    assert says in str(error.value)
