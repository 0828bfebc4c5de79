"""Images in words: cases beside those that a whole trace shows."""

from __future__ import annotations

import pytest
from scanrack.traces import Scan, SlotInfo
from scanrack.traces.format.layout import block_layout
from scanrack.traces.read.changes import ChangeRows
from scanrack.traces.read.event_text import describe
from scanrack.traces.read.image_text import input_wording, output_wording

ZEROS = (0,) * 8
IDLE = (0x4000, 0, 0, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        # chapter 5: command word LSW bits 0 and 1 choose the trapezoidal S curve
        (ZEROS, (1, 3, -1, -5, 0, 900, 1, 2000),
         "ABSOLUTE_MOVE S_CURVE TRAPEZOIDAL, target -1,005, speed 900, acceleration 1, deceleration 2,000"),
        # chapter 6, Command Error 4: words of opposite signs and an LSW beyond 999 are no value
        (ZEROS, (2, 0, -12, 345, 0, 1000, 0, 0), "RELATIVE_MOVE, target (-12, 345), speed (0, 1000)"),
        # chapter 4: with the blend bits the words are a block's, not a move's
        (ZEROS, (0, 0x0300, 3, 15, 0, 0, 1, 2), "BLEND_PROGRAM BLEND_TRANSMIT, words 2 to 7: 3 15 0 0 1 2"),
        (ZEROS, (0x4000, 0x0008, 0, 0, 0, 0, 0, 0), "RESERVED_14 bit3"),
        ((128, 0, 0, 0, 5, 0, 9, 9), (128, 0, 0, 0, 6, 0, 9, 9), "MANUAL_CW, speed 6,000"),
        (ZEROS, (-32768, 0, 0, 0, 7, 0, 0, 0),
         "MODE_CONFIG, active high none, starting speed 0, words 4 to 7: 7 0 0 0"),
    ],
)  # fmt: skip
def test_outputs(before: tuple[int, ...], after: tuple[int, ...], text: str) -> None:
    assert output_wording(before, after) == text


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        (IDLE, (0x4000, 0, 5, 0, 9, 0, 0, 0), ""),
        ((-15298, 63, 1, 0, 0, 0, 4, 1), (-15298, 63, 2, 0, 0, 0, 4, 1), "another configuration echoed"),
        (
            (0x4000, 0, 0, 0, 0, 0, 0, 0),
            (0x4000, 0x40, 0, 0, 0, 0, 0, 0),
            "reserved bits: status words 4000h 0040h",
        ),
        # the MSW of a value beyond 32,767,999 wraps [chapter 6, Current Position]
        (IDLE, (0x4000, 0, 0, 0, 0, 0, -1, 999), "captured 65,535,999"),
    ],
)
def test_inputs(before: tuple[int, ...], after: tuple[int, ...], text: str) -> None:
    assert input_wording(before, after) == text


@pytest.mark.parametrize(
    ("topic", "fields", "text"),
    [
        (
            "/events",
            {"kind": "move", "text": "absolute move from 0 complete at 5"},
            "absolute move from 0 complete at 5",
        ),
        (
            "/events",
            {"kind": "rule", "name": "X-1", "text": "HOME is on."},
            "rule at scan 7: HOME is on [X-1]",
        ),
        ("/events", {"n": 1, "m": 2}, "n = 1, m = 2"),
        ("/forces", {}, "forces: none"),
        ("/cpu", {"battery": "low"}, "CPU: battery = low"),
        ("/faults", {"text": "watchdog"}, "the CPU faulted: watchdog"),
    ],
)
def test_happenings(topic: str, fields: dict[str, object], text: str) -> None:
    assert describe(topic, 7, fields) == text


PLACES = block_layout([SlotInfo(1, "amci3601"), SlotInfo(2, "amci3601")]).places


def scan(number: int, words: dict[int, int], flags: int = 1) -> Scan:
    memory = bytearray(64)
    for word, value in words.items():
        memory[2 * word : 2 * word + 2] = (value & 0xFFFF).to_bytes(2, "little")
    return Scan(number, number, flags, bytes(memory), PLACES)


def texts(*scans: Scan) -> list[str]:
    changes = ChangeRows([SlotInfo(1, "amci3601"), SlotInfo(2, "amci3601")], lambda flags: [f"flags {flags}"])
    rows = [row for each in scans for row in changes.rows(each)]
    return [row.text for row in [*rows, *changes.rest()]][1:]  # less the flags of the first scan


# word 8 is status MSW of slot 1, 11 its position LSW, 13 its encoder LSW; 24 to 31 are slot 2's
def test_scans_are_folded_over_all_slots_and_counted() -> None:
    assert texts(scan(0, {}), scan(1, {11: 1}), scan(2, {11: 1, 27: 5}), scan(3, {11: 1, 27: 5})) == [
        "... 2 scans in which only the position changed"
    ]
    assert texts(scan(0, {}), scan(1, {13: 1})) == ["... 1 scan in which only the encoder count changed"]


def test_what_was_folded_earlier_is_not_told_again() -> None:
    assert texts(scan(0, {}), scan(1, {13: 1}), scan(2, {8: 1, 13: 1}), scan(3, {8: 1, 11: 1, 13: 1}))[
        ::2
    ] == [
        "... 1 scan in which only the encoder count changed",
        "... 1 scan in which only the position changed",
    ]


def test_a_change_of_the_echo_in_configuration_mode_is_not_folded() -> None:
    assert texts(scan(0, {8: 0xC000}), scan(1, {8: 0xC000, 10: 1}))[1:] == ["another configuration echoed"]


def test_a_captured_value_is_not_folded() -> None:
    assert texts(scan(0, {}), scan(1, {11: 1, 15: 9})) == ["captured 9"]


def test_a_change_of_flags_is_not_folded() -> None:
    assert texts(scan(0, {}), scan(1, {11: 1}, flags=2)) == ["+flags 2 -flags 1", ""]
