"""The serial line of a PMC006x3s: bytes and instants in, bytes out.

The device carries out a valid frame with its address when the last byte is complete, and replies with one
frame [4.1]. It ignores all other bytes. After the receive timeout it drops an incomplete frame, so that a
fragment does not corrupt the next frame.
"""

from __future__ import annotations

from scanrack.io_images.pmc006.frame import Framer, reply

from ...kinematics import FOREVER
from ...line.pmc006_frames import LINE_FORMAT
from .controller import Pmc006Controller

RECEIVE_TIMEOUT_NS = 50_000_000
"""Silence after which an incomplete frame is dropped (interpretation: the manual does not state it [4.1])."""


class Pmc006:
    """A PMC006x3s on its serial line (a `wire.Device`).

    Attributes:
        line_format: always 9,600 baud, 8N1.
    """

    line_format = LINE_FORMAT
    turnaround_ns = 0
    """The reply follows immediately, since the manual specifies no delay [4.1]."""

    def __init__(
        self, controller: Pmc006Controller | None = None, timeout_ns: int = RECEIVE_TIMEOUT_NS
    ) -> None:
        self.controller = controller or Pmc006Controller()
        self._framer = Framer()
        self._timeout_ns = timeout_ns
        self._latest_ns = 0
        self._replies = bytearray()

    @property
    def passed_over(self) -> int:
        """Number of received bytes outside frames."""
        return self._framer.skipped

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the next event; the current instant if a reply is waiting."""
        if self._replies:
            return self.controller.now_ns
        next_ns = self.controller.next_ns()
        return None if next_ns == FOREVER else next_ns

    def receive(self, now_ns: int, data: bytes) -> None:
        """Receive bytes; the last one is complete at `now_ns`."""
        self.controller.advance(now_ns)
        if now_ns - self._latest_ns > self._timeout_ns:
            self._framer.drop()
        self._latest_ns = now_ns
        for frame in self._framer.feed(data):
            if frame.second == self.controller.address:
                response = self.controller.execute(frame.third, frame.data)
                self._replies += reply(self.controller.address, response)

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the bytes to send."""
        self.controller.advance(now_ns)
        replies = bytes(self._replies)
        self._replies.clear()
        return replies

    @property
    def motor_position(self) -> int:
        """Physical position of the motor, steps."""
        return self.controller.axis.physical

    @property
    def motor_turns(self) -> bool:
        """Whether a motion is in progress."""
        return self.controller.axis.moving

    def power_cycle(self, now_ns: int) -> None:
        """Cycle the power; an incomplete frame or reply is lost."""
        self.controller.power_cycle()
        self._framer.drop()
        self._replies.clear()
