"""The orders of the two public drivers over real sockets: limits, a restart of the drive, a power cycle.

What they write is in tests/manual/test_drives_clients.py, in virtual time.
"""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager
from struct import pack, unpack
from time import monotonic, sleep

import pytest
from drive_served import TIMEOUT_S, ControlLine, Served, serving
from drive_unit import ENABLE, VALID

pytestmark = pytest.mark.slow

MOVING_CCW, STOPPED, MOVE_COMPLETE, CONFIG_ERROR = 2, 0x0008, 0x0080, 0x2000
BOTH_LIMITS = (0x8011, *VALID[1:])
SECONDS = 20
ZEROS = (0,) * 10


class Driver:
    """A connection of a driver."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT_S)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def close(self) -> None:
        self.socket.close()

    def ask(self, pdu: bytes) -> bytes:
        """Return the PDU that answers one.

        Raises:
            ConnectionError: the connection has ended.
        """
        self.socket.sendall(pack(">HHHB", 7, 0, len(pdu) + 1, 1) + pdu)
        head = self._read(7)
        return self._read(unpack(">H", head[4:6])[0] - 1)

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            if not more:
                raise ConnectionResetError("the drive has ended the connection")
            data += more
        return data

    def each(self, *writes: tuple[int, int]) -> None:
        """Write registers one by one, by function 6."""
        for address, value in writes:
            request = pack(">BHH", 6, address, value & 0xFFFF)
            assert self.ask(request) == request

    def block(self, *values: int) -> None:
        """Write registers from 1024 on, by function 16."""
        words = [value & 0xFFFF for value in values]
        head = pack(">BHHB", 16, 1024, len(words), 2 * len(words))
        assert self.ask(head + pack(f">{len(words)}H", *words))[0] == 16

    def read(self, function: int = 4) -> tuple[int, ...]:
        """Read the ten input registers."""
        return unpack(">10H", self.ask(pack(">BHH", function, 0, 10))[2:])

    def until(self, mask: int, value: int) -> tuple[int, ...]:
        """Read until bits of status word 0 are as they have to be."""
        end = monotonic() + SECONDS
        while (words := self.read())[0] & mask != value:
            assert monotonic() < end, [f"{word:04x}" for word in words]
            sleep(0.002)
        return words


def begin_as_epics(driver: Driver) -> None:
    """Preset, reset errors, enable: the start-up of the ANG1 driver."""
    driver.each((1026, 0), (1027, 0), (1024, 0x200), (1024, 0))
    driver.each((1024, 0), (1024, 0x400), (1024, 0), (1025, ENABLE))


def move_as_epics(driver: Driver, bit: int, upper: int, lower: int) -> None:
    driver.each((1028, 5), (1029, 0), (1030, 20), (1031, 20), (1026, upper), (1027, lower))
    driver.each((1024, 0), (1024, bit))


@contextmanager
def driven(model: str, *words: str) -> Iterator[tuple[Driver, ControlLine, Served]]:
    with (
        serving(model, "--tcp", "0", "--test-port", "0", *words) as served,
        closing(ControlLine(served.line)) as pins,
        closing(Driver(served.port)) as driver,
    ):
        yield driver, pins, served


def test_the_ang1_driver_moves_meets_a_limit_and_goes_on() -> None:
    with driven("ang1") as (driver, pins, _):
        driver.block(*BOTH_LIMITS)
        driver.block(0, *ZEROS[1:])
        begin_as_epics(driver)
        move_as_epics(driver, 1, 1, 500)
        assert driver.until(STOPPED | MOVE_COMPLETE, STOPPED | MOVE_COMPLETE)[2:4] == (1, 500)
        move_as_epics(driver, 2, 1000, 0)  # its jog
        driver.until(STOPPED, 0)
        pins.ask(pin="in1=on")
        seen = driver.until(STOPPED, STOPPED)
        assert seen[1] & 1
        for _ in range(3):  # polls: reset, and preset the present position
            driver.each((1024, 0), (1024, 0x400), (1024, 0), (1026, seen[2]), (1027, seen[3]))
            driver.each((1024, 0x200), (1024, 0))
        move_as_epics(driver, 2, -1, 0)
        driver.until(MOVING_CCW, MOVING_CCW)
        pins.ask(pin="in1=off")
        driver.until(STOPPED | MOVE_COMPLETE, STOPPED | MOVE_COMPLETE)


def test_the_anf2_driver_moves_meets_a_limit_and_goes_on() -> None:
    with driven("anf2") as (driver, pins, _):
        for name in ("cw_limit", "ccw_limit"):
            pins.ask(pin=f"{name}=on")  # active low
        driver.block(0x8428, 0, 0, 100, *ZEROS[4:])
        sleep(0.05)
        driver.block(*ZEROS)
        driver.block(0x0200, *ZEROS[1:])
        driver.until(0x0400, 0)
        driver.block(*ZEROS)
        driver.block(1, 0, 0, 500, 0, 1000, 20, 20, 0, 0)
        assert driver.until(STOPPED | MOVE_COMPLETE, STOPPED | MOVE_COMPLETE)[2:4] == (0, 500)
        driver.block(*ZEROS)
        driver.block(0x80, 0, 0, 0, 0, 1000, 20, 20, 0, 0)  # a jog
        driver.until(STOPPED, 0)
        pins.ask(pin="cw_limit=off")
        driver.until(STOPPED, STOPPED)
        driver.block(0x0800, *ZEROS[1:])
        driver.block(*ZEROS)
        driver.block(0x100, 0, 0, 0, 0, 1000, 20, 20, 0, 0)
        driver.until(MOVING_CCW, MOVING_CCW)
        driver.block(0, 0)  # its stop of a jog
        driver.until(STOPPED, STOPPED)


def test_smd_control_server_has_a_connection_for_each_operation() -> None:
    """One connection stays idle meanwhile; reads are by function 3."""
    with driven("smd23e2") as (idle, _, served):

        def operation(*writes: tuple[int, int]) -> None:
            with closing(Driver(served.port)) as driver:
                driver.each(*writes)

        operation((1025, VALID[1]), (1024, VALID[0]), *((1024 + at, VALID[at]) for at in (2, 3, 4, 6, 7, 8)))
        operation((1024, 0), (1024, 0x400), (1025, ENABLE))
        assert idle.read(3)[0] == 0x4408
        rates = (1028, 5), (1029, 0), (1030, 20), (1031, 10)
        operation((1024, 0), (1025, ENABLE), (1026, 1), (1027, 500), *rates, (1033, 0), (1024, 2))
        assert idle.until(STOPPED | MOVE_COMPLETE, STOPPED | MOVE_COMPLETE)[2:4] == (1, 500)
        operation((1024, 0), (1025, ENABLE), (1026, 0), (1027, 0), *rates, (1032, 0), (1033, 0), (1024, 0x80))
        idle.until(STOPPED, 0)
        operation((1024, 0), (1025, ENABLE), (1024, 4))
        idle.until(STOPPED, STOPPED)


def test_a_restarted_drive_has_to_be_configured_again() -> None:
    """The driver loses its connection, opens another one, and finds a drive without a configuration."""
    with serving("smd23e2", "--tcp", "0") as served:
        port = served.port
        driver = Driver(port)
        driver.block(*VALID)
        driver.block(0, *ZEROS[1:])
        begin_as_epics(driver)
        move_as_epics(driver, 2, 1000, 0)
        driver.until(STOPPED, 0)
    with closing(driver), pytest.raises(ConnectionError):
        driver.read()
    with serving("smd23e2", "--tcp", str(port)) as served, closing(Driver(served.port)) as again:
        assert again.read()[0] == 0x6408
        begin_as_epics(again)
        move_as_epics(again, 2, 1, 0)
        assert again.read()[0] & (CONFIG_ERROR | STOPPED) == CONFIG_ERROR | STOPPED
        again.block(*VALID)
        again.block(0, *ZEROS[1:])
        begin_as_epics(again)
        move_as_epics(again, 2, 1, 0)
        assert again.until(STOPPED | MOVE_COMPLETE, STOPPED | MOVE_COMPLETE)[2:4] == (1, 0)


def test_a_power_cycle_ends_the_connections_of_the_drive() -> None:
    with driven("smd23e2") as (driver, pins, served):
        driver.block(*VALID)
        driver.block(0, *ZEROS[1:])
        begin_as_epics(driver)
        pins.ask(pin="power=cycle")
        with pytest.raises(ConnectionError):
            driver.read()
        with closing(Driver(served.port)) as again:
            assert again.read()[0] == 0x6408


def test_a_power_cycle_of_one_axis_of_a_stack_ends_none() -> None:
    with driven("ang1", "--axes", "2") as (driver, pins, _):
        driver.block(*BOTH_LIMITS)
        pins.ask(pin="2:power=cycle")
        assert driver.read()[0] & 0x8000
