"""A networked drive on a real connection: a Modbus TCP server over a simulated drive, in a thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import Event, Thread
from time import perf_counter_ns

import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import status_names
from scanrack.io_images.drives.models import SMD23E2
from scanrack.io_images.site import SettingError
from scanrack.io_images.thousands import join_reported
from scanrack.runtime import SlotSpec
from scanrack.runtime.line.ports.modbustcp import ModbusTcpPort
from scanrack.runtime.modules.adapters.live import LiveAdapter
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.registers import DriveRegisters

pytestmark = pytest.mark.slow  # in real time

CONFIGURE = (0x8414, 63, 1, 0)
MOVE = (2, 0, 2, 0, 5, 0, 50, 50)
LONG_MOVE = (2, 0, 60, 0, 2, 0, 50, 50)
SCAN_S = 0.002


class ServedDrive:
    """A drive behind a port of this machine.

    Attributes:
        delay_s: before each answer.
    """

    def __init__(self) -> None:
        self.drive = DriveUnit(SMD23E2)
        self.delay_s = 0.0
        self._registers = DriveRegisters([self.drive])
        self._began_ns = perf_counter_ns()
        self._number = 0
        self.begin()

    @property
    def port(self) -> str:
        return f"tcp:127.0.0.1:{self._number}"

    def begin(self) -> None:
        self._port = ModbusTcpPort("127.0.0.1", self._number)
        self._number = int(self._port.name.rpartition(":")[2])
        self._over = Event()
        self._thread = Thread(target=self._serve)
        self._thread.start()

    def end(self) -> None:
        self._over.set()
        self._thread.join()
        self._port.close()

    def _serve(self) -> None:
        while not self._over.is_set():
            self._port.serve(0.01, self._answer)

    def _answer(self, _unit: int, pdu: bytes) -> bytes:
        if self.delay_s:
            Event().wait(self.delay_s)
        self.drive.advance(max(self.drive.now_ns, perf_counter_ns() - self._began_ns))
        return self._registers.answer(pdu)


@pytest.fixture
def served() -> Iterator[ServedDrive]:
    served = ServedDrive()
    yield served
    served.end()


class Live:
    """A live adapter, scanned in real time."""

    def __init__(self, port: str) -> None:
        module = SlotSpec(number=1, module="amci-drive", port=port, options={}).open()
        assert isinstance(module, LiveAdapter)
        self.module = module
        self.now_ns = 0
        self.image = Image()

    def give(self, *words: int, until: Callable[[set[str]], bool], seconds: float = 20) -> set[str]:
        """Scan with words until the status bits are as they should."""
        for _ in range(round(seconds / SCAN_S)):
            Event().wait(SCAN_S)
            self.now_ns += round(SCAN_S * 1e9)
            self.image = self.module.update(self.now_ns, Image(words))
            bits = set(status_names(self.image[0] & 0xFFFF, self.image[1] & 0xFFFF))
            if until(bits):
                return bits
        raise AssertionError(bits)

    def configured(self) -> Live:
        self.give(until=lambda bits: "MODULE_OK" in bits)
        self.give(*CONFIGURE, until=lambda bits: "MODE_CONFIG" in bits and "CONFIG_ERROR" not in bits)
        self.give(until=lambda bits: "MODULE_OK" in bits)
        self.give(512, until=lambda bits: "POSITION_INVALID" not in bits)
        self.give(until=lambda bits: bits == {"MODULE_OK"})
        return self


@pytest.fixture
def live(served: ServedDrive) -> Iterator[Live]:
    live = Live(served.port)
    yield live
    live.module.close()


def test_it_moves_a_drive_over_tcp(served, live):
    live.configured().give(*MOVE, until=lambda bits: "MOVE_COMPLETE" in bits)
    assert join_reported(live.image[2], live.image[3]) == served.drive.machine.shaft == 2000


def test_a_server_that_ends_is_a_lost_controller(served, live):
    live.configured().give(*LONG_MOVE, until=lambda bits: "MOVING_CW" in bits)
    served.end()
    live.give(*LONG_MOVE, until=lambda bits: "MODULE_OK" not in bits)
    assert "MOVING_CW" not in status_names(live.image[0] & 0xFFFF, 0)
    served.begin()
    bits = live.give(until=lambda bits: "MODULE_OK" in bits)
    assert {"POSITION_INVALID", "STOPPED"} <= bits
    assert not served.drive.axis.moving
    assert "port lost" in {event.name for event in live.module.events}


def test_late_exchanges_are_counted(served, live):
    live.configured()
    before, served.delay_s = live.module.driver.late, 0.02
    live.give(until=lambda _bits: live.module.driver.late >= before + 3)


def test_the_end_of_a_run_stops_the_motor(served):
    live = Live(served.port).configured()
    live.give(*LONG_MOVE, until=lambda bits: "MOVING_CW" in bits)
    live.module.close()
    assert not served.drive.axis.moving


def test_a_serial_device_is_refused():
    slot = SlotSpec(number=1, module="amci-drive", port="/dev/ttyUSB0", options={})
    with pytest.raises(SettingError, match="must be tcp:HOST:PORT"):
        slot.open()


def test_nobody_there_is_a_clear_error(served):
    served.end()
    with pytest.raises(ValueError, match=r"127\.0\.0\.1:\d+ can't be reached"):
        SlotSpec(number=1, module="amci-drive", port=served.port, options={}).open()
    served.begin()
