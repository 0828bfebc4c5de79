"""Lines as they are: characters that take time, faults on request, and a gateway with a time limit."""

from __future__ import annotations

import re

import pytest
from bench601 import PORT_TIMING
from scanrack.io_images.pmc006.frame import command, reply
from scanrack.io_images.pmc006.instructions import BY_NAME
from scanrack.runtime import Device
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.line.faulty import FaultInjector
from scanrack.runtime.line.gateway import Gateway, GatewayRequest
from scanrack.runtime.line.rtu import frame, is_frame
from scanrack.runtime.line.timed import TimedLine

MS = 1_000_000
CHARACTER_NS = 11 * 1e9 / 38_400
READ_ALL = bytes.fromhex("03 0000 0026")
READ_ONE = bytes.fromhex("03 0005 0001")
BASE_SPEED = bytes.fromhex("03 02 01f4")
"""Register 4x6, 500 at first."""


def pcl601(timed: bool = False) -> FaultInjector:
    device = Pcl601(timing=PORT_TIMING)
    return FaultInjector(device, (lambda: device.turnaround_ns) if timed else (lambda: 0))


def asked(device: Device, request: bytes, now_ns: int = 0) -> list[tuple[int, bytes]]:
    """Send a request; return what comes back within 300 ms, with its instants."""
    said = [(now_ns, device.advance(now_ns))]
    device.receive(now_ns, request)
    while (due_ns := device.next_wake_ns) is not None and due_ns <= now_ns + 300 * MS:
        said.append((due_ns, device.advance(due_ns)))
    return [each for each in said if each[1]]


def test_a_read_of_all_registers_takes_the_line_as_long_as_its_characters() -> None:
    """8 characters, 3.5 of silence, 81 characters: 26.5 ms; the first one is whole after 12.5."""
    said = asked(TimedLine(pcl601(timed=True)), frame(1, READ_ALL))
    assert [len(data) for _, data in said] == [1] * 81
    assert said[0][0] == pytest.approx(12.5 * CHARACTER_NS, abs=3)
    assert said[-1][0] == pytest.approx(92.5 * CHARACTER_NS, abs=3)
    assert is_frame(b"".join(data for _, data in said))


def test_a_pmc006_answers_after_sixteen_characters_of_ten_bits_at_9600_baud() -> None:
    device = Pmc006(Pmc006Controller(address=1))
    request = command(1, BY_NAME["read_position"].code)
    said = asked(TimedLine(FaultInjector(device, lambda: device.turnaround_ns)), request)
    assert b"".join(data for _, data in said) == reply(1, 0)
    assert said[-1][0] == pytest.approx(160 * 1e9 / 9600, abs=3)


@pytest.mark.parametrize(
    ("fault", "whole"),
    [
        ("drop=2", [None, None, True, True, True, True]),
        ("crc=1", [False, True, True, True, True, True]),
        ("crc=1/3", [True, True, False, True, True, False]),
        ("drop=2/3", [True, None, None, True, None, None]),
        ("drop=0", [True] * 6),
    ],
)
def test_replies_are_lost_or_damaged_as_asked(fault: str, whole: list[bool | None]) -> None:
    device = pcl601()
    device.set(fault)
    replies = [asked(device, frame(1, READ_ONE), at * 400 * MS) for at in range(6)]
    assert [is_frame(said[0][1]) if said else None for said in replies] == whole


def test_a_lost_reply_is_lost_after_the_controller_has_acted() -> None:
    device = pcl601()
    device.set("drop=1")
    assert asked(device, frame(1, bytes.fromhex("06 0005 0064"))) == []
    assert asked(device, frame(1, READ_ONE), 400 * MS)[0][1] == frame(1, bytes.fromhex("03 02 0064"))


def test_a_delayed_reply_comes_that_much_later_and_none_overtakes_it() -> None:
    device = pcl601()
    device.set("delay=200")
    device.receive(0, frame(1, READ_ONE))
    assert device.advance(0) == b""
    device.set("delay=0")
    device.receive(10 * MS, frame(1, READ_ALL))
    assert device.advance(10 * MS) == device.advance(200 * MS - 1) == b""
    assert device.next_wake_ns == 200 * MS
    assert len(device.advance(200 * MS)) == 7 + 81


def test_a_silent_unit_does_not_even_hear() -> None:
    device = pcl601()
    device.set("silence=on")
    assert asked(device, frame(1, bytes.fromhex("06 0005 0064"))) == []
    device.set("silence=off")
    assert asked(device, frame(1, READ_ONE), 400 * MS)[0][1] == frame(1, BASE_SPEED)


def test_a_reset_forgets_what_was_written() -> None:
    device = pcl601()
    asked(device, frame(1, bytes.fromhex("06 0005 0064")))
    device.set("reset")
    assert asked(device, frame(1, READ_ONE), 400 * MS)[0][1] == frame(1, BASE_SPEED)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("drop", "'' is not a number of replies"),
        ("drop=3/2", "'3/2' is not a number of replies"),
        ("crc=-1", "'-1' is not a number of replies"),
        ("crc=9999999", "'9999999' is not a number of replies"),
        ("delay=60001", "delay=60001: must be 0 to 60,000 ms"),
        ("delay=x", "delay=x: must be 0 to 60,000 ms"),
        ("silence", "'silence' is not a fault; choose from drop=N"),
        ("reset=1", "'reset=1' is not a fault"),
        ("", "'' is not a fault"),
    ],
)
def test_what_is_no_fault(text: str, said: str) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(said)):
        pcl601().set(text)


def gateway(device: Device, *, timed: bool = False) -> Gateway[str]:
    return Gateway(device, lambda unit: unit, 100 * MS, timed=timed)


def replies(door: Gateway[str], until_ns: int, now_ns: int = 0) -> list[tuple[int, str, bytes]]:
    """Return what a gateway answers, with the instants, woken when it wants to be."""
    said = [(now_ns, *each) for each in door.advance(now_ns)]
    while (due_ns := door.next_wake_ns) is not None and due_ns <= until_ns:
        said += [(due_ns, *each) for each in door.advance(due_ns)]
    return said


def test_through_a_gateway_a_read_of_all_registers_takes_27_and_a_half_milliseconds() -> None:
    """96 characters: 8, 81, and a silence of 3.5 behind each."""
    door = gateway(TimedLine(pcl601(timed=True)), timed=True)
    for name in ("first", "second"):
        assert door.ask(GatewayRequest(name, 1, READ_ALL)) is None
    [(first_ns, *first), (second_ns, *second)] = replies(door, 80 * MS)
    assert (first[0], second[0]) == ("first", "second")
    assert (first_ns, second_ns) == (pytest.approx(27.5 * MS, abs=5), pytest.approx(55 * MS, abs=10))
    assert len(first[1]) == 2 + 76


@pytest.mark.parametrize("fault", ["silence=on", "drop=1", "crc=1", "delay=150"])
def test_without_a_sound_reply_in_time_a_gateway_gives_exception_0b(fault: str) -> None:
    device = pcl601()
    device.set(fault)
    door = gateway(device)
    door.ask(GatewayRequest("me", 1, READ_ONE))
    assert replies(door, 300 * MS) == [(100 * MS, "me", b"\x83\x0b")]
    for text in ("silence=off", "delay=0"):
        device.set(text)
    door.ask(GatewayRequest("me", 1, READ_ONE))
    assert replies(door, 500 * MS, 400 * MS) == [(400 * MS, "me", BASE_SPEED)]


def test_nobody_at_the_address_is_exception_0b_and_a_broadcast_is_not_answered() -> None:
    door = gateway(pcl601())
    door.ask(GatewayRequest("me", 7, READ_ONE))
    assert replies(door, 300 * MS) == [(100 * MS, "me", b"\x83\x0b")]
    door.ask(GatewayRequest("me", 0, bytes.fromhex("06 0005 0064")))
    door.ask(GatewayRequest("me", 1, READ_ONE))
    assert [each[1:] for each in replies(door, 600 * MS, 300 * MS)] == [("me", bytes.fromhex("03 02 0064"))]


def test_more_requests_than_may_wait_get_exception_06() -> None:
    door = gateway(pcl601())
    said = [door.ask(GatewayRequest("me", 1, READ_ONE)) for _ in range(65)]
    assert said == [None] * 64 + [b"\x83\x06"]
    assert len(replies(door, 10 * MS)) == 64


def test_an_exception_of_the_controller_passes_through() -> None:
    """Exception 02h: registers beyond the map."""
    door = gateway(pcl601())
    door.ask(GatewayRequest("me", 1, bytes.fromhex("03 0100 0001")))
    assert replies(door, 10 * MS) == [(0, "me", b"\x83\x02")]
