"""Values in two words: sent, and reported beyond the range of what can be sent [chapters 1, 5 and 6]."""

from __future__ import annotations

import pytest
from bench3601 import CAPTURE, ENCODER, PRESET, PRESET_ENCODER, Bench, configuration

COUNTING = configuration(add=CAPTURE | ENCODER)
EXAMPLES = [
    ((-12, -345), -12_345),
    ((12, 0), 12_000),
    ((-12, 0), -12_000),
    ((0, 345), 345),
    ((0, -345), -345),
]
REPORTED = [
    (8_388_607, (8_388, 607)),
    (32_767_999, (32_767, 999)),  # 7FFFh
    (32_768_000, (-32_768, 0)),  # 8000h
    (32_768_001, (-32_768, 1)),
    (65_535_000, (-1, 0)),
    (65_535_999, (-1, 999)),  # FFFFh
]


@pytest.mark.rules("IOM-02", "IOM-03")
@pytest.mark.parametrize(("words", "value"), EXAMPLES)
def test_the_manuals_examples_as_a_move(words, value):
    """12,345 is 12 thousands and 345; a negative value makes both words negative."""
    bench = Bench.ready(config=configuration(start=1_000_000), scan_ms=1)
    bench.out(0x0002, 0, *words, 1_000, 0, 20, 10).run(20)
    assert (bench.words[2:4], bench.module.machine.shaft) == (list(words), value)


@pytest.mark.rules("IOM-06", "IOM-17", "IOM-13", "IOM-14")
def test_position_encoder_and_captured_value_in_their_words():
    """Three different values: the position counts steps, whatever the encoder says."""
    bench = Bench.ready(config=COUNTING, position=-12_345)
    bench.out(PRESET_ENCODER, 0, 6, 7).run(1).idle()
    bench.turn_encoder(-8_000, 10).inputs(capture=1).run(1)
    bench.turn_encoder(3_999, 10).relative(1_000, ms=600)
    assert bench.words == [0x4080, 0x0001, -11, -345, 2, 6, -1, -993]


@pytest.mark.rules("IOM-11", "IOM-12")
def test_the_position_reaches_65_535_999():
    """Moves of 8,388,607 steps at most, at a million a second; 65,536,000 reads as 0 (reading A-38)."""
    bench = Bench.ready(config=configuration(start=1_000_000), scan_ms=100)
    position = 0
    for value, words in [*REPORTED, (65_536_000, (0, 0))]:
        while position < value:
            distance = min(8_388_607, value - position)
            bench.relative(distance, speed=1_000_000, ms=distance // 1_000 + 100).idle(100)
            position += distance
        assert (bench.words[2:4], bench.module.machine.shaft) == (list(words), value)


@pytest.mark.rules("IOM-11", "IOM-12")
def test_the_position_is_live_on_its_way_past_7fffh():
    """2,000 steps from 32,767,000 at 1000 a second, looked at every 100 ms."""
    bench = Bench.ready(config=configuration(start=1_000), scan_ms=100, position=8_388_000)
    for distance in (8_388_000, 8_388_000, 7_603_000):
        bench.relative(distance, speed=1_000_000, up=2_000, down=2_000)
        bench.until("MOVE_COMPLETE")
        bench.idle(100)
    assert bench.words[2:4] == [32_767, 0]
    bench.relative(2_000, speed=1_000)
    shown = []
    for _ in range(20):
        bench.run(100)
        shown.append(tuple(bench.words[2:4]))
    assert shown[8:12] == [(32_767, 900), (-32_768, 0), (-32_768, 100), (-32_768, 200)]
    assert shown[-1] == (-32_767, 0)


@pytest.mark.rules("IOM-13", "IOM-14")
@pytest.mark.parametrize(("value", "words"), REPORTED)
def test_the_encoder_and_the_captured_value_reach_as_far(value, words):
    """8,000,000 preset, the rest turned by hand."""
    bench = Bench.ready(config=COUNTING).out(PRESET_ENCODER, 0, 8_000, 0).run(1)
    bench.turn_encoder(value - 8_000_000, 10).inputs(capture=1).run(1)
    assert (bench.words[4:6], bench.words[6:]) == (list(words), list(words))


@pytest.mark.rules("IOM-11")
def test_negative_positions_beyond_the_range_keep_the_sign_in_the_lsw():
    """-32,769,001: the thousands are -32,769, whose low 16 bits read 32,767 (reading A-38)."""
    bench = Bench.ready(config=COUNTING).out(PRESET_ENCODER, 0, -8_000, 0).run(1)
    bench.turn_encoder(-24_769_001, 10)
    assert bench.words[4:6] == [32_767, -1]


@pytest.mark.rules("IOM-11")
def test_a_position_out_of_the_targets_range_is_no_target():
    """An absolute move back is in range; the position itself could not be sent."""
    bench = Bench.ready(config=configuration(start=1_000_000), position=8_388_607, scan_ms=1)
    bench.relative(1_393, speed=1_000_000, ms=10).idle()
    assert bench.words[2:4] == [8_390, 0]
    bench.out(0x0001, 0, 8_390, 0, 1_000, 0, 20, 10).run(10)
    assert bench.fired == ["CMD-04", "PRF-02"]
    bench.reset_errors()
    bench.out(0x0001, 0, 8_388, 0, 1_000, 0, 20, 10).run(10)
    assert (bench.words[2:4], "MOVE_COMPLETE" in bench.bits) == ([8_388, 0], True)
    bench.out(PRESET).run(1)
    assert bench.words[2:4] == [0, 0]
