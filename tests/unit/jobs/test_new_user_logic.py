"""Mistakes that people make in their first program: each gets a message of ours, at their own line."""

import pytest
from scanrack import open_bench
from scanrack.commands import build
from scanrack.io_images.amci3601 import (
    Acceleration,
    BlendHeader,
    Configuration,
    Direction,
    FindHome,
    Follower,
    InputBit,
    Manual,
    Move,
    MoveKind,
    RunBlend,
)
from scanrack.io_images.image import Image
from scanrack.runtime import CpuFault
from scanrack.runtime.loop.faults import Cause
from typer.testing import CliRunner

RACK = """\
program = "line.py"
run_for_s = 0.02

[[slot]]
number = 1
module = "amci3601"
"""

HEAD = """\
from collections import namedtuple
import sys
from scanrack.io_images.amci3601 import Move, MoveKind
Point = namedtuple("Point", "x y")


def logic(scan):
    slot = scan.slot[1]
"""
LINE = HEAD.count("\n") + 1


@pytest.fixture
def bench(tmp_path):
    def make(statement):
        (tmp_path / "line.py").write_text(f"{HEAD}    {statement}\n", encoding="utf-8")
        (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
        return open_bench(tmp_path / "line.toml")

    return make


PLACES = {
    "a dataclass refuses": "Move(MoveKind.ABSOLUTE, 500000000, 1, 1, 1)",
    "a named tuple refuses": "Point(1)",
    "an image refuses": "slot.outputs.load([1, 2])",
    "evaluated text": "eval('1 / 0')",
    "it exits": "sys.exit(3)",
}


@pytest.mark.parametrize("statement", PLACES.values(), ids=PLACES)
def test_a_fault_names_the_file_and_line_of_the_user(bench, statement):
    table = bench(statement)
    with pytest.raises(CpuFault) as caught:
        table.scan()
    assert caught.value.fault.cause is Cause.PROGRAM
    assert caught.value.fault.where.endswith(f"line.py:{LINE}")


def test_logic_that_exits_faults_the_cpu(bench, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bench("sys.exit(3)")
    done = CliRunner().invoke(build(), ["run", "line.toml"])
    assert done.exit_code == 1
    assert done.stderr == (
        "scanrack: the CPU has faulted in scan 0 (t = 0 s): the program raised SystemExit: 3 "
        f"[line.py:{LINE}]\n"
    )


def test_a_rack_function_that_exits(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rack.py").write_text("import sys\n\n\ndef rack():\n    sys.exit(3)\n", encoding="utf-8")
    done = CliRunner().invoke(build(), ["run", "rack.py"])
    assert (done.exit_code, done.stderr) == (2, "scanrack: rack.py:5: rack() raised SystemExit: 3\n")


READ_ONLY = {
    "a word": "slot.inputs[0] = 1",
    "a bit": "slot.inputs.set_bit(0, 1, True)",
    "all words": "slot.inputs.load(slot.outputs)",
    "clearing": "slot.inputs.clear()",
}


@pytest.mark.parametrize("statement", READ_ONLY.values(), ids=READ_ONLY)
def test_logic_writes_no_inputs(bench, statement):
    with pytest.raises(CpuFault, match="an input image is read-only: the module writes it"):
        bench(statement).scan()


def test_logic_writes_no_memory_of_inputs(bench):
    with pytest.raises(CpuFault, match="read-only memory"):
        bench("slot.inputs.words[0] = 1").scan()


def test_logic_sees_the_inputs_of_every_scan(bench):
    table = bench("slot.outputs[7] = slot.inputs[1] + 1")
    table.scan()
    table.slot[1].set_input("home", True)
    table.scan()
    assert table.slot[1].outputs[7] == table.slot[1].inputs[1] + 1


def test_a_read_only_image_is_a_view_and_its_copy_is_not():
    image = Image([1, 2])
    view = image.read_only()
    image[1] = 3
    copy = view.copy()
    copy[0] = 9
    assert (list(view)[:2], list(copy)[:2], view == image) == ([1, 3], [9, 3], True)


BAD_WORDS = {
    "a fraction": (lambda: Image().__setitem__(0, 1.5), "word 1.5 is not allowed: a word is a whole number"),  # type: ignore[assignment]
    "text": (lambda: Image(["1"]), "word '1' is not allowed: a word is a whole number"),  # type: ignore[list-item]
    "a ninth word": (lambda: Image().__setitem__(8, 1), "no such word: 8; words are 0 to 7"),
    "a ninth word, read": (lambda: Image()[8], "no such word: 8; words are 0 to 7"),
    "a word by name": (lambda: Image()["speed"], "no such word: 'speed'; words are 0 to 7"),  # type: ignore[index]
    "a list": (lambda: Image().load([1, 2]), r"\[1, 2\] is not an image: write load\(Image"),  # type: ignore[arg-type]
    "half a bit": (lambda: Image().set_bit(0, 1.5, True), "no such bit: word 0, bit 1.5"),  # type: ignore[arg-type]
    "a kind as text": (
        lambda: Move("ABSOLUTE", 1, 1, 1, 1),  # type: ignore[arg-type]
        "kind 'ABSOLUTE' is not allowed; choose from MoveKind.ABSOLUTE, MoveKind.RELATIVE",
    ),
    "a shape as text": (
        lambda: Move(MoveKind.ABSOLUTE, 1, 1, 1, 1, shape="s"),  # type: ignore[arg-type]
        "shape 's' is not allowed; choose from Acceleration.CONSTANT",
    ),
    "a direction as text": (
        lambda: Manual("cw", 1),  # type: ignore[arg-type]
        "direction 'cw' is not allowed; choose from Direction.CW, Direction.CCW",
    ),
    "a search anywhere": (lambda: FindHome("cw", 1, 1, 1), "direction 'cw' is not allowed"),  # type: ignore[arg-type]
    "a profile anywhere": (lambda: RunBlend(None), "direction None is not allowed"),  # type: ignore[arg-type]
    "a follower anywhere": (lambda: Follower("cw", 1, 1), "direction 'cw' is not allowed"),  # type: ignore[arg-type]
    "segments as text": (lambda: BlendHeader(("s", "s"), 1), "acceleration type 's' is not allowed"),  # type: ignore[arg-type]
    "a target as text": (
        lambda: Move(MoveKind.ABSOLUTE, "5", 1, 1, 1),  # type: ignore[arg-type]
        "target position '5' is not allowed: must be a whole number, -8388608 to 8388607",
    ),
    "half a step": (lambda: Manual(Direction.CW, 0.5), "programmed speed 0.5 is not allowed"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("attempt", "told"), BAD_WORDS.values(), ids=BAD_WORDS)
def test_values_of_another_type_are_refused_in_our_words(attempt, told):
    with pytest.raises(ValueError, match=told):
        attempt()


def test_members_and_whole_numbers_are_taken():
    assert list(Move(MoveKind.RELATIVE, 1, 1, 1, 1, Acceleration.TRIANGULAR).to_image())[2:4] == [0, 1]
    assert Follower(None, 1, 1).to_image()[0] == 0


def test_an_invalid_configuration_says_what_is_wrong():
    with pytest.raises(ValueError, match="invalid") as caught:
        Configuration(inputs_used=InputBit.HOME, starting_speed=100)
    assert str(caught.value) == (
        "configuration is invalid: the configuration has neither a CW nor a CCW end limit switch "
        "[CFG-02, chapter 3]"
    )


LADDER = """\
PROGRAM p
TAG Lamp : BOOL
ROUTINE Main
XIC(S:FS)OTE(Lamp);
END
"""


def test_what_is_not_there_is_told_with_what_there_is(tmp_path):
    (tmp_path / "line.rung").write_text(LADDER, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK.replace("line.py", "line.rung"), encoding="utf-8")
    bench = open_bench(tmp_path / "line.toml")
    with pytest.raises(ValueError, match=r"no tag Lmap \(did you mean Lamp\?\)"):
        bench["Lmap"]
    with pytest.raises(ValueError, match=r"no tag Motor \(tags are Lamp\)"):
        bench["Motor"]
    with pytest.raises(ValueError, match="slot 2 is empty: modules sit in 1"):
        bench.slot[2]
