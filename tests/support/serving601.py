"""PCL601s served in a thread, for clients that others wrote; the clock runs fast, so that moves are short."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import Any

from scanrack.jobs.run.served_units import Unit, pcl601_units
from scanrack.jobs.serve.line import PortChoice, ServedLine
from scanrack.runtime import Clock, Contact
from scanrack.runtime.line.ports import Server, Stop, serve_until_interrupted


class Serving:
    """A server in a thread of its own.

    Attributes:
        place: where it is found: a path, or host:port.
        units: the controllers; touch them by `call` only.
    """

    def __init__(self, server: Server, place: str, units: list[Unit]) -> None:
        self.place, self.units = place, units
        self._stop = Stop()
        self._calls: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._thread = Thread(target=serve_until_interrupted, args=(server, self._each_step, self._stop))

    @property
    def port(self) -> int:
        return int(self.place.split(":")[1])

    def call(self, action: Callable[[], Any]) -> Any:
        """Do something between two steps of the server; return what it returns."""
        results: list[Any] = []
        done = Event()

        def act() -> None:
            results.append(action())
            done.set()

        self._calls.put(act)
        assert done.wait(120)
        return results[0]

    def connect(self, **contacts: Contact) -> None:
        """Wire contacts to inputs of the first unit."""
        controller: Any = self.units[0].device.controller  # type: ignore[attr-defined]

        def wire() -> None:
            for name, contact in contacts.items():
                controller.pins.connect(name, contact)
            controller.settle(controller.now_ns)

        self.call(wire)

    def _each_step(self) -> None:
        try:
            self._calls.get_nowait()()
        except Empty:
            return

    def run(self) -> Iterator[Serving]:
        self._thread.start()
        try:
            yield self
        finally:
            self._stop.request()
            self._thread.join(120)
            assert not self._thread.is_alive()


@contextmanager
def serving(*addresses: int, speed: float = 1.0, **port: Any) -> Iterator[Serving]:
    """Serve PCL601s.

    Args:
        addresses: of the units; 1 if there is none.
        speed: how many times as fast as real time.
        port: as for `PortChoice`.
    """
    units = pcl601_units(list(addresses), [], speed)
    server, place = ServedLine(units).server(PortChoice(**port), Clock(speed))
    yield from Serving(server, place, units).run()
