"""A PCL601 in the slot of a 3601."""

from ....line.pcl601_frames import LINE_FORMAT
from ..module import AdapterKind
from .driver import Pcl601Driver
from .pcl601_axis import Pcl601Axis
from .pcl601_capabilities import Pcl601Capabilities
from .pcl601_options import Pcl601Options
from .simulated import SimulatedPcl601

PCL601 = AdapterKind(
    Pcl601Options,
    LINE_FORMAT,
    Pcl601Driver,
    Pcl601Axis,
    SimulatedPcl601,
    Pcl601Capabilities,
)
