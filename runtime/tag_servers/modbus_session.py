"""A TCP connection of a Modbus client: frames in, replies out, no sockets. Any unit number is answered."""

from __future__ import annotations

from ..line.ports.modbustcp import HEADER, NotModbusError, reply_frame, split_frames
from .register_map import RegisterMap
from .tag_snapshot import BrokenClientError, Plan, TagSnapshot


class ModbusSession:
    """What a client has sent.

    Attributes:
        pending: bytes of a frame that is not whole.
    """

    def __init__(self, router: RegisterMap) -> None:
        self.router = router
        self.pending = b""

    def receive(self, data: bytes) -> list[bytes]:
        """Take bytes; return the frames that are whole.

        Raises:
            BrokenClientError: they are not Modbus TCP.
        """
        try:
            frames, self.pending = split_frames(self.pending + data)
        except NotModbusError as error:
            raise BrokenClientError(str(error)) from error
        return frames

    def plan(self, packet: bytes, version: int) -> Plan:
        """Return what a request needs; nothing changes."""
        plan = Plan(version)
        self.router.answer(packet[HEADER.size :], plan)
        return plan

    def reply(self, packet: bytes, snapshot: TagSnapshot) -> bytes:
        """Answer a request."""
        return reply_frame(packet, self.router.answer(packet[HEADER.size :], snapshot))
