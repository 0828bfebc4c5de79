"""A PCL601 that hears no Modbus because it is in AA ASCII: asked in 8N1, sent back, and used [adapters]."""

from __future__ import annotations

import pytest
from adapterbench import AdapterBench, move
from overheard import Overheard
from scanrack.io_images.pcl601 import Register
from scanrack.runtime.controllers.pcl601.controller import Protocol
from scanrack.runtime.line.master import Reply, Verdict
from scanrack.runtime.line.pcl601_ascii import ask_address

MODBUS, ASCII = "38400 8E1", "38400 8N1"


def in_ascii(bench: AdapterBench) -> AdapterBench:
    bench.device.controller.speak(Protocol.ASCII)
    return bench


def test_a_controller_found_in_ascii_is_sent_back_to_modbus():
    bench = in_ascii(AdapterBench())
    heard = Overheard(bench)
    bench.run(490)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
    assert bench.device.controller.protocol is Protocol.MODBUS
    # the first request left before anything was overheard
    assert heard.frames[:2] == [(b"@%\r", ASCII), (b"@1|\r", ASCII)]
    assert {line_format for _, line_format in heard.frames[2:]} == {MODBUS}
    bench.configured()
    bench.give(*move(500), ms=1000, until="MOVE_COMPLETE")
    assert bench.motor == 500


def test_one_that_goes_to_ascii_in_mid_move_comes_back_as_from_a_lost_link():
    bench = AdapterBench().configured()
    bench.give(*move(10_000), ms=500)
    in_ascii(bench)
    assert bench.run(200).bits == {"POSITION_INVALID"}
    bench.run(1000)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    assert bench.position == bench.motor < 10_000
    said = [event.text for event in bench.module.events if event.kind == "adapter"]
    assert said[0] == "the device used AA ASCII, and is switched back to Modbus"


def test_another_unit_in_ascii_is_left_alone():
    bench = AdapterBench()
    bench.device.controller.values[Register.ADDRESS] = 2
    in_ascii(bench)
    heard = Overheard(bench)
    assert bench.run(1200).bits == {"POSITION_INVALID"}
    assert bench.device.controller.protocol is Protocol.ASCII
    assert {data for data, line_format in heard.frames if line_format == ASCII} == {b"@%\r"}


def test_a_controller_without_power_is_asked_in_both_languages_four_times_a_second():
    bench = AdapterBench().configured()
    bench.module.controller.line.take_down()
    bench.run(300)
    heard = Overheard(bench)
    bench.run(1000)
    assert [line_format for _, line_format in heard.frames] == [MODBUS, ASCII] * 4


@pytest.mark.parametrize(
    ("heard", "read"),
    [
        (b"", Verdict.UNFINISHED),
        (b"1", Verdict.UNFINISHED),
        (b"1\r", Verdict.UNFINISHED),
        (b"1\r\n", Reply(b"1\r\n")),
        (b"01\r\n", Reply(b"01\r\n")),
        (b"11\r\n", Verdict.FOREIGN),
        (b"\r\n", Verdict.FOREIGN),
        (b"x\r\n", Verdict.FOREIGN),
        (b"\xb2\r\n", Verdict.FOREIGN),
    ],
)
def test_only_its_own_address_is_an_answer(heard, read):
    assert ask_address(1).read(heard) == read
