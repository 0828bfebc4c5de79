"""Builds scans of a module's words from EtherNet/IP reads and writes by clients of a CompactLogix.

Each packet that reads input words starts a scan. Output words belong to the latest scan.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scanrack.io_images.enip.listing import patched
from scanrack.io_images.image import WORDS

from .cip_pairing import ImageExchange
from .pairing import PairedExchange
from .words import WordScan


def cip_scans(exchanges: Sequence[PairedExchange]) -> tuple[list[WordScan], list[str]]:
    """Return the scans of one module, in order, and a sentence for each image with missing words.

    Raises:
        ValueError: no packet reads an input word.
    """
    images = {False: bytearray(2 * WORDS), True: bytearray(2 * WORDS)}
    used_bytes = {False: bytearray(2 * WORDS), True: bytearray(2 * WORDS)}
    scans: list[WordScan] = []
    packet: tuple[int, int] | None = None  # times of the packet of the latest scan
    for exchange in exchanges:
        if not isinstance(exchange, ImageExchange):
            continue
        span = slice(exchange.offset, exchange.offset + len(exchange.data))
        image = images[exchange.output]
        image[span] = patched(bytes(image[span]), exchange.data, exchange.keep)
        used_bytes[exchange.output][span] = b"\1" * len(exchange.data)
        times = exchange.requested_ns, exchange.answered_ns
        if not exchange.output and times != packet:
            scans.append(WordScan(exchange.answered_ns, [], []))
            packet = times
        if scans:
            scans[-1].apart |= exchange.output and times != packet
            scans[-1].outputs, scans[-1].inputs = _words(images[True]), _words(images[False])
    if not scans:
        raise ValueError("no input words are read, such as Local:1:I.Data")
    return scans, list(_missing(used_bytes))


def _words(image: bytearray) -> list[int]:
    return [int.from_bytes(image[offset : offset + 2], "little") for offset in range(0, 2 * WORDS, 2)]


def _missing(used_bytes: dict[bool, bytearray]) -> Iterator[str]:
    """Yield a sentence for each image with words that no message reads or writes."""
    for output, marks in used_bytes.items():
        missing = [str(word) for word in range(WORDS) if not any(marks[2 * word : 2 * word + 2])]
        if missing:
            kind = "output" if output else "input"
            yield f"{kind} words that no client reads or writes, 0 in the trace: {', '.join(missing)}"
