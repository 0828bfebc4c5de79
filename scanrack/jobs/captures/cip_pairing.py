"""EtherNet/IP: extracts from packets how clients read and write modules' images in a CompactLogix.

    frame, items -> message, out of Unconnected Send and batches -> read or write of Local:n:I or Local:n:O

A message identifies a tag by its name, or by its number in the controller's list of tags. If a capture began
after the list was read, tags with numbers stay unknown [1756-PM020].
"""

from __future__ import annotations

import struct
from collections import OrderedDict, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

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
"""Largest nesting depth of batches and routed messages."""

TAGS_MOST = 100_000
"""Largest number of tags kept from a list."""

_SOME_FAILED = 0x1E
"""Status of a batch in which some messages failed."""

_ATTRIBUTE_BYTES = {2: 2, 3: 4, 5: 4, 6: 4, 7: 2, 8: 12, 9: 1, 10: 1}
"""Sizes of a symbol's attributes, bytes; attribute 1 is its name [1756-PM020, tag list]."""

_REPLY = 0x80
_Key = tuple[int, bytes]
_Sent = tuple[int, bytes]


@dataclass(frozen=True, slots=True)
class ImageExchange(PairedExchange):
    """A read or write of a module's words; its unit is the slot number.

    Attributes:
        output: whether the words are those of `Local:n:O`, not of `Local:n:I`.
        at: offset of `data` in the eight words, bytes; negative if it begins before them.
        data: the bytes that were read or written.
        keep: mask of the bits that the message leaves unchanged; b"" for none.
    """

    output: bool
    at: int
    data: bytes
    keep: bytes = b""


class CipPairing(Pairing):
    """Pairs the messages of a TCP connection: a reply has the context or sequence number of its request.

    Attributes:
        reads: number of reads of tags that are not modules' images.
        unnamed: how many of these identify the tag by a number that the capture does not explain.
    """

    def __init__(self) -> None:
        self.reads = self.unnamed = 0
        self._rest = {True: b"", False: b""}
        self._open: OrderedDict[_Key, deque[_Sent]] = OrderedDict()
        self._names: dict[int, str] = {}

    @override
    def feed(self, at_ns: int, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[PairedExchange]:
        for key, message in self._messages(data, to_device=to_device, fresh=fresh):
            if to_device:
                self._open.setdefault(key, deque(maxlen=OPEN_MAX)).append((at_ns, message))
                self._open.move_to_end(key)
                if len(self._open) > OPEN_MAX:
                    self._open.popitem(last=False)
            elif (requests_open := self._open.get(key)) and requests_open[0][0] <= at_ns:
                requested_ns, request = requests_open.popleft()
                if not requests_open:
                    del self._open[key]
                yield from self._answered((requested_ns, at_ns), request, message, 0)

    @property
    @override
    def passed_over(self) -> str:
        if not self.reads:
            return ""
        unnamed = f", {self.unnamed:,} of them by numbers whose names came before the capture"
        return (
            f"{self.reads:,} reads of tags{unnamed if self.unnamed else ''}, none of Local:n:I: "
            "let the client read that, too"
        )

    @override
    def finish(self) -> Iterator[PairedExchange]:
        """Yield nothing: without a reply, a message has no words."""
        self._open.clear()
        return iter(())

    def _messages(self, data: bytes, *, to_device: bool, fresh: bool) -> Iterator[tuple[_Key, bytes]]:
        data, offset = (b"" if fresh else self._rest[to_device]) + data, 0
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
            message = items[1][1]
            if command == SEND:
                yield (command, context), message
            else:
                yield (command, message[:2]), message[2:]
        self._rest[to_device] = data[offset:]

    def _answered(
        self, times: tuple[int, int], request: bytes, reply: bytes, depth: int
    ) -> Iterator[PairedExchange]:
        """Yield the exchanges of a request and its reply."""
        try:
            service, path, data = _request_parts(request)
            if depth < DEEPEST and service == UNCONNECTED and path.numbers.get("class") == MANAGER:
                (size,) = struct.unpack_from("<H", data, 2)
                yield from self._answered(times, data[4 : 4 + size], reply, depth + 1)
                return
            status, answer = _reply_parts(service, reply)
            if service == BATCH and status in (DONE, _SOME_FAILED) and depth < DEEPEST:
                for part, its_reply in zip(_parts(data), _parts(answer), strict=False):
                    yield from self._answered(times, part, its_reply, depth + 1)
            elif service == LISTING and status in (DONE, PARTIAL):
                self._list(path, data, answer)
            elif status in (DONE, PARTIAL):
                yield from self._of_tag(times, (request, reply), service, path, data, answer)
        except (CipRefusedError, struct.error, IndexError):
            return  # truncated, or not a message about a tag

    def _list(self, path: Path, data: bytes, answer: bytes) -> None:
        """Store the names of the controller's tags by number."""
        if any(not isinstance(step, Instance) for step in path.steps):
            return  # ignore program-scoped tags
        (count,) = struct.unpack_from("<H", data)
        attributes = struct.unpack_from(f"<{count}H", data, 2)
        offset = 0
        while offset + 4 <= len(answer) and len(self._names) < TAGS_MOST:
            (number,) = struct.unpack_from("<I", answer, offset)
            offset += 4
            for attribute in attributes:
                if attribute == 1:
                    (size,) = struct.unpack_from("<H", answer, offset)
                    name = answer[offset + 2 : offset + 2 + size].decode("ascii", "replace")
                    self._names[number] = name
                    offset += 2 + size
                else:
                    offset += _ATTRIBUTE_BYTES.get(attribute, len(answer))

    def _of_tag(
        self,
        times: tuple[int, int],
        messages: tuple[bytes, bytes],
        service: int,
        path: Path,
        data: bytes,
        answer: bytes,
    ) -> Iterator[PairedExchange]:
        """Yield the exchange for a module's tag; count reads of other tags."""
        names = [
            self._names.get(step.number, "") if isinstance(step, Instance) else step for step in path.steps
        ]
        place = image_place(names)
        if place is None and service in (READ, READ_PART):
            self.reads += 1
            self.unnamed += names[:1] == [""]
        change = None if place is None else _change(place, service, data, answer)
        if place is not None and change is not None:
            now_ns, changed, keep = change
            yield ImageExchange(*times, place.slot, *messages, place.output, now_ns, changed, keep)


def _request_parts(message: bytes) -> tuple[int, Path, bytes]:
    end = 2 + 2 * message[1]
    return message[0], parse_path(message[2:end]), message[end:]


def _reply_parts(service: int, message: bytes) -> tuple[int, bytes]:
    if message[0] != service | _REPLY:
        raise CipRefusedError(DONE)
    return message[2], message[4 + 2 * message[3] :]


def _parts(batch: bytes) -> list[bytes]:
    """Return the messages of a batch; none if offsets decrease: bytes could repeat 16,000 times."""
    (count,) = struct.unpack_from("<H", batch)
    places: Sequence[int] = (*struct.unpack_from(f"<{count}H", batch, 2), len(batch))
    if any(end < begin for begin, end in pairwise(places)):
        return []
    return [batch[begin:end] for begin, end in pairwise(places)]


_Change = tuple[int, bytes, bytes]
"""Offset, bytes, and mask of the bits that stay."""


def _change(place: ImagePlace, service: int, data: bytes, answer: bytes) -> _Change | None:
    """Return the part of the words that a message reads or writes, or None."""
    if service == MODIFY:
        return _modified(place, data)
    if service not in (READ, READ_PART, WRITE, WRITE_PART):
        return None
    skip, body = _elements(service, data, answer)
    if place.bit is None:
        return _within(place.offset + skip, body, b"")
    mask = 1 << place.bit
    return _within(place.offset, bytes([mask if body[0] else 0]), bytes([~mask & 0xFF]))


def _modified(place: ImagePlace, data: bytes) -> _Change | None:
    """Return the change by a Read-Modify-Write, or None."""
    (size,) = struct.unpack_from("<H", data)
    ors, ands = data[2 : 2 + size], data[2 + size : 2 + 2 * size]
    if place.bit is not None or not size or len(ands) < size:
        return None
    keep = bytes(leave & ~on & 0xFF for on, leave in zip(ors, ands, strict=True))
    return _within(place.offset, bytes(on & leave for on, leave in zip(ors, ands, strict=True)), keep)


def _elements(service: int, data: bytes, answer: bytes) -> tuple[int, bytes]:
    """Return the offset of the elements in a message, and the elements."""
    is_write = service in (WRITE, WRITE_PART)
    typed = data if is_write else answer
    (code,) = struct.unpack_from("<H", typed)
    body = typed[(4 if code == STRUCTURED else 2) + 2 * is_write :]  # skip type and count
    if service == READ_PART:
        return struct.unpack_from("<I", data, 2)[0], body
    return (struct.unpack_from("<I", body)[0], body[4:]) if service == WRITE_PART else (0, body)


def _within(at: int, data: bytes, keep: bytes) -> _Change | None:
    """Return the part of a change that lies in the eight words of a 3601, or None."""
    first, end = max(0, -at), 2 * WORDS - at
    data = data[first:end] if end > 0 else b""
    return (at + first, data, keep[first:end]) if data else None
