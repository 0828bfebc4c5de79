"""A line on which frames get lost, doubled, delayed and damaged, as planned; and a master in virtual time."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import Enum, auto

from scanrack.runtime import Clock, Device, LineFormat, SerialBus
from scanrack.runtime.line.ports import LineServer, PtyPort

DELAY_NS = 260_000_000
"""Later than the clients wait, sooner than the silence that they keep afterwards."""


class Fault(Enum):
    """What becomes of a frame."""

    DROPPED = auto()
    DOUBLED = auto()
    DELAYED = auto()
    DAMAGED = auto()


def spoilt(frame: bytes, fault: Fault) -> bytes:
    """Return what arrives of a frame; a delayed one is left as it is."""
    if fault is Fault.DROPPED:
        return b""
    if fault is Fault.DOUBLED:
        return frame * 2
    if fault is Fault.DAMAGED:
        return frame[:3] + bytes((frame[3] ^ 0x10,)) + frame[4:]
    return frame


def dropped(first: int, count: int) -> dict[int, Fault]:
    """Return the plan by which so many frames are lost, from the `first` on, counted from 0."""
    return dict.fromkeys(range(first, first + count), Fault.DROPPED)


class FaultyDevice:
    """A device whose answers suffer.

    Args:
        inner: the device.
        plan: what becomes of which answer, counted from 0.
        delay_ns: of the delayed ones.
    """

    def __init__(self, inner: Device, plan: Mapping[int, Fault], delay_ns: int = DELAY_NS) -> None:
        self.inner = inner
        self.answers = 0
        self._plan = plan
        self._delay_ns = delay_ns
        self._held: list[tuple[int, bytes]] = []

    @property
    def line_format(self) -> LineFormat:
        return self.inner.line_format

    @property
    def next_wake_ns(self) -> int | None:
        times = [due_ns for due_ns, _ in self._held]
        if (wake_ns := self.inner.next_wake_ns) is not None:
            times.append(wake_ns)
        return min(times, default=None)

    def receive(self, now_ns: int, data: bytes) -> None:
        self.inner.receive(now_ns, data)

    def advance(self, now_ns: int) -> bytes:
        if answer := self.inner.advance(now_ns):
            delay_ns, sent = self.fate(answer)
            self.answers += 1
            self._held.append((now_ns + delay_ns, sent))
        said = b"".join(frame for due_ns, frame in self._held if due_ns <= now_ns)
        self._held = [(due_ns, frame) for due_ns, frame in self._held if due_ns > now_ns]
        return said

    def fate(self, answer: bytes) -> tuple[int, bytes]:
        """Return the delay of the next answer, ns, and what arrives of it."""
        fault = self._plan.get(self.answers)
        delay_ns = self._delay_ns if fault is Fault.DELAYED else 0
        return delay_ns, answer if fault is None else spoilt(answer, fault)


class BusLink:
    """The master's side of a bus in virtual time.

    Args:
        device: what is on the bus.
        plan: what becomes of which question, counted from 0.
    """

    def __init__(self, device: Device, plan: Mapping[int, Fault] | None = None) -> None:
        self.bus = SerialBus(device)
        self.questions: list[bytes] = []
        self._plan = plan or {}

    def send(self, data: bytes) -> None:
        fault = self._plan.get(len(self.questions))
        self.questions.append(data)
        sent = data if fault is None else spoilt(data, fault)
        self.bus.run_until(self.bus.send(sent, self.bus.devices[0].line_format))

    def receive(self, count: int, seconds: float) -> bytes:
        end_ns = self.bus.now_ns + round(seconds * 1e9)
        while len(self.bus.heard) < count and self.bus.now_ns < end_ns:
            due_ns = self.bus.next_event_ns()
            self.bus.run_until(end_ns if due_ns is None else min(due_ns, end_ns))
        data = bytes(self.bus.heard[:count])
        del self.bus.heard[:count]
        return data

    def follow(self, line_format: LineFormat) -> None:
        """The format is the device's."""

    def pause(self, seconds: float) -> None:
        self.bus.run_until(self.bus.now_ns + round(seconds * 1e9))

    def close(self) -> None:
        """Nothing is held."""


@contextmanager
def served_on_pty(device: Device, speed: float = 1.0) -> Iterator[str]:
    """Serve a device at a pseudo-terminal from another thread; yield its path."""
    server = LineServer(device, port := PtyPort(), Clock(speed))
    ended = threading.Event()

    def serve() -> None:
        while not ended.is_set():
            server.step(0.01)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield port.name
    finally:
        ended.set()
        thread.join()
        server.close()
