"""Every frame that the PCL601's manual prints, byte for byte; the test's id is where it stands."""

from __future__ import annotations

import pytest
from bench601 import Bench601, hexed
from scanrack.io_images.pcl601 import Register
from scanrack.runtime.controllers.pcl601.controller import Protocol
from scanrack.runtime.controllers.pcl601.line import FORMATS, SERIAL_TIMING
from scanrack.runtime.line.rtu import crc, is_frame


def outputs_1_and_2(bench):
    bench.controller.outputs = 0b00011


def input_3(bench):
    bench.pin("in1", "open")
    bench.pin("in3")


def acceleration_10000(bench):
    bench.controller.values[Register.ACCEL] = 0x2710


def input_5(bench):
    bench.pin("in5")


PRINTED = [
    ("0x01", outputs_1_and_2, "01 01 00 00 00 05 fc 09", "01 01 01 03 11 89"),
    ("0x02", input_3, "01 02 00 00 00 04 79 c9", "01 02 01 04 a0 4b"),
    ("0x03", acceleration_10000, "01 03 00 02 00 03 a4 0b", "01 03 06 00 00 27 10 00 00 2a 04"),
    ("0x04", input_5, "01 04 00 00 00 01 31 ca", "01 04 02 00 10 b8 fc"),
    ("0x05", None, "01 05 00 02 ff 00 2d fa", "01 05 00 02 ff 00 2d fa"),
    ("0x06", None, "01 06 00 06 07 d0 6a 67", "01 06 00 06 07 d0 6a 67"),
    ("0x0F", None, "01 0f 00 01 00 04 01 05 c3 55", "01 0f 00 01 00 04 05 c8"),
    ("0x10", None, "01 10 00 05 00 03 06 01 f4 0b b8 07 d0 c7 39", "01 10 00 05 00 03 90 09"),
    ("0x11", None, "01 11 c0 2c", "01 11 05 01 31 2e 30 30 c7 b2"),
]


@pytest.mark.parametrize(
    ("prepare", "request_", "reply"), [row[1:] for row in PRINTED], ids=[row[0] for row in PRINTED]
)
def test_appendix_3(prepare, request_, reply):
    bench = Bench601()
    if prepare is not None:
        prepare(bench)
    assert bench.exchange(hexed(request_)).hex(" ") == reply


def test_what_the_printed_writes_do():
    bench = Bench601()
    for _, _, request, _ in PRINTED[4:8]:
        bench.exchange(hexed(request))
    # 0x05: output 3 on; 0x0F: of outputs 2 to 5 the first and third on, so 3 is off again: 2 and 4
    assert bench.controller.outputs == 0b01010
    # 0x10 to registers 6 to 8, after 0x06 to register 7
    assert [bench.read(r) for r in (Register.BASE_SPEED, Register.MAX_SPEED, Register.JOG_SPEED)] == [
        500,
        3000,
        2000,
    ]


def test_the_misprint_of_section_3_and_appendix_4():
    """The broadcast switch to AA ASCII is printed with CRC C8 0D; that belongs to address 01."""
    printed = hexed("00 06 00 00 00 0b c8 0d")
    assert not is_frame(printed)
    assert is_frame(b"\x01" + printed[1:])
    assert crc(printed[:-2]) == hexed("c9 dc")
    bench = Bench601()
    assert bench.exchange(printed) == b""
    assert bench.controller.protocol is Protocol.MODBUS
    bench.to_ascii()
    assert bench.controller.protocol is Protocol.ASCII


def test_unicast_switch_is_answered_before_it_switches():
    bench = Bench601()
    assert bench.exchange(hexed("01 06 00 00 00 0b c8 0d")) == hexed("01 06 00 00 00 0b c8 0d")
    assert bench.talk("@%") == "1\r\n"


def test_character_times_of_message_framing():
    """About 286.5 µs, 430 µs and (3.5 t_char) 1003 µs."""
    assert FORMATS[Protocol.MODBUS].bits == 11
    assert round(FORMATS[Protocol.MODBUS].span_ns(1) / 1000, 1) == 286.5
    assert SERIAL_TIMING.pause_ns is not None
    assert round(SERIAL_TIMING.pause_ns / 1000) == 430
    assert round(SERIAL_TIMING.gap_ns / 1000) == 1003
