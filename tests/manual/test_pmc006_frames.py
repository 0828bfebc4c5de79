"""Every frame that the PMC006x3s manual prints, byte for byte, and the rules of chapter 4.1."""

from __future__ import annotations

import pytest
from bench006 import Bench006
from scanrack.io_images.pmc006.frame import Framer, command, decode, encode
from scanrack.runtime.controllers.pmc006.pins import Pin

STEP = "a5 01 73 1f 01 00 00 39", "a5 7a 01 03 00 00 00 23"
MICROSTEPPING = "a5 02 6d 04 00 00 00 18", "a5 7a 02 04 00 00 00 25"
WRITE_IO = "a5 02 79 82 01 00 00 a3", "a5 7a 02 00 00 00 00 21"
READ_LEVELS = "a5 ff 78 00 00 00 00 1c", "a5 7a ff 03 00 00 00 21"
PRINTED = [*STEP, *MICROSTEPPING, *WRITE_IO, *READ_LEVELS]


@pytest.mark.parametrize("printed", PRINTED)
def test_4_1_a_printed_frame_decodes_and_encodes_to_itself(printed: str) -> None:
    frame = decode(bytes.fromhex(printed))
    assert frame is not None
    assert encode(frame.second, frame.third, frame.data).hex(" ") == printed


def test_4_3_1_the_step_example() -> None:
    bench = Bench006(1, step_ack_value=3)
    assert bench.text(STEP[0]) == STEP[1]
    bench.wait(2000)
    assert bench.position == 287


def test_4_3_2_the_microstepping_example() -> None:
    bench = Bench006(2)
    assert bench.text(MICROSTEPPING[0]) == MICROSTEPPING[1]
    assert bench.ask("k") == 4


def test_4_3_14_the_output_example() -> None:
    bench = Bench006(2)
    bench.ask("y", 0)
    assert not bench.controller.gpio8
    assert bench.text(WRITE_IO[0]) == WRITE_IO[1]
    assert bench.controller.gpio8


def test_4_3_15_the_level_example() -> None:
    bench = Bench006(0xFF)
    bench.pin(Pin.EXT1, False)
    bench.pin(Pin.FSET, False)
    assert bench.text(READ_LEVELS[0]) == READ_LEVELS[1]


def test_4_1_4_the_low_byte_travels_first() -> None:
    assert command(1, 0x37, 0x12345678)[3:7].hex() == "78563412"
    bench = Bench006()
    assert bench.ask("7", 0x12345678) == 0x12345678
    assert bench.text(command(1, ord("6")).hex()) == "a5 7a 01 78 56 34 12 34"


@pytest.mark.parametrize("spoilt", range(1, 8))
def test_4_1_5_a_frame_with_a_wrong_byte_is_neither_answered_nor_carried_out(spoilt: int) -> None:
    bench = Bench006()
    frame = bytearray(command(1, ord("m"), 4))
    frame[spoilt] ^= 0x20
    assert bench.exchange(bytes(frame)) == b""
    assert bench.ask("k") == 16


@pytest.mark.parametrize("address", [0, 2, 0x7A, 0xFF])
def test_4_1_another_address_is_not_answered(address: int) -> None:
    bench = Bench006(1)
    assert bench.exchange(command(address, ord("k"))) == b""


def test_4_1_an_unknown_instruction_is_answered_all_the_same() -> None:
    bench = Bench006()
    codes = set(range(256)) - {ord(char) for char in "4789FIJLMNQSZabdefgilmostuvwy:6KOPRchjk;x"}
    assert {bench.ask(chr(code)) for code in sorted(codes)} == {7}


def test_2_1_a_frame_begun_and_not_finished_is_dropped_after_the_time_out() -> None:
    bench = Bench006()
    assert bench.exchange(command(1, ord("k"))[:5]) == b""
    assert bench.ask("k") == 16


def test_a_good_frame_right_behind_noise_is_found() -> None:
    bench = Bench006()
    good = command(1, ord("k"))
    for noise in (b"\xa5", b"\xa5\x01\x6b", b"\x00\xff\xa5\xa5", good[:7]):
        assert bench.exchange(noise + good).hex(" ") == "a5 7a 01 10 00 00 00 30", noise


def test_the_framer_counts_what_it_passes_over() -> None:
    framer = Framer()
    assert framer.feed(b"\x00\x01\xa5" + command(9, 9)) == [decode(command(9, 9))]
    assert (framer.skipped, len(framer)) == (3, 0)
    framer.feed(b"\xa5\x01")
    assert len(framer) == 2
    framer.drop()
    assert (framer.skipped, len(framer)) == (5, 0)


def test_9600_baud_an_exchange_takes_two_frames_of_eight_characters() -> None:
    bench = Bench006()
    end_ns = bench.bus.send(command(1, ord("k")), bench.device.line_format)
    assert end_ns == 8_333_333
    bench.bus.run_until(2 * end_ns - 1)
    assert len(bench.bus.heard) == 7
    bench.bus.run_until(2 * end_ns)
    assert len(bench.bus.heard) == 8


@pytest.mark.parametrize(
    ("second", "third", "data"),
    [(-1, 0, 0), (256, 0, 0), (0, -1, 0), (0, 256, 0), (0, 0, -(2**31) - 1), (0, 0, 2**32)],
)
def test_4_1_what_is_no_byte_and_no_32_bits_is_in_no_frame(second: int, third: int, data: int) -> None:
    with pytest.raises(ValueError, match="must be"):
        encode(second, third, data)


@pytest.mark.parametrize(
    ("data", "octets"),
    [(-(2**31), "00 00 00 80"), (-1, "ff ff ff ff"), (2**31 - 1, "ff ff ff 7f"), (2**32 - 1, "ff ff ff ff")],
)
def test_4_1_4_data_go_low_byte_first(data: int, octets: str) -> None:
    assert encode(255, 255, data)[3:7].hex(" ") == octets
