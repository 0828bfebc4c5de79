"""What a lockstep of an adapter does where a 3601 has nothing of the kind: lost links and power, and haste.

The adapter runs alone meanwhile; in the end the oracle is put where it is [docs/adapter-tables.md].
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import oracle_bits as bits
from adapter_laws import Laws
from lockstep3601 import describe
from oracle3601 import TICK_NS, Oracle
from oracle_bits import HOME
from oracle_world import World
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import join_reported
from scanrack.runtime.modules.adapters.module import SimulatedAdapter
from steps3601 import NOTHING

MS = 1_000_000
SCAN_TICKS = 20
SCAN_NS = SCAN_TICKS * TICK_NS
STOP, RESET = (bits.IMMEDIATE_STOP, *NOTHING[1:]), (bits.RESET_ERRORS, *NOTHING[1:])
A_MANUAL_MOVE = (bits.MANUAL_CCW, 0, 0, 0, 5, 0, 100, 100)


class AloneForAWhile(ABC):
    """What a bench adds to a lockstep."""

    controller: str
    module: SimulatedAdapter[Any]
    oracle: Oracle
    world: World
    laws: Laws
    now_ns: int
    calm_ns: int
    alone: bool
    expected: list[str]
    words: Sequence[int]
    oracle_words: Sequence[int]
    outputs: Image
    image: list[int]

    # ---- what the lockstep brings

    @property
    @abstractmethod
    def motor(self) -> int:
        """Where the motor truly stands."""

    @abstractmethod
    def updated(self) -> list[int]:
        """Let the adapter advance to now; return its image."""

    @abstractmethod
    def meet(self, at_rest: bool = False) -> None:
        """Let time run until adapter and oracle have settled."""

    @abstractmethod
    def out(self, words: Sequence[int]) -> None:
        """Write words, once both have settled."""

    @abstractmethod
    def note(self, text: str) -> None:
        """Add a line to the log."""

    @abstractmethod
    def fail(self, why: str) -> None:
        """Raise `Differ`."""

    # ---- what a 3601 does not know: its controller is away

    def link_loss(self, ms, meanwhile, loses_power):
        """The line is cut, and words that come meanwhile are passed over [docs/adapter-tables.md]."""
        self.meet()
        if self.oracle.config_error or self.configuring or not self.oracle.plc_running:
            return
        line = self.module.controller.line
        line.take_down()
        self.note(f"link down for {ms} ms" + ", and the controller's power off and on" * loses_power)
        self.laws.may_be_absent()
        self.run_alone(ms * MS - MS)
        if self.image[0] & bits.MODULE_OK:
            self.fail("the link is lost, and MODULE_OK set")
        self.write_unseen(meanwhile)
        if loses_power:
            self.module.cycle_device()
        self.run_alone(50 * MS)
        line.put_up()
        self.run_alone(2_000 * MS, until=bits.MODULE_OK)
        self.oracle_returns(loses_power or self.zeroed())

    def zeroed(self):
        """Whether a PMC006 has come home alone: its counter is then as near 0 as after a loss of power."""
        home = self.levels_at_motor() & HOME if self.controller == "PMC006" else 0
        return bool(home and self.laws.searched and self.image[0] & bits.CONFIG_ERROR)

    def levels_at_motor(self):
        """What energizes inputs where the motor stands, which may be elsewhere than the oracle's."""
        self.world.shaft, before = self.motor, self.world.shaft
        levels = self.world.levels()
        self.world.shaft = before
        return levels

    def device_power(self):
        """The controller alone loses its power."""
        self.meet()
        if self.oracle.config_error or self.configuring:
            return
        self.module.cycle_device()
        self.note("the controller's power off and on")
        self.laws.may_be_absent()
        self.run_alone(2_000 * MS, until=bits.CONFIG_ERROR)
        self.oracle_returns(loses_power=True)

    @property
    def configuring(self):
        return self.oracle.mode_config or bool(self.words[0] & bits.CONFIGURE)

    def write_unseen(self, words):
        self.words = self.oracle_words = list(words)
        self.outputs = Image(words)
        self.calm_ns = 0
        self.note(describe(words))

    def run_alone(self, duration_ns, until=0):
        """Let the adapter run; what it does is looked at, the oracle waits."""
        end_ns = self.now_ns + duration_ns
        self.alone = True
        while self.now_ns < end_ns and not self.image[0] & until:
            self.now_ns += SCAN_NS
            self.oracle.now_ns = self.now_ns
            self.image = self.updated()
            self.laws.look()
        self.alone = False
        if until and not self.image[0] & until:
            self.fail(f"no answer after {duration_ns / 1e6} ms")

    def oracle_returns(self, loses_power):
        """What a 3601 would have to show now, were it as far away; bits that are still set are no edges."""
        oracle = self.oracle
        if loses_power:
            oracle.power_up()
        else:
            oracle.rest("idle")
            oracle.clear_status()
            oracle.stopped = oracle.position_invalid = True
            oracle.resumable = False
            oracle.position += self.motor - self.world.shaft
        self.world.shaft = self.motor
        self.laws.interrupted()
        self.calm_ns = 0
        self.stay_locked_out(refuses=not loses_power)

    def stay_locked_out(self, refuses):
        """As long as a command bit is set, every other is refused; with all low, the next one counts."""
        another = A_MANUAL_MOVE if self.words[0] else NOTHING
        for words in (self.words, another, NOTHING):
            if refuses and words[0] & ~self.words[0]:
                self.oracle.command_error = True
                self.expected.append("locked out")
            self.write_unseen(words)
            self.oracle.previous0, self.oracle.previous1 = words[0] & 0xFFFF, words[1] & 0xFFFF
            self.meet()
        for words in (RESET, NOTHING) if another is A_MANUAL_MOVE else ():
            self.out(words)

    # ---- words that come too fast

    def haste(self, images):
        """Words follow each other faster than the line: only laws hold, and in the end the count is right."""
        self.meet(at_rest=True)
        if self.oracle.config_error or self.configuring or not self.oracle.plc_running:
            return
        origin = self.shown_position() - self.motor
        self.laws.anything_goes()
        for words, scans in (*images, (NOTHING, 200), (STOP, 20), (NOTHING, 200), (RESET, 5), (NOTHING, 40)):
            self.write_unseen(words)
            self.run_alone(scans * SCAN_NS)
        if self.shown_position() - self.motor != origin:
            self.fail("steps have been lost or counted twice in haste")
        self.oracle_overtakes()

    def shown_position(self):
        return join_reported(*self.image[2:4])

    def oracle_overtakes(self):
        """After haste the adapter says how the last motion ended; nothing moves, and no error is left."""
        oracle, msw = self.oracle, self.image[0]
        oracle.rest("idle")
        oracle.clear_status()
        oracle.move_complete, oracle.stopped = bool(msw & bits.MOVE_COMPLETE), bool(msw & bits.STOPPED)
        oracle.hold_state = bool(msw & bits.HOLD_STATE)
        oracle.position_invalid = bool(msw & bits.POSITION_INVALID)
        oracle.resumable = False
        oracle.position, self.world.shaft = self.shown_position(), self.motor
        oracle.previous0 = oracle.previous1 = 0
        self.laws.interrupted()
        self.calm_ns = 0
        self.module.events.clear()  # refusals in haste are not foreseen
        self.meet()
