"""Every kind of trouble finds a program that breaks under it, and under nothing else."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from scanrack.io_images.amci3601 import (
    Configuration,
    Direction,
    Idle,
    InputBit,
    Manual,
    Move,
    MoveKind,
    PresetPosition,
    StatusView,
)
from scanrack.jobs import Kind, possible_kinds
from scanrack.jobs.fuzz import STANDARD, Invariant, TrialBench, never, search
from scanrack.runtime import RackSpec

USED = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
COUNTED = Configuration(
    inputs_used=USED, step_and_direction=True, starting_speed=500, quadrature_encoder=True
).to_image()
IDLE = Idle().to_image()
MOVE = Move(MoveKind.RELATIVE, 300, speed=5000, acceleration=100, deceleration=100).to_image()


class Program:
    """Configures its module; a subclass says in `go` what it does then."""

    words = WORDS

    def __init__(self):
        self.step = "configure"

    def __call__(self, scan):
        status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
        if self.step == "configure":
            out.load(self.words)
            if status.MODE_CONFIG and not status.CONFIG_ERROR:
                out.load(IDLE)
                self.step = "leave"
        elif self.step == "leave":
            self.step = "leave" if status.MODE_CONFIG else "go"
        else:
            self.go(status, out, scan)

    def go(self, status, out, scan):
        """Do nothing."""


class Jogs(Program):
    """It jogs CW for ever."""

    def go(self, status, out, scan):
        out.load(Manual(Direction.CW, 400).to_image())


class Counts(Jogs):
    """It calls the position 0 where it is, and jogs; its encoder counts."""

    words = COUNTED
    since = None

    def go(self, status, out, scan):
        self.since = scan.number if self.since is None else self.since
        if scan.number - self.since < 4:
            out.load(PresetPosition(0).to_image() if scan.number - self.since < 2 else IDLE)
        else:
            super().go(status, out, scan)


class NeedsTheModule(Program):
    """It can't do without its module."""

    def go(self, status, out, scan):
        assert status.MODULE_OK


class NeedsPower(Program):
    """A module that has answered all the time has its configuration: so it thinks."""

    gone = False

    def go(self, status, out, scan):
        self.gone = self.gone or not status.MODULE_OK
        assert self.gone or not status.CONFIG_ERROR


class StartsOnce(Program):
    """Its first scan comes once."""

    def __call__(self, scan):
        assert scan.number == 0 or not scan.first
        super().__call__(scan)


class AllAtOnce(Program):
    """It writes parameters and command bit at once."""

    def go(self, status, out, scan):
        out.load(MOVE if scan.number % 100 > 50 else IDLE)


class Registers(Program):
    """It jogs with a distance after the registration input, which old firmware does not have."""

    def go(self, status, out, scan):
        out.load(Manual(Direction.CW, 2000, 100, 100, 300).to_image())


@never
def at_the_limit(now):
    """The CW limit is never met."""
    return now.slot[1].status.IN_CW_LIMIT


@never
def counts_differ(now):
    """The encoder counts as many steps as the module has made, but for what is under way."""
    at = now.slot[1].status
    return at.MODULE_OK and not at.MODE_CONFIG | at.POSITION_INVALID and abs(at.encoder - at.position) > 3


@never
def old_firmware(now):
    """No command is refused for want of a newer firmware."""
    return now.slot[1].status.COMMAND_ERROR and not now.slot[1].status.INPUT_ERROR


@dataclass(frozen=True)
class Case:
    """A program that breaks under one kind of trouble."""

    kind: Kind
    program: type[Program]
    invariant: Invariant | None = None
    controller: str = "micrologix"
    module: str = "amci3601"
    machine: dict = field(default_factory=dict)
    beside: frozenset[Kind] = frozenset()
    """Kinds under which it breaks, too."""

    def bench(self):
        slot = {"number": 1, "module": self.module, "machine": self.machine}
        spec = RackSpec.model_validate(
            {"program": "none.py", "run_for_s": 1, "controller": self.controller, "slot": [slot]}
        )
        invariants = [self.invariant] if self.invariant else []
        return TrialBench(spec, self.program, invariants, 200)


CASES = [
    # a configuration whose second word is late has other active levels
    Case(Kind.INPUTS, Jogs, at_the_limit, beside=frozenset({Kind.TORN})),
    Case(Kind.MACHINE, Counts, counts_differ, machine={"encoder": {"counts_per_step": 1}}),
    Case(Kind.LINK, NeedsTheModule),
    # a fatal error ends with a power cycle, and so does a module that is put in again
    Case(Kind.POWER, NeedsPower, beside=frozenset({Kind.LINK, Kind.TORN})),
    Case(Kind.MODE, StartsOnce),
    Case(Kind.TORN, AllAtOnce, STANDARD["no-invalid-profile"], controller="compactlogix"),
    Case(Kind.FIRMWARE, Registers, old_firmware, beside=frozenset({Kind.TORN})),
    Case(Kind.LINE, NeedsTheModule, module="pcl601-adapter", beside=frozenset({Kind.POWER})),
]


def found(case, kinds, examples):
    bench = case.bench()
    report = search(bench, kinds, examples=examples)
    return [each.broken.invariant for each in report.found]


def test_there_is_a_program_for_every_kind():
    assert {case.kind for case in CASES} == set(Kind)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.kind.value)
def test_a_kind_of_trouble_finds_what_only_it_breaks(case):
    assert found(case, {case.kind}, 150)
    assert not found(case, possible_kinds(case.bench().spec) - {case.kind} - case.beside, 20)


def rack(module):
    return RackSpec.model_validate({"program": "none.py", "slot": [{"number": 1, "module": module}]})


def test_what_can_happen_hangs_on_what_sits_in_the_rack():
    assert possible_kinds(rack("amci3601")) == set(Kind) - {Kind.LINE}
    assert possible_kinds(rack("pmc006-adapter")) == set(Kind) - {Kind.LINK, Kind.FIRMWARE}
