"""The master's end of a line: one request at a time, driven by a script.

    quiet   |  request  |  reply  |  quiet  |  request ...
    gap_ns                         gap_ns
            sent_ns ------ patience ------> failed

A late reply can arrive up to `LATE_NS` after the time limit, and can look like the reply to a later request.

A script is a generator. It yields a `LineRequest` and receives the `Reply`, or None if the exchange failed
because the reply was missing, damaged or for another request. It yields a `LinePause` to wait, and `PUBLISH`
when the caller should read its results.

Time is virtual, and the caller reads and writes all bytes. By contrast, pymodbus's clients use a port and the
wall clock.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from .wire import LineFormat


class Reply(NamedTuple):
    """The reply to a request."""

    data: bytes
    refused: int | None = None  # the code of a refusal, None if the device has obeyed
    words: tuple[int, ...] = ()  # registers that a Modbus request has read


class Verdict(Enum):
    """State of the received bytes if they are not a reply."""

    UNFINISHED = "unfinished"
    FOREIGN = "no reply to this request"


Read = Callable[[bytes], Reply | Verdict]
"""Function that returns the reply in the received bytes, or their state if they are not a reply."""


@dataclass(frozen=True, slots=True)
class LineRequest:
    """A frame to send."""

    frame: bytes
    size: int  # bytes of the reply
    read: Read
    line_format: LineFormat | None = None  # format of request and reply, None for the line's usual format


@dataclass(frozen=True, slots=True)
class LinePause:
    """A wait."""

    duration_ns: int


class Publish(Enum):
    """The token that a script yields to publish its results."""

    PUBLISH = "publish"


PUBLISH = Publish.PUBLISH
Step = LineRequest | LinePause | Publish
Script = Generator[Step, Reply | None, None]


LATE_NS = 1_000_000_000
"""Longest time from the failure of a request to the arrival of its late reply."""


@dataclass(frozen=True, slots=True)
class LineTiming:
    """Timing of a line."""

    line_format: LineFormat
    gap_ns: int  # silence before a request
    patience_ns: int  # longest wait for a reply, in addition to its time on the line
    second_ns: int = 0  # wait for a second reply while replies may be late, if they do not identify requests


class Master:
    """Runs a script over a line.

    Attributes:
        now_ns: the current time, which scripts read.
        published: whether the script has new results; the caller reads them and clears this flag.
        failures: number of failed exchanges.
        line_format: the current format of the line.
    """

    def __init__(self, line_timing: LineTiming) -> None:
        self.now_ns = 0
        self.published = False
        self.failures = 0
        self.line_format = line_timing.line_format
        self._timing = line_timing
        self._script: Script | None = None
        self._request: LineRequest | None = None  # the present request, None during a pause
        self._is_sent = False
        self._quiet_from_ns = 0  # the end of the gap before a request
        self._deadline_ns = 0  # of the reply to a sent request
        self._pause_until_ns: int | None = None
        self._received = bytearray()
        self._late_until_ns: list[int] = []  # for each missing reply, until when it may arrive

    @property
    def overdue(self) -> int:
        """Number of missing replies that can still arrive."""
        self._late_until_ns = [instant_ns for instant_ns in self._late_until_ns if instant_ns > self.now_ns]
        return len(self._late_until_ns)

    def expect_nothing_late(self) -> None:
        """Expect no late replies, because the device lost its requests or replies identify their requests."""
        self._late_until_ns.clear()

    def wake(self) -> None:
        """End the script's pause at the next `advance`."""
        if self._request is None and self._pause_until_ns is not None:
            self._pause_until_ns = min(self._pause_until_ns, self.now_ns)

    def begin(self, script: Script) -> None:
        """Start a script."""
        self._script = script
        self._request = None
        self._pause_until_ns = self.now_ns

    @property
    def next_wake_ns(self) -> int:
        """Instant at which `advance` must be called next."""
        if self.published:
            return self.now_ns
        if self._request is None:
            return self._pause_until_ns if self._pause_until_ns is not None else self.now_ns
        return self._deadline_ns if self._is_sent else max(self.now_ns, self._quiet_from_ns)

    def receive(self, now_ns: int, data: bytes) -> None:
        """Receive characters; the last one is complete at `now_ns`. Drop characters outside an exchange."""
        if not data:
            return
        self.now_ns = now_ns
        self._quiet_from_ns = now_ns + self._timing.gap_ns
        if self._request is None or not self._is_sent:
            return
        self._received += data
        reply = self._request.read(bytes(self._received))
        if isinstance(reply, Reply):
            if self._timing.second_ns and self.overdue:
                self._deadline_ns = now_ns + self._timing.second_ns
            else:
                self._resume(reply)

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the bytes to send at that instant."""
        self.now_ns = now_ns
        while not self.published:
            if self._request is None:
                if self._pause_until_ns is not None and now_ns < self._pause_until_ns:
                    return b""
                self._resume(None)
            elif not self._is_sent:
                return self._send(self._request) if now_ns >= self._quiet_from_ns else b""
            elif now_ns >= self._deadline_ns:
                self._end_wait(self._request)
            else:
                return b""
        return b""

    def _end_wait(self, request: LineRequest) -> None:
        """Resume the script with the reply, or with None if the bytes are not exactly one reply.

        A missing reply counts as a failure, and can still arrive late.
        """
        reply = request.read(bytes(self._received))
        if isinstance(reply, Reply):
            self._resume(reply)
            return
        self.failures += 1
        self._late_until_ns.append(self.now_ns + LATE_NS)
        self._quiet_from_ns = max(self._quiet_from_ns, self.now_ns + self._timing.gap_ns)
        self._resume(None)

    def _send(self, request: LineRequest) -> bytes:
        """Return the frame of a request; set the deadline of its reply, and the silence after the frame."""
        line_timing = self._timing
        self.line_format = request.line_format or line_timing.line_format
        end_ns = self.now_ns + self.line_format.span_ns(len(request.frame))
        self._is_sent = True
        self._quiet_from_ns = end_ns + line_timing.gap_ns
        self._deadline_ns = end_ns + line_timing.patience_ns + self.line_format.span_ns(request.size)
        return request.frame

    def _resume(self, reply: Reply | None) -> None:
        """Resume the script with a reply, and store its next step."""
        assert self._script is not None
        self._request, self._is_sent, self._pause_until_ns = None, False, None
        self._received.clear()
        step = self._script.send(reply)
        if isinstance(step, LineRequest):
            self._request = step
        elif isinstance(step, LinePause):
            self._pause_until_ns = self.now_ns + step.duration_ns
        else:
            self.published = True
            self._pause_until_ns = self.now_ns
