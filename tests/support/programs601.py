"""A PCL601 with a stored program, run by itself: where its motor stops, and when."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scanrack.io_images.pcl601 import Code, Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pcl601.controller import Pcl601Controller
from scanrack.runtime.controllers.pcl601.program import ProgramMachine

MS = 1_000_000
SAMPLES = Path(__file__).parents[2] / "examples/pcl601"


def sample(number: int) -> str:
    return (SAMPLES / f"sample{number}.pclt").read_text(encoding="utf-8")


@dataclass
class Stop:
    """The end of a motion."""

    at_ms: float
    position: int
    outputs: int


class Bench:
    """A controller whose program has been started."""

    def __init__(self, text: str, **options: Any) -> None:
        self.controller = Pcl601Controller(**options)
        self.controller.runner = ProgramMachine(parse_program(text))
        self.controller.power_up(0)
        self.stops: list[Stop] = []

    def start(self) -> None:
        self.controller.do(Code.RUN_PROGRAM)
        self.controller.settle(self.controller.now_ns)

    def connect(self, **contacts: Contact) -> None:
        for name, contact in contacts.items():
            self.controller.pins.connect(name, contact)
        self.controller.settle(self.controller.now_ns)

    def run(self, until_ms: float) -> None:
        """Let time run, event by event, and note the end of each motion."""
        controller = self.controller
        while (due_ns := controller.next_wake_ns) is not None and due_ns <= until_ms * MS:
            was_busy = controller.busy
            controller.advance(due_ns)
            if was_busy and not controller.busy:
                self.stops.append(Stop(due_ns / MS, self.position, controller.outputs))
        controller.advance(int(until_ms * MS))

    def run_until_stop(self, number: int, longest_ms: int = 30_000) -> None:
        """Let time run until so many motions have ended, in steps of 1 ms."""
        while len(self.stops) < number:
            assert self.controller.now_ns < longest_ms * MS
            self.run(self.controller.now_ns // MS + 1)

    @property
    def position(self) -> int:
        return self.controller.read()[Register.POSITION]

    @property
    def positions(self) -> list[int]:
        return [stop.position for stop in self.stops]
