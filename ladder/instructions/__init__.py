"""The instruction set: one file per family, one row per instruction.

A row is a `Spec`: the name, the operands, and the functions that check, execute and compile the instruction.
The parser, Python front end, back ends, debugger and drawings read it. A new family must only be added to
`FAMILIES`. Names are those of the Logix 5000 general instructions manual.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..model.spec import Spec
from . import (
    arrays,
    assertion,
    bits,
    blocks,
    compare,
    compute,
    control,
    decimal,
    diagnostics,
    files,
    move,
    sequencers,
    shifts,
    strings,
    timing,
    trigonometry,
)
from .motion import motion
from .process import (
    alarms,
    devices,
    drives,
    enhanced_pid,
    filters,
    measuring,
    process,
    pulses,
    ramp_soak,
    regulation,
    safety,
)
from .system import immediate, messages, phases, ports, sfc, system

FAMILIES = (
    bits,
    timing,
    compare,
    compute,
    move,
    files,
    arrays,
    shifts,
    sequencers,
    control,
    sfc,
    trigonometry,
    strings,
    blocks,
    regulation,
    filters,
    measuring,
    devices,
    drives,
    pulses,
    ramp_soak,
    enhanced_pid,
    system,
    messages,
    process,
    alarms,
    diagnostics,
    decimal,
    immediate,
    ports,
    phases,
    safety,
    motion,
    assertion,
)
"""The family files, in the manual's order."""

SPECS = tuple(each for family in FAMILIES for each in vars(family).values() if isinstance(each, Spec))
"""All instructions, in the manual's order."""

BY_NAME = {name: spec for spec in SPECS for name in (spec.name, spec.other) if name}
"""Instructions by either name, in capitals."""

NAMES = tuple(spec.name for spec in SPECS)
"""Names for `from .instructions import *`."""

if TYPE_CHECKING:
    from .arrays import *  # noqa: F403
    from .assertion import *  # noqa: F403
    from .bits import *  # noqa: F403
    from .blocks import *  # noqa: F403
    from .compare import *  # noqa: F403
    from .compute import *  # noqa: F403
    from .control import *  # noqa: F403
    from .decimal import *  # noqa: F403
    from .diagnostics import *  # noqa: F403
    from .files import *  # noqa: F403
    from .motion.motion import *  # noqa: F403
    from .move import *  # noqa: F403
    from .process.alarms import *  # noqa: F403
    from .process.devices import *  # noqa: F403
    from .process.drives import *  # noqa: F403
    from .process.enhanced_pid import *  # noqa: F403
    from .process.filters import *  # noqa: F403
    from .process.measuring import *  # noqa: F403
    from .process.process import *  # noqa: F403
    from .process.pulses import *  # noqa: F403
    from .process.ramp_soak import *  # noqa: F403
    from .process.regulation import *  # noqa: F403
    from .process.safety import *  # noqa: F403
    from .sequencers import *  # noqa: F403
    from .shifts import *  # noqa: F403
    from .strings import *  # noqa: F403
    from .system.immediate import *  # noqa: F403
    from .system.messages import *  # noqa: F403
    from .system.phases import *  # noqa: F403
    from .system.ports import *  # noqa: F403
    from .system.sfc import *  # noqa: F403
    from .system.system import *  # noqa: F403
    from .timing import *  # noqa: F403
    from .trigonometry import *  # noqa: F403
else:
    globals().update({spec.name: spec for spec in SPECS})
    __all__ = NAMES
