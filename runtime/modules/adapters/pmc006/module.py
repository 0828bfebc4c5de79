"""A PMC006x3s in the slot of a 3601."""

from ....line.pmc006_frames import LINE_FORMAT
from ..module import AdapterKind
from .driver import Pmc006Driver
from .pmc006_axis import Pmc006Axis
from .pmc006_capabilities import Pmc006Capabilities
from .pmc006_options import Pmc006Options
from .simulated import SimulatedPmc006

PMC006 = AdapterKind(
    Pmc006Options,
    LINE_FORMAT,
    Pmc006Driver,
    Pmc006Axis,
    lambda machine, _options: SimulatedPmc006(machine),
    Pmc006Capabilities,
)
