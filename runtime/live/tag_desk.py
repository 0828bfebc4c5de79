"""The scan process's side of the tag server: serves the waiting packets between two scans."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable
from typing import Protocol

from scanrack.io_images.enip.listing import Listing, part_at
from typing_extensions import override

from ..loop.listeners import QuietListener
from ..loop.pace import wall_ns
from ..loop.rack import Rack
from ..tag_servers.exchange import ANSWER, answered
from ..tag_servers.images import GENERIC, output_slot, with_images
from ..tag_servers.tag_snapshot import Operation, ReadBytes
from .actions import Store
from .mailbox import Mailbox, wake
from .operator_actions import OperatorActions


class ProgramTags(Protocol):
    """The tags of a program as bytes."""

    @property
    def listing(self) -> Listing:
        """The tags, numbered as in `read`."""

    def read(self, number: int, offset: int, size: int) -> bytes:
        """Return bytes of a tag; ValueError if they are not there."""


class NoTags(ProgramTags):
    """A program without tags."""

    listing = Listing(())

    @override
    def read(self, number: int, offset: int, size: int) -> bytes:
        raise ValueError(f"no tag number {number}")


class TagDesk(QuietListener):
    """Reads and writes for clients; the last listener of the scan loop.

    Args:
        tags: tags of the running program; an edit replaces them.
        writes: whether clients may write at all.
        profile: names of the parts of input images, see `images.PROFILES`.
        waker: wakes the server after an answer.

    Attributes:
        version: number of the program's edition, from 1.
        exchanges: number of answers.
        spent_ns: wall time that they took.
        rests: whether requests must wait because the orders of a recording are repeated.
    """

    def __init__(
        self,
        mailbox: Mailbox,
        waker: socket.socket,
        hands: OperatorActions,
        rack: Rack,
        period_ns: int,
        tags: Callable[[], ProgramTags],
        *,
        writes: bool,
        profile: str = GENERIC,
        version: int = 1,
    ) -> None:
        self._mailbox, self._waker, self._hands, self._rack = mailbox, waker, hands, rack
        waker.setblocking(False)
        self._period_ns, self._tags_now, self._writes, self._profile = period_ns, tags, writes, profile
        self._next = 0, 0  # time and number of the next scan
        self.exchanges = self.spent_ns = 0
        self.rests = False
        self.version = version
        self._settle()

    def _settle(self) -> None:
        self._tags = self._tags_now()
        self._own = len(self._tags.listing.tags)
        self._slots = [slot for slot in self._rack.slots for _ in range(2)]
        words = {slot.number: slot.words for slot in self._rack.slots.values()}
        self.listing = with_images(self._tags.listing, words, self._profile)

    def renew(self) -> None:
        """Switch to the tags of an edited program; requests for the earlier tags are repeated."""
        self.version += 1
        self._settle()

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        self._next = now_ns + self._period_ns, scan + 1
        self.attend()

    @property
    def waits(self) -> bool:
        """Whether a request waits."""
        return self._mailbox.waits

    def attend(self) -> None:
        """Answer the waiting request."""
        if self.rests or not self.waits:
            return
        begun_ns = wall_ns()
        at_ns = self._next[0]
        try:
            reply = answered(self._mailbox.request(), self.version, at_ns, self._carry_out)
        except (struct.error, IndexError):  # a damaged request of a server that has died
            reply = ANSWER.pack(0, at_ns)
        self._mailbox.answer(reply)
        wake(self._waker)
        self.exchanges += 1
        self.spent_ns += wall_ns() - begun_ns

    def _carry_out(self, client: str, operation: Operation) -> bytes | None:
        """Return the bytes that were read, b"" for a write, None for a refused operation."""
        try:
            if isinstance(operation, ReadBytes):
                return self._read(operation)
            if not self._writes:
                return None
            tag, data, keep_mask = self.listing.tags[operation.tag], operation.data, operation.keep
            part_name = part_at(tag, operation.offset, len(data), keep_mask, files=self.listing.files)
            order = Store(tag.full_name, operation.offset, data.hex(), keep_mask.hex(), client, part_name)
            self._hands.act(order, *self._next)
        except Exception:  # one packet's mistake never faults the CPU
            return None
        return b""

    def _read(self, requested: ReadBytes) -> bytes:
        if requested.tag < self._own:
            return self._tags.read(requested.tag, requested.offset, requested.size)
        tag = self.listing.tags[requested.tag]
        slot = self._rack.slots[self._slots[requested.tag - self._own]]
        is_output = output_slot(tag.name) is not None
        raw = bytes(slot.outputs.raw if is_output else slot.inputs.raw)
        if tag.size > len(raw):
            raw = struct.pack("<i", slot.fault) + raw
        if requested.offset + requested.size > len(raw):
            raise ValueError(f"{tag.name}: bytes {requested.offset} to {requested.offset + requested.size}")
        return raw[requested.offset : requested.offset + requested.size]
