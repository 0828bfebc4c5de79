"""Edges and envelopes of rows: the timing strip shows every pulse, and no position that is none."""

import numpy as np
import pytest
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.runtime.live.ring import row_type
from scanrack.watch.history.strip import MOST_EDGES, piece_of, signals_of

SIGNALS = signals_of({1: WORDS_3601})
STATUS, POSITION = 8, 10  # words of the rack's memory: eight outputs, then eight inputs
PERIOD = 2_000_000


def edges(rows, before):
    return piece_of(rows, before, SIGNALS, PERIOD)["bits"]


def envelopes(rows, most=1):
    return piece_of(rows, rows[:0], SIGNALS, PERIOD, most)["positions"]


def rows(count):
    made = np.zeros(count, row_type(32, 0))
    made["scan"] = np.arange(count)
    made["now_ns"] = np.arange(count) * PERIOD
    return made


def test_a_pulse_of_one_scan_is_two_edges():
    made = rows(100)
    made["words"][50, STATUS] = 1 << 7  # MOVE_COMPLETE
    assert edges(made[1:], made[:1]) == {"1.MOVE_COMPLETE": [[100_000_000, 1], [102_000_000, 0]]}


def test_without_a_row_before_every_bit_begins_with_its_level():
    found = edges(rows(3), rows(0))
    assert found["1.MOVE_COMPLETE"] == [[0, 0]]
    assert set(found) == {f"1.{name}" for names in WORDS_3601.groups.values() for name in names}


def test_of_a_command_and_a_status_of_one_name_the_status_is_shown():
    made = rows(3)
    made["words"][1:, 0] = -0x8000  # the command MODE_CONFIG
    made["words"][2:, STATUS] = -0x8000  # the module answers
    assert edges(made[1:], made[:1]) == {"1.MODE_CONFIG": [[4_000_000, 1]]}


@pytest.mark.parametrize("most", [1, 3, 10])
def test_an_envelope_holds_every_position(most):
    made = rows(10)
    made["words"][:, POSITION] = [0, 0, 1, 1, -2, 0, 0, 3, 0, 0]
    made["words"][:, POSITION + 1] = [5, 0, 0, 0, -1, 0, 0, 0, 0, 7]
    points = envelopes(made, most)["1.position"]
    assert len(points) == most
    assert min(point[1] for point in points) == -2001
    assert max(point[2] for point in points) == 3000
    assert points[-1][3] == 7


def test_the_mirror_of_a_configuration_is_no_position():
    made = rows(4)
    made["words"][:, STATUS] = [0, -0x8000, -0x8000, 0]
    made["words"][:, POSITION + 1] = [1, 500, 500, 2]
    assert envelopes(made) == {"1.position": [[0, 1, 1, 1], [PERIOD, None], [3 * PERIOD, 2, 2, 2]]}
    assert envelopes(made[1:3]) == {"1.position": [[PERIOD, None]]}


def test_a_piece_says_up_to_where_it_is_known():
    made = rows(10)
    piece = piece_of(made[3:8], made[2:3], SIGNALS, PERIOD)
    assert (piece["from"], piece["to"]) == (3 * PERIOD, 8 * PERIOD)
    assert piece_of(made[:0], made[:0], SIGNALS, PERIOD) == {}


def test_nothing_is_known_of_rows_that_were_lost():
    made = rows(100)
    made["words"][50:, STATUS] = 1 << 7  # MOVE_COMPLETE; nobody knows when
    known = np.r_[made[:40], made[60:]]
    rise = [[0, 0], [40 * PERIOD, None], [60 * PERIOD, 1]]
    assert edges(known, rows(0))["1.MOVE_COMPLETE"] == rise
    assert envelopes(known)["1.position"] == [
        [0, 0, 0, 0],
        [40 * PERIOD, None],
        [60 * PERIOD, 0, 0, 0],
    ]
    assert edges(made[60:], made[39:40])["1.MOVE_COMPLETE"] == rise[2:]  # every bit begins anew


def test_more_edges_than_there_is_room_for_are_counted():
    made = rows(20 * MOST_EDGES)
    made["words"][: 10 * MOST_EDGES : 2, STATUS] = 1 << 7
    points = edges(made, rows(0))["1.MOVE_COMPLETE"]
    assert len(points) == MOST_EDGES
    assert points[0] == [0, 0, 19]  # edges in scans 1 to 19; the first scan begins the lane
    assert points[1] == [20 * PERIOD, 0, 19]
    assert points[-1] == [20 * (MOST_EDGES - 1) * PERIOD, 0]


def test_words_of_a_configuration_are_no_commands_and_no_status():
    made = rows(4)
    made["words"][1:3, 0] = -0x8000 | 1 << 2  # bit 2 of a configuration is not a HOLD_MOVE
    made["words"][2, STATUS] = -0x8000 | 1 << 7  # nor is bit 7 of its mirror MOVE_COMPLETE
    found = edges(made[1:], made[:1])
    assert found == {"1.MODE_CONFIG": [[4_000_000, 1], [6_000_000, 0]]}
