"""Serial traffic: legal frames, damaged frames, noise, and sequences of these."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st
from pymodbus.framer import FramerRTU

from ..pcl601.registers import MAP, WORD_COUNT, Row, word_of
from ..pcl601.terminals import INPUT_COUNT, OUTPUT_COUNT
from ..pmc006.frame import FACTORY_ADDRESS, command
from ..pmc006.instructions import INSTRUCTIONS, InstructionRow, Kind

READ_FUNCTIONS = {1: OUTPUT_COUNT, 2: INPUT_COUNT, 3: WORD_COUNT, 4: 1}
"""Modbus functions that read, with the number of items in a PCL601 [Appendix 3]."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Bytes on a line without a pause; `whole` is true for a legal frame."""

    data: bytes
    whole: bool


def modbus_frame(unit: int, pdu: bytes) -> bytes:
    """Return an RTU frame.

    >>> modbus_frame(1, bytes.fromhex("11")).hex(" ")
    '01 11 c0 2c'
    """
    body = bytes((unit,)) + pdu
    return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")


def modbus_requests(unit: int = 1) -> st.SearchStrategy[bytes]:
    """Return a strategy of requests that an idle PCL601 accepts; `unit` is 1 to 99, or 0 for broadcasts."""
    pdus = st.just(b"\x11") | _reads() | _writes() | _coils()
    return pdus.map(lambda pdu: modbus_frame(unit, pdu))


def _reads() -> st.SearchStrategy[bytes]:
    """Return a strategy of Modbus PDUs that read a range inside a table of the PCL601."""

    def ranges(function: int) -> st.SearchStrategy[bytes]:
        """Return a strategy of PDUs that read items with one of the functions."""
        table_size = READ_FUNCTIONS[function]
        return st.integers(0, table_size - 1).flatmap(
            lambda first: st.integers(1, table_size - first).map(
                lambda count: bytes((function, *first.to_bytes(2, "big"), *count.to_bytes(2, "big")))
            )
        )

    return st.sampled_from([3, 1, 2, 4]).flatmap(ranges)


def _writes() -> st.SearchStrategy[bytes]:
    """Return a strategy of register writes, except for commands, behavior selectors and the address."""
    harmless_rows = [row for row in MAP if row.writable and row.ascii and not row.kept and not row.locked]
    writable_rows = [row for row in harmless_rows if row.high > 1]

    def write(row: Row) -> st.SearchStrategy[bytes]:
        return st.integers(row.low, row.high).map(lambda value: _write(row, value))

    return st.sampled_from(writable_rows).flatmap(write)


def _write(row: Row, value: int) -> bytes:
    """Return the Modbus PDU that writes a register: function 6 for one word, 16 for several."""
    words = [word_of(value, word) for word in range(row.words)]
    start = row.address.to_bytes(2, "big")
    if row.words == 1:
        return bytes((6, *start, *words[0].to_bytes(2, "big")))
    data = b"".join(word.to_bytes(2, "big") for word in words)
    return bytes((16, *start, 0, row.words, len(data))) + data


def _coils() -> st.SearchStrategy[bytes]:
    """Return a strategy of Modbus PDUs that switch one output."""
    levels = st.booleans().map(lambda on: b"\xff\x00" if on else b"\x00\x00")
    return st.builds(
        lambda coil, level: bytes((5, 0, coil)) + level, st.integers(0, OUTPUT_COUNT - 1), levels
    )


def pmc006_requests(address: int = FACTORY_ADDRESS) -> st.SearchStrategy[bytes]:
    """Return a strategy of valid frames that read or set a parameter of a PMC006."""
    rows = [row for row in INSTRUCTIONS if row.kind is not Kind.ACTION]

    def frames(row: InstructionRow) -> st.SearchStrategy[bytes]:
        """Return a strategy of frames of one instruction, with every allowed value, if any."""
        if row.values:
            data: st.SearchStrategy[int] = st.sampled_from(row.values)
        elif row.kind is Kind.READ or row.low is None or row.high is None:
            data = st.just(0)
        else:
            data = st.integers(row.low, row.high)
        return data.map(lambda value: command(address, row.code, value))

    return st.sampled_from(rows).flatmap(frames)


def noise(most: int = 40) -> st.SearchStrategy[bytes]:
    """Return a strategy of random bytes, at least one."""
    return st.binary(min_size=1, max_size=most)


@st.composite
def damaged(draw: st.DrawFn, frames: st.SearchStrategy[bytes]) -> bytes:
    """Return a frame with one defect: a wrong bit, a lost, doubled or added byte, or a missing end."""
    frame = draw(frames)
    position = draw(st.integers(0, len(frame) - 1))
    defect = draw(st.sampled_from(["bit", "lost", "doubled", "added", "cut"]))
    if defect == "bit":
        wrong_byte = frame[position] ^ 1 << draw(st.integers(0, 7))
        return frame[:position] + bytes((wrong_byte,)) + frame[position + 1 :]
    if defect == "lost":
        return frame[:position] + frame[position + 1 :]
    if defect == "doubled":
        return frame[:position] + frame[position : position + 1] + frame[position:]
    if defect == "added":
        return frame[:position] + bytes((draw(st.integers(0, 255)),)) + frame[position:]
    return frame[: max(position, 1)]


def line_traffic(frames: st.SearchStrategy[bytes], most: int = 8) -> st.SearchStrategy[list[Piece]]:
    """Return a strategy of at most `most` pieces: whole frames, damaged frames, and noise."""
    whole_pieces = frames.map(lambda data: Piece(data, whole=True))
    broken_pieces = (damaged(frames) | noise()).map(lambda data: Piece(data, whole=False))
    return st.lists(whole_pieces | broken_pieces, max_size=most)
