"""Detection of controllers on a line: read-only requests to one address after the other.

    PCL601 in Modbus RTU    function 11h, report address and firmware      38,400 8E1
    PCL601 in AA ASCII      @% CR, verify axis number, to any address      38,400 8N1
    PMC006x3s               j, read status register 1                       9,600 8N1

No request changes anything, and none starts a motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from scanrack.io_images.pmc006.frame import FACTORY_ADDRESS

from .. import pcl601_ascii as ascii
from .. import pcl601_frames as rtu
from .. import pmc006_frames as pmc006
from ..master import LineRequest, Reply
from ..pcl601_pdus import report_id
from ..wire import LineFormat
from .link import SILENCE_S, Link, drain

ANSWER_S = 0.1
"""Longest wait for an answer; USB adapters hold back received bytes for 16 ms."""

PCL601_ADDRESSES = range(1, 100)
PMC006_ADDRESSES = (FACTORY_ADDRESS, *range(1, 121))


@dataclass(frozen=True, slots=True)
class FoundDevice:
    """A controller that has answered."""

    controller: str
    address: int
    language: str
    line_format: LineFormat

    def __str__(self) -> str:
        return f"{self.controller} at address {self.address}, {self.language}, {self.line_format}"


Asked = Callable[[str, int], None]
"""Called before every request with its receiver: a language and an address, 0 for any."""

Opened = Callable[[LineFormat], Link]
"""Opens the line in a format."""


def probe(opened: Opened, addresses: Iterable[int] | None, on_request: Asked) -> Iterator[FoundDevice]:
    """Ask in one language after the other; yield each controller as soon as it answers.

    Args:
        opened: opens the line in a format; it is closed before it is opened in another one.
        addresses: the addresses to probe; None = all possible addresses.
        on_request: called before every request.

    Raises:
        LinkError: the line can't be opened, or is lost.
    """
    chosen_addresses = None if addresses is None else tuple(addresses)
    units = [
        address for address in PCL601_ADDRESSES if chosen_addresses is None or address in chosen_addresses
    ]
    sites = [
        address for address in PMC006_ADDRESSES if chosen_addresses is None or address in chosen_addresses
    ]
    yield from _rtu(opened, units, on_request)
    yield from _ascii(opened, chosen_addresses, on_request)
    yield from _pmc006(opened, sites, on_request)


def questions(addresses: Iterable[int] | None) -> int:
    """Return the maximum number of requests of a probe.

    >>> questions(None), questions([1, 255])
    (221, 4)
    """
    if addresses is None:
        return len(PCL601_ADDRESSES) + 1 + len(PMC006_ADDRESSES)
    return 1 + sum((address in PCL601_ADDRESSES) + (address in PMC006_ADDRESSES) for address in addresses)


def answer_to(link: Link, request: LineRequest) -> bool:
    """Ask once; return whether the received bytes are a valid answer."""
    drain(link, SILENCE_S)
    link.send(request.frame)
    answer = b""
    while len(answer) < request.size and (data := link.receive(1, ANSWER_S)):
        answer += data
        if isinstance(request.read(answer), Reply):
            return True
    return False


def _rtu(opened: Opened, units: Iterable[int], on_request: Asked) -> Iterator[FoundDevice]:
    line_format = rtu.LINE_FORMAT
    for unit in _answering(opened, line_format, "Modbus RTU", units, _ask_identity, on_request):
        yield FoundDevice("PCL601", unit, "Modbus RTU", line_format)


def _pmc006(opened: Opened, sites: Iterable[int], on_request: Asked) -> Iterator[FoundDevice]:
    for site in _answering(opened, pmc006.LINE_FORMAT, "PMC006", sites, _ask_status, on_request):
        yield FoundDevice("PMC006", site, "its own frames", pmc006.LINE_FORMAT)


def _ask_identity(unit: int) -> LineRequest:
    return rtu.request(unit, report_id())


def _ask_status(site: int) -> LineRequest:
    return pmc006.reading(site, "read_status1")


def _answering(
    opened: Opened,
    line_format: LineFormat,
    language: str,
    addresses: Iterable[int],
    question: Callable[[int], LineRequest],
    on_request: Asked,
) -> Iterator[int]:
    link = opened(line_format)
    try:
        for address in addresses:
            on_request(language, address)
            if answer_to(link, question(address)):
                yield address
    finally:
        link.close()


def _ascii(opened: Opened, chosen: tuple[int, ...] | None, on_request: Asked) -> Iterator[FoundDevice]:
    """Ask units in ASCII for their address; simultaneous answers garble each other."""
    line_format = ascii.LINE_FORMAT
    link = opened(line_format)
    try:
        on_request("AA ASCII", 0)
        drain(link, SILENCE_S)
        link.send(ascii.ASK)
        answer = link.receive(ascii.ANSWER_MAX, ANSWER_S)
    finally:
        link.close()
    digits = answer.removesuffix(b"\r\n")
    if digits != answer and digits.isdigit() and (chosen is None or int(digits) in chosen):
        yield FoundDevice("PCL601", int(digits), "AA ASCII", line_format)
