"""Updates that come in two parts: `parameters_first` sends a command bit once its parameters have crossed.

Each change of the output words is torn once, in each way of `TEARS`: those words come one packet interval
later. Without the option some tear makes an illegal command; with it none does, whatever is torn.
"""

from dataclasses import replace
from typing import Any

import pytest
from bench3601 import ENCODER, configuration
from scanrack import Axis3601, Configuration, Direction, Logic, dwell, sequence, until
from scanrack.io_images.amci3601 import Acceleration, BlendSegment, CommandMsw, InputBit
from scanrack.io_images.image import Image
from scanrack.runtime import Amci3601, Card, Cpu, CpuFault, FaultKind, InjectedFault, Rack
from scanrack.runtime.loop.exchange import EveryRpi
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.machine import Machine, MachineSpec, Switch

MOST_SCANS = 12_000
RPI_MS, SCAN_MS = 5, 2
RUN_CCW = CommandMsw.MANUAL_CCW.value
SETUP = Configuration.from_image(Image(configuration(add=ENCODER)))
FAST: Any = {"acceleration": 300, "deceleration": 400}
PATH = [BlendSegment(300, 5_000, 200), BlendSegment(220, 2_000, 400)]

TEARS = [(word,) for word in range(8)] + [(0, 1), (2, 3), (4, 5), (6, 7), (1, 2, 3, 4, 5, 6, 7), (3, 5, 7)]

HARMLESS = {"CER-01", "POS-01", "POS-02"}
"""Rules of power-up, of each configuration, and of a stop without a ramp."""


class Everything(Logic):
    """One command of each kind, some taken over by others."""

    axis = Axis3601(1, SETUP, round_trip_ms=2 * RPI_MS + SCAN_MS)

    @sequence
    async def cycle(self):
        axis = self.axis
        await axis.configure()
        await axis.set_position(-1_234)
        await axis.move_to(345, speed=14_999, **FAST)
        axis.move_by(2_000, speed=2_345, **FAST, shape=Acceleration.TRIANGULAR)
        await dwell("60 ms")
        await axis.halt()
        axis.run(-2_345, **FAST)
        await dwell("60 ms")
        axis.run(-3_456, **FAST)
        await dwell("60 ms")
        registration = axis.run(12_500, register=260, **FAST)
        await dwell("60 ms")
        registration.register()
        await registration
        gear = axis.gear(-3, 2, acceleration=5, deceleration=7)
        await until(lambda: gear.in_gear)
        await axis.gear_out()
        await axis.store_minimum(1_200)
        await axis.program_blend(PATH, final_deceleration=400)
        await axis.run_blend(Direction.CW)
        await axis.home(Direction.CW, speed=13_000, **FAST)
        await axis.configure()
        await axis.set_position(5)


class ParametersFirst(Everything):
    axis = Axis3601(1, SETUP, round_trip_ms=2 * RPI_MS + SCAN_MS, parameters_first=True)


class Run:
    """A run of such a program with one torn update or none.

    Attributes:
        images: when the output words changed, ns, and to what.
        fired: the rules of the manual that fired.
        ended: whether the program came to its end.
    """

    def __init__(self, kind, tear=None):
        machine = Machine(MachineSpec(switches=(Switch(InputBit.HOME, 3_000, 4_000),)))
        module = Amci3601("4.1", machine)
        exposed = ExposedModule(module, [tear]) if tear else module
        self.rack = Rack([Card(1, exposed)])
        self.logic = kind()
        self.images: list[tuple[int, list[int]]] = []
        self.fired: list[str] = []
        self.cpu = Cpu(
            self.rack,
            self.logic,
            SCAN_MS * 1_000_000,
            exchange=EveryRpi(RPI_MS * 1_000_000),
            listeners=[self],
        )
        try:
            self.cpu.run(1)
            while not self.logic.cycle.over and self.cpu.scan < MOST_SCANS:
                self.cpu.run(1)
        except CpuFault as fault:
            self.fired.append(str(fault))
        self.ended = self.logic.cycle.over

    def event(self, scan, now_ns, topic, fields):
        if topic == "/events" and fields["kind"] == "rule" and fields["name"] not in HARMLESS:
            self.fired.append(fields["name"])

    def scan(self, scan, now_ns, flags):
        words = list(self.rack.slots[1].outputs)
        if not self.images or words != self.images[-1][1]:
            self.images.append((now_ns, words))

    @property
    def commands(self):
        """The images with a command in word 0, but for Hold and Immediate Stop, which have no parameters."""
        return [words for _, words in self.images if words[0] not in (0, 4, 16)]

    def close(self):
        pass


def broken_by(kind, at_ns, late):
    """Return what a tear makes of a run: rules that fire, or where it does not end; empty if nothing."""
    run = Run(kind, InjectedFault(at_ns, FaultKind.TORN_UPDATE, late_words=late))
    return run.fired if run.fired or run.ended else [str(run.logic.cycle)]


def test_without_a_tear_both_do_the_same_commands():
    plain, first = Run(Everything), Run(ParametersFirst)
    assert plain.fired == first.fired == []
    assert (plain.ended, first.ended) == (True, True)
    assert plain.commands == first.commands


def test_without_the_option_a_late_speed_is_another_command():
    """The move to 345: word 4, the thousands of its speed, is still 0, so 999 is below the starting speed."""
    sent = next(at for at, words in Run(Everything).images if words[0] == 1)
    assert broken_by(Everything, sent, (4,))[:2] == ["CMD-05", "PRF-01"]


@pytest.mark.slow
def test_with_parameters_first_no_tear_of_any_change_is_an_illegal_command():
    """One tear of the list for each change, and the late word 1, which holds bits of commands, for all."""
    for number, (at_ns, _) in enumerate(Run(ParametersFirst).images):
        for late in ((1,), TEARS[3 * number % len(TEARS)]):
            assert broken_by(ParametersFirst, at_ns, late) == [], (at_ns, late)


class NewSpeed(Logic):
    """A change of speed in motion, in both of its words."""

    axis = Axis3601(
        1, replace(SETUP, starting_speed=500), round_trip_ms=2 * RPI_MS + SCAN_MS, parameters_first=True
    )

    @sequence
    async def cycle(self):
        await self.axis.configure()
        await self.axis.set_position(0)
        self.axis.run(-999, **FAST)
        await dwell("60 ms")
        self.axis.run(-1_000, **FAST)
        await dwell("60 ms")
        await self.axis.halt()


def test_a_new_speed_in_motion_is_sent_whole_and_a_torn_one_is_a_mixture():
    """999 to 1,000: torn it is 1,999, which runs, or 0, which is not a speed."""
    changes = [(at, words[4:6]) for at, words in Run(NewSpeed).images if words[0] == RUN_CCW]
    assert [speed for _, speed in changes] == [[0, 999], [1, 0]]
    at_ns = changes[-1][0]
    assert broken_by(NewSpeed, at_ns, (5,)) == []
    assert "CMD-15" in broken_by(NewSpeed, at_ns, (4,))
