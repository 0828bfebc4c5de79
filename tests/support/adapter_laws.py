"""What holds of an adapter in every scan, and how far it may stop from where it was told to.

    start |-----------------------------> end          path of the motion, on the machine
                    ^ event    ^ stops                 at most speed x round trip, and the ramp

Times and rates are those of docs/adapter-tables.md.
"""

from __future__ import annotations

from math import inf

import oracle_bits as bits
import oracle_commands as commands
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME
from scanrack.io_images.pmc006.instructions import ACCELERATIONS_PPS2
from scanrack.io_images.thousands import join_reported

ROUND_TRIP_S = {"PCL601": 0.065, "PMC006": 0.16}
SCAN_S = 0.005
STEPS_OF_ROUNDING = 2
ERRORS = bits.COMMAND_ERROR | bits.INVALID_PROFILE | bits.HOME_INVALID | bits.CONFIG_ERROR
LIMITS = CW_LIMIT | CCW_LIMIT
INPUTS = (CAPTURE, EXTERNAL, HOME, ESTOP, CW_LIMIT, CCW_LIMIT)
ALL_INPUTS = sum(INPUTS)
RECENT_NS = 500_000_000
"""Longer than a lost reply keeps an input from being read."""

FASTEST = 12_000
"""Of the motions that are commanded in haste, steps/s."""

STOPPING = {"PCL601": CW_LIMIT | CCW_LIMIT, "PMC006": CW_LIMIT | CCW_LIMIT | HOME}
"""Switches on the machine that stop a motion; a PMC006's home switch is an end limit."""

RAMPING = ("manual stop", "stop to hold")
ONE_STEP = ("step to hold", "step to stop", "one shot")
UNDER_WAY = ("move", "manual", "registration", "homing")


class Pace:
    """How fast a motion is, and how it stops.

    Attributes:
        speed: programmed, steps/s.
        rate: the controller's rate down, steps/s/s.
        ramp: steps of the ramp down from that speed, by that rate.
        steepest: the programmed rate down, steps/s/s.
        bulge: steps by which an S-curve and a constant rate that take as long may be apart.
    """

    def __init__(self, controller, words, start):
        self.start = start
        self.speed = max(commands.pair(words[4], words[5]) or 0, 1)
        self.acceleration, self.deceleration = max(1, words[6]), max(1, words[7])
        self.rate = self.by_controller(controller, words[1])
        self.steepest = 1000 * self.deceleration
        self.ramp = self.way(self.speed, self.rate)
        shorter = controller == "PMC006" and words[1] & bits.S_CURVE  # its ramps are S-curves in any case
        self.bulge = inf if shorter else self.ramp / 8

    def by_controller(self, controller, lsw):
        """The controller's rate down, steps/s/s."""
        if controller == "PMC006":
            return max(
                (rate for rate in ACCELERATIONS_PPS2[1:] if rate <= 1000 * self.deceleration), default=1
            )
        stretch = 1 if not lsw & bits.S_CURVE else 4 / 3 if lsw & bits.TRAPEZOIDAL else 2
        return 1000 * min(self.acceleration, self.deceleration) / stretch

    def way(self, speed, rate):
        """Steps from a speed down to the starting speed."""
        return max(0, speed**2 - self.start**2) / (2 * rate)


class Laws:
    """What holds of the adapter of a bench."""

    def __init__(self, bench):
        self.bench = bench
        self.round_trip_s = ROUND_TRIP_S[bench.controller]
        self.stopping = STOPPING[bench.controller]
        self.low = self.high = self.motor = self.event_at = bench.motor
        self.directions = set()
        self.direction = 1
        self.began_ns = 0
        self.pace = Pace(bench.controller, [0] * 8, 1)
        self.moved = self.ramps = self.searched = self.quickened = False
        self.registered = 0
        self.event_speed = self.speed = 0
        self.apart = 0
        self.answering = False
        self.op = "idle"
        self.least = 0
        self.op_began = None
        self.on_ns = {}
        self.motor_begins_ns = self.motor_ends_ns = self.ends_ns = 0

    # ---- what the bench tells

    def may_be_absent(self):
        """The adapter may lose its controller from now on."""
        self.answering = False

    def interrupted(self):
        """Whatever moved has been ended by a loss."""
        self.low = self.high = self.bench.motor
        self.moved = self.ramps = self.searched = self.quickened = False
        self.registered = 0
        self.directions = set()
        self.op = "idle"

    def anything_goes(self):
        """Commands come faster than they can be told apart."""
        self.low, self.high = -inf, inf
        self.directions = {1, -1}
        self.pace.speed = FASTEST

    def disturbed(self, duration_ns):
        """Round trips may take so much longer until the next rest."""
        self.round_trip_s = ROUND_TRIP_S[self.bench.controller] + duration_ns / 1e9

    def powered_up(self):
        """The adapter has to find its controller again."""
        self.answering = False
        self.something_happens()

    def something_happens(self):
        """An event from which the way to a stop counts."""
        self.event_at, self.event_speed = self.bench.motor, self.speed
        self.apart = abs(self.bench.motor - self.bench.world.shaft)

    def commanded(self, after):
        """Words have been written, of which a 3601 makes `after`."""
        before = self.bench.oracle
        active = ("one shot",)
        if (after.in_motion() or after.op in active) and not (before.in_motion() or before.op in active):
            self.set_out(before, after)
        elif before.op in ("manual", "registration") and after.seen_speed != before.seen_speed:
            self.quicken(after)
        self.something_happens()

    def end_of(self, before, after):
        """Where on the machine a motion ends that begins now; infinitely far for one without an end."""
        if after.op == "move":
            return self.bench.motor + after.hold_target - before.position
        return self.bench.motor + after.direction * (1 if after.op in ONE_STEP else inf)

    def set_out(self, before, after):
        """A motion begins."""
        bench = self.bench
        self.began_ns = bench.now_ns
        self.direction = after.home_direction if after.op == "homing" else after.direction
        self.directions = {1, -1} if after.op == "homing" else {self.direction}
        self.pace = Pace(bench.controller, bench.words, after.starting_speed)
        end = self.end_of(before, after)
        self.low, self.high = min(bench.motor, end), max(bench.motor, end)
        self.searched = after.op == "homing"
        if self.searched:
            self.low, self.high = -inf, inf
        if after.op in ONE_STEP:
            self.pace.speed = max(self.pace.speed, after.starting_speed)
        self.registered = after.registration_steps if after.op == "registration" else 0
        self.op_began, self.quickened = after.op, False
        self.motor_begins_ns = self.motor_ends_ns = 0
        self.moved = True

    def quicken(self, after):
        """A manual move changes its speed: an adapter stops it at its old rate, and starts it again."""
        pace = Pace(self.bench.controller, self.bench.words, after.starting_speed)
        pace.speed = max(pace.speed, self.pace.speed)
        pace.rate, pace.steepest = min(pace.rate, self.pace.rate), max(pace.steepest, self.pace.steepest)
        pace.ramp = pace.way(pace.speed, pace.rate)
        self.pace, self.op_began = pace, None  # how far ahead it may be depends on two ramps now
        self.quickened = True

    # ---- every scan

    def look(self):
        """After a scan."""
        bench, oracle = self.bench, self.bench.oracle
        if self.op in UNDER_WAY and oracle.op in RAMPING:
            self.ramps = bench.controller == "PCL601" or oracle.op != "stop to hold"
            self.least = self.pace.way(self.event_speed, self.pace.steepest) / 2
        self.op = oracle.op
        made, self.motor = bench.motor - self.motor, bench.motor
        self.passed = self.switches_between(*sorted((bench.motor - made, bench.motor)))
        self.speed = max(0, abs(made) - 1) / SCAN_S  # at least: a scan's steps are a whole number
        self.measure(made)
        if not self.low <= bench.motor <= self.high:
            bench.fail(f"the motor leaves its path, {self.low} to {self.high}")
        if abs(made) > self.pace.speed * SCAN_S + STEPS_OF_ROUNDING:
            bench.fail(f"{abs(made)} steps in a scan are faster than programmed")
        if made and (made > 0) - (made < 0) not in self.directions:
            bench.fail(f"the motor goes the other way, {made:+} steps")
        self.look_ahead()
        self.look_at_image(bench.image)

    def measure(self, made):
        """How long the motions take, in both; that of the motor as seen scan by scan."""
        now_ns, scan_ns = self.bench.now_ns, round(SCAN_S * 1e9)
        if made:
            self.motor_ends_ns = now_ns
            self.motor_begins_ns = self.motor_begins_ns or now_ns - scan_ns
        if self.bench.oracle.in_motion():
            self.ends_ns = now_ns

    def switches_between(self, low, high):
        """Inputs whose switches lie on a part of the way."""
        return sum(
            {
                bit
                for bit, first, last in self.bench.setting.switches
                if (first is None or first <= high) and (last is None or last >= low)
            }
        )

    def look_ahead(self):
        """A gentler motion that begins later is never ahead, but for the form of its ramps."""
        bench, oracle = self.bench, self.bench.oracle
        if oracle.op not in ("move", "manual") or self.op_began != oracle.op or bench.alone:
            return
        ahead = self.direction * (bench.motor - bench.world.shaft)
        if ahead > self.pace.bulge + self.pace.speed * SCAN_S + STEPS_OF_ROUNDING:
            bench.fail(f"{ahead} steps ahead of a 3601")

    def look_at_image(self, image):
        bench, oracle = self.bench, self.bench.oracle
        if image[0] & bits.MODULE_OK and not bench.alone:
            self.answering = True
        if not image[0] & bits.MODULE_OK:
            if self.answering:
                bench.fail("MODULE_OK is clear")
            if image[0] & ~bits.MODE_CONFIG & 0xFFFF != bits.POSITION_INVALID or image[1]:
                bench.fail("without the controller the position is invalid, and nothing else is shown")
            return
        if image[0] & bits.MODE_CONFIG or oracle.mode_config or bench.alone:
            return
        for bit, direction in ((bits.MOVING_CW, 1), (bits.MOVING_CCW, -1)):
            if image[0] & bit and direction not in self.directions:
                bench.fail("a motion is shown that nobody has commanded")
        if image[0] & ERRORS & ~oracle.image[0]:
            bench.fail("an error that a 3601 would not show")
        self.look_at_inputs(image[1] & ALL_INPUTS)
        shown = join_reported(*image[2:4]) - oracle.position + bench.world.shaft
        if not self.low <= shown <= self.high:
            bench.fail("the position shown is not on the path of the motion")

    def look_at_inputs(self, shown):
        """An input is shown if it, or what shares its pin, has been on not long ago."""
        now_ns, oracle = self.bench.now_ns, self.bench.oracle
        active = oracle.active | ~(self.bench.levels_at_motor() ^ oracle.active_high) & oracle.used
        self.on_ns |= {bit: now_ns for bit in INPUTS if (active | self.passed) & bit}
        recent = sum(bit for bit, on_ns in self.on_ns.items() if now_ns - on_ns < RECENT_NS)
        one = LIMITS if self.bench.controller == "PCL601" else HOME | CCW_LIMIT
        if recent & one:
            recent |= one
        if shown & ~recent:
            self.bench.fail("an input is shown that has not been on")

    # ---- where both rest

    def at_rest(self):
        """Both rest, and have been found to agree."""
        bench = self.bench
        arrived = bench.motor == (self.high if self.direction > 0 else self.low)
        if self.may_stop_elsewhere() and not arrived and self.directions == {self.direction}:
            self.check_stop()
        if self.moved and arrived and self.op_began == "move" and bench.oracle.move_complete:
            self.check_duration()
        self.low = self.high = bench.motor
        self.moved = self.ramps = self.searched = self.quickened = False
        self.registered = 0
        self.round_trip_s = ROUND_TRIP_S[bench.controller]
        if bench.oracle.op != "one shot":
            self.directions = set()

    def may_stop_elsewhere(self):
        """Whether the last motion was ended on its way."""
        oracle = self.bench.oracle
        return self.moved and not oracle.move_complete

    def check_stop(self):
        """A stop comes in time, and with its ramp where it has one."""
        bench, pace = self.bench, self.pace
        switches = [ends for bit, *ends in bench.setting.switches if bit & self.stopping]
        edges = [first if self.direction > 0 else last for first, last in switches]
        at = self.direction * bench.motor
        passed = [self.direction * edge for edge in edges if edge is not None]
        since = at - self.direction * self.event_at
        begun = max([at - since, *(edge for edge in passed if edge <= at)])
        made = at - begun
        allowed = pace.speed * (self.round_trip_s + SCAN_S) + self.registered + STEPS_OF_ROUNDING
        if self.ramps or self.registered or self.quickened:
            allowed += pace.ramp
        if self.ramps and made < self.least:
            bench.fail(f"a stop without its ramp: {made} steps, and not {self.least:.0f} at least")
        ended_early = bench.oracle.input_error or bench.oracle.command_error
        if self.registered and not ended_early and since < self.registered:
            bench.fail(f"a registration move ended after {made} steps, and not {self.registered}")
        if made > allowed:
            bench.fail(f"a stop took {made} steps, and not {allowed:.0f} at most")

    def check_duration(self):
        """A move at gentler rates takes no less time."""
        made_ns, ideal_ns = self.motor_ends_ns - self.motor_begins_ns, self.ends_ns - self.began_ns
        if self.pace.bulge < inf and made_ns + 2e9 * SCAN_S < ideal_ns:
            self.bench.fail(f"a move took {made_ns / 1e6} ms, and not {ideal_ns / 1e6} at least")

    def at_the_switch(self):
        """Home is where the switch changes."""
        bench = self.bench
        self.searched = False
        edges = [each for bit, *ends in bench.setting.switches if bit == HOME for each in ends]
        near = min(abs(bench.motor - edge) for edge in edges if edge is not None)
        if near > STEPS_OF_ROUNDING:
            bench.fail(f"home is {near} steps off the switch")

    def captured_apart(self):
        """Steps by which what is captured may differ."""
        return self.apart + self.pace.speed * (self.round_trip_s + SCAN_S) if self.moved else 0

    # ---- what is still to come

    @property
    def reach(self):
        """Steps that may be made before a stop has ended."""
        return self.pace.speed * (self.round_trip_s + 2 * SCAN_S) + self.pace.ramp

    def has_room(self):
        """Whether, in both, enough of the way is left for whatever comes next."""
        oracle, bench = self.bench.oracle, self.bench
        if oracle.op not in UNDER_WAY or (oracle.op == "homing" and oracle.phase != "seek"):
            return False
        end = self.high if self.direction > 0 else self.low
        edges = [edge for _, *ends in bench.setting.switches for edge in ends if edge is not None]
        stops = [self.direction * stop for stop in (end, *edges)]
        for at in (self.direction * bench.motor, self.direction * bench.world.shaft):
            if any(0 <= stop - at <= self.reach for stop in stops) or at > stops[0]:
                return False
        return True

    def seconds_left(self):
        """About how long the oracle's motion still takes."""
        oracle = self.bench.oracle
        if oracle.op in ("manual", "registration"):
            return inf
        if oracle.op != "move":
            return 0
        end = self.high if self.direction > 0 else self.low
        return abs(end - self.bench.world.shaft) / self.pace.speed
