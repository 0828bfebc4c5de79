"""RTU framing: noise, truncation and other units' traffic never cost a good frame."""

from __future__ import annotations

from random import Random

import pytest
from bench601 import PORT_TIMING, Bench601, hexed
from scanrack.io_images.pcl601 import Register
from scanrack.runtime import SerialBus
from scanrack.runtime.controllers.pcl601.line import SERIAL_TIMING, Pcl601
from scanrack.runtime.line.rtu import Framer, crc, frame

READ = frame(1, hexed("03 00 05 00 01"))
REPLY = frame(1, hexed("03 02 01 f4"))
CHARACTER = 286_458
MS = 1_000_000


def fed(framer, now_ns, data):
    """Feed bytes that end at an instant; return the frames that come at once."""
    return framer.receive(now_ns - len(data) * CHARACTER, now_ns, data)


def test_on_a_line_the_silence_ends_a_frame():
    framer = Framer(SERIAL_TIMING)
    assert fed(framer, 10 * MS, READ) == []
    assert framer.deadline_ns == 10 * MS + 1_002_604
    assert framer.silence() == [READ]
    assert framer.deadline_ns is None


@pytest.mark.parametrize(("pause_ns", "frames"), [(0, [READ]), (429_000, [READ]), (431_000, [])])
def test_a_pause_of_more_than_a_character_and_a_half_spoils_a_frame(pause_ns, frames):
    framer = Framer(SERIAL_TIMING)
    fed(framer, 10 * MS, READ[:3])
    fed(framer, 10 * MS + pause_ns + 5 * CHARACTER, READ[3:])
    assert framer.silence() == frames


def test_by_length_a_frame_is_taken_when_it_is_complete():
    framer = Framer(PORT_TIMING)
    assert fed(framer, MS, READ[:5]) == []
    assert fed(framer, 3 * MS, READ[5:]) == [READ]
    assert framer.deadline_ns is None


def test_by_length_several_frames_in_one_piece():
    framer = Framer(PORT_TIMING)
    write = frame(1, hexed("10 00 05 00 03 06 01 f4 0b b8 07 d0"))
    ident = frame(1, b"\x11")
    assert fed(framer, MS, READ + write + ident + READ[:2]) == [READ, write, ident]
    assert fed(framer, 2 * MS, READ[2:]) == [READ]


def test_by_length_a_stub_that_promises_much_delays_but_loses_nothing():
    framer = Framer(PORT_TIMING)
    stub = hexed("01 10 00 00 00 7b fa 00")  # byte count 250
    assert fed(framer, MS, stub) == []
    assert fed(framer, 2 * MS, READ) == []
    assert framer.deadline_ns == 2 * MS + PORT_TIMING.gap_ns
    assert framer.silence() == [READ]


WRITE = frame(1, hexed("10 00 05 00 03 06 01 f4 0b b8 07 d0"))
CONTAINS = frame(2, hexed("10 00 05 00 04 08") + frame(1, hexed("05 00 02 ff 00")))
UNKNOWN = frame(1, hexed("2b 0e 01 00"))
PIECES = [(each, cut) for each in (READ, WRITE, CONTAINS, UNKNOWN) for cut in range(1, len(each))]


@pytest.mark.parametrize("before", [b"", READ, READ[:3], b"\x55"], ids=["first", "second", "stub", "noise"])
@pytest.mark.parametrize(("whole", "cut"), PIECES)
def test_by_length_a_silence_within_a_frame_does_not_end_it(before, whole, cut):
    """TCP promises no timing: a second may pass between two pieces, at any place."""
    framer = Framer(PORT_TIMING)
    fed(framer, MS, before)
    framer.silence()
    frames = fed(framer, 1_000 * MS, whole[:cut])
    frames += framer.silence()
    frames += fed(framer, 2_000 * MS, whole[cut:])
    frames += framer.silence()
    assert frames == [whole]
    assert fed(framer, 3_000 * MS, READ) == [READ]


@pytest.mark.parametrize("cuts", [(1, 2, 3), (2, 4, 9), (6, 7, 8), (7, 13, 14)])
def test_by_length_a_frame_in_four_pieces(cuts):
    framer, frames, now_ns = Framer(PORT_TIMING), [], 0
    for start, end in zip((0, *cuts), (*cuts, len(WRITE)), strict=True):
        now_ns += 1_000 * MS
        frames += fed(framer, now_ns, WRITE[start:end]) + framer.silence()
    assert frames == [WRITE]


def test_by_length_a_client_that_begins_anew_after_a_silence_is_heard_at_once():
    """The beginning of a frame that never goes on does not swallow the requests behind it."""
    for cut in range(1, len(WRITE)):
        framer = Framer(PORT_TIMING)
        assert fed(framer, MS, WRITE[:cut]) + framer.silence() == []
        for at in range(1, 5):
            assert fed(framer, at * 1_000 * MS, READ) + framer.silence() == [READ]


def stub_of(whole):
    """Return the beginning of a frame of eight bytes that ends in `whole`, with the right CRC by chance."""
    for number in range(1 << 20):
        stub = bytes((1, 6)) + number.to_bytes(3, "big")
        if crc((stub + whole)[:6]) == (stub + whole)[6:8]:
            return stub
    raise AssertionError("no such one")


def test_by_length_a_whole_frame_is_not_the_end_of_a_stub_even_if_the_crc_is_right():
    """One stub in 65,536 fits a frame behind it; what begins and ends with new bytes is likelier."""
    stub = stub_of(READ)
    framer = Framer(PORT_TIMING)
    assert fed(framer, MS, stub) + framer.silence() == []
    assert fed(framer, 1_000 * MS, READ) == [READ]


def test_by_length_bytes_that_are_never_a_frame_are_not_kept():
    framer = Framer(PORT_TIMING)
    for at in range(1, 1_000):
        assert fed(framer, at * 100 * MS, b"\x01") + framer.silence() == []
    assert len(framer._buffer) <= 256


def test_by_length_an_unknown_function_is_taken_at_the_silence():
    framer = Framer(PORT_TIMING)
    odd = frame(1, hexed("2b 0e 01 00"))
    assert fed(framer, MS, odd) == []
    assert framer.silence() == [odd]


def test_the_frame_of_another_unit_is_consumed_whole():
    # its data are, byte for byte, a frame for unit 1: that is not one
    inner = frame(1, hexed("05 00 02 ff 00"))
    other = frame(2, hexed("10 00 05 00 04 08") + inner)
    for timing in (SERIAL_TIMING, PORT_TIMING):
        unit = Pcl601(timing=timing)
        unit.receive(10 * MS, other)
        unit.advance(30 * MS)
        assert unit.controller.outputs == 0


DAMAGE = {
    "a byte of noise": b"\x00",
    "a truncated request": READ[:-1],
    "a request with a damaged CRC": READ[:-1] + b"\x00",
    "a stub of a long write": hexed("01 10 00 00 00 7b fa 00"),
    "another unit's reply": frame(2, hexed("03 06 01 03 00 05 00 01")),
    "another unit's exception": frame(2, hexed("83 02")),
    "text": b"@1VZ\r\n",
    "three hundred bytes": bytes(300),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_after_damage_and_silence_a_good_frame_is_answered(damage):
    bench = Bench601()
    assert bench.exchange(damage) == b""
    assert bench.exchange(READ) == REPLY


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_by_length_even_without_silence(damage):
    unit = Pcl601(timing=PORT_TIMING)
    unit.receive(MS, damage + READ)
    assert unit.advance(MS) + unit.advance(20 * MS) == REPLY


def test_noise_right_before_a_frame_spoils_it_on_a_line():
    bench = Bench601()
    assert bench.exchange(b"\x55" + READ) == b""


def damaged(draw):
    """Return bytes that are no frame for this unit, in one of the ways in which lines go wrong."""
    good = bytearray(frame(1, bytes((draw.choice((1, 2, 3, 4, 5, 6, 15, 16, 17)),)) + draw.randbytes(4)))
    kind = draw.randrange(4)
    if kind == 0:
        return draw.randbytes(draw.randrange(1, 40))
    if kind == 1:
        return bytes(good[: draw.randrange(1, len(good))])
    if kind == 2:
        good[draw.randrange(len(good))] ^= 1 << draw.randrange(8)
        return bytes(good)
    return frame(draw.randrange(2, 248), draw.randbytes(draw.randrange(1, 30)))


def is_for_it(data):
    return len(data) >= 4 and crc(data[:-2]) == data[-2:] and data[0] in (0, 1)


@pytest.mark.parametrize("timing", [SERIAL_TIMING, PORT_TIMING], ids=["line", "port"])
def test_thousands_of_damaged_frames(timing):
    draw = Random(601)
    unit = Pcl601(timing=timing)
    unit.controller.values[Register.BASE_SPEED] = 500
    now_ns = 0
    for _ in range(3000):
        data = damaged(draw)
        if is_for_it(data):
            continue
        now_ns += 20 * MS
        unit.advance(now_ns)
        unit.receive(now_ns, data)
        now_ns += 20 * MS
        assert unit.advance(now_ns) == b""
        unit.receive(now_ns + 10 * MS, READ)
        assert unit.advance(now_ns + 20 * MS) == REPLY
        now_ns += 20 * MS


def test_ninety_nine_units_on_one_line():
    units = [Pcl601(address) for address in range(1, 100)]
    bus = SerialBus(*units)
    for address in (1, 42, 99):
        bus.send(frame(address, hexed("06 00 05 00") + bytes((address,))), units[0].line_format)
        bus.run_until(bus.now_ns + 20 * MS)
        assert bus.take() == frame(address, hexed("06 00 05 00") + bytes((address,)))
    bases = [unit.controller.values[Register.BASE_SPEED] for unit in units]
    assert {base for base in bases if base != 500} == {1, 42, 99}
    bus.send(frame(0, hexed("06 00 05 00 07")), units[0].line_format)
    bus.run_until(bus.now_ns + 20 * MS)
    assert bus.take() == b""
    assert {unit.controller.values[Register.BASE_SPEED] for unit in units} == {7}
