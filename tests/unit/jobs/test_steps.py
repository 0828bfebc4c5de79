"""Programs of steps: what each line sends, when the next one follows, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scanrack.io_images.amci3601 import Move, MoveKind, PresetPosition, StoreMinimumRegistration
from scanrack.io_images.image import Image
from scanrack.jobs import ProgramError, load_program
from scanrack.ladder.files.steps import parse_steps
from scanrack.runtime import Card, Rack
from scanrack.runtime.loop.scan import LogicScan

PERIOD_NS = 2_000_000
STOPPED, MODE_CONFIG = 0x0008, -0x8000


class Shown:
    """A module that shows nothing by itself."""

    def __init__(self) -> None:
        self.events: list[object] = []


def scans(program: Any, status: list[int], slot: int = 1) -> list[list[int]]:
    """Return the output words of scans in which input word 0 is as given."""
    rack = Rack([Card(slot, Shown())])  # type: ignore[arg-type]
    scan = LogicScan(rack.slots, PERIOD_NS)
    sent = []
    for number, word in enumerate(status):
        scan.number, scan.now_ns, scan.first = number, number * PERIOD_NS, number == 0
        rack.slots[slot].inputs[0] = word
        program(scan)
        sent.append(list(rack.slots[slot].outputs))
    return sent


@pytest.mark.parametrize(
    ("line", "image"),
    [
        ("words 843Eh 003Fh 1", Image([-31682, 63, 1])),
        ("words -1 65535 0", Image([-1, -1, 0])),
        ("zero", Image()),
        (
            "RELATIVE_MOVE S_CURVE target -12345 speed 5000 acceleration 20 deceleration 10",
            Image([2, 1, -12, -345, 5, 0, 20, 10]),
        ),
        (
            "ABSOLUTE_MOVE target 4000 speed 5000 acceleration 20 deceleration 10",
            Move(MoveKind.ABSOLUTE, 4000, speed=5000, acceleration=20, deceleration=10).to_image(),
        ),
        ("PRESET_POSITION target -1999", PresetPosition(-1999).to_image()),
        ("STORE_MIN_REG target 300", StoreMinimumRegistration(300).to_image()),
        ("MODE_CONFIG", Image([-32768])),
    ],
)
def test_a_line_is_an_output_image(line: str, image: Image) -> None:
    assert scans(parse_steps(line), [0]) == [list(image)]


def test_idle_leaves_the_parameters_and_same_leaves_all() -> None:
    program = parse_steps("words 1 2 3 4 for 2 ms\nsame for 2 ms\nidle")
    assert [sent[:4] for sent in scans(program, [0, 0, 0])] == [[1, 2, 3, 4], [1, 2, 3, 4], [0, 0, 3, 4]]


def test_the_next_step_follows_in_the_scan_that_sees_the_bits() -> None:
    program = parse_steps("words 1 until STOPPED -MODE_CONFIG\nwords 2")
    status = [STOPPED, 0, MODE_CONFIG | STOPPED, STOPPED, 0]
    assert [sent[0] for sent in scans(program, status)] == [1, 1, 1, 2, 2], "not in its own first scan"


def test_time_counts_from_the_scan_in_which_the_step_began() -> None:
    program = parse_steps("words 1 for 5 ms\nwords 2 for 2 ms\nwords 3")
    assert [sent[0] for sent in scans(program, [0] * 6)] == [1, 1, 1, 2, 3, 3]


def test_the_last_step_stays_and_a_restart_begins_anew() -> None:
    program = parse_steps("words 1 until STOPPED\nwords 2 until STOPPED")
    assert [sent[0] for sent in scans(program, [STOPPED] * 4)] == [1, 2, 2, 2]
    assert [sent[0] for sent in scans(program, [0])] == [1]


def test_another_slot_comments_and_empty_lines() -> None:
    program = parse_steps("# a comment\nSLOT 3\n\nwords 7   # and another\n")
    assert (program.slot, [step.line for step in program.steps]) == (3, [4])
    assert scans(program, [0], slot=3)[0][0] == 7


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no step in the file"),
        ("RELATIV_MOVE", "1: RELATIV_MOVE is not a command bit or parameter; did you mean RELATIVE_MOVE?"),
        ("zero\nzero until MOVE_COMPLET", "2: MOVE_COMPLET is not a status bit; did you mean MOVE_COMPLETE?"),
        ("zero for 20", "1: '20' is not a time"),
        ("words" + 251 * " 1", "1: 251 words; must be 1 to 250"),
        ("words", "1: 0 words; must be"),
        ("words 70000", "1: 70000 does not fit a word"),
        ("words 1x", "1: '1x' is not a word"),
        ("RELATIVE_MOVE target", "1: target '' is not a whole number"),
        ("zero\nSLOT 2", "2: 'SLOT 2' is not allowed"),
        ("SLOT 0\nzero", "1: 'SLOT 0' is not allowed"),
        ("RELATIVE_MOVE target 99999999999", "1: "),
        ("until MOVE_COMPLETE", "1: until is not a command bit"),
    ],
)
def test_a_line_that_cannot_be_used_is_named(text: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "line.steps"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ProgramError) as refusal:
        load_program("line.steps", tmp_path)
    assert str(refusal.value).startswith(f"{file}:")
    assert says in str(refusal.value)
