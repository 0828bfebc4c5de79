"""A networked drive in the slot of a 3601."""

from scanrack.io_images.site import SettingError

from ....line.clients.link import Link
from ....line.hosts import split_address
from ....line.liveport import TCP, check_address
from ..module import AdapterKind
from .amci_drive_capabilities import AmciDriveCapabilities
from .amci_drive_options import AmciDriveOptions
from .drive_axis import DriveAxis
from .driver import LINE_FORMAT, AmciDriver
from .simulated import SimulatedDrive

RESPONSE_S = 0.1
"""Longest wait for a response, in s; the same as the adapter's."""


def open_network(port: str) -> Link:
    """Connect to a drive at tcp:HOST:PORT.

    Raises:
        ValueError: the port is not tcp:HOST:PORT.
        LinkError: the connection fails.
    """
    from ....line.clients.modbus_tcp import ModbusTcpLink

    check_address(port)
    if not port.startswith(TCP):
        raise SettingError("port", f"port {port}: must be tcp:HOST:PORT, since a drive uses Modbus TCP")
    return ModbusTcpLink(*split_address(port.removeprefix(TCP)), RESPONSE_S)


AMCI_DRIVE = AdapterKind(
    AmciDriveOptions,
    LINE_FORMAT,
    AmciDriver,
    DriveAxis,
    SimulatedDrive,
    AmciDriveCapabilities,
    open_network,
)
