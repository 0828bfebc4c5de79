"""Finds reads and writes of module images by EtherNet/IP clients of a CompactLogix in packets.

    frame, items -> message, also in Unconnected Send and batches -> read or write of Local:n:I or Local:n:O

A message identifies a tag by its name, or by its number in the controller's list of tags. If a capture began
after the list was read, tags identified by number stay unknown [1756-PM020].
"""

from __future__ import annotations

import struct
from collections import OrderedDict, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from scanrack.io_images.enip.codes import (
    BATCH,
    DONE,
    LISTING,
    MANAGER,
    MODIFY,
    PARTIAL,
    READ,
    READ_PART,
    SEND,
    SEND_CONNECTED,
    STRUCTURED,
    UNCONNECTED,
    WRITE,
    WRITE_PART,
    CipRefusedError,
)
from scanrack.io_images.enip.frames import COMMAND_MOST, HEAD, items_in
from scanrack.io_images.enip.paths import Instance, Path, parse_path
from scanrack.io_images.image import WORDS
from scanrack.runtime.tag_servers.images import ImagePlace, image_place
from typing_extensions import override

from .pairing import OPEN_MAX, PairedExchange, Pairing

DEEPEST = 2
"""Maximum nesting depth of batches and routed messages."""

TAGS_MOST = 100_000
"""Maximum number of tags stored from a list."""

_SOME_FAILED = 0x1E
"""Status of a batch in which some messages failed."""

_ATTRIBUTE_BYTES = {2: 2, 3: 4, 5: 4, 6: 4, 7: 2, 8: 12, 9: 1, 10: 1}
"""Sizes of a symbol's attributes, bytes; attribute 1 is its name [1756-PM020, tag list]."""

_REPLY = 0x80
_Key = tuple[int, bytes]
"""Command of a frame, and the context or sequence number that a reply repeats."""


class _OpenMessage(NamedTuple):
    """A request without a reply so far."""

    at_ns: int
    message: bytes


@dataclass(frozen=True, slots=True)
class ImageExchange(PairedExchange):
    """A read or write of a module's words; its unit is the slot number.

    Attributes:
        output: whether the words belong to `Local:n:O`; otherwise to `Local:n:I`.
        offset: offset of `data` in the eight words, bytes.
        data: the bytes that were read or written.
        keep: mask of the bits that the message leaves unchanged; b"" if it changes all bits.
    """

    output: bool
    offset: int
    data: bytes
    keep: bytes = b""


class CipPairing(Pairing):
    """Pairs the messages of a TCP connection: a reply has the context or sequence number of its request.

    Attributes:
        reads: number of reads of tags other than module images.
        unnamed: number of these reads whose tag number has no name in the capture.
    """

    def __init__(self) -> None:
        self.reads = self.unnamed = 0
        self._unparsed = {True: b"", False: b""}
        self._open: OrderedDict[_Key, deque[_OpenMessage]] = OrderedDict()
        self._names: dict[int, str] = {}

    @override
    def feed(self, at_ns: int, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[PairedExchange]:
        for key, message in self._messages(data, to_device=to_device, fresh=fresh):
            if to_device:
                self._open.setdefault(key, deque(maxlen=OPEN_MAX)).append(_OpenMessage(at_ns, message))
                self._open.move_to_end(key)
                if len(self._open) > OPEN_MAX:
                    self._open.popitem(last=False)
            elif (requests_open := self._open.get(key)) and requests_open[0].at_ns <= at_ns:
                requested_ns, request = requests_open.popleft()
                if not requests_open:
                    del self._open[key]
                yield from self._exchanges((requested_ns, at_ns), request, message, 0)

    @property
    @override
    def passed_over(self) -> str:
        if not self.reads:
            return ""
        unnamed = f", {self.unnamed:,} of them by numbers without a name in the capture"
        return (
            f"{self.reads:,} reads of tags{unnamed if self.unnamed else ''}, none of Local:n:I: "
            "the client must also read that tag"
        )

    @override
    def finish(self) -> Iterator[PairedExchange]:
        """Yield nothing, because a message without a reply has no words."""
        self._open.clear()
        return iter(())

    def _messages(self, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[tuple[_Key, bytes]]:
        """Yield the messages of complete frames, with the keys that replies repeat; keep other bytes."""
        data, offset = (b"" if fresh else self._unparsed[to_device]) + data, 0
        while len(data) >= offset + HEAD.size:
            command, length, _, status, context, options = HEAD.unpack_from(data, offset)
            if command > COMMAND_MOST or options:  # wait until a segment begins with a frame
                offset = len(data)
            if len(data) < offset + HEAD.size + length:
                break
            body, offset = data[offset + HEAD.size : offset + HEAD.size + length], offset + HEAD.size + length
            items = items_in(body) if command in (SEND, SEND_CONNECTED) and not status else []
            if len(items) < 2:
                continue
            message = items[1][1]  # data of the second item; the first is an address
            if command == SEND:
                yield (command, context), message
            else:
                yield (command, message[:2]), message[2:]
        self._unparsed[to_device] = data[offset:]

    def _exchanges(
        self, times: tuple[int, int], request: bytes, reply: bytes, depth: int
    ) -> Iterator[PairedExchange]:
        """Yield the exchanges of a request and its reply."""
        try:
            service, path, data = _request_parts(request)
            if depth < DEEPEST and service == UNCONNECTED and path.numbers.get("class") == MANAGER:
                (size,) = struct.unpack_from("<H", data, 2)
                yield from self._exchanges(times, data[4 : 4 + size], reply, depth + 1)
                return
            status, reply_data = _reply_parts(service, reply)
            if service == BATCH and status in (DONE, _SOME_FAILED) and depth < DEEPEST:
                messages = zip(_batch_messages(data), _batch_messages(reply_data), strict=False)
                for message, message_reply in messages:
                    yield from self._exchanges(times, message, message_reply, depth + 1)
            elif service == LISTING and status in (DONE, PARTIAL):
                self._store_names(path, data, reply_data)
            elif status in (DONE, PARTIAL):
                yield from self._image_exchange(times, (request, reply), service, path, data, reply_data)
        except (CipRefusedError, struct.error, IndexError):
            return  # truncated, or not a message about a tag

    def _store_names(self, path: Path, data: bytes, reply_data: bytes) -> None:
        """Store the names of the controller's tags by number."""
        if any(not isinstance(step, Instance) for step in path.steps):
            return  # ignore program-scoped tags
        (count,) = struct.unpack_from("<H", data)
        attributes = struct.unpack_from(f"<{count}H", data, 2)
        offset = 0
        while offset + 4 <= len(reply_data) and len(self._names) < TAGS_MOST:
            (number,) = struct.unpack_from("<I", reply_data, offset)
            offset += 4
            for attribute in attributes:
                if attribute == 1:
                    (size,) = struct.unpack_from("<H", reply_data, offset)
                    name = reply_data[offset + 2 : offset + 2 + size].decode("ascii", "replace")
                    self._names[number] = name
                    offset += 2 + size
                else:
                    offset += _ATTRIBUTE_BYTES.get(attribute, len(reply_data))

    def _image_exchange(
        self,
        times: tuple[int, int],
        messages: tuple[bytes, bytes],
        service: int,
        path: Path,
        data: bytes,
        reply_data: bytes,
    ) -> Iterator[PairedExchange]:
        """Yield the exchange for a module's tag; count reads of other tags."""
        names = [
            self._names.get(step.number, "") if isinstance(step, Instance) else step for step in path.steps
        ]
        image = image_place(names)
        if image is None and service in (READ, READ_PART):
            self.reads += 1
            self.unnamed += names[:1] == [""]
        change = None if image is None else _change(image, service, data, reply_data)
        if image is not None and change is not None:
            offset, changed, keep = change
            yield ImageExchange(
                *times, image.slot, *messages, output=image.output, offset=offset, data=changed, keep=keep
            )


def _request_parts(message: bytes) -> tuple[int, Path, bytes]:
    end = 2 + 2 * message[1]
    return message[0], parse_path(message[2:end]), message[end:]


def _reply_parts(service: int, message: bytes) -> tuple[int, bytes]:
    if message[0] != service | _REPLY:
        raise CipRefusedError(DONE)
    return message[2], message[4 + 2 * message[3] :]


def _batch_messages(batch: bytes) -> list[bytes]:
    """Return the messages of a batch; none if offsets decrease, which could repeat bytes 16,000 times."""
    (count,) = struct.unpack_from("<H", batch)
    offsets: Sequence[int] = (*struct.unpack_from(f"<{count}H", batch, 2), len(batch))
    if any(end < begin for begin, end in pairwise(offsets)):
        return []
    return [batch[begin:end] for begin, end in pairwise(offsets)]


_Change = tuple[int, bytes, bytes]
"""Offset in the eight words, bytes, and mask of the unchanged bits, see `ImageExchange`."""


def _change(image: ImagePlace, service: int, data: bytes, reply_data: bytes) -> _Change | None:
    """Return the bytes of a module's image that a message reads or writes, or None."""
    if service == MODIFY:
        return _modify_change(image, data)
    if service not in (READ, READ_PART, WRITE, WRITE_PART):
        return None
    skip, body = _elements(service, data, reply_data)
    if image.bit is None:
        return _clipped(image.offset + skip, body, b"")
    mask = 1 << image.bit
    return _clipped(image.offset, bytes([mask if body[0] else 0]), bytes([~mask & 0xFF]))


def _modify_change(image: ImagePlace, data: bytes) -> _Change | None:
    """Return the change made by a Read-Modify-Write, or None."""
    (size,) = struct.unpack_from("<H", data)
    or_mask, and_mask = data[2 : 2 + size], data[2 + size : 2 + 2 * size]
    if image.bit is not None or not size or len(and_mask) < size:
        return None
    masks = list(zip(or_mask, and_mask, strict=True))
    keep = bytes(ands & ~ors & 0xFF for ors, ands in masks)
    return _clipped(image.offset, bytes(ors & ands for ors, ands in masks), keep)


def _elements(service: int, data: bytes, reply_data: bytes) -> tuple[int, bytes]:
    """Return the offset of the elements in a message, and the elements."""
    is_write = service in (WRITE, WRITE_PART)
    typed = data if is_write else reply_data
    (code,) = struct.unpack_from("<H", typed)
    body = typed[(4 if code == STRUCTURED else 2) + 2 * is_write :]  # skip type and count
    if service == READ_PART:
        return struct.unpack_from("<I", data, 2)[0], body
    return (struct.unpack_from("<I", body)[0], body[4:]) if service == WRITE_PART else (0, body)


def _clipped(offset: int, data: bytes, keep: bytes) -> _Change | None:
    """Return the part of a change within the eight words of a 3601; None if no byte is within them."""
    first, end = max(0, -offset), 2 * WORDS - offset
    data = data[first:end] if end > 0 else b""
    return (offset + first, data, keep[first:end]) if data else None
