"""Ten small failures whose instant of no return follows from their conditions by arithmetic.

A program sees three buttons, and the rising ones among them. What its condition notes in a scan turns the
first output on after a delay, whatever comes then. A scan takes 2 ms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from scanrack.jobs import ContactPress
from scanrack.jobs.fuzz import Counterexample, Scenario, TrialBench, never
from scanrack.runtime import RackSpec, SlotSpec

NS = 2_000_000
OPTIONS: Any = {"inputs": {"a": 0, "b": 1, "c": 2}}
RACK = RackSpec(
    program=print,
    slot=(
        SlotSpec(number=2, module="1769-IQ16", options=OPTIONS),
        SlotSpec(number=3, module="1769-OB16"),
    ),
)
A, B, C = 1, 2, 4

Condition = Callable[["Plant"], bool]


@dataclass
class Plant:
    """What a condition sees: the scan, what is on, what came on, and what it has noted."""

    number: int = -1
    on: int = 0
    rising: int = 0
    seen: Any = None


@never
def lamp(now):
    """The lamp stays off."""
    return now.slot[3].outputs[0] & 1


@dataclass(frozen=True)
class Planted:
    """A failure and its instant."""

    scan: int
    delay: int
    condition: Condition
    scenario: Scenario

    def bench(self) -> TrialBench:
        """Return its bench, of 800 ms."""
        return TrialBench(RACK, lambda: _Program(self), (lamp,), 400)

    def found(self) -> tuple[TrialBench, Counterexample]:
        """Return its bench and its failure."""
        bench = self.bench()
        broken = bench.run(self.scenario).broken
        assert broken is not None
        assert broken.scan == self.scan + self.delay
        return bench, Counterexample(self.scenario, broken, 1)


class _Program:
    def __init__(self, planted: Planted) -> None:
        self._planted, self._plant, self._due = planted, Plant(), -1

    def __call__(self, scan: Any) -> None:
        plant, planted = self._plant, self._planted
        on = scan.slot[2].inputs[0] & 7
        plant.rising, plant.on = on & ~plant.on, on
        noted = planted.condition(plant) if self._due < 0 else False
        plant.number = scan.number
        if noted:
            self._due = scan.number + planted.delay
        if 0 <= self._due <= scan.number:
            scan.slot[3].outputs[0] = 1


def pushes(*given: tuple[str, int, int]) -> Scenario:
    """Return pushes: name, first scan, scans."""
    return Scenario(pushes=tuple(ContactPress(2, name, at * NS, scans * NS) for name, at, scans in given))


def one(plant: Plant) -> bool:
    return bool(plant.rising & A)


def both_at_once(plant: Plant) -> bool:
    return plant.on & 3 == 3


def third(plant: Plant) -> bool:
    plant.seen = (plant.seen or 0) + bool(plant.rising & A)
    return plant.seen == 3


def double(plant: Plant) -> bool:
    last, now = plant.seen, plant.number + 1
    if plant.rising & A:
        plant.seen = now
    return bool(plant.rising & A) and last is not None and now - last <= 10


def thin(plant: Plant) -> bool:
    return bool(plant.rising & A) and 100 <= plant.number + 1 <= 102


def within_the_sequence(plant: Plant) -> bool:
    if plant.rising & A:
        plant.seen = plant.number
    return bool(plant.rising & B) and plant.seen is not None and 20 < plant.number - plant.seen < 40


def same_scan(plant: Plant) -> bool:
    return plant.rising & 3 == 3


def in_order(plant: Plant) -> bool:
    """The buttons a, b, c, one after the other, without another between."""
    if plant.rising:
        plant.seen = ((plant.seen or ()) + (plant.rising,))[-3:]
    return plant.seen == (A, B, C)


def alternating(plant: Plant) -> bool:
    if plant.rising:
        plant.seen = ((plant.seen or ()) + (plant.rising,))[-4:]
    return plant.seen == (A, B, A, B)


def failures() -> Iterator[tuple[str, Planted]]:
    """Yield the ten, by name."""
    yield "one press", Planted(50, 100, one, pushes(("a", 50, 5)))
    yield "both at once", Planted(90, 100, both_at_once, pushes(("a", 50, 200), ("b", 90, 3)))
    yield "third press", Planted(120, 60, third, pushes(("a", 20, 5), ("a", 60, 5), ("a", 120, 5)))
    yield "double", Planted(66, 80, double, pushes(("a", 60, 3), ("a", 66, 3)))
    yield "thin", Planted(101, 150, thin, pushes(("a", 101, 2), ("b", 30, 50), ("c", 140, 20)))
    yield "in the sequence", Planted(61, 200, within_the_sequence, pushes(("a", 30, 2), ("b", 61, 2)))
    yield "same scan", Planted(77, 30, same_scan, pushes(("a", 77, 4), ("b", 77, 9)))
    yield "in order", Planted(140, 90, in_order, pushes(("a", 40, 4), ("b", 90, 9), ("c", 140, 3)))
    rows = (("a", 10, 4), ("b", 30, 4), ("a", 60, 4), ("b", 75, 4))
    yield "alternating", Planted(75, 110, alternating, pushes(*rows))
    yield "late", Planted(300, 60, same_scan, pushes(("a", 300, 4), ("b", 300, 9), ("c", 20, 100)))
