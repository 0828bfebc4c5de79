"""Ports: real ends of a simulated controller's serial line, on this machine or on its network.

A port moves bytes and knows no device, a device knows no port; the loop in `server` connects
them. Sockets are bound to the loopback address unless set otherwise.
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
