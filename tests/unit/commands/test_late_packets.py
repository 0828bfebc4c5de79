"""Late packets of a class 1 connection, in virtual time: what the drive counts, and who learns of it."""

from __future__ import annotations

import struct

import pytest
from drive_scanner import class_1_packet, forward_open
from drive_unit import Unit
from scanrack.runtime.tag_servers.connections import forward_open_in
from scanrack.runtime.tag_servers.drive_adapter import DriveAdapter

MS = 1_000_000
SCANNER = ("10.0.0.9", 2222)


class Owner:
    """The owner of a drive at an RPI of 8 ms."""

    def __init__(self) -> None:
        self.adapter = DriveAdapter(Unit().drive)
        request = forward_open(rpi_us=8000, multiplier=7)
        reply = self.adapter.open(forward_open_in(request, large=False), SCANNER, 0)
        (self.ours,) = struct.unpack_from("<I", reply)

    def send_at(self, *instants_ms: float) -> None:
        for count, at_ms in enumerate(instants_ms, 1):
            packet = class_1_packet(self.ours, count, ())
            self.adapter.receive(packet, SCANNER[0], round(at_ms * MS))


@pytest.mark.parametrize(
    ("instants_ms", "late"),
    [((0, 8, 16, 24), 0), ((100, 108), 0), ((0, 16, 32), 0), ((0, 16.1, 17, 24), 1), ((0, 20, 40), 2)],
    ids=["in time", "begins late", "a packet lost", "one late", "two late"],
)
def test_a_packet_is_late_more_than_two_intervals_after_the_one_before(
    instants_ms: tuple[float, ...], late: int
) -> None:
    owner = Owner()
    owner.send_at(*instants_ms)
    assert (owner.adapter.late_received, owner.adapter.late_sent) == (late, 0)


def test_a_packet_that_is_sent_an_interval_after_it_was_due_is_late() -> None:
    owner = Owner()
    sent = [owner.adapter.due(round(at_ms * MS)) is not None for at_ms in (0, 7, 8, 23.9, 40, 47, 48)]
    assert sent == [True, False, True, True, True, False, True]
    assert owner.adapter.late_sent == 1  # at 40, due at 24
    assert owner.adapter.late_received == 0


def test_the_counts_outlive_their_connection() -> None:
    owner = Owner()
    owner.send_at(0, 50)
    assert owner.adapter.close((7, 99, 42))
    assert (owner.adapter.used, owner.adapter.late_received) == (True, 1)
