"""Converts a PLC's Modbus TCP reads and writes of a remote 3601 to traces (`remote_words`).

A scan is a read of input words and the writes of output words that follow, up to the next read. A write
before the first read belongs to the first scan.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from struct import Struct

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu.register_message import ReadWriteMultipleRegistersRequest
from scanrack.io_images.image import WORDS
from scanrack.runtime.line.remote_words import (
    READ_HOLDING,
    READ_INPUTS,
    WRITE_ONE,
    WRITE_SEVERAL,
)
from scanrack.traces.format.layout import SlotInfo, block_layout
from scanrack.traces.write.recorder import ScanRecorder

from .pairing import PairedExchange, decoded
from .recording import RUN_MODE, SCAN_PERIOD_NS

CATALOG = "amci3601"
_IMAGES = Struct(f"<{2 * WORDS}H")

Span = tuple[int, Sequence[int]]
"""Number of the first word, and the words."""
NO_WORDS: Span = 0, ()


@dataclass(slots=True)
class WordScan:
    """The words of a scan, 0 to 65,535.

    Attributes:
        apart: whether the output words come from a different packet than the input words.
    """

    at_ns: int
    outputs: list[int]
    inputs: list[int]
    apart: bool = False


def word_scans(exchanges: Sequence[PairedExchange]) -> list[WordScan]:
    """Return the scans of a PLC, in order.

    Raises:
        ValueError: the PLC reads no input words.
    """
    scans: list[WordScan] = []
    outputs, inputs = [0] * WORDS, [0] * WORDS
    for exchange in exchanges:
        pair = decoded(exchange)
        if pair is None:
            continue
        request, reply = pair
        if _copy_words(inputs, _input_span(request, reply)):
            scans.append(WordScan(exchange.answered_ns, list(outputs), list(inputs)))
        if _copy_words(outputs, _output_span(request)) and scans:
            scans[-1].outputs = list(outputs)
    if not scans:
        raise ValueError("no reads of input words: registers 0 to 7 by function 04, or 8 to 15 by 03 or 17h")
    return scans


def _input_span(request: ModbusPDU, reply: ModbusPDU) -> Span:
    """Return the input words in a reply: the number of the first word in the input image, and the words."""
    if isinstance(request, ReadWriteMultipleRegistersRequest):
        return request.read_address - WORDS, reply.registers
    if request.function_code == READ_HOLDING:
        return request.address - WORDS, reply.registers
    return (request.address, reply.registers) if request.function_code == READ_INPUTS else NO_WORDS


def _output_span(request: ModbusPDU) -> Span:
    if isinstance(request, ReadWriteMultipleRegistersRequest):
        return request.write_address, request.write_registers
    is_write = request.function_code in (WRITE_ONE, WRITE_SEVERAL)
    return (request.address, request.registers) if is_write else NO_WORDS


def _copy_words(image: list[int], span: Span) -> bool:
    """Copy words into an image; return whether any word belongs to the image."""
    first, words = span
    image_words = {number: word for number, word in enumerate(words, first) if 0 <= number < WORDS}
    for number, word in image_words.items():
        image[number] = word
    return bool(image_words)


SAMPLED, SAMPLED_APART = "sampled", "sampled apart"
"""Values of the fact `words` in traces of a client's reads, in one packet or in several."""

CAPTURED_AT = "captured_at"
"""Name of the fact with the start of a trace, as the date and time of the capture's clock."""

_YEAR_2000_NS = 946_684_800 * 10**9


def is_sampled(facts: Mapping[str, str]) -> bool:
    """Return whether the scans of a trace are a client's reads, by its facts."""
    return facts.get("words") in (SAMPLED, SAMPLED_APART)


def record_words(
    target: Path, scans: Sequence[WordScan], begin_ns: int, slot: int = 1, *, sampled: bool = False
) -> None:
    """Write a trace of scans.

    Args:
        begin_ns: time 0 of the trace, in the time of the scans, ns.
        slot: slot number of the module.
        sampled: whether the scans are a client's reads, between which words can change unseen.

    Raises:
        OSError: the file can't be written.
    """
    facts = {"name": target.stem, "controller": "remote i/o", "source": "capture"}
    if sampled:
        facts["words"] = SAMPLED_APART if any(sample.apart for sample in scans) else SAMPLED
    if begin_ns > _YEAR_2000_NS:
        facts[CAPTURED_AT] = datetime.fromtimestamp(begin_ns // 10**9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    module = SlotInfo(slot, CATALOG, "4.1")
    memory = bytearray(block_layout([module]).size)
    recorder = ScanRecorder(target, memory, [module], scan_period_ns=SCAN_PERIOD_NS, metadata=facts)
    with closing(recorder):
        for number, scan in enumerate(scans):
            _IMAGES.pack_into(memory, 0, *scan.outputs, *scan.inputs)
            recorder.scan(number, scan.at_ns - begin_ns, RUN_MODE)
