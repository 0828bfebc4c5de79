"""The steps of a script: what is done to a 3601, and for how long.

Small frozen objects with `play(bench)`; the bench may be a lockstep of module and oracle or a module
alone. Some look at the state of the oracle (`ToRest`, `Recover`), so that most commands find an axis
that can take them and deep states are reached.
"""

from __future__ import annotations

from dataclasses import dataclass

import oracle_bits as bits
from oracle_bits import CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL
from scanrack.io_images import split_thousands

ERRORS = bits.COMMAND_ERROR | bits.INVALID_PROFILE | bits.HOME_INVALID | bits.INPUT_ERROR
NOTHING = (0,) * 8


@dataclass(frozen=True)
class Out:
    """These eight words, for so many ticks."""

    words: tuple[int, ...]
    ticks: int

    def play(self, bench):
        bench.out(self.words)
        bench.run(self.ticks)


@dataclass(frozen=True)
class Alter:
    """Some words changed, the others as they are: (index, value) each."""

    changes: tuple[tuple[int, int], ...]
    ticks: int

    def play(self, bench):
        words = list(bench.words)
        for index, value in self.changes:
            words[index] = value
        bench.out(words)
        bench.run(self.ticks)


@dataclass(frozen=True)
class Wait:
    ticks: int

    def play(self, bench):
        bench.run(self.ticks)


@dataclass(frozen=True)
class ToRest:
    """Until nothing moves, for at most so many ticks."""

    ticks: int = 500

    def play(self, bench):
        bench.run_to_rest(self.ticks)


@dataclass(frozen=True)
class Input:
    """An input on or off; with `ticks`, the other way again after them."""

    bit: int
    energized: bool
    ticks: int

    def play(self, bench):
        bench.input(self.bit, self.energized)
        if self.ticks:
            bench.run(self.ticks)
            bench.input(self.bit, not self.energized)


@dataclass(frozen=True)
class Turn:
    """Somebody turns the encoder during the next ticks; `waited` says whether the script waits for it."""

    counts: int
    ticks: int
    waited: bool = True

    def play(self, bench):
        bench.turn(self.counts, self.ticks)
        if self.waited:
            bench.run(self.ticks)


@dataclass(frozen=True)
class Marker:
    """A Z pulse in so many ticks."""

    ticks: int

    def play(self, bench):
        bench.marker(self.ticks)


@dataclass(frozen=True)
class Plc:
    """The PLC goes to run or program mode."""

    running: bool
    ticks: int

    def play(self, bench):
        bench.plc(self.running)
        bench.run(self.ticks)


@dataclass(frozen=True)
class PowerCycle:
    def play(self, bench):
        bench.power_cycle()


@dataclass(frozen=True)
class Recover:
    """What a program does before it goes on: inputs off, errors reset, configured, position preset."""

    config: tuple[int, ...]
    position: int = 500

    def play(self, bench):
        for bit in (EXTERNAL, ESTOP, CW_LIMIT, CCW_LIMIT):
            if bench.world.hand_levels & bit:
                bench.input(bit, False)
        if not bench.oracle.plc_running:
            bench.plc(True)
        self.command(bench, [0, 0, *bench.words[2:]])
        if bench.oracle.config_error:
            self.command(bench, self.config)
        if bench.oracle.image[0] & ERRORS:
            self.command(bench, [bits.RESET_ERRORS, *NOTHING[1:]])
        bench.run_to_rest(100)
        if bench.oracle.in_motion():
            self.command(bench, [bits.IMMEDIATE_STOP, *NOTHING[1:]])
        if bench.oracle.position_invalid:
            words = [bits.PRESET_POSITION, 0, *split_thousands(self.position), 0, 0, 0, 0]
            self.command(bench, words)

    def command(self, bench, words):
        if list(words) != bench.words or words[0]:
            bench.out(words)
            bench.run(1)
        if words[0]:
            bench.out(NOTHING)
            bench.run(1)
