"""A PMC006x3s in the slot of a 3601."""

from __future__ import annotations

from collections.abc import Mapping

from typing_extensions import override

from ....controllers.pmc006.ramps import Speeds
from ....loop.events import JsonValue
from ....machine import Machine
from ..module import SimulatedAdapter
from .axis import Pmc006Axis
from .driver import Pmc006Driver
from .options import Pmc006Options
from .simulated import UNIT, SimulatedPmc006


class Pmc006Adapter(SimulatedAdapter[Speeds]):
    """A PMC006x3s that answers as a 3601.

    Args:
        machine: what is bolted to the simulated controller; by default a machine without switches.
        options: by name, see `options`.

    Raises:
        ValueError: an unknown option, a value that is not allowed, or a machine that slips or jams.
    """

    controller: SimulatedPmc006
    driver: Pmc006Driver

    def __init__(
        self, machine: Machine | None = None, options: Mapping[str, JsonValue] | None = None
    ) -> None:
        self.options = Pmc006Options.of(options)
        super().__init__(SimulatedPmc006(Machine() if machine is None else machine))

    @override
    def new_driver(self) -> Pmc006Driver:
        return Pmc006Driver(self.options, UNIT)

    @override
    def new_axis(self) -> Pmc006Axis:
        return Pmc006Axis(self.driver, self.options)
