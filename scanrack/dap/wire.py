r"""Messages of the Debug Adapter Protocol on two streams: a header with the length, then JSON.

    Content-Length: 119\r\n\r\n{"seq": 1, "type": "request", "command": "threads"}

A separate thread reads messages, so that a scan never waits for a client.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from contextlib import suppress
from queue import SimpleQueue
from typing import IO, Any

from scanrack.io_images.doors import json_value

from .protocol import Json

BODY_MOST = 1 << 22
"""Longest message, bytes."""

HEADER_MOST = 1 << 12
"""Longest line of a header, bytes."""


class MalformedMessageError(ValueError):
    """Bytes that are not a message; the text is the reason."""


class Wire:
    """The connection to a client.

    Args:
        requests: the stream from the client.
        responses: the stream to the client.
    """

    def __init__(self, requests: IO[bytes], responses: IO[bytes]) -> None:
        self._requests, self._responses = requests, responses
        self._queue: SimpleQueue[Json | MalformedMessageError | None] = SimpleQueue()
        self._sent = 0
        self._sending = threading.Lock()
        threading.Thread(target=self._read_all, name="debug client", daemon=True).start()

    @property
    def waiting(self) -> bool:
        """Whether a message has arrived."""
        return not self._queue.empty()

    def next(self, seconds: float | None) -> Json | MalformedMessageError | None:
        """Return the next message; None at the end of the stream.

        Args:
            seconds: longest wait; None = no limit.

        Raises:
            Empty: no message arrived in this time.
        """
        return self._queue.get(timeout=seconds)

    def send(self, message: Mapping[str, Any]) -> None:
        """Send a message with the next number; do nothing if the client has disconnected."""
        with self._sending, suppress(OSError, ValueError):  # the input stream reports the disconnection
            self._sent += 1
            data = json.dumps({"seq": self._sent, **message}).encode()
            self._responses.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
            self._responses.flush()

    def _read_all(self) -> None:
        """Put messages and errors into the queue; put None at the end of the stream."""
        with suppress(OSError, ValueError):
            while True:
                try:
                    message = self._read()
                except MalformedMessageError as malformed:
                    self._queue.put(malformed)
                    continue
                if message is None:
                    break
                self._queue.put(message)
        self._queue.put(None)

    def _read(self) -> Json | None:
        """Return the next message; None at the end of the stream."""
        size: int | None = None
        while line := self._requests.readline(HEADER_MOST):
            if not line.strip():
                if size is not None:
                    return self._body(size)
                continue  # an empty line between messages
            name, _, value = line.partition(b":")
            if name.strip().lower() == b"content-length":
                size = _size(value)
            elif size is None and b":" not in line:
                raise MalformedMessageError(
                    f"{line[:40]!r} is not a header: a message begins with Content-Length"
                )
        return None

    def _body(self, size: int) -> Json | None:
        """Return a message of `size` bytes; None if the stream ends before that."""
        data = self._requests.read(size)
        if len(data) < size:
            return None
        try:
            message = json_value(data)
        except (ValueError, RecursionError) as error:
            raise MalformedMessageError(f"{data[:40]!r} is not JSON: {error}") from error
        if not isinstance(message, dict):
            raise MalformedMessageError(f"{data[:40]!r} is not a message: it must be an object")
        return message


def _size(text: bytes) -> int:
    """Return the length in a header; raise MalformedMessageError unless it is 0 to `BODY_MOST`."""
    value = text.strip()
    if not value.isdigit() or len(value) > 9 or int(value) > BODY_MOST:
        raise MalformedMessageError(f"Content-Length {value[:20]!r}: must be 0 to {BODY_MOST:,}")
    return int(value)
