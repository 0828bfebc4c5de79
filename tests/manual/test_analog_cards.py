"""Analog cards: numbers and bits as the tables of Rockwell's manuals have them."""

from __future__ import annotations

from typing import Any

import pytest
from scanrack.io_images.cards import KINDS
from scanrack.io_images.image import Image
from scanrack.runtime.modules.cards.card_options import CardOptions
from scanrack.runtime.modules.cards.module import GenericCard

# 1769-UM002B, table 3.7 (page 3-12) and page 3-10: range, signal, raw, engineering, PID, percent. For 1 V the
# table prints 6243, 1000, 1, 1 and for 0.5 V raw 3121; the numbers here are proportional, as in other rows.
INPUT_TABLE = [
    ("1..5 V", "5.5", 32767, 5250, 17407, 10625),
    ("1..5 V", "5.25", 32767, 5250, 17407, 10625),
    ("1..5 V", "5.0", 31206, 5000, 16383, 10000),
    ("1..5 V", "1.0", 6241, 1000, 0, 0),
    ("1..5 V", "0.5", 3120, 500, -2048, -1250),
    ("1..5 V", "0.0", 3120, 500, -2048, -1250),
    ("0..20 mA", "22.0", 32767, 21000, 17202, 10500),
    ("0..20 mA", "21.0", 32767, 21000, 17202, 10500),
    ("0..20 mA", "20.0", 31206, 20000, 16383, 10000),
    ("0..20 mA", "0.0", 0, 0, 0, 0),
    ("-10..10 V", "10.5", 32767, 10500, 16793, None),
    ("-10..10 V", "-10.5", -32767, -10500, -410, None),
    ("4..20 mA", "21", 32767, 21000, 17407, 10625),  # table 3.17
    ("4..20 mA", "3.2", 4993, 3200, -819, -500),
    ("0..5 V", "5.25", 32767, 5250, 17202, 10500),
    ("0..10 V", "10.5", 32767, 10500, 17202, 10500),
]


def card(kind: str, **options: Any) -> GenericCard:
    return GenericCard(CardOptions(**options), KINDS[kind])


def shown(kind: str, wanted: str, form: str, signal: str, channel: int = 0) -> Image:
    """Return the input image of a card with a signal at a channel."""
    module = card(
        kind,
        inputs={"level": channel},
        ranges={"level": wanted},
        formats={"level": form},
        timeline=[{"at_ms": 0, "input": "level", "value": float(signal)}],
    )
    return module.update(0, Image())


@pytest.mark.parametrize(("wanted", "signal", "raw", "engineering", "pid", "percent"), INPUT_TABLE)
def test_a_1769_if4_converts_as_its_table_says(
    wanted: str, signal: str, raw: int, engineering: int, pid: int, percent: int | None
) -> None:
    numbers = {"raw": raw, "engineering": engineering, "pid": pid, "percent": percent}
    for form, number in numbers.items():
        if number is not None:
            assert shown("1769-IF4", wanted, form, signal)[0] == number, form


def test_a_1762_if4_has_the_same_raw_numbers() -> None:
    """4 to 20 mA are 6,241 to 31,206."""
    assert [shown("1762-IF4", "4..20 mA", "raw", signal)[0] for signal in ("4", "20")] == [6241, 31206]


@pytest.mark.parametrize("kind", ["1762-IF4", "1769-IF4"])
@pytest.mark.parametrize(("channel", "over", "under"), [(0, 14, 15), (1, 12, 13), (2, 10, 11), (3, 8, 9)])
def test_range_bits_of_inputs(kind: str, channel: int, over: int, under: int) -> None:
    """Word 5: U0 O0 U1 O1 U2 O2 U3 O3 from bit 15 on; word 4: S0 to S3 from bit 0 on [1769-UM002B, 3-3]."""
    for signal, bit in (("20.1", over), ("3.9", under)):
        image = shown(kind, "4..20 mA", "raw", signal, channel)
        assert image[5] & 0xFFFF == 1 << bit
        assert image[4] == 1 << channel
    image = shown(kind, "4..20 mA", "raw", "20", channel)
    assert (image[4], image[5]) == (0, 0)


def test_an_open_circuit_is_under_range_and_the_bit_goes_with_the_condition() -> None:
    module = card(
        "1769-IF4",
        inputs={"level": 0},
        ranges={"level": "4..20 mA"},
        timeline=[{"at_ms": 1, "input": "level", "value": 4}, {"at_ms": 2, "input": "level", "value": 25}],
    )
    seen = [module.update(ms * 1_000_000, Image()) for ms in (0,)]
    assert (seen[0][0], seen[0][5] & 0xFFFF) == (4993, 1 << 15)
    assert module.update(1_000_000, Image())[5] == 0
    assert module.update(2_000_000, Image())[5] == 1 << 14
    assert [event.text for event in module.events] == [
        "The level input is 4 mA.",
        "The level input is 25 mA.",
    ]


# 1762-IN016D, pages 14 and 15; data ranges of 1763-RM001C, page 18: 21 mA is 32,760, 20 mA 31,200, 4 mA 6,240
@pytest.mark.parametrize(
    ("word", "over", "under"),
    [
        *((6240, False, False), (31_200, False, False), (31_207, False, False), (31_208, True, False)),
        *((32_767, True, False), (6239, False, True), (0, False, True), (-1, False, True)),
    ],
)
def test_a_1762_of4_ignores_three_bits_and_tells_the_range(word: int, over: bool, under: bool) -> None:
    """Word 1: U0 O0 U1 O1 U2 O2 U3 O3 in bits 7 to 0; word 0: S0 to S3 in bits 0 to 3."""
    module = card("1762-OF4", outputs={"valve": 1}, ranges={"valve": "4..20 mA"})
    image = module.update(0, Image([0, word]))
    assert image[1] == over << 4 | under << 5
    assert image[0] == (over or under) << 1


@pytest.mark.parametrize(
    ("word", "echo", "over", "under"),
    [(31_206, 31_206, 0, 0), (31_207, 31_207, 1, 0), (32_767, 32_767, 1, 0), (-32_768, -32_767, 0, 1)],
)
def test_a_1769_of4_repeats_its_outputs_and_tells_the_range(
    word: int, echo: int, over: int, under: int
) -> None:
    """Words 1 to 4: the echo; word 0: U3 O3 ... U0 O0 from bit 15 on, S0 to S3 from bit 0 on [IN087A, 15]."""
    module = card("1769-OF4", outputs={"valve": 3}, ranges={"valve": "-10..10 V"})
    image = module.update(0, Image([1, 2, 3, word]))
    assert list(image)[1:5] == [1, 2, 3, echo]
    assert image[0] & 0xFFFF == over << 14 | under << 15 | (over or under) << 3
    module.plc_run(False)
    assert list(module.update(1, Image([1, 2, 3, word])))[1:5] == [0, 0, 0, 0]
