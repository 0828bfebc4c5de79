"""Reads a text log of frames; each line has a time, a direction and bytes.

    0.000 > 01 03 00 00 00 26 c5 d0
    0.027 < 01 03 4c 00 00 ...
    12:00:01.250 TX: a5 01 70 00 00 00 00 16

`>`, `->`, TX, sent and request mark bytes to the controller; `<`, `<-`, RX, received and reply mark bytes
from it. Lines in any other form are skipped and counted. A time is in seconds, or in hours, minutes and
seconds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

LINE_MAX = 4096
_LINE = re.compile(
    r"\s*\[?(?:(?P<hours>\d{1,4}):(?P<minutes>\d\d):)?(?P<seconds>\d{1,12}(?:[.,]\d{1,9})?)\]?[\s,;]+"
    r"(?P<direction><-|->|[<>]|[A-Za-z]{2,8})[\s:,;]+(?P<hex>[0-9A-Fa-f]{2}(?:[\s:,-]?[0-9A-Fa-f]{2}){0,511})\s*"
)
_TO_DEVICE = {">", "->", "tx", "sent", "request"}
_FROM_DEVICE = {"<", "<-", "rx", "received", "reply"}
_NOT_HEX = re.compile(r"[^0-9A-Fa-f]")


@dataclass(frozen=True, slots=True)
class LoggedBytes:
    """The bytes in one line of a log."""

    at_ns: int
    to_device: bool
    data: bytes


class TextLog:
    """Reads the lines of a log.

    Attributes:
        passed_over: number of skipped lines so far.
    """

    def __init__(self) -> None:
        self.passed_over = 0

    def entries(self, lines: Iterable[str]) -> Iterator[LoggedBytes]:
        """Yield the bytes of the lines; times never decrease."""
        latest_ns = 0
        for line in lines:
            match = _LINE.fullmatch(line) if len(line) <= LINE_MAX else None
            direction = "" if match is None else match["direction"].lower()
            if match is None or direction not in _TO_DEVICE | _FROM_DEVICE:
                self.passed_over += bool(line.strip())
                continue
            latest_ns = max(latest_ns, _time_ns(match))
            data = bytes.fromhex(_NOT_HEX.sub("", match["hex"]))
            yield LoggedBytes(latest_ns, direction in _TO_DEVICE, data)


def _time_ns(match: re.Match[str]) -> int:
    whole_seconds, _, fraction = match["seconds"].replace(",", ".").partition(".")
    minutes = int(match["hours"] or 0) * 60 + int(match["minutes"] or 0)
    return (minutes * 60 + int(whole_seconds)) * 1_000_000_000 + int(fraction.ljust(9, "0"))
