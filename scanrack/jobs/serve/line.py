"""Serves simulated controllers on a line at a port, with the line's behavior and the controllers' wiring."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from scanrack.io_images.pcl601 import Code
from scanrack.io_images.times import exact_ns
from scanrack.runtime.line.faulty import FaultInjector
from scanrack.runtime.line.gateway import Gateway
from scanrack.runtime.line.hosts import split_address
from scanrack.runtime.line.ports import (
    BusSegment,
    Client,
    GatewayServer,
    LineListener,
    LineServer,
    ModbusTcpPort,
    PduServer,
    Port,
    PtyPort,
    RawTcpPort,
    SerialPort,
    Server,
)
from scanrack.runtime.line.timed import TimedLine
from scanrack.runtime.line.wire import Device
from scanrack.runtime.loop.pace import Clock
from typing_extensions import override

from ..run.served_units import NO_PROGRAM, ServedUnit, Unit

LOOPBACK = "127.0.0.1"
BROADCAST = 0
GATEWAY_MS = 1000.0
GATEWAY_MS_MAX = 60_000


@dataclass(frozen=True, slots=True)
class PortChoice:
    """The requested ports. A line needs exactly one of `pty`, `serial` and `tcp`."""

    pty: bool = False  # whether to open a pseudo terminal
    serial: str | None = None  # a serial device
    tcp: str | None = None  # [HOST:]PORT
    rtu_over_tcp: bool = False  # whether the TCP port passes the bytes of the line, instead of Modbus TCP
    ethernet_ip: str | None = None  # [HOST:]PORT, for drives
    io_port: int = 0  # UDP port of class 1 packets, for drives; 0 = any free port


class LineService(Protocol):
    """The units that a port serves.

    Attributes:
        units: the units, in order of address.
    """

    units: Sequence[ServedUnit]

    @property
    def title(self) -> str:
        """Description of the served units."""

    def set_fault(self, text: str) -> None:
        """Set a fault of the line; raise ValueError for an unknown fault."""

    def server(
        self, choice: PortChoice, clock: Clock, listener: LineListener | None = None
    ) -> tuple[Server, str]:
        """Open the requested port; return its server and the address for clients.

        Raises:
            ValueError: the choice of ports is invalid, or a port can't be opened.
        """


class ServedLine(LineService):
    """Units on a line.

    Args:
        controller: model name of the units.
        timed: whether each character takes as long as it does at the line's speed, on every port.
        faulty: whether faults may be set; Modbus TCP then has a gateway, as with `timed`.
        gateway_ms: time from the end of a request on the line to the gateway's exception 0Bh, ms.

    Raises:
        ValueError: `gateway_ms` is out of range.
    """

    def __init__(
        self,
        units: list[Unit],
        controller: str = "",
        *,
        timed: bool = False,
        faulty: bool = False,
        gateway_ms: float = GATEWAY_MS,
    ) -> None:
        if not 0 < gateway_ms <= GATEWAY_MS_MAX:
            raise ValueError(f"--gateway-ms {gateway_ms:g}: must be above 0, and at most {GATEWAY_MS_MAX}")
        self.units = self._line_units = units
        self._controller = controller
        self._timed = timed
        self._is_direct = not (timed or faulty)  # without faults, times and a gateway
        self._gateway_ns = exact_ns(gateway_ms, "ms", "--gateway-ms")
        # by address; used on the line unless it is direct
        self._faulty = {unit.address: self._with_faults(unit) for unit in units}
        self.device = self._line()

    @property
    @override
    def title(self) -> str:
        names = ", ".join(str(unit.address) for unit in self._line_units)
        return f"{self._controller} at address {names}, {self._line_units[0].device.line_format}"

    @override
    def set_fault(self, text: str) -> None:
        """Set a fault: `drop=3`, or `2:reset` for the unit at address 2; see `runtime.line.faulty`.

        Raises:
            ValueError: the unit or fault is unknown.
        """
        address, colon, fault = text.replace(" ", "").rpartition(":")
        units = [unit for number, unit in self._faulty.items() if not colon or str(number) == address]
        if not units:
            raise ValueError(f"{text!r} is not a fault of a unit: must be FAULT, or ADDRESS:FAULT")
        for unit in units:
            unit.set(fault)

    @override
    def server(
        self, choice: PortChoice, clock: Clock, listener: LineListener | None = None
    ) -> tuple[Server, str]:
        """Open the only requested port; return its server and the address for clients."""
        if [choice.pty, choice.serial is not None, choice.tcp is not None].count(True) != 1:
            raise ValueError("use one of --pty, --serial DEVICE and --tcp HOST:PORT")
        if choice.serial is not None and self._timed:
            raise ValueError("--line-time: no effect on serial ports")
        if choice.tcp is not None and not choice.rtu_over_tcp and self._line_units[0].answer is not None:
            return self._modbus_server(ModbusTcpPort(*socket_address(choice.tcp)), clock, listener)
        if choice.tcp is not None:
            port: Port = RawTcpPort(*socket_address(choice.tcp))
        else:
            port = PtyPort() if choice.serial is None else SerialPort(choice.serial, self.device.line_format)
        return LineServer(self.device, port, clock, listener), port.name

    def _modbus_server(
        self, modbus: ModbusTcpPort, clock: Clock, listener: LineListener | None
    ) -> tuple[Server, str]:
        """Return a Modbus TCP server, direct or with a gateway to the line, and the address for clients."""
        if self._is_direct:
            return PduServer(self.device, answering(self._line_units), modbus, clock, listener), modbus.name
        # a single unit receives all requests, whatever their unit identifier
        only_address = self.units[0].address if len(self.units) == 1 else None
        gateway: Gateway[Client] = Gateway(
            self.device,
            lambda unit: unit if only_address is None else only_address,
            self._gateway_ns,
            timed=self._timed,
        )
        return GatewayServer(gateway, modbus, clock, listener), modbus.name

    def _with_faults(self, unit: Unit) -> FaultInjector:
        device = unit.device
        return FaultInjector(device, (lambda: device.turnaround_ns) if self._timed else lambda: 0)

    def _line(self) -> Device:
        """Return the units as one device: on a timed line, alone, or on a bus."""
        devices: Sequence[Device] = list(self._faulty.values())
        if self._is_direct:
            devices = [unit.device for unit in self._line_units]
        if self._timed:
            return TimedLine(*devices)
        return devices[0] if len(devices) == 1 else BusSegment(*devices)


def socket_address(text: str, option: str = "--tcp") -> tuple[str, int]:
    """Return the host and port; the default host is the loopback address.

    >>> socket_address("5020"), socket_address("0.0.0.0:502"), socket_address("[::1]:502")
    (('127.0.0.1', 5020), ('0.0.0.0', 502), ('::1', 502))

    Raises:
        ValueError: the text is not an address.
    """
    try:
        host, port = split_address(text)
    except ValueError as error:
        raise ValueError(f"{option} {error}") from error
    return host or LOOPBACK, port


def answering(units: list[Unit]) -> Callable[[int, bytes], bytes | None]:
    """Return a function that passes a Modbus request to its unit and returns the reply.

    A single unit answers every request, as through a gateway. If there are several units, the addressed unit
    answers. All units carry out a request to unit 0, and no unit answers it.
    """
    answers = {unit.address: unit.answer for unit in units if unit.answer is not None}
    if len(answers) == 1:
        [only_answer] = answers.values()
        return lambda _unit, pdu: only_answer(pdu)

    def pass_on(unit: int, pdu: bytes) -> bytes | None:
        """Pass a request to its unit, or a broadcast to all; return the reply, None if there is none."""
        if unit == BROADCAST:
            for answer in answers.values():
                answer(pdu)
            return None
        return answers[unit](pdu) if unit in answers else None

    return pass_on


def wire(units: Sequence[ServedUnit], text: str) -> None:
    """Set an input: `in1=ground`, or `2:home=..-3000` for the unit at address 2.

    Raises:
        ValueError: the unit, input or state is unknown.
    """
    name, equals, state = text.replace(" ", "").partition("=")
    address, colon, pin = name.rpartition(":")
    matching_units = [unit for unit in units if not colon or str(unit.address) == address]
    if not equals or not matching_units:
        raise ValueError(f"{text!r} does not set an input: must be NAME=STATE, or ADDRESS:NAME=STATE")
    matching_units[0].wire(pin, state)


def begin(units: list[Unit], *, ascii_mode: bool, start: bool) -> None:
    """Switch the units to AA ASCII, and start their programs, as SMC60WIN does.

    Raises:
        ValueError: a unit does not support this.
    """
    if not (ascii_mode or start):
        return
    for unit in units:
        if unit.do is None:
            raise ValueError("--ascii and --start: these options are only for the PCL601")
        if ascii_mode:
            unit.do(Code.SWITCH_TO_ASCII)
        if start and unit.status()["program"] != NO_PROGRAM:
            unit.do(Code.RUN_PROGRAM)
