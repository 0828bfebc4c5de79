"""Somebody turns the encoder, and gives Z pulses on the bench."""

from __future__ import annotations

import pytest
from scanrack.runtime.machine import Machine


def test_counts_are_spread_evenly_and_the_last_comes_at_the_end() -> None:
    machine = Machine()
    machine.turn_encoder(4, 100, 120)  # at 105, 110, 115, 120
    assert [machine.encoder_counts(now_ns) for now_ns in (100, 104, 105, 119, 120, 900)] == [0, 0, 1, 3, 4, 4]


def test_counts_backward_are_rounded_toward_zero() -> None:
    machine = Machine()
    machine.turn_encoder(-3, 0, 10)  # at 3 1/3, 6 2/3 and 10
    assert [machine.encoder_counts(now_ns) for now_ns in (3, 4, 6, 7, 10)] == [0, -1, -1, -2, -3]


def test_turns_follow_each_other() -> None:
    machine = Machine()
    machine.turn_encoder(10, 0, 10)
    machine.turn_encoder(-10, 10, 20)
    assert [machine.encoder_counts(now_ns) for now_ns in (5, 10, 15, 20)] == [5, 10, 5, 0]


@pytest.mark.parametrize(
    ("start_ns", "end_ns", "message"),
    [
        (50, 49, r"turn_encoder: end_ns 49: must be 50 \(start_ns\) or more"),
        (19, 30, r"turn_encoder: start_ns 19: must be 20 \(end of the last turn\) or more"),
    ],
)
def test_turns_that_cannot_be(start_ns: int, end_ns: int, message: str) -> None:
    machine = Machine()
    machine.turn_encoder(5, 10, 20)
    with pytest.raises(ValueError, match=message):
        machine.turn_encoder(5, start_ns, end_ns)


def test_turning_is_over_with_the_last_count() -> None:
    machine = Machine()
    machine.turn_encoder(1, 10, 20)
    assert [machine.turning(now_ns) for now_ns in (0, 19, 20)] == [True, True, False]


def test_markers_by_hand_come_after_the_instant_asked_for() -> None:
    machine = Machine()
    for at_ns in (30, 10, 20):
        machine.marker_at(at_ns)
    assert [machine.next_marker_ns(now_ns) for now_ns in (0, 9, 10, 20, 30)] == [10, 10, 20, 30, None]


def test_letting_go_drops_what_has_not_come_yet() -> None:
    machine = Machine()
    machine.turn_encoder(10, 0, 100)
    machine.marker_at(40)
    machine.marker_at(60)
    machine.let_go(40)
    assert machine.encoder_counts(1000) == 4
    assert machine.next_marker_ns(39) == 40
    assert machine.next_marker_ns(40) is None
    machine.turn_encoder(5, 1000, 1000)  # and somebody else takes over
    assert machine.encoder_counts(1000) == 9
