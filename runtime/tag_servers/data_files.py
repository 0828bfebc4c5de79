"""Access to the data files of SLC 500 and MicroLogix by Execute PCCC [1770-RM516, chapter 7].

requester  length, vendor u16, serial number u32
command    CMD 0F, STS 00, TNS u16, FNC
A2         size, file, type, element, sub-element    protected typed logical read, three address fields
AA         the same, then data                       write
AB         the same, mask u16, data                  write with mask
A1, A9     without sub-element                       read, write
CMD 06, FNC 03                                       diagnostic status
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from typing import NamedTuple

from scanrack.io_images.enip.codes import NO_PRIVILEGE, TOO_SHORT, CipRefusedError

from .database import Database, Symbol, Target
from .tag_snapshot import ReadBytes, TagSnapshot, WriteBytes

TYPES: Mapping[str, tuple[int, ...]] = {
    "O": (0x8B, 0x82),
    "I": (0x8C, 0x83),
    "S": (0x84,),
    "B": (0x85,),
    "T": (0x86,),
    "C": (0x87,),
    "R": (0x88,),
    "N": (0x89,),
    "F": (0x8A,),
    "ST": (0x8D,),
    "A": (0x8E,),
    "L": (0x91,),
}
"""File types in messages, by file letters; the directory shows the last type."""

WORDS: Mapping[str, int] = {"T": 3, "C": 3, "R": 3, "F": 2, "L": 2, "ST": 42}
"""Words per element; elements of other file types have one word."""

FIXED = {"O": 0, "I": 1, "S": 2}
"""Files whose number is fixed."""

READS, TYPED, MASKED = (0xA1, 0xA2), (0xA2, 0xAA, 0xAB), 0xAB
FUNCTIONS = (0xA1, 0xA2, 0xA9, 0xAA, 0xAB)
DATA_MOST = 236
"""Maximum number of data bytes in a message."""

ILLEGAL, EXTENDED = 0x10, 0xF0
ADDRESS, TOO_BIG, READ_ONLY, NO_FILE = 0x06, 0x0A, 0x0B, 0x50
_REPLY = 0x40
_WHOLE_FILE, _DIAGNOSTIC = 0x0F, 0x06

PROCESSOR = "1764-LRP"
"""Processor named in the diagnostic status, from which clients choose the directory format."""

_NAME = re.compile(r"(?P<letters>[A-Z]{1,2})(?::(?P<slot>\d+)|(?P<number>\d*))")

# The directory of a MicroLogix 1500, as clients read it: words of file 0 of type 2
_DIRECTORY, _SIZE_AT, _SIZE_ADDED = 2, 80, 19_968
_LADDERS_AT, _FILES_AT, _ROWS_AT, _ROW_BYTES, _GAP = 46, 52, 233, 10, 0x81


class PcccRefusedError(ValueError):
    """A refused command; the reply contains an error status."""

    def __init__(self, status: int, extended: int | None = None) -> None:
        super().__init__(f"STS {status:02X}h")
        self.status, self.extended = status, extended


class Run(NamedTuple):
    """Successive bytes of a message that are also successive in the tag."""

    message_offset: int
    tag_offset: int
    length: int


class DataFile:
    """A file: a tag's bytes in PCCC layout, where each pair of characters in a text is swapped."""

    def __init__(self, letters: str, symbol: Symbol) -> None:
        self.letters, self._symbol = letters, symbol
        self.element = 2 * WORDS.get(letters, 1)
        self.size = symbol.tag.count * self.element
        self._tag_element = symbol.tag.element  # bytes of an element in the tag

    def runs(self, start: int, size: int) -> list[Run]:
        """Return the runs of `size` bytes of the file, beginning at byte `start`."""
        if self.letters != "ST":
            is_same_layout = self._tag_element == self.element
            return [Run(0, start, size)] if is_same_layout else self._by_element(start, size)
        return [Run(index, self._text_offset(start + index), 1) for index in range(size)]

    def _by_element(self, start: int, size: int) -> list[Run]:
        """Return a run per element, for a file whose elements have another size in the tag."""
        runs, position = [], start
        while position < start + size:
            number, byte_offset = divmod(position, self.element)
            length = min(self.element - byte_offset, start + size - position)
            runs.append(Run(position - start, number * self._tag_element + byte_offset, length))
            position += length
        return runs

    def _text_offset(self, position: int) -> int:
        """Return a file byte's position in the tag, where LEN has four bytes instead of one word."""
        number, byte_offset = divmod(position, self.element)
        return number * self._tag_element + (byte_offset if byte_offset < 2 else 4 + (byte_offset - 2 ^ 1))

    def read(self, snapshot: TagSnapshot, start: int, size: int) -> bytes:
        """Return bytes of the file."""
        runs = self.runs(start, size)
        first_byte, end_byte = _bounds(runs)
        raw = snapshot.read(ReadBytes(self._symbol.index, first_byte, end_byte - first_byte))
        return b"".join(raw[offset - first_byte :][:length] for _, offset, length in runs)

    def write(self, snapshot: TagSnapshot, start: int, data: bytes, mask: int) -> None:
        """Write the bits in a mask to bytes of the file, as one write."""
        runs = self.runs(start, len(data))
        first_byte, end_byte = _bounds(runs)
        new_bytes, keep_mask = bytearray(end_byte - first_byte), bytearray(b"\xff" * (end_byte - first_byte))
        for data_offset, offset, length in runs:
            for number in range(length):
                index = offset - first_byte + number
                byte_mask = mask >> 8 * ((start + data_offset + number) % 2) & 0xFF
                new_bytes[index], keep_mask[index] = data[data_offset + number] & byte_mask, ~byte_mask & 0xFF
        kept_bits = bytes(keep_mask) if any(keep_mask) else b""
        snapshot.write(WriteBytes(self._symbol.index, first_byte, bytes(new_bytes), kept_bits))

    def target(self) -> Target:
        """Return the whole file as a target, for the access check."""
        tag = self._symbol.tag
        return Target(self._symbol, tag.kind, 0, tag.count, None, tag.name)


def _bounds(runs: list[Run]) -> tuple[int, int]:
    """Return the first byte of the tag that the runs cover, and the byte after the last one."""
    return min(run.tag_offset for run in runs), max(run.tag_offset + run.length for run in runs)


class DataFiles:
    """The data files of a program."""

    def __init__(self, database: Database, processor: str = PROCESSOR) -> None:
        """Find the controller's tags that are named like files (`N7`) or like images of a slot (`I:1`)."""
        self._database, self._processor = database, processor
        self._files: dict[int, DataFile] = {}
        self._images: dict[tuple[int, int], DataFile] = {}  # by file and slot
        for symbol in database.scopes[""]:
            match = _NAME.fullmatch(symbol.tag.name.upper())
            if match is None or match["letters"] not in TYPES:
                continue
            letters = match["letters"]
            if match["slot"] is not None:
                self._images[FIXED.get(letters, -1), int(match["slot"])] = DataFile(letters, symbol)
            elif match["number"] or letters in FIXED:
                number = int(match["number"]) if match["number"] else FIXED[letters]
                self._files[number] = DataFile(letters, symbol)

    def execute(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Return the reply to a command, with its requester and number; the status shows a refusal."""
        if not data or not 1 <= data[0] <= 16 or len(data) < data[0] + 4:
            raise CipRefusedError(TOO_SHORT)
        requester, command_data = data[: data[0]], data[data[0] :]
        command, _, number = struct.unpack_from("<BBH", command_data)
        status, body = 0, b""
        try:
            body = self._command(command, command_data[4:], snapshot)
        except PcccRefusedError as refusal:
            status = refusal.status
            body = b"" if refusal.extended is None else bytes([refusal.extended])
        except (struct.error, IndexError):
            status = ILLEGAL
        return requester + struct.pack("<BBH", command | _REPLY, status, number) + body

    def _command(self, command: int, request: bytes, snapshot: TagSnapshot) -> bytes:
        """Carry out a command: diagnostic status, or a read or write of a file or its directory.

        Return the data of the reply; it is empty for a write.
        """
        if command == _DIAGNOSTIC and request[:1] == b"\x03":
            name = self._processor.encode("ascii", "replace")[:11].ljust(11)
            return b"\x00\xee\x31\x5b\x01" + name + bytes(8)
        if command != _WHOLE_FILE or not request or request[0] not in FUNCTIONS:
            raise PcccRefusedError(ILLEGAL)
        function, size = request[0], request[1]
        number, offset = _field(request, 2)
        file_type = request[offset]
        element, offset = _field(request, offset + 1)
        sub_element, offset = _field(request, offset) if function in TYPED else (0, offset)
        if not 1 <= size <= DATA_MOST:
            raise PcccRefusedError(EXTENDED, TOO_BIG)
        if (number, file_type, function) == (0, _DIRECTORY, 0xA1):
            return self._directory_part(2 * element, size)
        file, start = self._locate(number, file_type, element, sub_element)
        if start + size > file.size:
            raise PcccRefusedError(EXTENDED, ADDRESS)
        if function in READS:
            return file.read(snapshot, start, size)
        self._write(file, start, size, request[offset:], snapshot, masked=function == MASKED)
        return b""

    def _locate(self, number: int, file_type: int, element: int, sub_element: int) -> tuple[DataFile, int]:
        """Return the file at an address, and the byte in that file."""
        image = self._images.get((number, element))
        if image is not None and file_type in TYPES[image.letters]:
            return image, 2 * sub_element
        file = self._files.get(number)
        if file is None or file_type not in TYPES[file.letters]:
            raise PcccRefusedError(EXTENDED, NO_FILE if file is None else ADDRESS)
        if 2 * sub_element >= file.element and file.element > 2:
            raise PcccRefusedError(EXTENDED, ADDRESS)
        return file, element * file.element + 2 * sub_element

    def _write(
        self, file: DataFile, start: int, size: int, data: bytes, snapshot: TagSnapshot, *, masked: bool
    ) -> None:
        """Write data to a file, or only the bits in the mask before the data; refuse a read-only file."""
        mask = 0xFFFF
        if masked:
            (mask,) = struct.unpack_from("<H", data)
            data = data[2:]
            if file.letters == "ST" and 2 <= len(data) < size and len(data) % 2 == 0:
                size = len(data)  # some clients state the size of the element, but send only the text
        if len(data) != size or (masked and size % 2):
            raise PcccRefusedError(ILLEGAL)
        try:
            self._database.refuse_write(file.target())
            file.write(snapshot, start, data, mask)
        except CipRefusedError as refusal:
            denied = refusal.status == NO_PRIVILEGE
            raise PcccRefusedError(EXTENDED, READ_ONLY if denied else ADDRESS) from refusal

    # --- the directory

    def _directory_part(self, start: int, size: int) -> bytes:
        """Return bytes of the directory; a read that begins at its size field may go beyond the end."""
        directory = self._directory()
        if start + size > len(directory):
            if start == _SIZE_AT:
                return directory[start:].ljust(size, b"\0")
            raise PcccRefusedError(EXTENDED, ADDRESS)
        return directory[start : start + size]

    def _directory(self) -> bytes:
        """Return the file directory, with a row for each file number: its type and size in bytes."""
        types_and_sizes = {
            number: (TYPES[file.letters][-1], file.size) for number, file in self._files.items()
        }
        for (number, _), image in self._images.items():
            _, size_before = types_and_sizes.get(number, (0, 0))
            types_and_sizes[number] = TYPES[image.letters][-1], size_before + image.size
        last_number = max(types_and_sizes, default=-1)
        rows = [types_and_sizes.get(number, (_GAP, 0)) for number in range(last_number + 1)]
        table = b"".join(struct.pack("<BH", *row).ljust(_ROW_BYTES, b"\0") for row in rows)
        head = bytearray(_ROWS_AT)
        head[_LADDERS_AT], head[_FILES_AT] = 3, len(rows) & 0xFF
        struct.pack_into("<H", head, _SIZE_AT, _ROWS_AT + len(table) + _SIZE_ADDED)
        return bytes(head) + table


def _field(data: bytes, offset: int) -> tuple[int, int]:
    """Return an address field and the offset after it; a field is one byte, or FF followed by a word."""
    if data[offset] == 0xFF:
        return struct.unpack_from("<H", data, offset + 1)[0], offset + 3
    return data[offset], offset + 1
