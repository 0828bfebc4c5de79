"""A PCL601 in the slot of a 3601."""

from __future__ import annotations

from collections.abc import Mapping

from typing_extensions import override

from ....loop.events import JsonValue
from ....machine import Machine
from ..module import SimulatedAdapter
from .axis import Pcl601Axis
from .driver import Pcl601Driver
from .options import Pcl601Options
from .simulated import SimulatedPcl601
from .units import Drive


class Pcl601Adapter(SimulatedAdapter[Drive]):
    """A PCL601 that answers as a 3601.

    Args:
        machine: what is bolted to the simulated controller; by default a machine without switches.
        options: by name, see `options`.

    Raises:
        ValueError: an unknown option, a value that is not allowed, or a machine that slips or jams.
    """

    controller: SimulatedPcl601
    driver: Pcl601Driver

    def __init__(
        self, machine: Machine | None = None, options: Mapping[str, JsonValue] | None = None
    ) -> None:
        self.options = Pcl601Options.of(options)
        super().__init__(SimulatedPcl601(Machine() if machine is None else machine, self.options))

    @override
    def new_driver(self) -> Pcl601Driver:
        return Pcl601Driver(self.options)

    @override
    def new_axis(self) -> Pcl601Axis:
        return Pcl601Axis(self.driver, self.options)
