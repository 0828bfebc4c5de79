"""Blend profiles: every fault in every block, and the nearest that is accepted [chapters 5 and 6].

Starting speed 1000. The good profile: 3000 steps at 5000/s with rate 20, which
takes 600 steps to reach; 2200 steps at 2000/s with rate 10, which takes 1050
steps to reach and 150 to end.
"""

from __future__ import annotations

import pytest
from bench3601 import Bench
from blends3601 import (
    PROGRAM,
    TWO,
    C,
    T,
    Z,
    block,
    blocks_of,
    drop,
    header,
    is_stored,
    program,
    send,
    transmit,
)

HEADER, FIRST, SECOND = blocks_of(TWO)

PROFILE = {"INVALID_PROFILE"}
BOTH = {"INVALID_PROFILE", "COMMAND_ERROR"}


# -- faults

HEADER_FAULTS = [
    pytest.param(header(count=1), PROFILE, ["PRF-04"], id="1 segment"),
    pytest.param(header(count=0), PROFILE, ["PRF-04"], id="0 segments"),
    pytest.param(header(count=-2), PROFILE, ["PRF-04"], id="-2 segments"),
    pytest.param(header(count=17), PROFILE, ["PRF-04"], id="17 segments"),
    pytest.param(header(count=32767), PROFILE, ["PRF-04"], id="32,767 segments"),
    pytest.param(header(final=0), BOTH, ["PRF-07", "BLD-15"], id="no final deceleration"),
    pytest.param(header(final=0, final_type=Z), BOTH, ["PRF-07", "BLD-15"], id="only a final type"),
    pytest.param(header(final=2001), BOTH, ["BLD-13"], id="final deceleration 2001"),
    pytest.param(header(final=0x3FFF, final_type=T), BOTH, ["BLD-13"], id="final deceleration 16,383"),
    pytest.param(header(final_type=0b10), BOTH, ["BLD-13"], id="final type 10"),
    pytest.param(header(count=17, final=0), BOTH, ["PRF-04", "PRF-07", "BLD-15"], id="two faults"),
]


@pytest.mark.rules("PRF-04", "PRF-07", "BLD-13", "BLD-14", "BLD-15", "BLD-25", "BLD-11")
@pytest.mark.parametrize(("words", "bits", "fired"), HEADER_FAULTS)
def test_fault_in_the_first_block(words, bits, fired):
    """It shows with the acknowledge; what follows is acknowledged to no effect [routine 2; reading A-57]."""
    bench = Bench.ready()
    transmit(bench, words)
    assert bench.bits == {"MODULE_OK", "BLEND_ACK", *bits}
    assert bench.fired == fired
    drop(bench)
    send(bench, FIRST, SECOND)
    bench.out().scan()
    assert (bench.bits, bench.fired) == ({"MODULE_OK", *bits}, fired)
    bench.reset_errors()
    assert bench.bits == {"MODULE_OK"}
    assert not is_stored(bench)


SEGMENT_FAULTS = [
    pytest.param([3, -1, 5, 0, 20, 0], PROFILE, "BLD-21", id="length LSW -1"),
    pytest.param([-3, 0, 5, 0, 20, 0], PROFILE, "BLD-21", id="length MSW -3"),
    pytest.param([-3, -1, 5, 0, 20, 0], PROFILE, "BLD-21", id="length -3001"),
    pytest.param([3, 1000, 5, 0, 20, 0], PROFILE, "BLD-22", id="length LSW 1000"),
    pytest.param([0, 0, 5, 0, 20, 0], PROFILE, "BLD-22", id="length 0"),
    pytest.param(block(8_388_608, 5000, 20), PROFILE, "BLD-19", id="length 8,388,608"),
    pytest.param(block(3000, 999, 20), BOTH, "CMD-05", id="speed 999"),
    pytest.param(block(3000, 0, 20), BOTH, "PRF-02", id="speed 0"),
    pytest.param(block(3000, 1_000_001, 20), BOTH, "PRF-02", id="speed 1,000,001"),
    pytest.param([3, 0, 5, -1, 20, 0], BOTH, "PRF-02", id="speed words that are no value"),
    pytest.param([3, 0, 5, 1000, 20, 0], BOTH, "PRF-02", id="speed LSW 1000"),
    pytest.param(block(3000, 5000, 0), PROFILE, "BLD-18", id="no rate"),
    pytest.param(block(3000, 5000, 2001), PROFILE, "BLD-18", id="rate 2001"),
    pytest.param(block(3000, 5000, -1), PROFILE, "BLD-18", id="rate -1"),
    pytest.param(block(599, 5000, 20), PROFILE, "PRF-05", id="too short"),
]


@pytest.mark.rules(
    "BLD-18", "BLD-19", "BLD-21", "BLD-22", "BLD-16", "PRF-05", "PRF-02", "CMD-05", "PRF-01", "BLD-25"
)
@pytest.mark.parametrize(("words", "bits", "rule"), SEGMENT_FAULTS)
@pytest.mark.parametrize("at", [1, 2, 4])
def test_fault_in_a_segment_block(words, bits, rule, at):
    """In the first, a middle and the last of four; those before end at 1000/s, so the ramp is the same."""
    bench = Bench.ready()
    plain = [block(10 + number, 1000 + number % 2, 2000) for number in range(at - 1)]
    send(bench, header((C,) * 4), *plain[::-1])
    transmit(bench, words)
    assert bench.bits == {"MODULE_OK", "BLEND_ACK", *bits}
    assert bench.fired[0] == rule
    assert set(bench.fired[1:]) <= {"CMD-04", "PRF-01"}
    drop(bench)
    send(bench, *[FIRST] * (4 - at))
    bench.out().scan()
    assert bench.bits == {"MODULE_OK", *bits}
    bench.reset_errors()
    assert not is_stored(bench)


@pytest.mark.rules("BLD-17", "PRF-06")
@pytest.mark.parametrize("before", [[], [FIRST], [FIRST, block(2000, 2000, 20)]], ids=len)
def test_equal_speeds_of_consecutive_segments(before):
    """Only the previous segment is compared, not the one before it."""
    bench = Bench.ready()
    send(bench, header((C,) * 4), *before, block(3000, 4000, 20))
    assert bench.fired == []
    transmit(bench, block(3000, 4000, 10))
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "BLEND_ACK", *PROFILE}, ["PRF-06"])


@pytest.mark.rules("BLD-25")
@pytest.mark.parametrize("fault", [header(count=1), header(final=0)], ids=["Invalid Profile", "both"])
def test_a_fault_blocks_everything_but_reset_errors(fault):
    bench = Bench.ready()
    transmit(bench, fault)
    bits = bench.bits - {"BLEND_ACK"}
    bench.out().scan()
    for msw in (0x0001, 0x0002, 0x0004, 0x0008, 0x0020, 0x0080, 0x0200, 0x1000, 0x0003):
        bench.out(msw, 0, 0, 0, 5, 0, 20, 10).run(1).out().run(1)
        assert (bench.bits, bench.position) == (bits, 0)
    transmit(bench, HEADER)
    assert bench.bits == bits
    bench.out(0x0800, PROGRAM).run(1)  # the command LSW has to be zero
    assert bench.bits == bits
    bench.idle().reset_errors()
    assert bench.bits == {"MODULE_OK"}
    assert is_stored(program(bench))


# -- the nearest that is accepted


def accepted(segments: list[list[int]], **head) -> bool:
    bench = Bench.ready()
    send(bench, header(head.pop("types", (C,) * len(segments)), **head), *segments)
    assert bench.fired == []
    return is_stored(bench)


@pytest.mark.rules("BLD-13", "BLD-15", "PRF-07")
@pytest.mark.parametrize("final", [1, 2000])
@pytest.mark.parametrize("final_type", [C, T, Z])
def test_final_decelerations(final, final_type):
    assert accepted([FIRST, block(9000, 2000, 20)], final=final, final_type=final_type)


@pytest.mark.rules("BLD-18", "BLD-22", "BLD-17", "CMD-05", "PRF-02")
@pytest.mark.parametrize(
    "first",
    [
        pytest.param(block(1, 1000, 1), id="a step at the starting speed, rate 1"),
        pytest.param(block(999, 1001, 2000), id="999 steps, rate 2000"),
        pytest.param(block(250_000, 1_000_000, 2000), id="1,000,000 steps/s"),
    ],
)
def test_segments_at_the_ends_of_the_ranges(first):
    assert accepted([first, block(300_000, 5000, 2000)])


@pytest.mark.rules("BLD-19")
@pytest.mark.parametrize(("second", "good"), [(388_607, True), (388_608, False)])
def test_the_sum_of_the_lengths(second, good):
    bench = Bench.ready()
    send(bench, HEADER, block(8_000_000, 5000, 20))
    transmit(bench, block(second, 2000, 20))
    assert bench.fired == ([] if good else ["BLD-19"])
    assert ("INVALID_PROFILE" in bench.bits) is not good


@pytest.mark.rules("BLD-16", "PRF-05", "BLD-10", "BLD-12")
@pytest.mark.parametrize(
    ("kind", "segment", "least"),
    [
        # From 1000 to 5000/s at 20: 24e6/40,000 = 600 steps; at 1,000,000/s and 2000: 249,999.75.
        pytest.param(C, (5000, 20), 600, id="up, constant"),
        pytest.param(T, (5000, 20), 1200, id="up, triangular S"),
        pytest.param(Z, (5000, 20), 800, id="up, trapezoidal S"),
        pytest.param(C, (1_000_000, 2000), 250_000, id="up to 1,000,000/s"),
    ],
)
def test_the_first_segment_contains_its_ramp(kind, segment, least):
    for length, fired in [(least, []), (least - 1, ["PRF-05"])]:
        bench = Bench.ready()
        send(bench, header((kind, C)), block(length, *segment))
        assert bench.fired == fired


@pytest.mark.rules("BLD-16", "PRF-05", "BLD-10", "BLD-12")
@pytest.mark.parametrize("final_type", [C, T, Z])
@pytest.mark.parametrize("kind", [C, T, Z])
def test_the_last_segment_contains_its_ramp_and_the_final_one(kind, final_type):
    """5000 to 2000/s at 10: 21e6/20,000 = 1050 steps. 2000 to 1000/s at 15: 3e6/30,000 = 100 steps."""
    factor = {C: 3, T: 6, Z: 4}  # thirds
    least = (1050 * factor[kind] + 100 * factor[final_type] + 2) // 3
    for length, fired in [(least, []), (least - 1, ["PRF-05"])]:
        bench = Bench.ready()
        send(bench, header((C, kind), 15, final_type), FIRST, block(length, 2000, 10))
        assert bench.fired == fired


@pytest.mark.rules("BLD-16", "PRF-05")
def test_a_middle_segment_contains_its_ramp_only():
    """5000 to 2000/s at 10: 1050 steps."""
    for length, fired in [(1050, []), (1049, ["PRF-05"])]:
        bench = Bench.ready()
        send(bench, header((C, C, C)), FIRST, block(length, 2000, 10))
        assert bench.fired == fired
