"""Numeric codes of the EtherNet/IP protocol."""

from __future__ import annotations

from collections.abc import Mapping

TYPE_CODES: Mapping[str, int] = {
    "BOOL": 0xC1,
    "SINT": 0xC2,
    "INT": 0xC3,
    "DINT": 0xC4,
    "LINT": 0xC5,
    "USINT": 0xC6,
    "UINT": 0xC7,
    "UDINT": 0xC8,
    "ULINT": 0xC9,
    "REAL": 0xCA,
    "LREAL": 0xCB,
    "DWORD": 0xD3,
}
"""Codes of elementary types [1756-PM020, CIP data types]."""

STRUCTURED = 0x02A0
"""Type of a structure in a message; its template's handle follows."""

# General statuses of a reply
DONE, NO_CONNECTION, BAD_SEGMENT, UNKNOWN_OBJECT, PARTIAL, NO_SERVICE = 0, 1, 4, 5, 6, 8
BAD_VALUE, SOME_ATTRIBUTES, NOT_SETTABLE, NO_PRIVILEGE = 0x09, 0x0A, 0x0E, 0x0F
TOO_LARGE, TOO_SHORT, NO_ATTRIBUTE, TOO_MUCH, GENERAL = 0x11, 0x13, 0x14, 0x15, 0xFF

# Extended statuses
OFFSET_BEYOND, BEYOND, OTHER_TYPE = 0x2104, 0x2105, 0x2107
IN_USE, NOT_FOUND, BAD_SIZE, NO_PLACES, NO_SLOT, NO_TARGET = 0x0100, 0x0107, 0x0109, 0x0113, 0x0312, 0x0315
TRANSPORT, NOT_OWNER, BAD_RPI, OTHER_PRODUCT, OTHER_DEVICE, OTHER_REVISION = (
    0x0103,
    0x0106,
    0x0111,
    0x0114,
    0x0115,
    0x0116,
)
CONFIGURATION_SIZE, TO_TARGET_SIZE, TO_ORIGINATOR_SIZE, CONFIGURATION_PATH = 0x0126, 0x0127, 0x0128, 0x0129
CONSUMED_PATH, PRODUCED_PATH, TO_TARGET_TYPE, TO_ORIGINATOR_TYPE = 0x012A, 0x012B, 0x0123, 0x0124

# Statuses of the encapsulation
BAD_COMMAND, BAD_DATA, BAD_SESSION, BAD_LENGTH, BAD_REVISION = 1, 3, 0x64, 0x65, 0x69

# Commands of the encapsulation
NOP, LIST_SERVICES, LIST_IDENTITY, LIST_INTERFACES = 0, 4, 0x63, 0x64
REGISTER, UNREGISTER, SEND, SEND_CONNECTED = 0x65, 0x66, 0x6F, 0x70

# Classes of objects
IDENTITY, ROUTER, MANAGER, SYMBOL, TEMPLATE = 1, 2, 6, 0x6B, 0x6C
ASSEMBLY = 4
PROGRAM_NAME, PCCC, CLOCK, CHANGES = 0x64, 0x67, 0x8B, 0xAC
TCP_IP_INTERFACE, ETHERNET_LINK = 0xF5, 0xF6

# Services
GET_ALL, GET_LIST, BATCH, GET_ONE = 1, 3, 0x0A, 0x0E
READ, WRITE, MODIFY, READ_PART, WRITE_PART, LISTING = 0x4C, 0x4D, 0x4E, 0x52, 0x53, 0x55
CLOSE, OPEN, LARGE_OPEN, UNCONNECTED, EXECUTE_PCCC = 0x4E, 0x54, 0x5B, 0x52, 0x4B

FRAME_MOST = 4_600
"""Maximum bytes in a frame's body: 4,002 bytes of a large connection, plus items and headers."""

UNCONNECTED_MOST = 504
"""Maximum bytes of an unconnected reply."""

CONNECTION_LEAST, CONNECTION_MOST = 32, 4_002
"""Minimum and maximum bytes of a connection's packets."""

PORT = 44_818
"""TCP and UDP port of EtherNet/IP."""


class CipRefusedError(ValueError):
    """A request was answered with an error status."""

    def __init__(self, status: int, *more: int) -> None:
        statuses = [f"{status:02X}h", *(f"{extended_status:04X}h" for extended_status in more)]
        super().__init__(f"status {' '.join(statuses)}")
        self.status, self.more = status, more  # general status, extended statuses
