"""Adapters on real ports: the same state machines as in simulation, run in real time.

    scan n                     scan n + 1                 scan n + 2
    |  words, received bytes     |                          |
    |  ------ request ------> threads ------ reply -------> |

Every scan advances the adapter to the wall clock. It reads the line once, before it counts time-outs, so a
late scan never counts a received reply as missing.
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
"""Longest wait, in s, for the motor to stop at the end of a run."""

READ_PERIOD_S = 0.002
"""Time, in s, between two reads of the line while the motor stops."""


class LiveAdapter(Adapter[Drive]):
    """An adapter on a real port."""

    def __init__(self, line: LiveLine, kind: AdapterKind[Drive], options: object, address: int) -> None:
        self._line = line
        self._clock = Clock()
        self._present_ns = 0
        super().__init__(LinkedController(Machine(), line), kind, options, address)

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to the wall clock's time; events are stamped with the scan's time, `now_ns`."""
        self._present_ns = self._clock.now_ns()
        for reason in self._line.take_losses():
            self._note(self._present_ns, "port lost", f"{reason}; the port is reopened when it is back")
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
        """Process the line until no stop or motion is left, for at most `STOP_S`."""
        end_ns = self._clock.now_ns() + round(STOP_S * 1e9)
        driver, is_moving = self.driver, True
        while is_moving and self._clock.now_ns() < end_ns:
            Signal().wait(READ_PERIOD_S)
            self.update(self._now_ns, Image())
            is_moving = driver.cut or driver.task is not None or bool(driver.tasks)

    @override
    def _words_due_ns(self) -> int:
        """Return the present, because after a late scan, the next scan may come before the next tick."""
        return self._now_ns

    @override
    def _wire_due_ns(self) -> int:
        return max(super()._wire_due_ns(), self._present_ns)


def open_adapter(kind: AdapterKind[Drive], port: str, address: int, options: Options) -> LiveAdapter[Drive]:
    """Return the adapter of a device at an address of a port: a serial device, or tcp:HOST:PORT.

    Raises:
        ValueError: an invalid option, or a port that can't be opened.
    """
    chosen_options = kind.options.of(options)
    connect = partial(kind.network, port) if kind.network else partial(open_port, port, kind.line_format)
    try:
        return LiveAdapter(LiveLine(connect), kind, chosen_options, address)
    except LinkError as error:
        raise ValueError(str(error)) from error
