"""Makes scans of a module's words from the EtherNet/IP reads and writes of a CompactLogix's clients.

Each packet that reads input words begins a scan, whatever else it reads. Output words in later packets belong
to the scan until the next such packet.
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
    seen = {False: bytearray(2 * WORDS), True: bytearray(2 * WORDS)}
    scans: list[WordScan] = []
    packet: tuple[int, int] | None = None  # times of the packet of the latest scan
    for exchange in exchanges:
        if not isinstance(exchange, ImageExchange):
            continue
        span = slice(exchange.at, exchange.at + len(exchange.data))
        image = images[exchange.output]
        image[span] = patched(bytes(image[span]), exchange.data, exchange.keep)
        seen[exchange.output][span] = b"\1" * len(exchange.data)
        now = exchange.requested_ns, exchange.answered_ns
        if not exchange.output and now != packet:
            scans.append(WordScan(exchange.answered_ns, [], []))
            packet = now
        if scans:
            scans[-1].apart |= exchange.output and now != packet
            scans[-1].outputs, scans[-1].inputs = _words(images[True]), _words(images[False])
    if not scans:
        raise ValueError("no input words are read, such as Local:1:I.Data")
    return scans, list(_missing(seen))


def _words(image: bytearray) -> list[int]:
    return [int.from_bytes(image[offset : offset + 2], "little") for offset in range(0, 2 * WORDS, 2)]


def _missing(seen: dict[bool, bytearray]) -> Iterator[str]:
    for output, marks in seen.items():
        missing = [str(word) for word in range(WORDS) if not any(marks[2 * word : 2 * word + 2])]
        if missing:
            way = "output" if output else "input"
            yield f"{way} words that no client reads or writes, 0 in the trace: {', '.join(missing)}"
