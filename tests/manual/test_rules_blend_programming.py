"""Blend profiles: the handshake word by word [chapter 5].

Starting speed 1000. The good profile: 3000 steps at 5000/s with rate 20, which
takes 600 steps to reach; 2200 steps at 2000/s with rate 10, which takes 1050
steps to reach and 150 to end.
"""

from __future__ import annotations

import pytest
from bench3601 import BLEND_CW, CONFIGURATION, Bench
from blends3601 import (
    PROGRAM,
    TRANSMIT,
    TWO,
    TWO_STEPS,
    C,
    block,
    blocks_of,
    drop,
    is_stored,
    program,
    send,
    transmit,
)

HEADER, FIRST, SECOND = blocks_of(TWO)


# -- the handshake


@pytest.mark.rules("BLD-02", "BLD-03", "BLD-04", "BLD-05", "BLD-01", "LSW-08", "LSW-09", "STS-L09")
@pytest.mark.parametrize("firmware", ["2.0", "4.1"])
@pytest.mark.parametrize("scan_ms", [0.25, 2])
def test_handshake_image_by_image(scan_ms, firmware):
    """One exchange for each of the routine's steps 1 to 4, once for each block; step 6."""
    bench = Bench.ready(firmware, scan_ms=scan_ms)
    for words in (HEADER, FIRST, SECOND):
        bench.out(0, PROGRAM, *words).scan()
        assert bench.bits == {"MODULE_OK"}
        transmit(bench, words)
        assert bench.bits == {"MODULE_OK", "BLEND_ACK"}
        bench.run(20)
        assert bench.bits == {"MODULE_OK", "BLEND_ACK"}
        drop(bench)
        assert bench.bits == {"MODULE_OK"}
    bench.out().scan()
    assert (bench.bits, bench.fired) == ({"MODULE_OK"}, [])
    bench.out(BLEND_CW).until("MOVE_COMPLETE")
    assert bench.position == TWO_STEPS


@pytest.mark.rules("BLD-02", "LSW-08", "LSW-09")
def test_either_bit_alone_begins_nothing():
    bench = Bench.ready()
    bench.out(0, TRANSMIT, *HEADER).run(5)
    assert bench.bits == {"MODULE_OK"}
    bench.out(0, PROGRAM, *HEADER).run(5)
    assert bench.bits == {"MODULE_OK"}
    send(bench, HEADER, FIRST, SECOND)
    assert is_stored(bench)


@pytest.mark.rules("BLD-02", "BLD-04")
def test_a_transmit_bit_that_waits_for_the_program_bit_reads_then():
    bench = Bench.ready()
    bench.out(0, TRANSMIT, *HEADER).run(5)
    transmit(bench, HEADER)
    assert "BLEND_ACK" in bench.bits
    drop(bench)
    send(bench, FIRST, SECOND)
    assert is_stored(bench)


@pytest.mark.rules("BLD-04", "LSW-09")
def test_a_block_is_read_when_the_transmit_bit_rises_and_not_later():
    bench = Bench.ready()
    transmit(bench, HEADER)
    bench.out(0, PROGRAM | TRANSMIT, *FIRST).run(5)  # the bit stays: no block
    drop(bench)
    send(bench, FIRST, SECOND)
    assert bench.fired == []
    assert is_stored(bench)


@pytest.mark.rules("BLD-05", "LSW-08")
@pytest.mark.parametrize("sent", range(1, 4))
@pytest.mark.parametrize("lsw", [0, TRANSMIT])
def test_program_bit_dropped_before_all_blocks_were_sent(sent, lsw):
    """Reading A-60: no profile, and no error; the acknowledge goes off with it."""
    bench = Bench.ready()
    good = [HEADER, FIRST, SECOND]
    send(bench, *good[: sent - 1])
    transmit(bench, good[sent - 1])
    bench.out(0, lsw, *SECOND).scan()
    assert (bench.bits, bench.fired) == ({"MODULE_OK"}, [])
    assert is_stored(bench) is (sent == 3)


@pytest.mark.rules("BLD-05", "BLD-02")
def test_the_next_session_begins_with_a_first_block_again():
    bench = Bench.ready()
    send(bench, HEADER, FIRST).out().scan()
    program(bench)
    assert is_stored(bench)


@pytest.mark.rules("BLD-04", "BLD-11")
def test_extra_blocks_are_acknowledged_and_ignored():
    """Reading A-60; a faulty one, too."""
    bench = Bench.ready()
    send(bench, HEADER, FIRST, SECOND, SECOND, block(0, 0, 0))
    assert bench.fired == []
    bench.out().scan().out(BLEND_CW).until("MOVE_COMPLETE")
    assert bench.position == TWO_STEPS


@pytest.mark.rules("BLD-02")
def test_unused_words_of_a_block_are_ignored():
    """Reading A-60."""
    bench = Bench.ready()
    send(bench, [*HEADER[:4], 77, -1], [*FIRST[:5], 77], [*SECOND[:5], -77])
    assert bench.fired == []
    assert is_stored(bench)


@pytest.mark.rules("BLD-01", "BLD-11")
@pytest.mark.parametrize("count", [2, 3, 8, 9, 15, 16])
def test_two_to_sixteen_segments(count):
    """Alternately at 2000 and 3000/s, a step of ramp each at least: every one gets 500 steps."""
    bench = Bench.ready()
    program(bench, [(500, 2000 + 1000 * (number % 2), 2000, C) for number in range(count)], (2000, C))
    bench.out(BLEND_CW).until("MOVE_COMPLETE")
    assert bench.position == 500 * count


# -- when it is not the time for it


@pytest.mark.rules("LSW-08")
@pytest.mark.parametrize("move", ["relative", "manual"])
def test_programming_during_another_move_is_an_error(move):
    """The move goes on; nothing is read, and the old profile stays."""
    bench = program(Bench.ready())
    getattr(bench, move)(4000 if move == "relative" else 1, ms=100)
    msw, _, *rest = bench.outputs
    bench.out(msw, PROGRAM | TRANSMIT, *rest).run(1)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING", "COMMAND_ERROR"}
    assert bench.fired == ["LSW-08"]
    bench.idle().until(clear=["MOVING_CW"])
    bench.reset_errors()
    assert is_stored(bench)


@pytest.mark.rules("BLD-25", "CMD-16")
def test_nothing_is_read_under_a_command_error():
    bench = Bench.ready()
    bench.out(BLEND_CW).run(1)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-16"])
    bench.out(0, PROGRAM | TRANSMIT, *HEADER).run(5)
    assert "BLEND_ACK" not in bench.bits
    bench.reset_errors()
    program(bench)
    bench.fired.clear()
    assert is_stored(bench)


@pytest.mark.rules("BLD-02", "CFG-28")
def test_nothing_is_read_before_a_configuration():
    bench = Bench()
    bench.out(0, PROGRAM | TRANSMIT, *HEADER).run(5)
    assert "BLEND_ACK" not in bench.bits


@pytest.mark.rules("BLD-24", "CFG-24")
def test_configuration_mode_ends_a_session():
    bench = Bench.ready()
    send(bench, HEADER, FIRST)
    bench.out(*CONFIGURATION).run(5)
    transmit(bench, SECOND)  # read as a first block: 2 segments, and no final deceleration in word 5
    assert bench.fired == ["POS-01", "PRF-07", "BLD-15"]


@pytest.mark.rules("BLD-02")
def test_bits_that_are_set_when_configuration_mode_is_left_have_risen():
    bench = Bench.ready()
    bench.out(*CONFIGURATION).run(5)
    transmit(bench, HEADER)
    assert "BLEND_ACK" in bench.bits
    drop(bench)
    send(bench, FIRST, SECOND)
    assert is_stored(bench)


@pytest.mark.rules("BLD-02", "PRG-01")
def test_program_mode_suspends_a_session():
    """Reading A-78: words are not acted on."""
    bench = Bench.ready()
    send(bench, HEADER)
    bench.plc("program")
    transmit(bench, FIRST)
    assert "BLEND_ACK" not in bench.bits
    bench.plc("run").scan()
    assert "BLEND_ACK" in bench.bits
    drop(bench)
    send(bench, SECOND)
    assert is_stored(bench)
