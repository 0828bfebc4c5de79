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
    """The requested port; for a line, exactly one of the first three fields."""

    pty: bool = False
    serial: str | None = None
    tcp: str | None = None
    rtu_over_tcp: bool = False
    ethernet_ip: str | None = None
    io_port: int = 0


class LineService(Protocol):
    """The units that a port serves.

    Attributes:
        units: the units, in order of address.
    """

    units: Sequence[ServedUnit]

    @property
    def title(self) -> str:
        """A readable description of what is served."""

    def set_fault(self, text: str) -> None:
        """Set a fault of the line; raise ValueError if it is unknown."""

    def server(
        self, choice: PortChoice, clock: Clock, listener: LineListener | None = None
    ) -> tuple[Server, str]:
        """Open the requested port; return its server and the address for clients.

        Raises:
            ValueError: not exactly one port is requested, or it can't be opened.
        """


class ServedLine(LineService):
    """Units on a line.

    Args:
        controller: model name of the units.
        timed: whether characters take the time of the line's speed on every port.
        faulty: whether faults may be set; Modbus TCP then goes through a gateway, as with `timed`.
        gateway_ms: time from the end of a request on the line to the gateway's exception 0Bh, ms.

    Raises:
        ValueError: a time is unusable.
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
        self._plain = not (timed or faulty)
        self._gateway_ns = exact_ns(gateway_ms, "ms", "--gateway-ms")
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
        chosen = [
            faulty_unit for number, faulty_unit in self._faulty.items() if not colon or str(number) == address
        ]
        if not chosen:
            raise ValueError(f"{text!r} is no fault of a unit: must be FAULT, or ADDRESS:FAULT")
        for unit in chosen if not colon else chosen[:1]:
            unit.set(fault)

    @override
    def server(
        self, choice: PortChoice, clock: Clock, listener: LineListener | None = None
    ) -> tuple[Server, str]:
        if [choice.pty, choice.serial is not None, choice.tcp is not None].count(True) != 1:
            raise ValueError("give one of --pty, --serial DEVICE and --tcp HOST:PORT")
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
        if self._plain:
            return PduServer(self.device, answering(self._line_units), modbus, clock, listener), modbus.name
        only = self.units[0].address if len(self.units) == 1 else None
        gateway: Gateway[Client] = Gateway(
            self.device, lambda unit: unit if only is None else only, self._gateway_ns, timed=self._timed
        )
        return GatewayServer(gateway, modbus, clock, listener), modbus.name

    def _with_faults(self, unit: Unit) -> FaultInjector:
        device = unit.device
        return FaultInjector(device, (lambda: device.turnaround_ns) if self._timed else lambda: 0)

    def _line(self) -> Device:
        devices: Sequence[Device] = (
            [unit.device for unit in self._line_units] if self._plain else list(self._faulty.values())
        )
        if self._timed:
            return TimedLine(*devices)
        return devices[0] if len(devices) == 1 else BusSegment(*devices)


def socket_address(text: str, option: str = "--tcp") -> tuple[str, int]:
    """Return host and port; the default host is the loopback address.

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
    """Return a function that passes Modbus requests to their units.

    A single unit answers every request, like a gateway. Of several units, the addressed one answers. All
    units carry out a request to unit 0, and none answers it.
    """
    answers = {unit.address: unit.answer for unit in units if unit.answer is not None}
    if len(answers) == 1:
        [only] = answers.values()
        return lambda _unit, pdu: only(pdu)

    def pass_on(unit: int, pdu: bytes) -> bytes | None:
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
    chosen = [unit for unit in units if not colon or str(unit.address) == address]
    if not equals or not chosen:
        raise ValueError(f"{text!r} wires no input: must be NAME=STATE, or ADDRESS:NAME=STATE")
    chosen[0].wire(pin, state)


def begin(units: list[Unit], *, ascii_mode: bool, start: bool) -> None:
    """Apply the options before the units are served, as SMC60WIN does.

    Raises:
        ValueError: these units do not support an option.
    """
    for unit in units if ascii_mode or start else ():
        if unit.do is None:
            raise ValueError("--ascii and --start: only a PCL601 has them")
        if ascii_mode:
            unit.do(Code.SWITCH_TO_ASCII)
        if start and unit.status()["program"] != NO_PROGRAM:
            unit.do(Code.RUN_PROGRAM)
