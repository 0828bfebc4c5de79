"""Records a serial line and the values of its devices as an MCAP file.

    /line       received and sent bytes, as hex and as text
    /unit1      registers, inputs and outputs of the device at address 1, by name; on change only
    /unit2      ...

`log_time` is virtual ns since power-up. Every value is a separate field, so that Foxglove and Lichtblick can
plot `/unit1.position` directly.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from scanrack.io_images.versions import distribution_version

from ..files.keeping import RecordingKeeper
from ..format.schema import LIBRARY
from .chunks import ChunkWriter
from .output import SUMMARY_ROOM, open_trace_file

PROFILE = "scanrack-line"
METADATA = "scanrack.line"
CHUNK_BYTES = 256 * 1024
"""Maximum size of a chunk, bytes; a killed process loses at most the last chunk."""

LINE_SCHEMA = {
    "title": "scanrack.Line",
    "description": "Bytes on the line.",
    "type": "object",
    "properties": {
        "direction": {"type": "string", "description": "received or sent, as the units see it"},
        "hex": {"type": "string", "description": "the bytes"},
        "text": {"type": "string", "description": "the same bytes; what is not printable as a dot"},
    },
}


@dataclass(frozen=True, slots=True)
class UnitColumns:
    """A device on the line, with its address and the names of its values."""

    address: int
    names: Sequence[str]


class LineRecorder:
    """Records a serial line and its devices.

    Args:
        target: path of the file, replaced if it exists.
        keeping: keeps earlier recordings; if None, `target` is replaced.

    Raises:
        OSError: the target can't be written.
    """

    def __init__(
        self,
        target: Path | str,
        units: Sequence[UnitColumns],
        metadata: Mapping[str, str],
        keeping: RecordingKeeper | None = None,
    ) -> None:
        self._file = open_trace_file(Path(target), 2 * CHUNK_BYTES + SUMMARY_ROOM, keeping)
        self._writer = ChunkWriter(
            self._file,
            profile=PROFILE,
            library=LIBRARY + distribution_version("scanrack"),
            chunk_bytes=CHUNK_BYTES,
        )
        self._line_channel = self._channel("/line", LINE_SCHEMA)
        self._unit_channels = {
            unit.address: self._channel(f"/unit{unit.address}", _schema(unit)) for unit in units
        }
        self._latest: dict[int, Mapping[str, int]] = {}  # recorded values by address
        self._sequence = 0  # number of messages so far
        self._writer.add_metadata(METADATA, dict(metadata))

    def received(self, now_ns: int, data: bytes) -> None:
        """Record bytes that the devices received."""
        self._bytes(now_ns, "received", data)

    def sent(self, now_ns: int, data: bytes) -> None:
        """Record bytes that a device sent."""
        self._bytes(now_ns, "sent", data)

    def unit(self, now_ns: int, address: int, values: Mapping[str, int]) -> None:
        """Record the values of a device, unless they are unchanged."""
        if self._latest.get(address) != values:
            self._latest[address] = dict(values)
            self._message(self._unit_channels[address], now_ns, values)

    def draft(self) -> None:
        """Write the open chunk uncompressed, so that it survives if the process is killed."""
        self._writer.draft(self._file)

    def close(self) -> None:
        """Write the open chunk and the summary, and close the file."""
        try:
            self._writer.finish()
        finally:
            self._file.close()

    def _bytes(self, now_ns: int, direction: str, data: bytes) -> None:
        """Record bytes on the line as hex and as text, with dots for unprintable bytes."""
        text = "".join(chr(byte) if 32 <= byte < 127 else "." for byte in data)
        self._message(
            self._line_channel, now_ns, {"direction": direction, "hex": data.hex(" "), "text": text}
        )

    def _message(self, channel: int, now_ns: int, fields: Mapping[str, str | int]) -> None:
        content = json.dumps(fields, separators=(",", ":")).encode()
        self._writer.add_message(channel, now_ns, content, now_ns, self._sequence)
        self._sequence += 1

    def _channel(self, topic: str, schema: Mapping[str, object]) -> int:
        text = json.dumps(schema, separators=(",", ":"))
        return self._writer.json_channel(topic, str(schema["title"]), text)


def _schema(unit: UnitColumns) -> Mapping[str, object]:
    """Return the JSON schema of a device's messages, which contain an integer for each value."""
    return {
        "title": f"scanrack.Unit{unit.address}",
        "description": f"What the unit at address {unit.address} holds.",
        "type": "object",
        "properties": {name: {"type": "integer"} for name in unit.names},
    }
