"""Adapters on real ports: the same state machines, in step with the wall clock.

    scan n                     scan n + 1                 scan n + 2
    |  words, received bytes     |                          |
    |  ------ request ------> threads ------ reply -------> |

At every scan the adapter's time is the wall clock's. A late scan reads the received
replies before it counts time-outs, so that no received reply counts as missing. A line is
read once a scan.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from threading import Event as Signal

from scanrack.io_images.image import Image
from typing_extensions import override

from ...line.clients.link import LinkError
from ...line.liveport import LiveLine, open_port
from ...loop.pace import Clock
from ...machine import Machine
from ..record import Options
from .module import Adapter, AdapterKind
from .plant import LinkedController
from .task import Drive

STOP_S = 0.5
"""Longest wait for the motor to stop at the end of a run."""

LOOK_S = 0.002
"""Time between two reads of the line during that wait."""


class LiveAdapter(Adapter[Drive]):
    """An adapter on a real port."""

    def __init__(self, line: LiveLine, kind: AdapterKind[Drive], options: object, address: int) -> None:
        self._line = line
        self._clock = Clock()
        self._present_ns = 0
        super().__init__(LinkedController(Machine(), line), kind, options, address)

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to the present on the wall clock; events have the scan's time, `now_ns`."""
        self._present_ns = self._clock.now_ns()
        for reason in self._line.take_losses():
            self._note(self._present_ns, "port lost", f"{reason}; the port is opened again when it is back")
        image = super().update(self._present_ns, outputs)
        self.events[:] = [replace(event, at_ns=min(event.at_ns, now_ns)) for event in self.events]
        return image

    def close(self) -> None:
        """Stop the motor if possible, as a PLC does on leaving run mode, and close the port."""
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
    def _words_due_ns(self) -> int:
        """Return the present: two scans may be closer together than two ticks, if the first is late."""
        return self._now_ns

    @override
    def _wire_due_ns(self) -> int:
        return max(super()._wire_due_ns(), self._present_ns)


def open_adapter(kind: AdapterKind[Drive], port: str, address: int, options: Options) -> LiveAdapter[Drive]:
    """Open a port, a serial device or tcp:HOST:PORT, with the adapter of a controller at an address.

    Raises:
        ValueError: an illegal option, or a port that can't be opened.
    """
    chosen_options = kind.options.of(options)
    try:
        opened = (
            partial(open_port, port, kind.line_format)
            if kind.network is None
            else partial(kind.network, port)
        )
        return LiveAdapter(LiveLine(opened), kind, chosen_options, address)
    except LinkError as error:
        raise ValueError(str(error)) from error
