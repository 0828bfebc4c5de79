"""An adapter with its simulated controller, and an oracle of the 3601, under the same words, inputs and time.

Over a line the images can't agree tick by tick. So a script goes on only when both have settled:

* at rest: nothing has changed for a round trip; then the images have to be the same, and the motor has to
  stand where the position shown says;
* in mid-motion: the same motion is under way in both, with so much of the way left that whatever comes
  next still meets it in both.

Where a motion is ended on its way (hold, stop, limit, input) the two stop at different places: the adapter
within what its round trip and its ramp take it, and the oracle takes over where that is.

What the adapter's capabilities refuse (`adapter_wishes`), the oracle passes over, and shows its bits.
`adapter_laws` has what must hold in every scan.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import adapter_wishes as wishes
import oracle_bits as bits
import oracle_blend
from adapter_alone import MS, SCAN_NS, SCAN_TICKS, AloneForAWhile
from adapter_laws import ONE_STEP, Laws
from adapter_worlds import ANY_LIMIT, WORLD, SharedPin
from lockstep3601 import describe, show
from noisyline import made_noisy
from oracle3601 import TICK_NS, Oracle
from oracle_bits import ESTOP, HOME
from oracle_world import World
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import join_reported
from scanrack.runtime.machine import EncoderSpec, Machine, MachineSpec, Switch
from scanrack.runtime.modules.adapters.module import SimulatedAdapter
from scanrack.runtime.modules.adapters.pcl601.module import PCL601
from scanrack.runtime.modules.adapters.pmc006.module import PMC006

MAKE: dict[str, Callable[..., SimulatedAdapter[Any]]] = {
    "PCL601": PCL601.simulated,
    "PMC006": PMC006.simulated,
}
CALM_NS = {"PCL601": 65 * MS, "PMC006": 160 * MS}
"""The longest round trip: what has not changed for so long is settled [docs/adapter-tables.md]."""

LOW_BYTE = {"PCL601": 4, "PMC006": 3}
"""Where a reply has the lower bits of what has been read first."""

PATIENCE_NS = 700 * MS
"""What has not changed for so long, a configuration included, will not any more."""

FOR_EVER_NS = 15_000 * MS
"""Longer than any search for home."""

SLOWER = 3
"""How much longer a motion may take than a 3601 does; the ramps are gentler."""

TOO_LONG_S = 3
FIND_HOME = bits.FIND_HOME_CW | bits.FIND_HOME_CCW
SOFT = bits.ACCELERATING | bits.DECELERATING


class Differ(AssertionError):  # noqa: N818 - they do
    """Adapter and oracle show different things, or a law is broken."""


class AdapterLockstep(AloneForAWhile):
    """An adapter and an oracle, as the steps of `steps3601` and `adapter_scripts` play on them."""

    def __init__(self, setting):
        self.setting = setting
        self.controller = setting.controller
        switches = tuple(Switch(InputBit(bit), first, last) for bit, first, last in setting.switches)
        gear = setting.counts_per_step
        machine = Machine(MachineSpec(switches=switches, encoder=EncoderSpec(gear) if gear else None))
        self.module = MAKE[self.controller](machine, dict(setting.options))
        self.world = WORLD[self.controller](setting.switches, gear)
        self.oracle = Oracle("4.1", self.world)
        self.words = self.oracle_words = [0] * 8
        self.outputs = Image()
        self.now_ns = self.turned_until = self.calm_ns = 0
        self.side_unknown = self.alone = False
        self.wired = sum({bit for bit, _, _ in setting.switches})
        self.oracle_rests_ns = self.disturbed_ns = 0
        self.noise = made_noisy(self.module, LOW_BYTE[self.controller])
        self.expected, self.refused, self.log = [], [], [str(setting)]
        self.image = self.updated()
        self.laws = Laws(self)

    @property
    def motor(self):
        """Where the motor truly stands."""
        plant: Any = self.module.controller
        return plant.device.motor_position

    def updated(self):
        """The adapter's image, its status words unsigned."""
        words = self.module.update(self.now_ns, self.outputs).words.tolist()
        return [words[0] & 0xFFFF, words[1] & 0xFFFF, *words[2:]]

    @property
    def oracle_image(self):
        """The oracle's image, its status words unsigned."""
        words = self.oracle.image
        return [words[0] & 0xFFFF, words[1] & 0xFFFF, *words[2:]]

    # ---- what a script does

    def out(self, words):
        """Write words, once both have settled; some that mean nothing to compare are left out."""
        words = list(words)
        self.meet()
        if self.means_nothing(words):
            return
        after = copy.deepcopy(self.oracle)
        after.tick(words)
        if self.ends_on_a_limit(after):
            return
        self.note(describe(words))
        self.words = self.oracle_words = words
        self.outputs = Image(words)
        self.foresee(after)
        self.calm_ns = 0

    def input(self, bit, energized):
        if bit & self.wired or not bit & self.oracle.used:
            return
        self.meet()
        if energized and bit & (ANY_LIMIT | ESTOP) and self.controller == "PCL601":
            self.side_unknown |= not self.oracle.in_motion() or bool(self.world.levels() & ANY_LIMIT)
        self.module.machine.set_input(InputBit(bit), energized)
        self.module.look_again()
        self.world.hand_levels = self.world.hand_levels & ~bit | (bit if energized else 0)
        self.note(f"input {InputBit(bit).name} {'on' if energized else 'off'}")
        self.laws.something_happens()
        self.calm_ns = 0

    def turn(self, counts, ticks):
        self.meet()
        if self.now_ns < self.turned_until:
            return
        end = self.turned_until = self.now_ns + ticks * TICK_NS
        self.module.machine.turn_encoder(counts, self.now_ns, end)
        self.module.look_again()
        self.world.turns.append((counts, self.now_ns, end))
        self.note(f"encoder turned by {counts:+} in {ticks * 0.25} ms")
        self.calm_ns = 0

    def plc(self, running):
        self.meet()
        self.module.plc_run(running)
        self.oracle.plc_running = running
        self.note("PLC in run mode" if running else "PLC in program mode")
        self.laws.something_happens()
        self.calm_ns = 0

    def power_cycle(self):
        """Adapter and controller lose their power."""
        self.meet()
        self.module.power_cycle()
        self.oracle.power_up()
        self.world.shaft = self.motor
        self.side_unknown = self.controller == "PCL601"  # if there is one
        self.oracle_words = self.words
        self.note("power off and on")
        self.laws.powered_up()
        self.calm_ns = 0

    def disturb(self, lost, damaged):
        """The next replies get lost, others have a wrong bit; the start of what comes may take longer."""
        self.module.controller.line.faults.drop_next += lost
        self.noise.damage_next += damaged
        self.disturbed_ns += (lost + damaged) * 2 * CALM_NS[self.controller]
        self.laws.disturbed(self.disturbed_ns)
        self.note(f"{lost} replies lost, {damaged} damaged")
        self.calm_ns = 0

    def note(self, text):
        self.log.append(f"{self.now_ns / 1e6:10.2f} ms  {text}")

    # ---- what is left out, and what is refused

    def means_nothing(self, words):
        """Whether the machine differs from a 3601's here, or the script would take for ever."""
        starts = words[0] & ~self.words[0] & 0x7FFF and not words[0] & bits.CONFIGURE
        if starts and self.side_unknown and words[0] & (bits.MANUAL_CW | bits.MANUAL_CCW):
            return True  # a PCL601 learns by a motion which limit it is
        if starts and isinstance(self.world, SharedPin) and self.world.levels() & HOME:
            # the home switch is the CCW limit: moves may leave it
            return bool(words[0] & (bits.ABSOLUTE | bits.RELATIVE | bits.RESUME))
        hard_limits = self.wired & ANY_LIMIT if self.controller == "PCL601" else 0
        if words[0] & bits.CONFIGURE and hard_limits & ~words[0]:
            return True  # they act in any case
        waits = words[0] & bits.CONFIGURE and self.oracle.op in ("move", "homing")
        return bool(waits) and self.laws.seconds_left() > TOO_LONG_S

    def ends_on_a_limit(self, after):
        """Whether the last step of a motion meets a limit: a 3601 has moved then, an adapter shows the limit.

        [docs/adapter-tables.md, what is done, and how]
        """
        if self.oracle.in_motion() or after.op not in ("move", *ONE_STEP):
            return False
        end = self.laws.end_of(self.oracle, after)
        return any(
            end == (first if after.direction > 0 else last)
            for bit, first, last in self.setting.switches
            if bit & self.laws.stopping
        )

    def foresee(self, after):
        """Find out what the words start, and what the adapter has to refuse; tell the laws and the oracle."""
        row = wishes.refusal(self.controller, self.setting.options, self.oracle, after, self.words)
        if row is None:
            self.laws.commanded(after)
            return
        self.expected.append(row.name)
        self.laws.something_happens()
        if row.shown == bits.CONFIG_ERROR:
            self.oracle_words = [*self.words[:7], 1]  # one that a 3601 rejects
        else:
            self.pass_over(row)

    def pass_over(self, row):
        """Let the oracle show a refusal instead of doing what was asked."""
        oracle = self.oracle
        oracle.previous0, oracle.previous1 = self.words[0] & 0xFFFF, self.words[1] & 0xFFFF
        oracle.command_error |= bool(row.shown & bits.COMMAND_ERROR)
        oracle.invalid_profile |= bool(row.shown & bits.INVALID_PROFILE)
        oracle.home_invalid |= bool(row.shown & bits.HOME_INVALID)
        oracle.resumable = False
        if row.stops:
            oracle.controlled_stop("manual stop")
        elif row.name == "blend move":
            oracle.ack, oracle.session = True, oracle_blend.Session()
            oracle.session.good = False

    # ---- time

    def run(self, ticks):
        """So many ticks, in whole scans."""
        for _ in range(-(-ticks // SCAN_TICKS)):
            self.scan()

    def run_to_rest(self, ticks=0):
        """Until both rest, unless that is too far."""
        self.meet()
        if self.oracle.in_motion() and self.laws.seconds_left() < TOO_LONG_S:
            self.meet(at_rest=True)

    def scan(self):
        """One scan: the adapter first, then the oracle."""
        shown = self.image, self.oracle.op, self.motor
        self.now_ns += SCAN_NS
        self.image = self.updated()
        self.refused += [event.name for event in self.module.events if event.kind == "refusal"]
        self.module.events.clear()
        for _ in range(SCAN_TICKS):
            if isinstance(self.world, SharedPin):
                sought = (
                    self.oracle_words[0] & ~self.oracle.previous0 & (bits.FIND_HOME_CW | bits.FIND_HOME_CCW)
                )
                self.world.searching = bool(sought) or self.oracle.op == "homing"
            self.oracle.tick(self.oracle_words)
        if self.oracle.open_bits:
            self.oracle.take_over(self.image[0])
            self.oracle.open_bits = 0
        if self.oracle.at_home and self.laws.searched and self.image[0] & bits.AT_HOME:
            self.take_home()
        if not World.levels(self.world) & ANY_LIMIT:
            self.side_unknown = False
        self.laws.look()
        now_shown = self.image, self.oracle.op, self.motor
        self.calm_ns = self.calm_ns + SCAN_NS if self.same(shown, now_shown) else 0

    def take_home(self):
        """Home is where the adapter has found it; for the oracle, too, position and count are zero there."""
        self.laws.at_the_switch()
        moved = self.motor - self.world.shaft
        self.world.shaft += moved
        self.oracle.count_offset -= moved * self.setting.counts_per_step

    def same(self, shown, now_shown):
        """Whether nothing has changed; in motion, positions and ramps aside."""
        if shown[1] != now_shown[1]:
            return False
        if self.oracle.in_motion():
            return (shown[0][0] ^ now_shown[0][0]) & ~SOFT == 0 and shown[0][1] == now_shown[0][1]
        return shown == now_shown and self.now_ns >= self.turned_until

    # ---- where both have settled

    def meet(self, at_rest=False):
        """Let time run until both have settled."""
        began_ns = self.now_ns
        while not self.settled(at_rest):
            self.scan()
            resting_ns = 0 if self.oracle.in_motion() else self.calm_ns
            if resting_ns > PATIENCE_NS + self.disturbed_ns:
                self.compare()
            if self.now_ns > min(self.limit_ns(began_ns), began_ns + FOR_EVER_NS):
                self.fail("they do not settle")
        if not self.oracle.in_motion():
            self.compare()

    def limit_ns(self, began_ns):
        """Until when both have to have settled, once the oracle rests."""
        if self.oracle.in_motion():
            self.oracle_rests_ns = self.now_ns
        rested_ns = max(began_ns, self.oracle_rests_ns)
        return rested_ns + SLOWER * (rested_ns - self.laws.began_ns) + 3_000 * MS

    def settled(self, at_rest):
        if self.calm_ns < CALM_NS[self.controller] + self.disturbed_ns:
            return False
        if self.oracle.in_motion():
            return not at_rest and self.in_mid_motion()
        return self.agrees()

    def in_mid_motion(self):
        """Whether the same motion is under way in both, with room for whatever comes next."""
        moving = bits.MOVING_CW | bits.MOVING_CCW
        theirs, ours = self.image, self.oracle_image
        if self.words[0] & bits.CONFIGURE:
            return False  # it waits for the end of the motion
        both = theirs[0] & moving and (theirs[0] ^ ours[0]) & ~SOFT == 0
        return bool(both) and self.lsw(theirs) == self.lsw(ours) and self.laws.has_room()

    def agrees(self):
        """Whether status words and the place on the machine are the same."""
        theirs, ours = self.image, self.oracle_image
        if ours[0] & bits.MODE_CONFIG:
            return theirs == ours
        ours[1] ^= self.home_seen_elsewhere()
        return theirs[0] == ours[0] and self.lsw(theirs) == self.lsw(ours)

    def home_seen_elsewhere(self):
        """The bit of the home input, where the two have stopped on different sides of the switch."""
        if HOME & self.laws.stopping or not self.laws.may_stop_elsewhere():
            return 0
        return (self.levels_at_motor() ^ self.world.levels()) & HOME & self.oracle.used

    def lsw(self, image):
        """Input word 1; where a PCL601 can't know which limit is on, either is as good as both."""
        word = image[1]
        return word | ANY_LIMIT if self.side_unknown and word & ANY_LIMIT else word

    # ---- the comparison at rest

    def compare(self):
        """Everything, at rest; the oracle goes on from where the adapter stands."""
        if not self.agrees():
            self.fail("status words at rest")
        if self.refused != self.expected:
            self.fail(f"refusals {self.refused}, and not {self.expected}")
        self.refused, self.expected = [], []
        if self.oracle.mode_config:
            self.stand_where_it_stands()
        else:
            self.compare_values()
        self.laws.at_rest()
        self.disturbed_ns = 0

    def stand_where_it_stands(self):
        """In configuration mode no position is shown, and it will be 0; a count that is kept has gone on."""
        if not self.oracle.quadrature:
            self.oracle.count_kept += (self.motor - self.world.shaft) * self.setting.counts_per_step
        self.world.shaft = self.motor

    def compare_values(self):
        """Positions, counts and captured value."""
        theirs, ours = self.image, self.oracle_image
        position, encoder, captured = (
            join_reported(*theirs[at : at + 2]) - join_reported(*ours[at : at + 2]) for at in (2, 4, 6)
        )
        motor = self.motor - self.world.shaft
        gear = self.setting.counts_per_step
        if motor != position:
            self.fail(f"the position shown is {position - motor:+} steps off the motor's")
        if position and not self.laws.may_stop_elsewhere():
            self.fail(f"a motion ended {position:+} steps off")
        if encoder != position * gear * self.oracle.quadrature:
            self.fail(f"encoder counts {encoder:+} apart")
        if abs(captured) > self.laws.captured_apart() * max(1, gear):
            self.fail(f"captured values {captured:+} apart")
        self.oracle.captured += captured
        self.oracle.position += position
        self.oracle.own_steps += position
        self.world.shaft = self.motor

    def fail(self, why):
        """Tell what differs, and how it came to that."""
        raise Differ(
            "\n".join(
                [
                    f"{self.controller} and oracle differ: {why}.",
                    *self.log,
                    f"{self.now_ns / 1e6:10.2f} ms",
                    f"   adapter {show(self.image)}  motor {self.motor}",
                    f"   oracle  {show(self.oracle.image)}  shaft {self.world.shaft}",
                    f"   the oracle's axis: {self.oracle.op}, {self.oracle.phase}",
                ]
            )
        )


def played(script):
    """Play a script to an adapter and an oracle; return the bench.

    Raises:
        Differ: they differ, or a law is broken.
    """
    setting, steps = script
    bench = AdapterLockstep(setting)
    for step in steps:
        step.play(bench)
    bench.run_to_rest()
    return bench


def differs(script):
    """Whether something is found."""
    try:
        played(script)
    except Differ:
        return True
    return False
