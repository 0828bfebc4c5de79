"""Detects devices on a line by read-only requests to each address in turn.

    PCL601 in Modbus RTU    function 11h, report address and firmware      38,400 8E1
    PCL601 in AA ASCII      @% CR, verify axis number, to any address      38,400 8N1
    PMC006x3s               j, read status register 1                       9,600 8N1

No request changes a value or starts a motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace

from scanrack.io_images.pmc006.frame import FACTORY_ADDRESS

from .. import pcl601_ascii as ascii
from .. import pcl601_frames as rtu
from .. import pmc006_frames as pmc006
from ..master import LineRequest, Reply
from ..pcl601_pdus import report_id
from ..wire import LineFormat
from .link import SILENCE_S, Link, drain

ANSWER_S = 0.1
"""Longest wait for an answer, s; USB adapters delay received bytes by 16 ms."""

PCL601_ADDRESSES = range(1, 100)
PMC006_ADDRESSES = (FACTORY_ADDRESS, *range(1, 121))


@dataclass(frozen=True, slots=True)
class FoundDevice:
    """A device that has answered."""

    controller: str
    address: int
    language: str
    line_format: LineFormat

    def __str__(self) -> str:
        return f"{self.controller} at address {self.address}, {self.language}, {self.line_format}"


OnRequest = Callable[[str, int], None]
"""Function called before every request with its protocol and address; 0 means any address."""

OpenLine = Callable[[LineFormat], Link]
"""Function that opens the line in a format."""


def probe(
    open_line: OpenLine, addresses: Iterable[int] | None, on_request: OnRequest
) -> Iterator[FoundDevice]:
    """Probe the addresses in each protocol in turn; yield each device as soon as it answers.

    Args:
        open_line: function that opens the line in a format; the line is closed before it is opened in another
            format.
        addresses: the addresses to probe, or None for all possible addresses.
        on_request: called before every request.

    Raises:
        LinkError: the line can't be opened, or it is lost.
    """
    chosen = None if addresses is None else frozenset(addresses)
    yield from _find_in_turn(
        open_line,
        FoundDevice("PCL601", 0, "Modbus RTU", rtu.LINE_FORMAT),
        [address for address in PCL601_ADDRESSES if chosen is None or address in chosen],
        lambda address: rtu.request(address, report_id()),
        on_request,
    )
    yield from _find_ascii(open_line, chosen, on_request)
    yield from _find_in_turn(
        open_line,
        FoundDevice("PMC006", 0, "its own frames", pmc006.LINE_FORMAT),
        [address for address in PMC006_ADDRESSES if chosen is None or address in chosen],
        lambda address: pmc006.reading(address, "read_status1"),
        on_request,
    )


def questions(addresses: Iterable[int] | None) -> int:
    """Return the maximum number of requests in a probe.

    >>> questions(None), questions([1, 255])
    (221, 4)
    """
    if addresses is None:
        return len(PCL601_ADDRESSES) + 1 + len(PMC006_ADDRESSES)
    return 1 + sum((address in PCL601_ADDRESSES) + (address in PMC006_ADDRESSES) for address in addresses)


def answers(link: Link, request: LineRequest) -> bool:
    """Send a request once; return whether a valid answer arrives."""
    drain(link, SILENCE_S)
    link.send(request.frame)
    received = b""
    while len(received) < request.size and (data := link.receive(1, ANSWER_S)):
        received += data
        if isinstance(request.read(received), Reply):
            return True
    return False


def _find_in_turn(
    open_line: OpenLine,
    device: FoundDevice,
    addresses: Iterable[int],
    request_for: Callable[[int], LineRequest],
    on_request: OnRequest,
) -> Iterator[FoundDevice]:
    """Probe each address in turn; yield `device` with each address that answers."""
    with closing(open_line(device.line_format)) as link:
        for address in addresses:
            on_request(device.language, address)
            if answers(link, request_for(address)):
                yield replace(device, address=address)


def _find_ascii(
    open_line: OpenLine, chosen: frozenset[int] | None, on_request: OnRequest
) -> Iterator[FoundDevice]:
    """Find devices in AA ASCII by asking for their addresses; simultaneous answers garble each other."""
    line_format = ascii.LINE_FORMAT
    with closing(open_line(line_format)) as link:
        on_request("AA ASCII", 0)
        drain(link, SILENCE_S)
        link.send(ascii.ASK)
        received = link.receive(ascii.ANSWER_MAX, ANSWER_S)
    digits = received.removesuffix(b"\r\n")
    if digits != received and digits.isdigit() and (chosen is None or int(digits) in chosen):
        yield FoundDevice("PCL601", int(digits), "AA ASCII", line_format)
