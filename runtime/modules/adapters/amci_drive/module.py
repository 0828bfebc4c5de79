"""A networked drive in the slot of a 3601."""

from ..module import AdapterKind
from .capabilities import COMMAND_ROWS, CONFIGURATION_ROWS
from .drive_axis import DriveAxis
from .driver import LINE_FORMAT, AmciDriver
from .options import AmciDriveOptions
from .simulated import SimulatedDrive

AMCI_DRIVE = AdapterKind(
    AmciDriveOptions,
    LINE_FORMAT,
    AmciDriver,
    DriveAxis,
    SimulatedDrive,
    CONFIGURATION_ROWS,
    COMMAND_ROWS,
)
