"""What an adapter shows and hands on: no ramp where there is none, the machine's events, a blend's speeds."""

from __future__ import annotations

import pytest
from adapterbench import MS, AdapterBench, AdapterBench006, move
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.pcl601 import Register
from scanrack.runtime.machine import Machine, MachineSpec
from scanrack.runtime.machine.spec import press
from scanrack.runtime.modules.adapters.pcl601.module import PCL601

MOVING = {"MOVING_CW", "ACCELERATING", "DECELERATING"}


@pytest.mark.parametrize("make", [AdapterBench, AdapterBench006])
def test_a_move_at_its_starting_speed_shows_no_ramp(make: type[AdapterBench]) -> None:
    bench = make(scan_ms=1).configured()
    bench.put(*move(400, speed=1000))  # the starting speed of CONFIGURE
    seen = set()
    while "MOVE_COMPLETE" not in bench.bits:
        bench.run(1)
        seen |= bench.bits & MOVING
    assert seen == {"MOVING_CW"}
    assert bench.position == bench.motor == 400


def test_what_the_machine_does_is_among_the_events_once() -> None:
    module = PCL601.simulated(Machine(MachineSpec(timeline=press(30 * MS, InputBit.HOME, 20 * MS))), {})
    for now_ns in range(0, 200 * MS, 10 * MS):
        module.update(now_ns, Image())
    told = [(event.at_ns, event.name) for event in module.events if event.kind == "stimulus"]
    assert told == [(30 * MS, "home"), (50 * MS, "home")]


def test_the_segments_of_a_blend_begin_at_the_starting_speed() -> None:
    bench = AdapterBench(blend="segmented").configured()
    blocks = [(0, 256 + 512, 2, 0, 0, 20), (0, 256 + 512, 4, 0, 3, 0, 20), (0, 256 + 512, 3, 500, 5, 0, 20)]
    for block in blocks:
        bench.give(*block, ms=100).give(0, 256, ms=100)
    bench.give(ms=100).give(8192, ms=300)
    assert "BLEND_RUNNING" in bench.bits
    assert bench.device.controller.values[Register.BASE_SPEED] == 1000
