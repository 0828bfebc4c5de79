"""Ranges of analog channels in a rack file: what is refused, names of the range bits, a program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.cards import KINDS
from scanrack.io_images.image import Image
from scanrack.io_images.signal_ranges import FORMATS, RANGES, Channel
from scanrack.jobs import open_bench
from scanrack.runtime.modules.cards.card_options import CardOptions
from scanrack.runtime.modules.cards.module import GenericCard


def card(kind: str, **options: Any) -> GenericCard:
    return GenericCard(CardOptions(**options), KINDS[kind])


def at(value: float, name: str = "a") -> list[dict[str, object]]:
    return [{"at_ms": 1, "input": name, "value": value}]


A = {"inputs": {"a": 0}}


@pytest.mark.parametrize(
    ("kind", "options", "says"),
    [
        (
            "1769-IF4",
            {**A, "ranges": {"a": "4-20 mA"}},
            r"ranges: 'a' = '4-20 mA': a 1769-IF4 has -10..10 V, ",
        ),
        (
            "1762-OF4",
            {"outputs": {"a": 0}, "ranges": {"a": "0..5 V"}},
            r"a 1762-OF4 has 0..10 V, 4..20 mA, 0..20",
        ),
        ("1769-IQ16", {**A, "ranges": {"a": "0..5 V"}}, "a 1769-IQ16 has no channels"),
        ("1769-IF4", {**A, "ranges": {"b": "0..5 V"}}, "no channel 'b': channels are a"),
        ("1769-IF4", {**A, "formats": {"a": "raw"}}, "formats: 'a' has no range; add it to ranges"),
        (
            "1762-IF4",
            {**A, "ranges": {"a": "0..5 V"}, "formats": {"a": "pid"}},
            "formats: 'a' = 'pid': a 1762-IF4 has raw",
        ),
        (
            "1769-IF4",
            {**A, "ranges": {"a": "-10..10 V"}, "formats": {"a": "percent"}},
            r"a range of -10..10 V has no percent",
        ),
        (
            "1769-IF4",
            {**A, "ranges": {"a": "4..20 mA"}, "timeline": at(31)},
            "'a': 31 mA must be -30 to 30",
        ),
        (
            "1769-IF4",
            {**A, "timeline": at(1.5)},
            "1.5 is not a word: must be -32768 to 32767; for V or mA",
        ),
    ],
)
def test_what_a_channel_cannot_have_is_refused(kind: str, options: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        card(kind, **options)


def test_a_value_of_a_test_is_checked_too() -> None:
    module = card("1769-IF4", inputs={"a": 0, "b": 1}, ranges={"a": "0..10 V"})
    module.set_value("a", 10)
    module.set_value("b", 6240)
    assert list(module.update(0, Image()))[:2] == [31_206, 6240]
    for name, value in (("a", 31), ("b", 0.5), ("b", 40_000)):
        with pytest.raises(ValueError, match="must be"):
            module.set_value(name, value)


@given(st.sampled_from(sorted(RANGES)), st.fractions(-30, 30), st.fractions(-30, 30))
def test_numbers_rise_with_the_signal_and_stay_words(wanted: str, one: Any, other: Any) -> None:
    for convert in FORMATS.values():
        channel = Channel(RANGES[wanted], convert)
        low, high = sorted((one, other))
        assert -32_768 <= channel.word(low) <= channel.word(high) <= 32_767
        assert channel.limited(channel.word(low)) == channel.word(low)


def test_a_channel_without_a_range_has_the_image_of_before() -> None:
    module = card("1769-IF4", **A, timeline=at(32_767))
    assert list(module.update(1_000_000, Image())) == [32_767, *[0] * 7]
    assert list(card("1762-OF4").update(0, Image([1, -2, 3, 4]))) == [0] * 8


RACK = """
program = "tank.rung"
scan_ms = 2
run_for_s = 0.1
tags = ["Alarm"]

[[slot]]
number = 2
module = "1769-IF4"
[slot.options]
inputs = { level = 1 }
ranges = { level = "4..20 mA" }
formats = { level = "engineering" }
timeline = [
    { at_ms = 0, input = "level", value = 12.5 },
    { at_ms = 40, input = "level", value = 3.9 },
    { at_ms = 60, input = "level", value = 4 },
]
"""
RUNGS = """
PROGRAM tank
TAG Alarm : BOOL
TAG Level : INT
ROUTINE Main
MOV(I:2.1,Level);
XIC(I:2.5/13)OTE(Alarm);
END
"""


def test_a_test_gives_an_input_a_value(tmp_path: Path) -> None:
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "tank.rung").write_text(RUNGS, encoding="utf-8")
    with open_bench(tmp_path / "rack.toml") as bench:
        bench.scan(2)
        assert not bench["Alarm"]
        bench.slot[2].set_value("level", 21.5)
        bench.scan(2)
        assert (bench["Level"], bench.slot[2].status["level"]) == (21_000, 21_000)
        bench.slot[2].set_value("level", 0)
        bench.scan(2)
        assert (bench["Level"], bench["Alarm"]) == (3200, True)
        with pytest.raises(ValueError, match="31 mA must be -30 to 30"):
            bench.slot[2].set_value("level", 31)


def test_a_module_without_analog_inputs_says_so(tmp_path: Path) -> None:
    slot = "[[slot]]\nnumber = 1\nmodule = 'amci3601'\n"
    (tmp_path / "rack.toml").write_text(RACK.partition("[[slot]]")[0] + slot, encoding="utf-8")
    (tmp_path / "tank.rung").write_text(RUNGS.replace("I:2", "I:1"), encoding="utf-8")
    with open_bench(tmp_path / "rack.toml") as bench, pytest.raises(ValueError, match="has no analog inputs"):
        bench.slot[1].set_value("level", 1)


def test_an_output_that_changes_is_not_foreseen() -> None:
    """Its echo is in the input image: the card is calm only as long as the program writes the same."""
    module = card("1769-OF4")
    module.update(0, Image([7]))
    assert module.calm_until_ns(Image([7])) > 10**15
    assert module.calm_until_ns(Image([8])) == 0
    module.plc_run(False)
    assert module.calm_until_ns(Image([7])) == 0
