"""A trace of a 3601 as remote I/O: what a PLC reads and writes over Modbus TCP, by the map of `remote_words`.

A scan is a read of input words, with the output words that the PLC writes until its next read: as a program
that reads, computes and writes. A write without a read before it belongs to the first scan.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from struct import Struct

from ...runtime.line.remote_words import (
    READ_HOLDING,
    READ_INPUTS,
    WORDS,
    WRITE_AND_READ,
    WRITE_ONE,
    WRITE_SEVERAL,
)
from ...traces.format.layout import SlotInfo, block_layout
from ...traces.write.recorder import ScanRecorder
from .pairing import PairedExchange
from .recording import RUN_MODE, SCAN_PERIOD_NS

CATALOG = "amci3601"
_PAIR = Struct(">HH")
_BOTH = Struct(">HHHH")
_IMAGES = Struct(f"<{2 * WORDS}H")

Span = tuple[int, bytes]
"""Address of the first word, and words, high byte first."""


@dataclass(slots=True)
class WordScan:
    """The words of a scan, 0 to 65,535.

    Attributes:
        apart: output words were told by another packet than the input words.
    """

    at_ns: int
    outputs: list[int]
    inputs: list[int]
    apart: bool = False


def word_scans(exchanges: Sequence[PairedExchange]) -> list[WordScan]:
    """Return the scans of a PLC, in order.

    Raises:
        ValueError: it reads no input words.
    """
    scans: list[WordScan] = []
    outputs, inputs = [0] * WORDS, [0] * WORDS
    for exchange in exchanges:
        if exchange.reply is None or exchange.reply[:1] != exchange.request[:1]:
            continue  # unanswered, or refused
        if _put(inputs, _read(exchange.request, exchange.reply)):
            scans.append(WordScan(exchange.answered_ns, list(outputs), list(inputs)))
        if _put(outputs, _written(exchange.request)) and scans:
            scans[-1].outputs = list(outputs)
    if not scans:
        raise ValueError("no input words are read: registers 0 to 7 by function 04, or 8 to 15 by 03 or 17h")
    return scans


def _read(request: bytes, reply: bytes) -> Span | None:
    """Return the input words that a reply brings: their number in the input image, and the words."""
    if request[0] not in (READ_HOLDING, READ_INPUTS, WRITE_AND_READ) or len(request) < 5:
        return None
    first, _ = _PAIR.unpack_from(request, 1)
    return first - (0 if request[0] == READ_INPUTS else WORDS), reply[2:]


def _written(request: bytes) -> Span | None:
    if request[0] == WRITE_ONE and len(request) == 5:
        return _PAIR.unpack_from(request, 1)[0], request[3:]
    if request[0] == WRITE_SEVERAL and len(request) > 6:
        return _PAIR.unpack_from(request, 1)[0], request[6:]
    if request[0] == WRITE_AND_READ and len(request) > 10:
        return _BOTH.unpack_from(request, 1)[2], request[10:]
    return None


def _put(image: list[int], span: Span | None) -> bool:
    """Put words into an image; return whether any is of it."""
    if span is None:
        return False
    found = dict(_inside(*span))
    for at, word in found.items():
        image[at] = word
    return bool(found)


def _inside(first: int, data: bytes) -> Iterator[tuple[int, int]]:
    for place in range(len(data) // 2):
        if 0 <= first + place < WORDS:
            yield first + place, int.from_bytes(data[2 * place : 2 * place + 2], "big")


SAMPLED, SAMPLED_APART = "sampled", "sampled apart"
"""Facts `words` of a trace whose scans are a client's reads: of both images in one packet, or in several."""

CAPTURED_AT = "captured_at"
"""Fact of a trace: date and time of its beginning, by the clock of the capture."""

_YEAR_2000_NS = 946_684_800 * 10**9


def is_sampled(facts: Mapping[str, str]) -> bool:
    """Whether the scans of a trace are a client's reads, by its facts."""
    return facts.get("words") in (SAMPLED, SAMPLED_APART)


def record_words(
    target: Path, scans: Sequence[WordScan], begin_ns: int, slot: int = 1, *, sampled: bool = False
) -> None:
    """Write a trace of scans.

    Args:
        begin_ns: its time 0.
        slot: of the module.
        sampled: the scans are a client's reads, between which words may come and go.

    Raises:
        OSError: it can't be written.
    """
    facts = {"name": target.stem, "controller": "remote i/o", "source": "capture"}
    if sampled:
        facts["words"] = SAMPLED_APART if any(each.apart for each in scans) else SAMPLED
    if begin_ns > _YEAR_2000_NS:
        facts[CAPTURED_AT] = datetime.fromtimestamp(begin_ns // 10**9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    module = SlotInfo(slot, CATALOG, "4.1")
    memory = bytearray(block_layout([module]).size)
    recorder = ScanRecorder(target, memory, [module], scan_period_ns=SCAN_PERIOD_NS, metadata=facts)
    with closing(recorder):
        for number, scan in enumerate(scans):
            _IMAGES.pack_into(memory, 0, *scan.outputs, *scan.inputs)
            recorder.scan(number, scan.at_ns - begin_ns, RUN_MODE)
