"""A PMC006x3s in the slot of a 3601."""

from __future__ import annotations

from collections.abc import Mapping

from ....controllers.pmc006.ramps import Pmc006Speeds
from ....loop.events import JsonValue
from ....machine import Machine
from ..module import Kit, SimulatedAdapter
from .axis import Pmc006Axis
from .driver import Pmc006Driver
from .options import Pmc006Options
from .simulated import UNIT, SimulatedPmc006


def kit(options: Pmc006Options, unit: int) -> Kit[Pmc006Speeds]:
    """Return driver and axis of a PMC006x3s with these options at an address."""
    return Kit(lambda: Pmc006Driver(options, unit), lambda driver: Pmc006Axis(driver, options))


class Pmc006Adapter(SimulatedAdapter[Pmc006Speeds]):
    """A PMC006x3s that acts as a 3601.

    Args:
        machine: of the simulated controller; by default a machine without switches.
        options: by name, see `options`.

    Raises:
        ValueError: an unknown option, an illegal value, or a machine that slips or jams.
    """

    controller: SimulatedPmc006

    def __init__(
        self, machine: Machine | None = None, options: Mapping[str, JsonValue] | None = None
    ) -> None:
        chosen = Pmc006Options.of(options)
        super().__init__(SimulatedPmc006(Machine() if machine is None else machine), kit(chosen, UNIT))
