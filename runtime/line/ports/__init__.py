"""Ports: real ends of a simulated device's serial line, on this machine or its network.

Ports and devices are independent; the loop in `server` connects them. By default, sockets are bound to the
loopback address.
"""

from __future__ import annotations

from .modbustcp import ModbusTcpPort
from .port import Port, PortError, Traffic
from .pty import PtyPort
from .rawtcp import RawTcpPort
from .segment import BusSegment
from .serialdevice import SerialPort
from .server import (
    LONGEST_S,
    Client,
    GatewayServer,
    LineListener,
    LineServer,
    PduServer,
    Server,
    Stop,
    serve_until_interrupted,
)

__all__ = [
    "LONGEST_S",
    "BusSegment",
    "Client",
    "GatewayServer",
    "LineListener",
    "LineServer",
    "ModbusTcpPort",
    "PduServer",
    "Port",
    "PortError",
    "PtyPort",
    "RawTcpPort",
    "SerialPort",
    "Server",
    "Stop",
    "Traffic",
    "serve_until_interrupted",
]
