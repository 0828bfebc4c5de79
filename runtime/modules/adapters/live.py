"""Adapters on real ports: the same state machines, in step with the wall clock.

    scan n                     scan n + 1                 scan n + 2
    |  words, what was received  |                          |
    |  ------ request ------> threads ------ reply -------> |

At every scan the adapter's time is the wall clock's. A late scan reads the received
replies before it counts time-outs, so no reply that has come counts as missing. A line is
read once a scan.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from threading import Event as Signal

from typing_extensions import override

from ....io_images.amci3601 import Configuration
from ....io_images.image import Image
from ...controllers.pmc006.ramps import Speeds
from ...line.clients.link import LinkError
from ...line.liveport import LiveLine, open_port
from ...line.wire import LineFormat
from ...loop.events import JsonValue
from ...loop.pace import Clock
from ...machine import Machine
from .module import Adapter
from .pcl601.axis import Pcl601Axis
from .pcl601.driver import LINE_FORMAT as PCL601_FORMAT
from .pcl601.driver import Pcl601Driver
from .pcl601.options import Pcl601Options
from .pcl601.units import Drive as Pcl601Drive
from .plant import LinkedController
from .pmc006.axis import Pmc006Axis
from .pmc006.driver import LINE_FORMAT as PMC006_FORMAT
from .pmc006.driver import Pmc006Driver
from .pmc006.options import Pmc006Options
from .task import Drive

STOP_S = 0.5
"""How long the end of a run waits for the motor to stop."""

LOOK_S = 0.002
"""Time between two reads of the line then."""


class RealController(LinkedController):
    """A controller at the end of a real line; its machine is a real one, too.

    Args:
        line: to it.
    """

    def __init__(self, line: LiveLine) -> None:
        self._machine = Machine()
        self._line = line

    @property
    @override
    def machine(self) -> Machine:
        return self._machine

    @property
    @override
    def line(self) -> LiveLine:
        return self._line

    @override
    def next_event_ns(self, now_ns: int) -> int | None:
        """Return the present if bytes were received (`LiveLine.next_event_ns`)."""
        return self.line.next_event_ns()

    @override
    def run_until(self, now_ns: int) -> None:
        """Do nothing: a real controller's time runs by itself."""

    @override
    def sense(self, now_ns: int) -> None:
        """Do nothing: the driver reads real inputs."""

    @override
    def rewire(self, now_ns: int, configuration: Configuration) -> None:
        """Do nothing: a real controller is wired."""

    @override
    def power_cycle(self, now_ns: int) -> None:
        """Do nothing: the power is out of reach; only the adapter forgets."""


class LiveAdapter(Adapter[Drive]):
    """An adapter on a real port.

    Args:
        line: to the controller.
    """

    def __init__(self, line: LiveLine) -> None:
        self._line = line
        self._clock = Clock()
        self._present_ns = 0
        super().__init__(RealController(line))

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to the present on the wall clock; events carry `now_ns`, the scan's time."""
        self._present_ns = self._clock.now_ns()
        for reason in self._line.take_losses():
            self._note(self._present_ns, "port lost", f"{reason}; the port is opened again when it is back")
        image = super().update(self._present_ns, outputs)
        self.events[:] = [replace(event, at_ns=min(event.at_ns, now_ns)) for event in self.events]
        return image

    def close(self) -> None:
        """Stop the motor as when the PLC leaves run mode, if possible, and close the port."""
        try:
            self.plc_run(False)
            self._wait_for_standstill()
        finally:
            self._line.close()

    def _wait_for_standstill(self) -> None:
        end_ns = self._clock.now_ns() + round(STOP_S * 1e9)
        driver, moves = self.driver, True
        while moves and self._clock.now_ns() < end_ns:
            Signal().wait(LOOK_S)
            self.update(self._now_ns, Image())
            moves = driver.cut or driver.task is not None or bool(driver.tasks)

    @override
    def _wire_due_ns(self) -> int:
        return max(super()._wire_due_ns(), self._present_ns)


class LivePcl601(LiveAdapter[Pcl601Drive]):
    """A PCL601 on a real port that answers as a 3601.

    Args:
        line: to it.
        options: by name.
        unit: its address.
    """

    driver: Pcl601Driver

    def __init__(self, line: LiveLine, options: Pcl601Options, unit: int) -> None:
        self._options, self._unit = options, unit
        super().__init__(line)

    @override
    def new_driver(self) -> Pcl601Driver:
        return Pcl601Driver(self._options, self._unit)

    @override
    def new_axis(self) -> Pcl601Axis:
        return Pcl601Axis(self.driver, self._options)


class LivePmc006(LiveAdapter[Speeds]):
    """A PMC006x3s on a real port that answers as a 3601.

    Args:
        line: to it.
        options: by name.
        unit: its address.
    """

    driver: Pmc006Driver

    def __init__(self, line: LiveLine, options: Pmc006Options, unit: int) -> None:
        self._options, self._unit = options, unit
        super().__init__(line)

    @override
    def new_driver(self) -> Pmc006Driver:
        return Pmc006Driver(self._options, self._unit)

    @override
    def new_axis(self) -> Pmc006Axis:
        return Pmc006Axis(self.driver, self._options)


def open_pcl601(port: str, unit: int, options: Mapping[str, JsonValue]) -> LivePcl601:
    """Open a port and put a PCL601's adapter on it.

    Args:
        port: serial device, or tcp:HOST:PORT.
        unit: address of the controller.
        options: by name.

    Raises:
        ValueError: an option, or a port that can't be opened.
    """
    chosen = Pcl601Options.of(options)
    return LivePcl601(_live_line(port, PCL601_FORMAT), chosen, unit)


def open_pmc006(port: str, unit: int, options: Mapping[str, JsonValue]) -> LivePmc006:
    """Open a port and put a PMC006's adapter on it; arguments as for `open_pcl601`."""
    chosen = Pmc006Options.of(options)
    return LivePmc006(_live_line(port, PMC006_FORMAT), chosen, unit)


def _live_line(port: str, line_format: LineFormat) -> LiveLine:
    try:
        return LiveLine(partial(open_port, port, line_format))
    except LinkError as error:
        raise ValueError(str(error)) from error
