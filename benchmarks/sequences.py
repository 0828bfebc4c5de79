"""What logic costs per scan: a sequence and its axis beside the same line written by hand.

    python benchmarks/sequences.py [--calls N] [--smoke]

Two programs of the three-station line run on a simulated 3601 each: `examples/three_stations/line.py`, a
state machine over raw words, and a sequence. At two moments, in the middle of a move and waiting for the next
pulse, the logic alone is called again and again while the position word changes. The programs take turns;
times are processor time, the best of the rounds, less the loop itself.

A third program is that sequence with what most have besides: `every_scan`, which writes an output.

All must have given the module the same commands, word for word, in the same order.

Exit status 1 if one axis and one waiting sequence cost more than 1.5 us.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from itertools import cycle
from math import inf
from pathlib import Path
from time import process_time

from scanrack import Axis3601, Configuration, Cpu, Input, InputBit, Logic, LogicScan, Output, Rack, sequence
from scanrack.io_images import Image
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.jobs.load.program import load_program
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.rack import Card
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.modules.amci3601 import Amci3601

BY_HAND = Path(__file__).parents[1] / "examples" / "three_stations" / "line.py"

MOST_US = 1.5
PERIOD_NS = 2_000_000
ROUNDS = 7
PULSE = 500
"""A pulse on the capture input begins in every multiple of so many scans, 1 s."""

MOVING, WAITING = 100 + 3 * PULSE, 3 * PULSE - 10
"""Scans in which the line moves, and waits."""


class Line(Logic):
    """The line as a sequence; `every_scan` and an output would add to it what they do."""

    axis = Axis3601(
        1,
        Configuration(
            inputs_used=InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT | InputBit.CCW_LIMIT,
            step_and_direction=True,
            starting_speed=500,
        ),
    )
    pulse = Input("slot1.status.IN_CAPTURE")

    @sequence
    async def stations(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        for station in cycle((4000, 8000, 0)):
            await self.pulse.rises
            await self.axis.move_to(station, speed=5000, acceleration=100, deceleration=100)


class Lit(Line):
    """The line with a lamp that is lit while the axis moves."""

    lamp: Output = Output("Local:2:O.Data[0].0")

    def every_scan(self) -> None:
        self.lamp = self.axis.moving


class Still:
    """A module that does nothing, for the lamp."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self._inputs = Image()

    def update(self, now_ns: int, outputs: Image) -> Image:
        return self._inputs

    def plc_run(self, running: bool) -> None:
        pass

    def power_cycle(self) -> None:
        pass


class Side:
    """One program on a rack of its own.

    Attributes:
        commands: the output images with a command in word 0, each once in a row.
    """

    def __init__(self, logic: Callable[[LogicScan], None]) -> None:
        self.logic = logic
        machine = Machine(MachineSpec(switches=(Switch(InputBit.HOME, -1500, -1300),)))
        self.module = Amci3601("4.1", machine)
        self.rack = Rack([Card(1, self.module, "amci3601", "4.1", WORDS_3601), Card(2, Still())])
        self.commands: list[list[int]] = []
        self.scan: LogicScan | None = None
        self.cpu = Cpu(self.rack, self._keep, PERIOD_NS)

    def _keep(self, scan: LogicScan) -> None:
        self.scan = scan
        self.logic(scan)

    def run_to(self, number: int) -> None:
        """Run scans; a pulse of 20 comes at every multiple of `PULSE`."""
        outputs = self.rack.slots[1].outputs
        while self.cpu.scan < number:
            self.module.machine.set_input(InputBit.CAPTURE, 0 < self.cpu.scan % PULSE <= 20 < self.cpu.scan)
            self.module.look_again()
            self.cpu.run(1)
            if outputs[0] and [*outputs] not in self.commands[-1:]:
                self.commands.append([*outputs])

    def time(self, calls: int) -> float:
        """Return the seconds of `calls` calls while the position changes; time stands still."""
        scan, words, logic = self.scan, self.rack.slots[1].inputs.words, self.logic
        assert scan is not None
        position = words[3]
        begin = process_time()
        for number in range(calls):
            words[3] = number & 511
            logic(scan)
        took = process_time() - begin
        words[3] = position
        return took


def loop(scan: LogicScan) -> None:
    """Do nothing: what the measurement itself costs."""


def measure(calls: int, rounds: int) -> dict[str, list[float]]:
    """Return what a scan costs by program, us: moving, waiting.

    Raises:
        AssertionError: the programs commanded different things.
    """
    hand = load_program(str(BY_HAND)).function
    hand.__globals__["Move"] = _quicker(hand.__globals__["Move"])
    sides = {"by hand": Side(hand), "sequence": Side(Line()), "with lamp": Side(Lit())}
    idle = Side(loop)
    costs: dict[str, list[float]] = {name: [] for name in sides}
    for number in (WAITING, MOVING):
        best = dict.fromkeys([*sides, "loop"], inf)
        for side in (*sides.values(), idle):
            side.run_to(number)
        for _ in range(rounds):
            for name, side in (*sides.items(), ("loop", idle)):
                best[name] = min(best[name], side.time(calls))
        for name, figures in costs.items():
            figures.append((best[name] - best["loop"]) / calls * 1e6)
    commands = [side.commands for side in sides.values()]
    assert commands[0] == commands[1] == commands[2], f"they commanded different things: {commands}"
    assert len(commands[0]) == 5, f"a configuration, a preset and three moves were to be: {commands[0]}"
    return costs


def _quicker(move: type) -> Callable[..., object]:
    """Return `Move` with the rates of the sequence; those of the example would take eleven seconds a move."""

    def make(kind: object, target: int, *, speed: int, acceleration: int, deceleration: int) -> object:
        return move(kind, target, speed=speed, acceleration=100, deceleration=100)

    return make


def main() -> int:
    """Measure, print, and say whether the bound holds."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--calls", type=int, default=28_000)
    parser.add_argument("--smoke", action="store_true", help="a few calls, only to see that it works")
    arguments = parser.parse_args()
    costs = measure(*((100, 1) if arguments.smoke else (arguments.calls, ROUNDS)))
    for name, (waiting, moving) in costs.items():
        print(f"{name:9} waiting {waiting:.2f} us, moving {moving:.2f} us")
    return int(not arguments.smoke and max(*costs["sequence"], *costs["with lamp"]) > MOST_US)


if __name__ == "__main__":
    sys.exit(main())
