"""An oracle of the AMCI 3601: slow, plain, in floats, from the manual and its readings only.

It shares no code with `scanrack.runtime` and goes tick by tick, 250 µs each:

    oracle = Oracle("4.1", World())
    oracle.tick([0x843E, 0x003F, 1, 0, 0, 0, 0, 0])     # one tick under these output words
    oracle.image                                        # the eight input words at its end

What happens in a tick, in this order:

    1   the inputs are sampled as they stand at its start
    2   mode, commands, and the words that a running motion looks at
    3   emergency stop, end limits
    4   the motion goes on to the end of the tick; if it ended, the image shows that

Sections are those of the manual, A-numbers those of docs/readings.md. The other
oracle_*.py files hold what each kind of motion looks at; all of them work on one
Oracle, called `m` (the module).
"""

from __future__ import annotations

from typing import Any

import oracle_commands
import oracle_follower
import oracle_homing
import oracle_manual
import oracle_motion as motion
from oracle_bits import (
    ACCELERATING,
    AT_HOME,
    BACKPLANE_PROXIMITY,
    BLEND_ACK,
    BLEND_RUNNING,
    CAPTURE,
    CCW_LIMIT,
    COMMAND_ERROR,
    CONFIG_ERROR,
    CONFIGURE,
    CW_LIMIT,
    DECELERATING,
    DIAGNOSTIC,
    ENC_FOLLOWER,
    ENCODER_MOVE,
    ESTOP,
    EXTERNAL,
    HOLD_STATE,
    HOME,
    HOME_INVALID,
    HOME_PROX_ECHO,
    INPUT_ERROR,
    INVALID_PROFILE,
    MARKER,
    MIN_REG_NONZERO,
    MODE_CONFIG,
    MODULE_OK,
    MOVE_COMPLETE,
    MOVING_CCW,
    MOVING_CW,
    POSITION_INVALID,
    PROGRAM,
    PROXIMITY,
    QUADRATURE,
    STEP_AND_DIRECTION,
    STOPPED,
    TRANSMIT,
)
from scanrack.io_images.thousands import split_reported

TICK_NS = 250_000


HOMING_KINDS = {
    # (home switch, backplane proximity, marker)
    (True, False, False): "switch",
    (True, True, False): "switch after proximity bit",
    (True, False, True): "marker after switch",
    (False, True, True): "marker after proximity bit",
}
"""The four homing possibilities [chapter 3]."""


def homing_bits(msw):
    return (
        bool(msw & HOME),
        bool(msw & BACKPLANE_PROXIMITY),
        bool(msw & MARKER),
    )


class Oracle:
    """The module.

    `op` says what the axis does:

        idle, held
        move, stop to hold, step to hold         absolute and relative
        encoder, encoder end, encoder stop       encoder moves: running, count reached, external input
        manual, manual stop, one shot, step to stop
        registration, registration end           before and after its input
        blend, blend stop
        homing                                   `phase` says more (oracle_homing)
        follower
    """

    def __init__(self, firmware, world):
        major, minor = firmware.split(".")
        self.firmware = (int(major), int(minor))
        self.world = world
        self.now_ns = 0
        self.start_ns = 0
        self.plc_running = True
        self.open_bits = 0
        self.configuring = False
        self.close_call = False
        self.power_up()

    def power_up(self):
        """Chapter 3 note 1: command mode with a configuration error; nothing is remembered (A-04, A-02)."""
        self.mode_config = False
        self.waiting = False
        self.config = None
        self.mirror = [0, 0, 0, 0]
        self.quadrature = self.diagnostic = False
        self.starting_speed = 1
        self.config_error = True
        self.position_invalid = True
        self.clear_status()
        self.op = "idle"
        self.course: Any = None
        self.encoder_target = self.deceleration = 0
        self.shape: Any = None
        self.direction = 1
        self.travelled = 0
        self.origin = 0
        self.ramp = 0
        self.moving = 0
        self.phase = None
        self.resumable = False
        self.hold_target = 0
        self.position = 0
        self.captured = 0
        self.count_offset = 0
        self.count_kept = 0
        self.own_steps = 0
        self.used = 0
        self.active_high = 0
        self.active = self.were_active = 0
        self.previous0 = self.previous1 = 0
        self.o0 = self.o1 = 0
        self.words = [0] * 8
        self.ack = False
        self.session = None
        self.profile = None
        self.minimum = 0
        self.hold_error = False
        self.echo = False

    def clear_status(self):
        """Bits 2 to 4 and 7 to 12 of the status MSW, less Position Invalid (A-102)."""
        self.move_complete = self.stopped = self.hold_state = self.at_home = False
        self.command_error = self.invalid_profile = self.home_invalid = self.input_error = False

    # ---- one tick

    def tick(self, words):
        self.start_ns = self.now_ns
        self.now_ns += TICK_NS
        self.words = list(words)
        self.close_call = False
        self.look_at_inputs()
        if self.plc_running:
            self.obey()
        else:
            self.leave_run_mode()
        if not self.mode_config:
            self.obey_stop_inputs()
        self.world.shaft_before = self.world.shaft
        self.advance()
        self.look_at_hand()

    def leave_open(self, bits):
        """Status bits of which manual and readings say nothing in this case: the module may choose."""
        self.open_bits |= bits

    def take_over(self, msw):
        """Take the module's choice of the bits that were left open."""
        if self.open_bits & COMMAND_ERROR:
            self.command_error = bool(msw & COMMAND_ERROR)

    def look_at_inputs(self):
        """Chapter 3, Input Active Level: levels count for the inputs in use (A-13)."""
        self.were_active = self.active
        self.active = ~(self.world.levels() ^ self.active_high) & self.used
        if self.became(CAPTURE) and not self.mode_config:
            self.captured = self.encoder(self.start_ns) if self.quadrature else self.position

    def became(self, bit):
        return bool(self.active & ~self.were_active & bit)

    def on(self, bit):
        return bool(self.active & bit)

    def obey(self):
        """Sections 5 and 6: which mode, then what the words command."""
        self.o0, self.o1 = self.words[0] & 0xFFFF, self.words[1] & 0xFFFF
        edge0 = self.o0 & ~self.previous0 & 0x7FFF
        edge1 = self.o1 & ~self.previous1
        if edge1 & PROGRAM:
            edge1 |= self.o1 & TRANSMIT  # both are first set now, whichever was before
        self.configuring = bool(self.o0 & CONFIGURE)
        if self.configuring:
            self.want_configuration()
        else:
            if self.mode_config:
                self.leave_configuration()
            self.waiting = False
            self.echo = bool(self.o1 & PROXIMITY)
            if self.op == "follower" or (self.o0, self.o1) != (self.previous0, self.previous1):
                oracle_commands.command(self, edge0, edge1)
            self.look_after_motion()
        self.previous0, self.previous1 = self.o0, self.o1

    def look_after_motion(self):
        """What a running motion reads in the words, tick by tick."""
        if self.op in ("manual", "registration", "registration end", "one shot"):
            oracle_manual.watch(self)
        elif self.op == "encoder":
            self.watch_encoder()
        elif self.op == "homing":
            oracle_homing.watch(self)
        elif self.op in ("move", "blend"):
            self.watch_external()

    def leave_run_mode(self):
        """Chapter 5 note 9: any move stops, the position becomes invalid (A-78). No word is acted on."""
        if self.in_motion():
            self.cut()
        if self.op == "one shot":
            self.rest("idle")

    # ---- configuration mode [chapter 3]

    def want_configuration(self):
        """Output word 0 bit 15 is set; while it is, no bit is a command (A-10)."""
        self.o0, self.o1 = CONFIGURE, 0
        self.echo = False
        if not self.mode_config:
            homing = self.op == "homing"
            self.release()
            if not self.in_motion() and not homing:  # a home that has just been found is shown first
                self.enter_configuration()
            elif not self.waiting:
                self.command_error = True  # CMD-01
                self.waiting = True
        if self.mode_config:
            self.judge_configuration()
        self.o0, self.o1 = self.words[0] & 0xFFFF, self.words[1] & 0xFFFF

    def release(self):
        """No command bit counts as set: a motion that this ends at once is over (A-10)."""
        if self.op == "follower":
            oracle_follower.leave(self)
            return
        self.look_after_motion()
        if self.course is not None and self.course.at(self.start_ns)[3]:
            self.finish()

    def enter_configuration(self):
        self.rest("idle")
        self.mode_config = True
        self.waiting = False
        self.clear_status()
        self.ack = False
        self.session = None
        self.resumable = False

    def judge_configuration(self):
        """Invalid Configurations, items 1 to 11 [chapter 3]; judged in every tick (A-08)."""
        if not self.configuration_is_valid():
            self.config_error = True
            self.forget_configuration()
            return
        self.config_error = False
        if self.quadrature or self.diagnostic:
            self.count_kept = self.encoder(self.start_ns)
        self.config = self.mirror = self.words[:4]
        msw = self.words[0] & 0xFFFF
        self.homing_kind = HOMING_KINDS[homing_bits(msw)]
        self.quadrature = bool(msw & QUADRATURE)
        self.diagnostic = bool(msw & DIAGNOSTIC)
        self.starting_speed = 1000 * self.words[2] + self.words[3]
        self.used = msw & 0x3F
        self.active_high = self.words[1] & 0x3F
        self.active = ~(self.world.levels() ^ self.active_high) & self.used
        self.set_encoder(self.count_kept)  # counted whenever configured [chapter 6, Optical Encoder]
        self.profile = None  # BLD: erased when "the configuration data is programmed"
        self.minimum = 0

    def configuration_is_valid(self):
        msw, lsw, start_msw, start_lsw = (
            self.words[0] & 0xFFFF,
            self.words[1] & 0xFFFF,
            self.words[2],
            self.words[3],
        )
        marker = bool(msw & MARKER)
        quadrature = bool(msw & QUADRATURE)
        diagnostic = bool(msw & DIAGNOSTIC)
        if homing_bits(msw) not in HOMING_KINDS:
            return False  # 1, 9, 10
        if not msw & (CW_LIMIT | CCW_LIMIT):
            return False  # 2
        if quadrature and diagnostic:
            return False  # 3
        if marker and not quadrature:
            return False  # 4
        if diagnostic and not msw & STEP_AND_DIRECTION:
            return False  # 5
        if not 0 <= start_lsw <= 999 or not 1 <= 1000 * start_msw + start_lsw <= 1_000_000:
            return False  # 6, 7
        if msw & 0b0110_1000_1000_0000 or lsw & 0xFFC0:
            return False  # 8
        if any(self.words[4:]):
            return False  # 11
        # Revision history, 0.1: capture without encoder since firmware 2.1.
        return not (msw & CAPTURE and not quadrature and self.firmware < (2, 1))

    def leave_configuration(self):
        """Chapter 4: the position is invalid, and zero (A-102, A-07)."""
        self.mode_config = False
        self.clear_status()
        self.position = 0
        self.position_invalid = True

    def forget_configuration(self):
        """A rejected one takes the place of the one before: no input counts, and no encoder."""
        if self.quadrature or self.diagnostic:
            self.count_kept = self.encoder(self.start_ns)
        self.config = None
        self.quadrature = self.diagnostic = False
        self.used = 0
        self.active = 0

    # ---- motion

    def start(self, op, direction, course):
        """A motion begins: what it clears is A-19."""
        self.move_complete = self.stopped = self.hold_state = self.at_home = self.input_error = False
        self.resumable = False
        self.op = op
        self.direction = direction
        self.go(course)

    def go(self, course, direction=None):
        """A course from here, counted from 0."""
        if direction is not None:
            self.direction = direction
        self.course = course
        self.origin = self.position
        self.travelled = 0
        self.moving = self.direction

    def rest(self, op):
        self.op = op
        self.course = None
        self.moving = 0
        self.ramp = 0
        self.phase = None

    def in_motion(self):
        """The dwell of homing counts as motion (A-29); a held axis and a one-shot that is done do not."""
        return self.op not in ("idle", "held", "one shot")

    def cut(self):
        """An immediate stop [chapter 4, Immediate Stop]: no deceleration, the position is lost."""
        self.rest("idle")
        self.stopped = True
        self.position_invalid = True

    def look_at_hand(self):
        """Counts that a hand gives in this tick act in it: an encoder move begins to stop at its end."""
        turned = any(start < self.now_ns and end > self.start_ns for _, start, end in self.world.turns)
        if self.op == "encoder" and turned and self.plc_running:
            self.compare_counts(self.now_ns)
            if self.op == "encoder end":
                _, _, self.ramp, over = self.course.at(self.now_ns)
                if over:
                    self.finish()

    def compare_counts(self, now_ns):
        """At the count the deceleration begins, as long as bit 2 stays set (A-49, A-52)."""
        compared = self.configuring or self.o1 & ENCODER_MOVE
        if compared and (self.encoder(now_ns) - self.encoder_target) * self.direction >= 0:
            self.controlled_stop("encoder end", now_ns)

    def controlled_stop(self, op, now_ns=None):
        """Decelerate with the rate that the motion has, then stop."""
        self.op = op
        begin_ns = self.start_ns if now_ns is None else now_ns
        self.course = motion.stop(self.course, begin_ns, self.starting_speed, self.deceleration, self.shape)

    def advance(self):
        """The motion up to the end of the tick."""
        if self.op == "follower":
            oracle_follower.steps(self)
        if self.course is None:
            return
        x, v, self.ramp, over = self.course.at(self.now_ns)
        if motion.is_close_call(x, v) and not over:
            self.close_call = True
        self.make_steps(motion.whole(x) - self.travelled)
        if over:
            self.finish()

    def make_steps(self, steps):
        self.travelled += steps
        self.position += self.direction * steps
        self.world.shaft += self.direction * steps
        self.own_steps += self.direction * steps

    def finish(self):
        """The course is over: which bit says so [chapter 6, Stopped and Move Complete bits]."""
        op = self.op
        if op == "homing":
            oracle_homing.phase_over(self)
            return
        self.rest("idle")
        if op in ("move", "encoder end", "blend"):
            self.move_complete = True
        elif op in ("stop to hold", "step to hold"):
            self.op = "held"
            self.hold_state = True
        else:
            self.stopped = True
        if op == "blend" and self.hold_error:
            self.command_error = False  # CMD-19
            self.hold_error = False

    # ---- external input, emergency stop, end limits [chapter 6]

    def watch_external(self):
        """During an absolute or relative move: a controlled stop to a hold state."""
        if self.op == "move" and self.on(EXTERNAL):
            self.hold()

    def hold(self):
        """Ignored once the move is stopping anyway: on its last ramp, or with no step left to hold."""
        course = motion.stop(self.course, self.start_ns, self.starting_speed, self.deceleration, self.shape)
        stopping = self.course.at(self.start_ns)[2] == motion.DOWN
        if not stopping and course.last_step < self.course.last_step - 0.5:
            self.op = "stop to hold"
            self.resumable = True
            self.course = course

    def watch_encoder(self):
        """Encoder Move [chapter 4]: the external input makes a controlled stop, and so does the count."""
        if self.on(EXTERNAL):
            self.controlled_stop("encoder stop")
            return
        self.compare_counts(self.start_ns)

    def ahead(self, direction):
        """The end limit in a direction."""
        return CW_LIMIT if direction > 0 else CCW_LIMIT

    def obey_stop_inputs(self):
        if self.on(ESTOP):
            if self.in_motion():
                self.cut()
                self.input_error = True
            elif self.became(ESTOP):
                self.input_error = True
                self.resumable = False
            return
        if self.op == "homing":
            oracle_homing.obey_limits(self)
        elif self.op in ("manual", "manual stop", "registration", "registration end", "step to stop"):
            if self.on(self.ahead(self.direction)):
                self.cut()
                self.input_error = True
        elif self.in_motion():
            if self.on(CW_LIMIT | CCW_LIMIT):
                self.cut()
                self.input_error = True
        elif self.op == "held" and self.on(CW_LIMIT | CCW_LIMIT):
            self.resumable = False

    # ---- what it shows [chapter 6]

    def encoder(self, now_ns):
        """Current Encoder / Diagnostic Feedback value; 0 without either (A-89)."""
        if self.quadrature or self.diagnostic:
            return self.encoder_input(now_ns) + self.count_offset
        return 0

    def encoder_input(self, now_ns):
        """What the encoder inputs have counted: the encoder, or with the diagnostic wiring own steps."""
        if self.diagnostic and self.world.wired_back:
            return self.own_steps
        return self.world.counts(now_ns)

    def set_encoder(self, value):
        self.count_offset = value - self.encoder_input(self.start_ns)

    @property
    def image(self):
        """The eight input words."""
        if self.mode_config:
            live = MODE_CONFIG | MODULE_OK | (CONFIG_ERROR if self.config_error else 0)
            words = [self.mirror[0] & 0x1FFF | live, self.mirror[1] & 0xFFFF, *self.mirror[2:]]
            return [*words, 0, 0, *self.firmware]
        return [
            self.status_msw(),
            self.status_lsw(),
            *split_reported(self.position),
            *split_reported(self.encoder(self.now_ns)),
            *split_reported(self.captured),
        ]

    def status_msw(self):
        word = MODULE_OK
        word |= MOVING_CW if self.moving > 0 else 0
        word |= MOVING_CCW if self.moving < 0 else 0
        word |= HOLD_STATE if self.hold_state else 0
        word |= STOPPED if self.stopped else 0
        word |= AT_HOME if self.at_home else 0
        word |= ACCELERATING if self.ramp > 0 else 0
        word |= DECELERATING if self.ramp < 0 else 0
        word |= MOVE_COMPLETE if self.move_complete else 0
        word |= HOME_INVALID if self.home_invalid else 0
        word |= INVALID_PROFILE if self.invalid_profile else 0
        word |= POSITION_INVALID if self.position_invalid else 0
        word |= INPUT_ERROR if self.input_error else 0
        word |= COMMAND_ERROR if self.command_error else 0
        word |= CONFIG_ERROR if self.config_error else 0
        return word

    def status_lsw(self):
        word = self.active
        word |= ENC_FOLLOWER if self.op == "follower" else 0
        word |= BLEND_RUNNING if self.op in ("blend", "blend stop") else 0
        word |= BLEND_ACK if self.ack else 0
        word |= MIN_REG_NONZERO if self.minimum > 0 else 0
        word |= HOME_PROX_ECHO if self.echo else 0
        return word
