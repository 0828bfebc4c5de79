"""The module and its oracle side by side under one script; the first difference is told readably.

What may differ, and for how long:

* motion and completion bits, for one exchange: a float and an integer may see
  a ramp's end on different sides of a tick;
* positions while moving by STEPS_APART, at rest by one step (a stop "on the next
  whole step" may find another one), and then the oracle takes over the count.

Everything else has to agree in every image. Images are exchanged tick by tick while anything can happen;
where nothing but a motion goes on (oracle_calm.py), only every so many ticks. A script is given up
where either may be right: if something new is commanded while the two are apart, and if they
differ where the nanoseconds to which an integer rounds decide whether a step has
been made (a switch, a limit or a minimum distance may hang on it).
"""

from __future__ import annotations

import oracle_bits as bits
from oracle3601 import TICK_NS, Oracle
from oracle_calm import FOREVER, calm_ticks
from oracle_world import World
from scanrack.io_images.amci3601 import CommandMsw, InputBit, status_names
from scanrack.io_images.amci3601.bits import CommandLsw
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import join_reported
from scanrack.runtime import Amci3601
from scanrack.runtime.machine import EncoderSpec, Machine, MachineSpec, Switch

SOFT_MSW = (
    bits.MOVING_CW
    | bits.MOVING_CCW
    | bits.ACCELERATING
    | bits.DECELERATING
    | bits.MOVE_COMPLETE
    | bits.STOPPED
    | bits.HOLD_STATE
)
SOFT_LSW = bits.BLEND_RUNNING
STEPS_APART = 3
SETTLED = 2
"""Exchanges after which new words, or whatever else is new, have had their effect."""


class GivenUp(Exception):  # noqa: N818 - no error
    """Both are right so far, but what comes next would part them for good."""


class Differ(AssertionError):  # noqa: N818 - they do
    """Module and oracle show different images."""


class Lockstep:
    """A module on its machine and an oracle in its world, under the same words, inputs and time."""

    def __init__(self, setting):
        self.setting = setting
        switches = tuple(Switch(InputBit(bit), first, last) for bit, first, last in setting.switches)
        gear, every = setting.counts_per_step, setting.marker_every
        encoder = EncoderSpec(gear, marker_every=every) if gear else None
        self.machine = Machine(MachineSpec(switches=switches, encoder=encoder))
        self.module = Amci3601(setting.firmware, self.machine, None, diagnostic_wiring=setting.wired_back)
        self.world = World(setting.switches, gear, every, setting.wired_back)
        self.oracle = Oracle(setting.firmware, self.world)
        self.wired = {bit for bit, _, _ in setting.switches}
        self.words = [0] * 8
        self.outputs = Image()
        self.now_ns = 0
        self.turned_until = 0
        self.seen = 0
        self.apart = self.close_call = False
        self.log = []
        self.inputs = list(self.module.update(0, self.outputs))
        self.compare()

    # ---- what a script does

    def out(self, words):
        self.words = list(words)
        self.outputs = Image(words)
        self.note(self.words)

    def input(self, bit, energized):
        if bit in self.wired:
            return
        self.machine.set_input(InputBit(bit), energized)
        self.module.look_again()
        self.world.hand_levels = self.world.hand_levels & ~bit | (bit if energized else 0)
        self.note(f"input {InputBit(bit).name} {'on' if energized else 'off'}")

    def turn(self, counts, ticks):
        if self.now_ns < self.turned_until:
            return
        end = self.turned_until = self.now_ns + ticks * TICK_NS
        self.machine.turn_encoder(counts, self.now_ns, end)
        self.module.look_again()
        self.world.turns.append((counts, self.now_ns, end))
        self.note(f"encoder turned by {counts:+} in {ticks * 0.25} ms")

    def marker(self, ticks):
        at = self.now_ns + ticks * TICK_NS
        self.machine.marker_at(at)
        self.module.look_again()
        self.world.markers.append(at)
        self.note(f"Z pulse in {ticks * 0.25} ms")

    def plc(self, running):
        self.module.plc_run(running)
        self.oracle.plc_running = running
        self.note("PLC in run mode" if running else "PLC in program mode")

    def power_cycle(self):
        self.module.power_cycle()
        self.oracle.power_up()
        self.note("power off and on")

    def note(self, what):
        """Something new: words, or a text that says what it is."""
        if self.apart:
            raise GivenUp
        self.seen = 0
        self.log.append((self.now_ns, what))

    # ---- time

    def run(self, ticks):
        """So many ticks."""
        left = -(-ticks // self.setting.scan_ticks)
        while left > 0:
            left -= self.exchange(left)

    def run_to_rest(self, ticks):
        """Until the axis rests, or for so many ticks, those not counted in which homing just waits."""
        left = -(-ticks // self.setting.scan_ticks)
        while left > 0:
            if self.oracle.phase == "dwell" and not self.apart:
                self.exchange(FOREVER)
            else:
                left -= self.exchange(left if self.oracle.in_motion() else 1)
            if not self.apart and not self.oracle.in_motion():
                break

    def exchange(self, most=1):
        """The next exchange of images, or the last of up to `most` if nothing happens before it; how many."""
        exchanges = max(1, min(most, self.calm_exchanges()))
        self.oracle.now_ns += (exchanges - 1) * self.setting.scan_ticks * TICK_NS
        self.oracle.open_bits = 0
        close_call = self.oracle.close_call
        for _ in range(self.setting.scan_ticks):
            self.oracle.tick(self.words)
            close_call = close_call or self.oracle.close_call
        self.close_call = close_call
        self.now_ns = self.oracle.now_ns
        self.inputs = self.module.update(self.now_ns, self.outputs).words.tolist()
        self.seen += 1
        self.compare()
        return exchanges

    def calm_exchanges(self):
        """Exchanges that nobody has to look at, under words that have been seen."""
        if self.apart or self.seen < SETTLED:
            return 0
        return calm_ticks(self.oracle) // self.setting.scan_ticks

    # ---- the comparison

    def compare(self):
        if self.oracle.open_bits:
            self.oracle.take_over(self.inputs[0])
        theirs, ours = self.inputs, self.oracle.image
        msw, lsw = (theirs[0] ^ ours[0]) & 0xFFFF, (theirs[1] ^ ours[1]) & 0xFFFF
        if not msw and not lsw and theirs[2:] == ours[2:]:
            self.apart = False
        elif ours[0] & bits.MODE_CONFIG:
            self.fail("in configuration mode every word has to agree")
        elif msw & ~SOFT_MSW or lsw & ~SOFT_LSW:
            self.fail("a bit that has to agree in every image")
        elif msw or lsw:
            if self.apart:
                self.fail("motion bits for more than one exchange")
            self.apart = True
            self.compare_values(theirs, ours)
        else:
            self.apart = False
            self.compare_values(theirs, ours)

    def compare_values(self, theirs, ours):
        """Position, encoder count and captured value; at rest the oracle goes on from the module's."""
        position, encoder, captured = (
            join_reported(*theirs[at : at + 2]) - join_reported(*ours[at : at + 2]) for at in (2, 4, 6)
        )
        gear = max(1, self.setting.counts_per_step)
        at_rest = not self.apart and not self.oracle.in_motion()
        if abs(position) > (1 if at_rest else STEPS_APART):
            self.fail(f"positions {position:+} steps apart")
        if abs(encoder) > abs(position) * gear:
            self.fail(f"encoder counts {encoder:+} apart")
        if abs(captured) > STEPS_APART * gear:
            self.fail(f"captured values {captured:+} apart")
        self.oracle.captured += captured
        if at_rest:
            self.oracle.position += position
            self.oracle.own_steps += position
            self.world.shaft += position

    def fail(self, why):
        if self.close_call:
            raise GivenUp
        raise Differ(
            "\n".join(
                [
                    f"Module and oracle differ: {why}.",
                    str(self.setting),
                    *(line(ns, describe(what) if isinstance(what, list) else what) for ns, what in self.log),
                    line(self.now_ns, ""),
                    "   module  " + show(self.inputs),
                    "   oracle  " + show(self.oracle.image),
                    f"   the oracle's axis: {self.oracle.op}, {self.oracle.phase}",
                ]
            )
        )


def line(now_ns, text):
    return f"{now_ns / 1e6:10.2f} ms  {text}"


def describe(words):
    """Output words as they stand in a script: command words in hex and by name, the others as numbers."""
    msw, lsw = words[0] & 0xFFFF, words[1] & 0xFFFF
    if msw & bits.CONFIGURE:
        names = "configuration"
    else:
        names = " ".join(
            [str(bit.name) for bit in CommandMsw if msw & bit]
            + [str(bit.name) for bit in CommandLsw if lsw & bit]
        )
    return f"{msw:04X} {lsw:04X} {list(words[2:])}  {names}"


def show(image):
    """Input words: in hex and by name, and the values in the others."""
    msw, lsw = image[0] & 0xFFFF, image[1] & 0xFFFF
    position, encoder, captured = (join_reported(*image[at : at + 2]) for at in (2, 4, 6))
    names = " ".join(status_names(msw, lsw))
    return f"{msw:04X} {lsw:04X} position {position} encoder {encoder} captured {captured}  {names}"
