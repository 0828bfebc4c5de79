"""Lanes of tags: points show every change; what is run again is what ran."""

import pytest
from scanrack.watch.history.lanes import MOST_POINTS, UNKNOWN, ValueHistory, points_of

TIMES = list(range(0, 20, 2))


def test_a_bool_has_a_point_at_each_edge():
    values = [False, False, True, False, False, True, True, True, True, False]
    assert points_of(TIMES, values) == [[0, 0], [4, 1], [6, 0], [10, 1], [18, 0]]


def test_a_number_has_a_point_at_each_change():
    assert points_of(TIMES, [5] * 4 + [7] * 6) == [[0, 5, 5, 5], [8, 7, 7, 7]]


def test_a_text_has_a_point_at_each_change_and_none_where_nothing_changes():
    assert points_of(TIMES[:3], ["wait", "move", "move"], "wait") == [[2, "move"]]
    assert points_of(TIMES[:3], ["wait"] * 3, "wait") == []
    assert points_of(TIMES[:3], [float("nan") for _ in range(3)], float("nan")) == []


def test_what_is_not_known_is_null():
    assert points_of([0, 2], [None, 3]) == [[0, None], [2, 3, 3, 3]]


@pytest.mark.parametrize("count", [MOST_POINTS, MOST_POINTS + 1, 10 * MOST_POINTS + 7])
def test_many_changes_of_a_number_become_an_envelope(count):
    values = [(place * 7919) % 1009 for place in range(count)]
    points = points_of(range(count), values)
    assert len(points) == MOST_POINTS
    assert min(point[1] for point in points) == min(values)
    assert max(point[2] for point in points) == max(values)
    assert points[-1][3] == values[-1]
    starts = [point[0] for point in points]
    assert starts == sorted(set(starts))
    for start, end, (_, least, most, last) in zip(starts, [*starts[1:], count], points, strict=True):
        assert (least, most, last) == (min(values[start:end]), max(values[start:end]), values[end - 1])


def test_many_edges_of_a_bool_are_counted_and_of_a_text_the_last_ones_are_known():
    count = 10 * MOST_POINTS
    points = points_of(range(count), [bool(place % 2) for place in range(count)])
    assert points == [[10 * place, 1, 9] for place in range(MOST_POINTS)]
    points = points_of(range(count), [f"step {place}" for place in range(count)])
    assert points[:2] == [[0, None], [count - MOST_POINTS + 1, f"step {count - MOST_POINTS + 1}"]]
    assert len(points) == MOST_POINTS


def test_true_is_another_value_than_one():
    assert points_of([0, 2], [True, 1], UNKNOWN) == [[0, 1], [2, 1, 1, 1]]


def test_values_that_were_looked_at_begin_with_the_one_of_before():
    told = ValueHistory(2_000_000)
    told.take(3, {"step": "wait"})
    told.take(20, {"step": "move"})
    assert told.points("step", 10, 30) == [[20_000_000, "wait"], [40_000_000, "move"]]
    assert told.points("step", 0, 5) == [[6_000_000, "wait"]]
    assert told.points("step", 20, 30) == [[40_000_000, "move"]]
    assert told.points("other", 0, 30) == []
