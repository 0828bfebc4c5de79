"""The tag server's side in the scan process: it answers waiting packets between two scans."""

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
        """Return bytes of a tag; raise ValueError if they are outside the tag."""


class NoTags(ProgramTags):
    """A program without tags."""

    listing = Listing(())

    @override
    def read(self, number: int, offset: int, size: int) -> bytes:
        raise ValueError(f"no tag number {number}")


class TagDesk(QuietListener):
    """The last listener of the scan loop: it reads and writes tags for clients.

    Args:
        tags: function that returns the tags of the running program; an edit replaces them.
        writes: whether clients may write tags.
        profile: names of the parts of input images, see `images.PROFILES`.
        waker: socket that wakes the server after an answer.

    Attributes:
        version: version number of the program, 1 or more.
        exchanges: number of answers so far.
        spent_ns: total wall time spent on answers.
        on_hold: whether requests wait because a trace's actions are being repeated.
    """

    def __init__(
        self,
        mailbox: Mailbox,
        waker: socket.socket,
        operator_actions: OperatorActions,
        rack: Rack,
        period_ns: int,
        tags: Callable[[], ProgramTags],
        *,
        writes: bool,
        profile: str = GENERIC,
        version: int = 1,
    ) -> None:
        self._mailbox, self._waker, self._rack = mailbox, waker, rack
        self._operator_actions = operator_actions
        waker.setblocking(False)
        self._period_ns, self._present_tags, self._writes, self._profile = period_ns, tags, writes, profile
        self._next_scan = 0, 0  # its time and number
        self.exchanges = self.spent_ns = 0
        self.on_hold = False
        self.version = version
        self._list_tags()

    def _list_tags(self) -> None:
        """List the program's tags, followed by two tags per slot: its input image and its output image."""
        self._tags = self._present_tags()
        self._program_tag_count = len(self._tags.listing.tags)
        self._image_slots = [slot for slot in self._rack.slots for _ in range(2)]
        words = {slot.number: slot.words for slot in self._rack.slots.values()}
        self.listing = with_images(self._tags.listing, words, self._profile)

    def renew(self) -> None:
        """Switch to the tags of an edited program; clients then repeat requests for the earlier tags."""
        self.version += 1
        self._list_tags()

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        self._next_scan = now_ns + self._period_ns, scan + 1
        self.attend()

    @property
    def has_request(self) -> bool:
        """Whether a request is waiting."""
        return self._mailbox.has_request

    def attend(self) -> None:
        """Answer the waiting request."""
        if self.on_hold or not self.has_request:
            return
        begun_ns = wall_ns()
        at_ns, _ = self._next_scan
        try:
            reply = answered(self._mailbox.request(), self.version, at_ns, self._carry_out)
        except (struct.error, IndexError):  # a server died while it wrote the request
            reply = ANSWER.pack(0, at_ns)
        self._mailbox.post_reply(reply)
        wake(self._waker)
        self.exchanges += 1
        self.spent_ns += wall_ns() - begun_ns

    def _carry_out(self, client: str, operation: Operation) -> bytes | None:
        """Carry out an operation; return the bytes for a read, b"" for a write, None if refused."""
        try:
            if isinstance(operation, ReadBytes):
                return self._read(operation)
            if not self._writes:
                return None
            tag, data, keep_mask = self.listing.tags[operation.tag], operation.data, operation.keep
            part_name = part_at(tag, operation.offset, len(data), keep_mask, files=self.listing.files)
            store = Store(tag.full_name, operation.offset, data.hex(), keep_mask.hex(), client, part_name)
            self._operator_actions.act(store, *self._next_scan)
        except Exception:  # an error in a packet never faults the CPU
            return None
        return b""

    def _read(self, requested: ReadBytes) -> bytes:
        """Return bytes of a program's tag or of an image; raise a ValueError beyond its end."""
        image_number = requested.tag - self._program_tag_count
        if image_number < 0:
            return self._tags.read(requested.tag, requested.offset, requested.size)
        tag = self.listing.tags[requested.tag]
        slot = self._rack.slots[self._image_slots[image_number]]
        is_output = output_slot(tag.name) is not None
        raw = bytes(slot.outputs.raw if is_output else slot.inputs.raw)
        if tag.size > len(raw):  # an input image of Logix begins with the connection fault
            raw = struct.pack("<i", slot.fault) + raw
        end = requested.offset + requested.size
        if end > len(raw):
            raise ValueError(f"{tag.name} has no byte {end - 1}; it has {len(raw)} bytes")
        return raw[requested.offset : end]
