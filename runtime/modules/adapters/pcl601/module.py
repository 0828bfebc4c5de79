"""A PCL601 in the slot of a 3601."""

from __future__ import annotations

from collections.abc import Mapping

from ....loop.events import JsonValue
from ....machine import Machine
from ..module import Kit, SimulatedAdapter
from .axis import Pcl601Axis
from .driver import Pcl601Driver
from .options import Pcl601Options
from .simulated import SimulatedPcl601
from .units import Drive

UNIT = 1


def kit(options: Pcl601Options, unit: int) -> Kit[Drive]:
    """Return driver and axis of a PCL601 with these options at an address."""
    return Kit(lambda: Pcl601Driver(options, unit), lambda driver: Pcl601Axis(driver, options))


class Pcl601Adapter(SimulatedAdapter[Drive]):
    """A PCL601 that acts as a 3601.

    Args:
        machine: of the simulated controller; by default a machine without switches.
        options: by name, see `options`.

    Raises:
        ValueError: an unknown option, an illegal value, or a machine that slips or jams.
    """

    controller: SimulatedPcl601

    def __init__(
        self, machine: Machine | None = None, options: Mapping[str, JsonValue] | None = None
    ) -> None:
        chosen = Pcl601Options.of(options)
        super().__init__(
            SimulatedPcl601(Machine() if machine is None else machine, chosen), kit(chosen, UNIT)
        )
