"""Searches as short as the CI profile's find every one of a dozen broken user programs.

User programs with one deliberate mistake each, and what must hold: `search` has to find them all.

Every program configures its module, and does the same again after a power failure unless that is its
mistake. What is random, is what the mistake is blind to.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
    ResetErrors,
    StatusView,
)
from scanrack.jobs import Kind
from scanrack.jobs.fuzz import STANDARD, Invariant, TrialBench, eventually, never, search
from scanrack.jobs.fuzz.run import NO_FAULT
from scanrack.runtime import RackSpec

USED = InputBit.EXTERNAL | InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
CONFIGURATION = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
IDLE, RESET = Idle().to_image(), ResetErrors().to_image()
FORWARD = Move(MoveKind.RELATIVE, 500, speed=5000, acceleration=100, deceleration=100).to_image()
HOMEWARD = Move(MoveKind.ABSOLUTE, 0, speed=5000, acceleration=100, deceleration=100).to_image()
JOG = Manual(Direction.CW, speed=400).to_image()
ZERO = PresetPosition(0).to_image()
SCANS = 300


class Program:
    """A step program; a subclass says in `go` what it does once the module is configured."""

    notices_a_power_failure = True

    def __init__(self):
        self.step = "configure"
        self.since = 0

    def __call__(self, scan):
        self.scan, self.out = scan, scan.slot[1].outputs
        self.status = StatusView(scan.slot[1].inputs)
        if self.step == "configure":
            self.out.load(CONFIGURATION)
            if self.status.MODE_CONFIG and not self.status.CONFIG_ERROR:
                self.next("leave", IDLE)
        elif self.step == "leave":
            if not self.status.MODE_CONFIG:
                self.next("start")
        elif self.status.CONFIG_ERROR and self.notices_a_power_failure:
            self.next("configure")
        else:
            self.go()

    def next(self, step, image=None):
        self.step, self.since = step, self.scan.number
        if image is not None:
            self.out.load(image)

    def go(self):
        raise NotImplementedError


@dataclass(frozen=True)
class BrokenProgram:
    """A program, what must hold, and what is random.

    Attributes:
        name: a short name.
        sentence: what is wrong with the program.
        program: makes a new one.
        invariant: what must hold and does not; None = that the program does not fault the CPU.
        kinds: what is random.
        controller: whose rack it is.
    """

    name: str
    sentence: str
    program: Callable[[], Program]
    invariant: Invariant | None
    kinds: frozenset[Kind]
    controller: str

    def bench(self) -> TrialBench:
        """Return what is searched."""
        slot = {"number": 1, "module": "amci3601"}
        spec = RackSpec.model_validate(
            {"program": "none.py", "run_for_s": 1, "controller": self.controller, "slot": [slot]}
        )
        return TrialBench(spec, self.program, [] if self.invariant is None else [self.invariant], SCANS)


BROKEN_PROGRAMS: list[BrokenProgram] = []


def broken(invariant: Invariant | None, *kinds: Kind, controller: str = "micrologix"):
    """Add a program; its docstring is the sentence."""

    def add(program):
        sentence = program.__doc__
        BROKEN_PROGRAMS.append(
            BrokenProgram(program.__name__, sentence, program, invariant, frozenset(kinds), controller)
        )
        return program

    return add


NO_COMMAND_ERROR, NO_INVALID_PROFILE = STANDARD["no-command-error"], STANDARD["no-invalid-profile"]
ONE_MOTION = STANDARD["one-motion"]


@never
def beyond_the_part(now):
    """The axis never goes beyond the part, which is 500 steps long."""
    return now.slot[1].position > 501


@eventually("60 ms", after=lambda now: now.slot[1].status.CONFIG_ERROR and now.slot[1].status.MODULE_OK)
def configured(now):
    """A module without a configuration has one within 60 ms."""
    return not now.slot[1].status.CONFIG_ERROR


@eventually("60 ms", after=lambda now: now.slot[1].status.COMMAND_ERROR or now.slot[1].status.INPUT_ERROR)
def recovered(now):
    """An error is reset within 60 ms."""
    return not (now.slot[1].status.COMMAND_ERROR or now.slot[1].status.INPUT_ERROR)


@never
def jogs_into_the_limit(now):
    """No jog happens while the CW limit is active."""
    return now.slot[1].status.IN_CW_LIMIT and "MANUAL_CW" in now.slot[1].commands


@broken(configured, Kind.POWER)
class BlindToPower(Program):
    """It never looks whether the module has lost its configuration."""

    notices_a_power_failure = False

    def go(self):
        self.out.load(IDLE)


@broken(NO_COMMAND_ERROR, Kind.INPUTS)
class TrustsThePosition(Program):
    """It moves to an absolute position though an emergency stop may have made it invalid."""

    def go(self):
        if self.step == "start":
            self.next("zeroed", ZERO)
        elif self.step == "zeroed":
            self.next("forward", IDLE)
        elif self.step == "forward":
            self.next("there", FORWARD)
        elif self.step == "there" and (self.status.MOVE_COMPLETE or self.status.STOPPED):
            self.next("rest", IDLE)
        elif self.step == "rest" and self.scan.number > self.since:
            self.next("back", HOMEWARD)


@broken(ONE_MOTION, Kind.INPUTS)
class TwoButtons(Program):
    """Two buttons pressed together set two command bits."""

    def go(self):
        self.out.load(IDLE)
        if self.status.IN_HOME:
            self.out[0] |= 0x0080
        if self.status.IN_EXTERNAL:
            self.out[0] |= 0x0100


@broken(NO_COMMAND_ERROR, Kind.INPUTS)
class ChangesTheSpeed(Program):
    """A button changes the speed of a jog that runs below the starting speed."""

    def go(self):
        self.out.load(JOG)
        if self.status.IN_HOME:
            self.out[5] = 450


@broken(None, Kind.INPUTS)
class DividesByZero(Program):
    """It divides by the time since a button was pressed."""

    def go(self):
        if self.status.IN_HOME and self.step != "pressed":
            self.next("pressed")
        if self.step == "pressed":
            self.rate = 1000 / (self.scan.number - self.since)


@broken(beyond_the_part, Kind.INPUTS)
class StartsOver(Program):
    """A move that was held by the external input is made again from where it stands, not resumed."""

    def go(self):
        if self.step == "start":
            self.next("zeroed", ZERO)
        elif self.step == "zeroed":
            self.next("forward", IDLE)
        elif self.step == "forward" and not self.status.IN_EXTERNAL:
            self.next("moves", FORWARD)
        elif self.step == "moves" and self.status.HOLD_STATE:
            self.next("forward", IDLE)


@broken(NO_INVALID_PROFILE, Kind.TORN, controller="compactlogix")
class ParametersWithTheCommand(Program):
    """It writes parameters and command bit at once, so that an update can tear them apart."""

    def go(self):
        phase = (self.scan.number - self.since) % 150
        if phase == 1:
            self.out.load(FORWARD)
        elif phase == 120:
            self.out.load(IDLE)


@broken(NO_COMMAND_ERROR, Kind.FIRMWARE)
class NewestFirmwareOnly(Program):
    """It makes registration moves without asking which firmware the module has."""

    def go(self):
        self.out.load(Manual(Direction.CW, 2000, 100, 100, 300).to_image())


@broken(recovered, Kind.INPUTS)
class ForgetsToReset(Program):
    """It resets a command error, and forgets that an input error has to be reset, too."""

    def go(self):
        self.out.load(RESET if self.status.COMMAND_ERROR else IDLE)


@broken(jogs_into_the_limit, Kind.INPUTS)
class JogsIntoTheLimit(Program):
    """The jog button is obeyed though the limit it leads to is active."""

    def go(self):
        self.out.load(JOG if self.status.IN_HOME else IDLE)


@broken(configured, Kind.LINK)
class ConfiguresBlindly(Program):
    """It sends the configuration for ten scans and takes it for granted that it has arrived."""

    def __call__(self, scan):
        scan.slot[1].outputs.load(CONFIGURATION if scan.number < 10 else IDLE)


EXAMPLES, TASKS = 50, 25
"""Scenarios per search and searches, each with a seed of its own: a small campaign.

What a search finds depends on its seed alone.
"""


def found_after(broken_program: BrokenProgram) -> int | None:
    """Search until what must hold is broken; return after how many runs, None if it never is.

    The runs that shrink what is found are not counted.
    """
    bench = broken_program.bench()
    wanted = NO_FAULT if broken_program.invariant is None else broken_program.invariant.name
    runs = 0
    for task in range(TASKS):
        known = bench.names - {wanted}
        report = search(bench, broken_program.kinds, examples=EXAMPLES, start=task, known=known)
        if report.found:
            return runs + report.found[0].after
        runs += report.runs
    return None


@pytest.mark.slow
@pytest.mark.parametrize("program", BROKEN_PROGRAMS, ids=lambda program: program.name)
def test_a_broken_program_is_found(program):
    assert found_after(program) is not None, program.sentence


def test_there_are_at_least_ten_of_them():
    assert len({program.name for program in BROKEN_PROGRAMS}) >= 10
