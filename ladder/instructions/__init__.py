"""The instruction set: one file per family, one row per instruction.

A row is a `Spec`: the name, the operands, and the functions that check, execute and compile the instruction.
The parser, Python front end, back ends, debugger and drawings read it. To add a family, add its name to
`_FILES` and, for type checkers, an import. Names are those of the Logix 5000 general instructions manual.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from ..model.spec import Spec

_FILES = (
    "bits timing compare compute move files arrays shifts sequencers control system.sfc trigonometry "
    "strings blocks process.regulation process.filters process.measuring process.devices process.drives "
    "process.pulses process.ramp_soak process.enhanced_pid system.system system.messages process.process "
    "process.alarms diagnostics decimal system.immediate system.ports system.phases process.safety "
    "motion.motion assertion"
)

FAMILIES = tuple(import_module(f"{__name__}.{name}") for name in _FILES.split())
"""The family files, in the manual's order."""

SPECS = tuple(row for family in FAMILIES for row in vars(family).values() if isinstance(row, Spec))
"""All instructions, in the manual's order."""

BY_NAME = {name: spec for spec in SPECS for name in (spec.name, spec.other) if name}
"""Instructions by either of their names, in uppercase."""

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
