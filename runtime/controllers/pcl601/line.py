"""The PCL601 on its line: bytes in, bytes out, Modbus RTU or AA ASCII.

    power-up, reset, |  ------->  Modbus RTU, 8E1  ------ code 11 ----->  AA ASCII, 8N1

In Modbus, a silence ends a frame, and then the reply follows. In ASCII a line ends with CR,
and the reply follows immediately.
"""

from __future__ import annotations

from scanrack.io_images.pcl601 import Register
from scanrack.io_images.site import SettingError

from ...line import pcl601_ascii, pcl601_frames
from ...line.rtu import Framer, Timing, frame
from ...line.wire import LineFormat
from .controller import Pcl601Controller, Protocol
from .direct import Direct
from .modbus import Modbus
from .motor import EncoderModel
from .program.machine import ProgramMachine
from .wiring import Wiring

FORMATS = {Protocol.MODBUS: pcl601_frames.LINE_FORMAT, Protocol.ASCII: pcl601_ascii.LINE_FORMAT}
"""Speed and character format of each protocol."""

BROADCAST = 0
WRITING = frozenset({0x05, 0x06, 0x0F, 0x10})
"""Functions that write; only these may be broadcast."""

_BIT_NS = 1_000_000_000 / pcl601_frames.LINE_FORMAT.baud
SERIAL_TIMING = Timing(gap_ns=round(3.5 * 11 * _BIT_NS), pause_ns=round(1.5 * 11 * _BIT_NS))
"""A silence of 3.5 t_char ends a frame; a pause of 1.5 t_char inside it is an error [Message Framing]."""


class Pcl601:
    """A simulated PCL601 (a `wire.Device`).

    Args:
        address: the saved address, 1 to 99 (0 to 99 with AA ASCII's `~`).
        wiring: SW2 and the thumbwheel.
        runner: the saved program, which does not start yet.
        timing: the silence that separates frames.

    Raises:
        ValueError: the address is invalid.
    """

    def __init__(
        self,
        address: int = 1,
        encoder: EncoderModel | None = None,
        wiring: Wiring | None = None,
        runner: ProgramMachine | None = None,
        timing: Timing = SERIAL_TIMING,
    ) -> None:
        if not 0 <= address <= 99:
            raise SettingError("address", f"address {address}: must be 0 to 99")
        self.controller = Pcl601Controller(encoder, wiring)
        self.controller.values[Register.ADDRESS] = address
        self.controller.runner = runner
        self._modbus = Modbus(self.controller)
        self._direct = Direct(self.controller)
        self._framer = Framer(timing)
        self._format = pcl601_frames.LINE_FORMAT
        self._output = bytearray()
        self._now_ns = 0

    @property
    def line_format(self) -> LineFormat:
        """The line format; the reply to the command that switches to ASCII still uses the Modbus format."""
        return self._format

    @property
    def _present_format(self) -> LineFormat:
        """The format of the current protocol."""
        is_ascii = self.controller.protocol is Protocol.ASCII  # faster than a look-up in `FORMATS`
        return pcl601_ascii.LINE_FORMAT if is_ascii else pcl601_frames.LINE_FORMAT

    @property
    def quiet_ns(self) -> int:
        """Silence required before a frame, ns."""
        return self._framer.gap_ns if self.controller.protocol is Protocol.MODBUS else 0

    @property
    def turnaround_ns(self) -> int:
        """Silence between a request and its reply, ns: 3.5 characters in Modbus, none in ASCII."""
        return SERIAL_TIMING.gap_ns if self._format is pcl601_frames.LINE_FORMAT else 0

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the next event on the line or in the controller."""
        if self._output:
            return self._now_ns
        wake_ns, deadline_ns = self.controller.next_wake_ns, self._framer.deadline_ns
        if wake_ns is None or deadline_ns is None:
            return deadline_ns if wake_ns is None else wake_ns
        return min(wake_ns, deadline_ns)

    def receive(self, now_ns: int, data: bytes) -> None:
        """Receive characters that arrive without gaps; the last one is complete at `now_ns`."""
        self._format = self._present_format
        self._now_ns = now_ns
        if self.controller.protocol is Protocol.ASCII:
            self._receive_ascii(now_ns, data)
            return
        start_ns = now_ns - self._format.span_ns(len(data))
        for request in self._framer.receive(start_ns, now_ns, data):
            self._carry_out(now_ns, request)

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the bytes to send at that instant."""
        self._format = self._present_format
        while (due_ns := self._framer.deadline_ns) is not None and due_ns <= now_ns:
            self.controller.advance(due_ns)
            for request in self._framer.silence():
                self._carry_out(due_ns, request)
        self.controller.advance(now_ns)
        self._now_ns = now_ns
        data = bytes(self._output) + self.controller.take_sent()
        self._output.clear()
        if not data:
            self._format = self._present_format
        return data

    def answer(self, pdu: bytes) -> bytes | None:
        """Return the reply to a request from Modbus TCP, or None in ASCII mode.

        Args:
            pdu: function code and data, at least one byte; it acts at the instant of the last `advance`.
        """
        if self.controller.protocol is Protocol.ASCII:
            return None
        reply = self._modbus.answer(pdu)
        if pdu[0] in WRITING:
            self.controller.settle(self._now_ns)
        return reply

    @property
    def motor_position(self) -> int:
        """Position of the motor, steps."""
        return self.controller.motor.position

    @property
    def motor_turns(self) -> bool:
        """Whether a motion is in progress."""
        return self.controller.axis.busy

    def power_cycle(self, now_ns: int) -> None:
        """Cycle the power, as the reset button does."""
        self.controller.power_up(now_ns)
        self._framer.clear()
        self._direct.clear()
        self._output.clear()
        self._format = self._present_format

    def _carry_out(self, now_ns: int, request: bytes) -> None:
        """Carry out a frame addressed to this device, or a broadcast write."""
        address, pdu = request[0], request[1:-2]
        own_address = self.controller.values[Register.ADDRESS]
        if address == BROADCAST:
            if pdu[0] in WRITING:
                self._modbus.answer(pdu)
        elif address == own_address:
            self._output += frame(own_address, self._modbus.answer(pdu))
        else:
            return
        if pdu[0] in WRITING:
            self.controller.settle(now_ns)
        if self.controller.protocol is Protocol.ASCII:
            self._framer.clear()
            self._direct.clear()

    def _receive_ascii(self, now_ns: int, data: bytes) -> None:
        """Pass characters to the ASCII mode; one of its commands switches back to Modbus."""
        for character in data:
            self._output += self._direct.receive(character)
            self.controller.settle(now_ns)
        if self.controller.protocol is Protocol.MODBUS:
            self._framer.clear()
