"""The ring: rows and records of one process as another one sees them."""

import os

import numpy as np
import pytest
from scanrack.runtime.live.ring import MESSAGE_BYTES, ORDERS, Records, Ring, row_type
from scanrack.runtime.live.shared_memory import SharedMemory


@pytest.fixture
def ring():
    made = Ring(64, figures=3, rows=16)
    yield made
    made.close()


def put(ring, scan):
    memory = bytearray(scan.to_bytes(2, "little") * 32)
    ring.put(scan, 1, scan * 2_000_000, scan * 7, (scan, -scan, 1 << 40), memory)


def test_a_row_is_read_as_it_was_written(ring):
    put(ring, 300)
    (row,) = ring.take(0).rows
    assert (row["scan"], row["flags"], row["now_ns"], row["wall_ns"]) == (300, 1, 600_000_000, 2100)
    assert row["figures"].tolist() == [300, -300, 1 << 40]
    assert row["words"].tolist() == [300] * 32


def test_rows_are_taken_once_and_in_order(ring):
    for scan in range(5):
        put(ring, scan)
    first = ring.take(0)
    put(ring, 5)
    second = ring.take(first.end)
    assert first.rows["scan"].tolist() == [0, 1, 2, 3, 4]
    assert second.rows["scan"].tolist() == [5]
    assert (first.lost, second.lost) == (0, 0)


def test_rows_that_were_overwritten_are_counted_as_lost(ring):
    for scan in range(40):
        put(ring, scan)
    taken = ring.take(10)
    assert taken.rows["scan"].tolist() == list(range(28, 40))  # 16 rows, 4 of which may be being written
    assert taken.lost == 18


def test_rows_written_at_once_are_those_written_one_by_one(ring):
    put(ring, 0)
    other, place = [*ring.take(0).rows], 1
    for last in range(ring.at_once, 10 * ring.at_once + 1, ring.at_once):  # over the end of the rows, too
        scans = range(last - ring.at_once + 1, last + 1)
        images = [scan.to_bytes(2, "little") * 32 for scan in scans]
        row = last, 1, last * 2_000_000, last * 7, (5, -5, 1 << 40)
        ring.put_all(*row, images, period_ns=2_000_000, wall_step_ns=7)
        taken = ring.take(place)
        place, other = taken.end, [*other, *taken.rows]
        assert taken.lost == 0
    assert [row["scan"] for row in other] == list(range(41))
    for row in other[1:]:
        scan = int(row["scan"])
        assert (row["again"], row["flags"], row["now_ns"], row["wall_ns"]) == (
            scan,
            1,
            scan * 2_000_000,
            scan * 7,
        )
        assert row["figures"].tolist() == [5, -5, 1 << 40]
        assert row["words"].tolist() == [scan] * 32


def test_a_row_that_is_half_written_is_left_out(ring):
    for scan in range(3):
        put(ring, scan)
    rows = np.frombuffer(ring._rows, ring.dtype)
    rows["again"][1] = 99
    assert ring.take(0).rows["scan"].tolist() == [0, 2]


def test_another_opening_of_the_file_sees_the_same(ring):
    put(ring, 7)
    ring.messages.write(b"hello")
    place = ring.memory.handle
    again = os.dup(place) if isinstance(place, int) else place
    other = Ring.opened(ring.shape, SharedMemory(ring.memory.size, again))
    other.head[ORDERS] = 3
    assert other.take(0).rows["scan"].tolist() == [7]
    assert other.messages.read(0)[0] == [b"hello"]
    assert ring.head[ORDERS] == 3
    other.close()


def test_a_row_begins_at_a_multiple_of_eight():
    assert [row_type(size, 0).itemsize % 8 for size in (32, 64, 96, 34)] == [0, 0, 0, 0]


def test_a_ring_needs_a_power_of_two():
    with pytest.raises(ValueError, match="a ring of 12 rows is not allowed: must be a power of two"):
        Ring(32, rows=12)


def records(size):
    return Records(memoryview(bytearray(64)).cast("Q"), 0, memoryview(bytearray(size)))


def test_records_of_any_length_come_out_as_they_went_in():
    made, place, seen = records(512), 0, []
    given = [bytes([number % 251]) * (number % 97) for number in range(1000)]
    for record in given:
        assert made.write(record)
        found, place, lost = made.read(place)
        assert not lost
        seen += found
    assert seen == given


def test_a_reader_that_is_too_late_is_told_and_goes_on_with_what_comes():
    made = records(512)
    for _ in range(100):
        made.write(b"x" * 40)
    found, place, lost = made.read(0)
    assert (found, lost) == ([], True)
    made.write(b"next")
    assert made.read(place)[0] == [b"next"]


def test_a_record_that_is_too_long_is_refused(ring):
    assert not ring.messages.write(b"x" * (MESSAGE_BYTES // 4))
    assert ring.messages.end == 0
