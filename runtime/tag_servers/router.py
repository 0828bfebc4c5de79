"""Requests to objects, batches of requests, and routes [ODVA volume 1, chapters 2 and 3; 1756-PM020]."""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import lru_cache
from itertools import accumulate, pairwise

from scanrack.io_images.enip.codes import (
    BAD_SEGMENT,
    BAD_VALUE,
    BATCH,
    CHANGES,
    CLOCK,
    DONE,
    EXECUTE_PCCC,
    GET_ALL,
    IDENTITY,
    MANAGER,
    NO_CONNECTION,
    NO_SERVICE,
    NO_SLOT,
    PCCC,
    PROGRAM_NAME,
    ROUTER,
    SYMBOL,
    TEMPLATE,
    TOO_LARGE,
    TOO_SHORT,
    UNCONNECTED,
    UNKNOWN_OBJECT,
    CipRefusedError,
)
from scanrack.io_images.enip.paths import Path, parse_path

from .data_files import DataFiles
from .database import Database
from .objects import (
    INTERFACES,
    LOOPBACK,
    Lister,
    answer_changes,
    answer_clock,
    answer_identity,
    answer_interface,
    answer_template,
    identity,
)
from .tag_services import HEAD_BYTES, TAG_SERVICES, Answer
from .tag_snapshot import TagSnapshot

DEEPEST = 2
"""Maximum nesting of batches and routed requests."""

BATCH_MOST = 200
"""Maximum number of requests in a batch."""

PATHS_KEPT = 4096
"""Maximum number of paths whose targets are cached, because most clients repeat the same requests."""

OWN_ROUTE = (1, 0)
"""Port and slot of the controller on its backplane."""

_CLASSES = (ROUTER, MANAGER, SYMBOL, PROGRAM_NAME, PCCC)


class Router:
    """A router that answers requests to the objects of a controller.

    Args:
        name: name of the program.
        product: product name in the identity.
        address: IPv4 address of the server.
    """

    def __init__(
        self,
        database: Database,
        name: str = "rack",
        product: str = "1769-L33ER scanrack",
        address: bytes = LOOPBACK,
    ) -> None:
        self.database = database
        self.identity = identity(product.encode("ascii", "replace")[:32])
        self._name = name.encode("ascii", "replace")[:40]
        self._lister = Lister(database)
        self._path = lru_cache(PATHS_KEPT)(parse_path)
        self._target = lru_cache(PATHS_KEPT)(
            lambda path_bytes: database.resolve(self._path(path_bytes).steps)
        )
        self._files = DataFiles(database) if database.listing.files else None
        # by class; called with the service, the path, the data, the tags and the longest reply in bytes
        self._objects: dict[int | None, Callable[[int, Path, bytes, TagSnapshot, int], Answer]] = {
            SYMBOL: lambda service, path, data, _, most: self._lister.answer(service, path, data, most),
            TEMPLATE: lambda service, path, data, _, most: answer_template(
                database, service, path, data, most
            ),
            IDENTITY: lambda service, path, *_: answer_identity(self.identity, service, path),
            **dict.fromkeys(INTERFACES, lambda service, path, *_: answer_interface(address, service, path)),
            CLOCK: lambda service, _, *arguments: answer_clock(service, *arguments),
            CHANGES: lambda service, _, *arguments: answer_changes(service, *arguments),
        }

    def answer(self, request: bytes, snapshot: TagSnapshot, most: int, depth: int = 0) -> bytes:
        """Return the reply (service, status, data), at most `most` bytes long."""
        service = request[0] if request else 0
        try:
            path_bytes, data = split(request)
            path = self._path(path_bytes)
            if service == UNCONNECTED and path.numbers.get("class") == MANAGER:
                return self._answer_routed(data, snapshot, most, depth)
            return replied(service, self._serve(service, path_bytes, path, data, snapshot, most, depth), most)
        except CipRefusedError as refusal:
            return refused(service, refusal, most)
        except struct.error:
            return refused(service, CipRefusedError(TOO_SHORT), most)

    def _answer_routed(self, data: bytes, snapshot: TagSnapshot, most: int, depth: int) -> bytes:
        """Answer the request inside an Unconnected Send."""
        if depth >= DEEPEST:
            raise CipRefusedError(NO_SERVICE)
        (size,) = struct.unpack_from("<H", data, 2)
        if 4 + size > len(data):
            raise CipRefusedError(TOO_SHORT)
        offset = 4 + size + size % 2
        check_route(data[offset:])
        return self.answer(data[4 : 4 + size], snapshot, most, depth + 1)

    def _serve(
        self,
        service: int,
        path_bytes: bytes,
        path: Path,
        data: bytes,
        snapshot: TagSnapshot,
        most: int,
        depth: int,
    ) -> Answer:
        """Return status and data of the reply from the object in the path; refuse an unknown request."""
        kind = path.numbers.get("class")
        if service in TAG_SERVICES and path.steps and kind in (None, SYMBOL):
            return TAG_SERVICES[service](self.database, self._target(path_bytes), data, snapshot, most)
        if kind == ROUTER and service == BATCH:
            return DONE, self._answer_batch(data, snapshot, most, depth)
        if kind in self._objects:
            return self._objects[kind](service, path, data, snapshot, most)
        if kind == PROGRAM_NAME and service == GET_ALL:
            return DONE, struct.pack("<H", len(self._name)) + self._name
        if kind == PCCC and service == EXECUTE_PCCC and self._files is not None:
            return DONE, self._files.execute(data, snapshot)
        if kind in _CLASSES or path.steps:
            raise CipRefusedError(NO_SERVICE)
        raise CipRefusedError(BAD_SEGMENT if kind is None else UNKNOWN_OBJECT)

    def _answer_batch(self, data: bytes, snapshot: TagSnapshot, most: int, depth: int) -> bytes:
        """Return the replies of a batch; each reply leaves space to refuse the requests after it."""
        if depth >= DEEPEST:
            raise CipRefusedError(NO_SERVICE)
        (request_count,) = struct.unpack_from("<H", data)
        if not 1 <= request_count <= BATCH_MOST:
            raise CipRefusedError(BAD_VALUE)
        heads_size = 2 + 2 * request_count
        bytes_left = most - HEAD_BYTES - heads_size
        if bytes_left < 6 * request_count:  # a refusal has up to six bytes
            raise CipRefusedError(TOO_LARGE)
        offsets = [*struct.unpack_from(f"<{request_count}H", data, 2), len(data)]
        if offsets[0] < heads_size or any(end <= begin for begin, end in pairwise(offsets)):
            raise CipRefusedError(BAD_VALUE)
        replies: list[bytes] = []
        for number, (begin, end) in enumerate(pairwise(offsets), 1):
            reply = self.answer(
                data[begin:end], snapshot, bytes_left - 6 * (request_count - number), depth + 1
            )
            bytes_left -= len(reply)
            replies.append(reply)
        starts = list(accumulate(map(len, replies), initial=heads_size))[:-1]
        return struct.pack(f"<H{request_count}H", request_count, *starts) + b"".join(replies)


def check_route(data: bytes) -> None:
    """Refuse a route to another device; an empty route leads to this controller."""
    if len(data) < 2:
        return
    if len(data) < 2 + 2 * data[0]:
        raise CipRefusedError(TOO_SHORT)
    if any(port != OWN_ROUTE for port in parse_path(data[2 : 2 + 2 * data[0]]).ports):
        raise CipRefusedError(NO_CONNECTION, NO_SLOT)


def split(request: bytes) -> tuple[bytes, bytes]:
    """Return the path and the data of a request; refuse a request that is too short."""
    if len(request) < 2 or len(request) < 2 + 2 * request[1]:
        raise CipRefusedError(TOO_SHORT)
    end = 2 + 2 * request[1]
    return request[2:end], request[end:]


def replied(service: int, answer: Answer, most: int) -> bytes:
    """Return the reply to a request; refuse a reply longer than `most` bytes."""
    status, data = answer
    if HEAD_BYTES + len(data) > most:
        raise CipRefusedError(TOO_LARGE)
    return bytes((service & 0x7F | 0x80, 0, status, 0)) + data


def refused(service: int, refusal: CipRefusedError, most: int) -> bytes:
    """Return the reply to a refused request, without the extended status if that does not fit."""
    extra_words = refusal.more if HEAD_BYTES + 2 * len(refusal.more) <= most else ()
    return bytes((service & 0x7F | 0x80, 0, refusal.status, len(extra_words))) + struct.pack(
        f"<{len(extra_words)}H", *extra_words
    )
