"""A Modbus client's TCP connection, with frames in and replies out; any unit number is valid."""

from __future__ import annotations

from typing import NamedTuple

from pymodbus.pdu import ModbusPDU

from ..line.modbus_pdus import encoded
from ..line.ports.modbustcp import HEADER, NotModbusError, reply_frame, split_frames
from .register_map import RegisterMap, decoded
from .tag_snapshot import BrokenClientError, Plan, TagSnapshot


class ModbusPacket(NamedTuple):
    """A frame and its decoded request."""

    frame: bytes
    request: ModbusPDU


class ModbusSession:
    """The state of a client's connection.

    Attributes:
        pending: bytes of an incomplete frame.
    """

    def __init__(self, router: RegisterMap) -> None:
        self.router = router
        self.pending = b""

    def receive(self, data: bytes) -> list[ModbusPacket]:
        """Receive bytes; return the complete requests.

        Raises:
            BrokenClientError: the bytes are not Modbus TCP.
        """
        try:
            frames, self.pending = split_frames(self.pending + data)
        except NotModbusError as error:
            raise BrokenClientError(str(error)) from error
        return [ModbusPacket(frame, decoded(frame[HEADER.size :])) for frame in frames]

    def plan(self, packet: ModbusPacket, version: int) -> Plan:
        """Return the operations of a request, without any effect."""
        plan = Plan(version)
        self.router.answer(packet.request, plan)
        return plan

    def reply(self, packet: ModbusPacket, snapshot: TagSnapshot) -> bytes:
        """Answer a request."""
        return reply_frame(packet.frame, encoded(self.router.answer(packet.request, snapshot)))
