"""The serial line of a PMC006x3s: bytes and instants in, bytes out.

The controller carries out a valid frame to its own address when its last byte is
complete, and answers with one frame [4.1]; it ignores everything else. At the
receive time-out after its latest byte it drops an incomplete frame, so that a
fragment cannot swallow the start of the next frame.
"""

from __future__ import annotations

from scanrack.io_images.pmc006.frame import Framer, reply

from ...kinematics import FOREVER
from ...line.pmc006_frames import LINE_FORMAT
from .controller import Pmc006Controller

RECEIVE_TIMEOUT_NS = 50_000_000
"""Silence after which an unfinished frame is dropped (reading: the manual gives no figure [4.1])."""


class Pmc006:
    """A controller on its serial line, as `wire.Device`.

    Attributes:
        line_format: 9,600 baud, 8N1, fixed.
    """

    line_format = LINE_FORMAT
    turnaround_ns = 0
    """It answers at once: the manual gives no time [4.1]."""

    def __init__(
        self, controller: Pmc006Controller | None = None, timeout_ns: int = RECEIVE_TIMEOUT_NS
    ) -> None:
        self.controller = controller or Pmc006Controller()
        self._framer = Framer()
        self._timeout_ns = timeout_ns
        self._latest_ns = 0
        self._answers = bytearray()

    @property
    def passed_over(self) -> int:
        """Bytes received so far outside any frame."""
        return self._framer.skipped

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the next event; the present if an answer waits."""
        if self._answers:
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
                answer = self.controller.execute(frame.third, frame.data)
                self._answers += reply(self.controller.address, answer)

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the answers that go onto the line."""
        self.controller.advance(now_ns)
        answers = bytes(self._answers)
        self._answers.clear()
        return answers

    @property
    def motor_position(self) -> int:
        """Physical position of the motor, steps."""
        return self.controller.axis.physical

    @property
    def motor_turns(self) -> bool:
        """Whether a motion is under way."""
        return self.controller.axis.moving

    def power_cycle(self, now_ns: int) -> None:
        """Cycle the power: an incomplete frame or answer is lost."""
        self.controller.power_cycle()
        self._framer.drop()
        self._answers.clear()
