"""The interface between a recorder and the writer of its MCAP records."""

from __future__ import annotations

from array import array
from typing import Protocol

from .output import TraceFile


class TraceWriter(Protocol):
    """A writer of records: channels and metadata first, then messages.

    Attachments may be added at any time.
    """

    @property
    def open_bytes(self) -> int:
        """Bytes of messages in the chunk that is not written yet."""

    def channel(self, topic: str, encoding: str, schema_name: str, schema_encoding: str, schema: str) -> int:
        """Register a channel with its own schema; return the channel's id."""

    def add_metadata(self, name: str, data: dict[str, str]) -> None:
        """Write a metadata record."""

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, without a time."""

    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int, /
    ) -> None:
        """Add one message; times in ns."""

    def add_block(self, channel_id: int, log_times: array[int], block: bytearray) -> None:
        """Add message records of the same size, already laid out; times are in ns, 64-bit, ascending.

        The writer takes ownership of the block.
        """

    def draft(self, file: TraceFile) -> None:
        """Write the open chunk's new messages, uncompressed."""

    def finish(self) -> None:
        """Write the open chunk, the summary and the footer. The file stays open."""
