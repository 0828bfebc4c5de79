"""A rack of modules with 2, 31, 8 and 8 + 4 words: its memory, its exchange, and its recording.

slot 1  2 + 2     slot 2  31 + 31     slot 3  8 + 4     slot 5  a 3601
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from scanrack.io_images import Image
from scanrack.io_images.memory_layout import ALIGNED_TO, memory_layout
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.runtime.modules.amci3601 import Amci3601
from scanrack.traces import open_trace
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.format.tagplan import Tag, plan_of
from scanrack.traces.read.arrays import read_columns
from scanrack.traces.write.recorder import ScanRecorder
from sized import SIZES, Repeater, words_of

MS = 1_000_000
SLOTS = {1: "small", 2: "large", 3: "mixed"}
AT = {  # byte of each image in the memory: two bytes a word, output before input
    (1, "out"): 0, (1, "in"): 4,
    (2, "out"): 8, (2, "in"): 70,
    (3, "out"): 132, (3, "in"): 148,
    (5, "out"): 156, (5, "in"): 172,
}  # fmt: skip
END = 188


def rack() -> Rack:
    own = (Card(slot, Repeater(*SIZES[name]), name, words=words_of(name)) for slot, name in SLOTS.items())
    return Rack([*own, Card(5, Amci3601(), "amci3601", "4.1")])


def test_the_images_of_a_rack_follow_each_other() -> None:
    made = rack()
    assert len(made.memory) == 192 == -(-END // ALIGNED_TO) * ALIGNED_TO
    for number, slot in made.slots.items():
        for direction, image in (("out", slot.outputs), ("in", slot.inputs)):
            image[0], image[-1] = 1, -1
            at, end = AT[number, direction], AT[number, direction] + 2 * len(image)
            assert made.memory[at : at + 2] == b"\x01\x00", (number, direction)
            assert made.memory[end - 2 : end] == b"\xff\xff"
            image.clear()
    assert made.memory == bytes(192)
    assert [len(slot.outputs) for slot in made.slots.values()] == [2, 31, 8, 8]
    assert [len(slot.inputs) for slot in made.slots.values()] == [2, 31, 4, 8]


@pytest.mark.parametrize("exchange", [EndOfScan(), EveryRpi(2 * MS)], ids=["end of scan", "every RPI"])
def test_every_word_is_exchanged(exchange: Any) -> None:
    made = rack()
    exchange.attach(made)
    for slot in made.slots.values():
        for word in range(len(slot.outputs)):
            slot.outputs[word] = 2 * (100 * slot.number + word) if slot.number < 5 else 0
    made.slots[2].outputs.set_bit(30, 0, True)
    for now_ns in range(0, 12 * MS, 2 * MS):
        exchange.latch_inputs(now_ns)
        exchange.latch_outputs()
    assert list(made.slots[1].inputs) == [200, 0]
    *repeated, counted = made.slots[2].inputs
    assert repeated == [2 * (200 + word) for word in range(30)]
    assert counted > 0
    assert list(made.slots[3].inputs) == [600, 602, 604, 0]


@pytest.mark.parametrize(("outputs", "inputs", "says"), [(0, 2, "0 output"), (2, 251, "251 input")])
def test_a_module_without_words_or_with_too_many_is_refused(outputs: int, inputs: int, says: str) -> None:
    words = ModuleWords("Odd", tuple(map(str, range(outputs))), tuple(map(str, range(inputs))))
    with pytest.raises(ValueError, match=f"slot 4: Odd has {says} words: must be 1 to 250"):
        Rack([Card(4, Repeater(2, 2), words=words)])


def test_the_block_of_eight_word_modules_has_no_padding() -> None:
    """Recordings of racks with 3601s and cards have the bytes that they always had."""
    for modules in range(1, 5):
        layout = memory_layout((number, PLAIN_WORDS) for number in range(1, modules + 1))
        assert (layout.size, layout.padding) == (32 * modules, 0)


class Tags:
    """A DINT and a LREAL, which need alignment in CDR."""

    plan = plan_of([Tag("Count", "DINT"), Tag("Length", "LREAL")])

    def __init__(self, memory: bytearray) -> None:
        self.pending: list[Any] = []
        self._memory = memory

    def take(self) -> bytes:
        return bytes(self._memory) + struct.pack("<di", 1.5, 7)


def value(scan: int, slot: int, direction: str, word: int) -> int:
    return (scan * 31 + slot * 1_000 + word * 7 + (direction == "in") * 3) % 30_000


@pytest.fixture(scope="module", params=[False, True], ids=["without tags", "with tags"])
def recorded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sizes") / "sizes.mcap"
    made = rack()
    slots = [SlotInfo(each.number, each.catalog, each.firmware, each.words) for each in made.slots.values()]
    tags = Tags(made.memory) if request.param else None
    recorder = ScanRecorder(path, made.memory, slots, scan_period_ns=MS, chunk_scans=20, tags=tags)
    for scan in range(50):
        for slot in made.slots.values():
            for direction, image in (("out", slot.outputs), ("in", slot.inputs)):
                for word in range(len(image)):
                    image[word] = value(scan, slot.number, direction, word)
        recorder.scan(scan, scan * MS, 1)
    recorder.close()
    return path


def test_a_recording_has_every_word_by_name(recorded: Path) -> None:
    with open_trace(recorded) as trace:
        words = {slot.number: slot.words for slot in trace.head.slots}
        assert {slot: words[slot].inputs for slot in SLOTS} == {
            slot: words_of(name).inputs for slot, name in SLOTS.items()
        }
        assert words[2].groups["command"] == words_of("large").groups["command"]
        for scan in trace.scans():
            for slot in (1, 2, 3, 5):
                for direction, image in (("out", scan.outputs(slot)), ("in", scan.inputs(slot))):
                    assert list(image) == [
                        value(scan.scan, slot, direction, word) for word in range(len(image))
                    ]
            assert isinstance(scan.inputs(2), Image)
        named = trace.by_name()
        assert named["slot2"]["in"]["counted"].tolist() == [value(scan, 2, "in", 30) for scan in range(50)]
        assert named["slot3"]["out"]["out7"].tolist() == [value(scan, 3, "out", 7) for scan in range(50)]
        columns = read_columns(trace, tags=True)
        if columns.tags is not None:
            assert columns.tags["count"].tolist() == [7] * 50
            assert columns.tags["length"].tolist() == [1.5] * 50


def test_the_stock_reader_and_a_ros2_decoder_read_it(recorded: Path) -> None:
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support is not installed")
    with recorded.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        decoded: list[Any] = [found.decoded_message for found in reader.iter_decoded_messages("/scan")]
    assert len(decoded) == 50
    for scan, message in enumerate(decoded):
        for slot, name in SLOTS.items():
            own = words_of(name)
            for direction, names in (("out", own.outputs), ("in", own.inputs)):
                image = getattr(getattr(message, f"slot{slot}"), f"{direction}puts")
                for word, field in enumerate(names):
                    assert getattr(image, field) == value(scan, slot, direction, word), (slot, field)
        if hasattr(message, "tags"):
            assert (message.tags.count, message.tags.length) == (7, 1.5)
