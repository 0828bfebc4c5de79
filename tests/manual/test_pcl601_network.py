"""Several PCL601s on one RS485 line; Sample Program 5 with its three axes [Section 6]."""

from __future__ import annotations

import pytest
from bench601 import PORT_TIMING
from programs601 import MS, sample
from scanrack.io_images.pcl601 import Code, Error, Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.runtime import SerialBus
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pcl601.program import ProgramMachine
from scanrack.runtime.controllers.pcl601.wiring import Wiring
from scanrack.runtime.line.ports import BusSegment
from scanrack.runtime.line.rtu import frame

TO_ASCII = frame(0, bytes.fromhex("06 0000 000B"))
"""The broadcast that takes all units to AA ASCII; its CRC is misprinted in the manual."""


def three_axes() -> list[Pcl601]:
    """Axes 0, 1 and 2; the first two have thumbwheels, at 2500 and 3000."""
    program = ProgramMachine(parse_program(sample(5)))
    return [
        Pcl601(0, wiring=Wiring(True, 2500), runner=program),
        Pcl601(1, wiring=Wiring(True, 3000)),
        Pcl601(2),
    ]


def positions(axes: list[Pcl601]) -> list[int]:
    return [axis.controller.read()[Register.POSITION] for axis in axes]


def start(axes: list[Pcl601], now_ns: int) -> None:
    """Start axis 0's program as SMC60WIN does, by a protocol that is not published."""
    axes[0].controller.do(Code.RUN_PROGRAM)
    axes[0].controller.settle(now_ns)


@pytest.mark.slow
def test_sample_5_moves_three_axes_over_a_line_with_the_baud_rates_timing() -> None:
    """Axes 0 and 1 go out by their thumbwheels, axis 2 to -4000 and back, then 0 and 1 back.

    By v² = B² + A N and t = 2 (v - B) / A, 3000 steps take 2.6 s and 4000 take 3.1 s.
    """
    axes = three_axes()
    line = SerialBus(*axes)
    line.send(TO_ASCII, axes[0].line_format)
    line.run_until(10 * MS)
    start(axes, line.now_ns)
    seen = [positions(axes)]
    while line.now_ns < 18_000 * MS:
        line.run_until(line.now_ns + 20 * MS)
        if not any(axis.controller.busy for axis in axes) and positions(axes) != seen[-1]:
            seen.append(positions(axes))
    assert seen == [[0, 0, 0], [2500, 3000, 0], [2500, 3000, -4000], [2500, 3000, 0], [0, 0, 0]]
    assert [axis.controller.errors for axis in axes] == [Error(0)] * 3
    assert b"@1A1000\r@1B500\r" in line.take()


def test_sample_5_over_a_port_hands_its_text_to_all_units_and_to_the_host() -> None:
    axes = three_axes()
    line = BusSegment(*axes)
    said = bytearray()
    line.receive(0, TO_ASCII)
    said += line.advance(10 * MS)
    start(axes, 10 * MS)
    said += line.advance(4000 * MS)
    assert positions(axes) == [2500, 3000, 0]
    assert said.startswith(b"@1A1000\r@1B500\r@1M5000\r@2A1000\r")


def test_each_of_99_units_answers_to_its_own_address_and_all_carry_out_a_broadcast() -> None:
    """Base speed 4x6: 100 for all, then 100 + n for each."""
    units = [Pcl601(address, timing=PORT_TIMING) for address in range(1, 100)]
    line = BusSegment(*units)
    now_ns = 0

    def ask(request: bytes) -> bytes:
        nonlocal now_ns
        now_ns += 20 * MS
        said = line.advance(now_ns)
        line.receive(now_ns, request)
        now_ns += 20 * MS
        return said + line.advance(now_ns)

    assert ask(frame(0, bytes.fromhex("06 0005 0064"))) == b""
    assert {unit.controller.read()[Register.BASE_SPEED] for unit in units} == {100}
    for address in (1, 50, 99):
        request = frame(address, bytes.fromhex("06 0005") + (100 + address).to_bytes(2))
        assert ask(request) == request
    speeds = [unit.controller.read()[Register.BASE_SPEED] for unit in units]
    assert [speed for speed in speeds if speed != 100] == [101, 150, 199]
