"""A 3601 beside a drive, a card, and modules of 2 and of 31 words: each by its own names and numbers.

The expected positions follow from the commands: the drive moves to 4,500, in thousands and in 32 bits.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scanrack.commands import build
from scanrack.io_images.amci3601.image_form import ImageForm
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.io_images.module_words import Quantity
from scanrack.io_images.number_formats import NumberFormat
from scanrack.traces import open_trace
from scanrack.traces.export import write_mcap
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.image_text import module_text
from scanrack.traces.read.number_formats import NumberFormats
from scanrack.traces.signals import Catalog, blocks
from typer.testing import CliRunner

RACK = """
program = "logic.py"
scan_ms = 2
run_for_s = 1.4

[modules]
small = "small.py"
large = "large.py"

[[slot]]
number = 1
module = "amci3601"

[[slot]]
number = 2
module = "smd23e2"
[slot.machine]
switches = [{ input = "home", first = 1000, last = 1500 }]

[[slot]]
number = 3
module = "1769-OB16"
[slot.options]
outputs = { lamp = 4 }

[[slot]]
number = 4
module = "small"

[[slot]]
number = 5
module = "large"
"""
PROGRAM = """
WORD_1 = {word_1}
TARGET = {target}
SPEED = {speed}

def put(out, words):
    for at, word in enumerate(words):
        out[at] = word

def logic(scan):
    out, n = scan.slot[2].outputs, scan.number
    if n < 5:
        put(out, [-0x7FF9, WORD_1, 1, 0, 2048, 0, 4096, 20, 28, 0])
    elif n < 10 or 20 <= n < 30:
        put(out, [0, -0x8000, *8 * [0]])
    elif n < 20:
        put(out, [0x200, -0x8000, *8 * [0]])
    else:
        put(out, [1, -0x8000, *TARGET, *SPEED, 50, 50, 28, 0])
    scan.slot[3].outputs.set_bit(0, 4, n > 7)
    scan.slot[4].outputs[1] = n
    scan.slot[5].outputs[30] = n
"""
MODULE = """
from scanrack.modules import Image, ModuleRecord, ModuleWords

NAMES = tuple(f"word{{number}}" for number in range({size}))
WORDS = ModuleWords("{name}", NAMES, NAMES)

class Echo:
    def __init__(self):
        self.events = []

    def update(self, now_ns, outputs):
        return outputs

    def plc_run(self, running):
        pass

    def power_cycle(self):
        pass

RECORD = ModuleRecord(name="{name_lower}", make=lambda **_: Echo(), words=lambda _: WORDS)
"""
FORMATS = {
    "thousands": (0x0003, (4, 500), (5, 0)),
    "binary": (0x0303, (0, 4500), (0, 5000)),
}


def scanrack(*words: object) -> str:
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture(scope="module", params=FORMATS)
def recorded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mixed")
    word_1, target, speed = FORMATS[request.param]
    texts = {
        "rack.toml": RACK,
        "logic.py": PROGRAM.format(word_1=word_1, target=target, speed=speed),
        "small.py": MODULE.format(name="Small", name_lower="small", size=2),
        "large.py": MODULE.format(name="Large", name_lower="large", size=31),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    scanrack("run", folder / "rack.toml", "--record", folder / "a.mcap", "--quiet")
    return folder / "a.mcap"


def test_the_drive_ends_at_its_target_in_either_format(recorded: Path) -> None:
    with open_trace(recorded) as trace:
        catalog = Catalog.of(trace)
        (last,) = list(blocks(trace))[-1:]
        position = catalog["slot2.in.position"].read(last)
        assert (position[-1], np.nanmax(position)) == (4500, 4500)
        assert catalog["slot2.out.target"].read(last)[-1] == 4500
        assert catalog["slot2.out.programmed_speed"].read(last)[-1] == 5000
        assert catalog["slot2.speed"].read(last).max() == pytest.approx(5000, rel=0.05)
        assert catalog["slot5.in.word30"].read(last)[-1] == catalog["slot4.in.word1"].read(last)[-1]


def test_configuration_mode_has_no_numbers_and_no_status(recorded: Path) -> None:
    with open_trace(recorded) as trace:
        catalog = Catalog.of(trace)
        first = next(iter(blocks(trace)))
        configured = catalog["slot2.in.MODE_CONFIG"].read(first)
        assert configured.any()
        assert np.isnan(catalog["slot2.in.position"].read(first)[configured]).all()
        assert not catalog["slot2.in.MODULE_OK"].read(first)[configured].any()


@pytest.mark.slow
def test_show_names_the_bits_and_numbers_of_the_drive(recorded: Path) -> None:
    shown = scanrack("show", recorded)
    assert "ABSOLUTE_MOVE ENABLE_DRIVER, target 4,500, programmed_speed 5,000" in shown
    assert "+MOVE_COMPLETE" in shown


def test_why_says_what_the_drive_waits_for(recorded: Path) -> None:
    answer = " ".join(scanrack("why", recorded, "--at", "300", "--trust").split())
    assert "slot 2: moving CW" in answer
    assert "ABSOLUTE_MOVE since scan 30 (0.06 s); MOVE_COMPLETE not yet, its target is 4,500" in answer


def test_a_status_bit_is_no_terminal(recorded: Path) -> None:
    answer = " ".join(scanrack("why", recorded, "slot2.in.MOVE_COMPLETE", "--trust").split())
    assert "absolute move from 0: complete at 4500" in answer
    assert "slot2.command.ABSOLUTE_MOVE is on" in answer


def test_a_copy_has_the_decoded_numbers_of_all_steppers(recorded: Path, tmp_path: Path) -> None:
    with open_trace(recorded) as trace:
        write_mcap(trace, tmp_path / "copy.mcap")
    with open_trace(tmp_path / "copy.mcap") as copy:
        sizes = [(len(slot.words.outputs), len(slot.words.inputs)) for slot in copy.head.slots]
        assert sizes == [(8, 8), (10, 10), (8, 8), (2, 2), (31, 31)]
        assert sum(len(rows) for section in copy.sections for rows in copy.scan_rows(section)) == 700


def test_a_trace_compares_equal_to_itself(recorded: Path) -> None:
    assert "show the same: 700 scans" in scanrack("compare", recorded, recorded)


def test_all_formats_of_export_take_the_mixed_rack(recorded: Path, tmp_path: Path) -> None:
    signals = [word for name in ("slot2.in.position", "slot5.in.word30") for word in ("--signal", name)]
    for format in ("csv", "vcd", "parquet", "jsonl"):
        scanrack("export", recorded, f"--{format}", tmp_path / f"a.{format}", *signals, "--quiet")
    last = json.loads((tmp_path / "a.jsonl").read_text(encoding="utf-8").splitlines()[-1])
    assert last["slot2.in.position"] == 4500


def test_formats_change_at_the_scans_of_their_events() -> None:
    formats, reads = NumberFormats(), Quantity("position", "I", 0, format=None)
    writes = Quantity("target", "O", 0, format=None)
    for scan, format in ((100, "binary"), (200, "thousands")):
        formats.note(scan, {"kind": "format", "slot": 2, "reads": format, "writes": format})
    assert [formats.at(2, reads, scan).value for scan in (99, 100, 199, 200)] == [
        "thousands",
        "binary",
        "binary",
        "thousands",
    ]
    assert [formats.at(2, writes, scan) for scan in (98, 99)] == [
        NumberFormat.THOUSANDS,
        NumberFormat.BINARY,
    ]
    words = np.array([[1, 2]] * 3, np.int16)
    assert formats.values(2, reads, np.array([99, 100, 200]), words).tolist() == [1002, 65538, 1002]


def test_sign_and_magnitude_is_read_as_the_page_writes_it() -> None:
    """-345 = 8000h, 345 [3502 manual 1.0, page 1]."""
    pairs = np.array([[-0x8000, 345], [12, 345], [-0x7FF4, 1]], np.int16)
    format = NumberFormat.SIGN_MAGNITUDE
    assert format.reported_all(pairs[:, 0], pairs[:, 1]).tolist() == [-345, 12_345, -12_001]
    assert [format.reported(*pair) for pair in pairs.tolist()] == [-345, 12_345, -12_001]


def test_a_3401_shows_its_position_in_its_own_words() -> None:
    """Status and position follow two zeros behind a ControlLogix [3401 manual 2.0, page 34]."""
    form = ImageForm(("zero0", "zero1", "status_msw", "status_lsw", "position_msw", "position_lsw"))
    slot = SlotInfo(1, "amci3401", words=form.words(WORDS_3601))
    position = slot.words.quantity("position")
    assert position is not None
    assert position.word == 4
    assert slot.words.quantity("encoder") is None
    before, after = (0, 0, 0x4008, 0, 0, 0), (0, 0, 0x4021, 0, 12, 345)
    assert module_text(slot, "in", before, after) == "+MOVING_CW +ACCELERATING -STOPPED"
    assert NumberFormats().value(1, 0, position, after) == 12_345
    assert slot.words.configures("in", (0, 0, -0x8000, 0, 0, 0))
