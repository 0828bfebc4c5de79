"""One program in three shapes of a 3601: generic profile, the 3601's own profile, MicroLogix words.

Each configures the module, presets the position and makes one relative move. All images are the same in
every scan.
"""

from decimal import Decimal

import pytest
from l5x_files import document, ladder, module, program, tag, task
from scanrack.io_images.amci3601 import Configuration, InputBit, Move, MoveKind, PresetPosition
from scanrack.jobs import build_cpu, build_rack, load_program
from scanrack.runtime import RackSpec, SlotSpec

SETUP = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT, step_and_direction=True, starting_speed=500
)
MOVE = Move(MoveKind.RELATIVE, 4000, speed=5000, acceleration=20, deceleration=10)
ZEROS = [0] * 8
WAITS = [(15, 1), (15, 0), (10, 0), (10, 0), (7, 1), (7, 1)]
"""Bits of word 0 that end each step: MODE_CONFIG on and off, POSITION_INVALID off, MOVE_COMPLETE on."""

STEPS = [
    list(SETUP.to_image()),
    ZEROS,
    list(PresetPosition(0).to_image()),
    ZEROS,
    list(MOVE.to_image()),
    ZEROS,
]

GENERIC = {"in": "Local:1:I.Data[{}]", "out": "Local:1:O.Data[{}]", "bit": "Local:1:I.Data[0].{}"}
PROFILE = {"in": "Local:1:I.Data{}", "out": "Local:1:O.Data{}", "bit": "Local:1:I.Data0.{}"}
MICRO = {"in": "I:1.{}", "out": "O:1.{}", "bit": "I:1.0/{}"}


def rungs(shape, step="Step", new="New"):
    """A sequencer: step n writes its words until the bit that ends it; New counts from the next scan on."""
    lines = []
    for number, (words, (bit, level)) in enumerate(zip(STEPS, WAITS, strict=True)):
        moves = " ".join(f"MOV({word},{shape['out'].format(place)})" for place, word in enumerate(words))
        lines.append(f"EQU({step},{number}){moves};")
        contact = "XIC" if level else "XIO"
        last = number == len(STEPS) - 1
        if not last:
            lines.append(f"EQU({step},{number}){contact}({shape['bit'].format(bit)})MOV({number + 1},{new});")
    return [*lines, f"MOV({new},{step});"]


def l5x(tmp_path, shape, kind, members):
    """An export with a module of this data type in slot 1."""
    tags = [tag("Step", "DINT"), tag("New", "DINT")]
    values = "".join(members)
    structure = f'<Structure DataType="{kind}:I:0">{values}</Structure>'
    inputs = f'<InputTag><Data Format="Decorated">{structure}</Data></InputTag>'
    outputs = inputs.replace("InputTag", "OutputTag").replace(":I:0", ":O:0")
    file = tmp_path / "machine.L5X"
    file.write_text(
        document(
            modules=[module("Axis", 1, inputs, outputs, catalog="1769-MODULE")],
            programs=[program("Main", ladder("Main", *rungs(shape)), tags=tags)],
            tasks=[task("T", "Main")],
        ),
        encoding="utf-8",
    )
    return file


def slc(tmp_path):
    """The same as text of RSLogix 500."""
    lines = ["SLOT 1 OTHER 3 10 25", 'LADDER 2 "MAIN"']
    for rung in rungs(MICRO, "N7:0", "N7:1"):
        words = rung.rstrip(";").replace("(", " ").replace(")", " ").replace(",", " ")
        lines.append(f"SOR {words} EOR")
    lines += ["DATA N7:0", "% N7:0 % 0 0"]
    file = tmp_path / "machine.SLC"
    file.write_text("\n".join(lines), encoding="utf-8")
    return file


def images(file, scans=1500):
    """Return the images of slot 1 in every scan."""
    spec = RackSpec(program=print, scan_ms=Decimal(2), slot=(SlotSpec(number=1, module="amci3601"),))
    rack = build_rack(spec)
    cpu = build_cpu(spec, load_program(str(file), slots={1}).function, rack)
    seen = []
    for _ in range(scans):
        cpu.run(1)
        seen.append((list(rack.slots[1].inputs), list(rack.slots[1].outputs)))
    return seen


def array(name, length):
    elements = "".join(f'<Element Index="[{place}]" Value="0"/>' for place in range(length))
    return f'<ArrayMember Name="{name}" DataType="INT" Dimensions="{length}">{elements}</ArrayMember>'


def word(name, kind="INT"):
    return f'<DataValueMember Name="{name}" DataType="{kind}" Value="0"/>'


@pytest.fixture
def generic(tmp_path):
    return images(
        l5x(tmp_path, GENERIC, "AB:1769_MODULE_INT_16Bytes", [word("Fault", "DINT"), array("Data", 8)])
    )


def test_the_move_is_made(generic):
    """4,000 steps: the position words 4 and 0, MOVE_COMPLETE in word 0."""
    inputs, _ = generic[-1]
    assert inputs[2:4] == [4, 0]
    assert inputs[0] >> 7 & 1


def test_the_profile_of_the_3601_shows_the_same_images(tmp_path, generic):
    members = [word("Fault", "DINT"), *(word(f"Data{place}") for place in range(8))]
    assert images(l5x(tmp_path, PROFILE, "AM:1769_3601", members)) == generic


def test_the_words_of_a_micrologix_show_the_same_images(tmp_path, generic):
    assert images(slc(tmp_path)) == generic
