"""Encoder follower: steps = counts * multiplier / divisor, exactly [chapter 4, Encoder Follower].

At the end of each scan, its counts are added to the owed steps, which include fractions of a step.
With rates of zero, all owed steps are output at once, up to the module's 1 MHz.
Otherwise the step rate ramps, limited by the owed steps:

    v <= sqrt(2 * deceleration * owed)        so that it can stop on the last step
    v grows by no more than acceleration * tick

If the encoder does not turn and no step is owed, a scan changes nothing: the mode sleeps until
its words change or the encoder turns.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt, lcm
from typing import ClassVar

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, StatusLsw
from typing_extensions import override

from ....kinematics import MILLI, PICO
from ..amci3601_capabilities import Feature
from ..command_words import CommandWords
from ..latches import STOPPED
from ..operation import Host, Limits, Operation
from ..refusals import FOLLOWER, FOLLOWER_WORDS, MANUAL_BITS, refuse_if_broken
from .manual_move import MANUAL_BIT

FOLLOW = CommandLsw.ENC_FOLLOWER.value
RESET = CommandMsw.RESET_ERRORS.value


class EncoderFollower(Operation):
    """The encoder follower mode, from the rise of LSW bit 7 until the mode is left."""

    name: ClassVar[str] = "follower"
    limits: ClassVar[Limits] = Limits.EITHER
    status_lsw: ClassVar[int] = StatusLsw.ENC_FOLLOWER.value

    def __init__(self, host: Host, now_ns: int, command: CommandWords) -> None:
        super().__init__(host, now_ns)
        self.sense = 0  # +1 manual CW, -1 manual CCW, 0 neither
        self.is_left = False
        self._last_count = host.axis.encoder
        self._scan_ns = 1000 * host.options.input_scan_us
        self._top_speed_msps = host.profile.limits.speed * MILLI
        self._divisor = 1
        self._parts_per_step = 1  # a multiple of the divisor
        self._owed = 0  # in parts of a step, CW positive
        self._speed_msps = 0  # millisteps/s, CW positive
        self._phase = 0  # picosteps made toward the next step, CW positive
        self._at_rest = False  # whether the last scan changed nothing, so that the next won't either

    @property
    @override
    def over(self) -> bool:
        """Whether the mode has been left; it continues while the encoder is at rest."""
        return self.is_left

    # -- the words ----------------------------------------------------------------------------

    def _leave(self, now_ns: int, command: CommandWords) -> None:
        """End the mode; a command other than a reset is a fault."""
        if command.msw & MANUAL_BITS:
            self.host.fire(now_ns, "CMD-35")
        elif command.msw not in (0, RESET):
            self.host.fire(now_ns, "CMD-34")  # such as Hold with a command LSW of 0
        self.is_left = True

    @override
    def on_words(self, now_ns: int, command: CommandWords) -> None:
        """Check the words; any fault ends the mode (interpretation A-65)."""
        self._at_rest = False
        if self.is_left:
            return
        if not command.lsw & FOLLOW:
            self._leave(now_ns, command)
            return
        sense = next((sense for sense, bit in MANUAL_BIT.items() if command.msw & bit), 0)
        self.is_left = refuse_if_broken(self.host, now_ns, command, FOLLOWER_WORDS)
        if not self.is_left and sense * self.sense < 0:
            self.host.fire(now_ns, "CMD-33")
            self.is_left = True
        if self.is_left:
            return
        if sense and not self.sense:  # counts without a direction are not followed
            self._last_count = self.axis.encoder
        elif self.sense and not sense:
            self._owed = self._speed_msps = self._phase = 0
            self.shown_direction = self.shown_ramp = 0
        self.sense = sense

    @override
    def on_release(self, now_ns: int) -> None:
        """Leave the mode, because all bits count as 0."""
        self.is_left = True

    @override
    def on_end(self, now_ns: int) -> None:
        """Show STOPPED [chapter 6, The Stopped Bit 5]."""
        self.host.finish(now_ns, STOPPED, "left")

    # -- the steps ----------------------------------------------------------------------------

    @override
    def counts_from_ns(self, now_ns: int, turns_ns: int | None) -> int | None:
        """Return when the follower next reads counts: now, or at rest, when the encoder next turns.

        None while no direction is selected.
        """
        if not self.sense:
            return None
        return turns_ns if self._at_rest else now_ns

    @override
    def on_counts(self, now_ns: int, command: CommandWords) -> None:
        """Add the new counts, times word 2 and divided by word 3, to the owed steps; make due steps."""
        counts = self.axis.encoder
        new_counts = counts - self._last_count
        self._last_count = counts
        self.shown_direction = self.shown_ramp = 0
        self._divide_by(command.words[3])
        self._owed += self.sense * new_counts * command.words[2] * (self._parts_per_step // self._divisor)
        steps = self._steps_of_scan(self._scan_ns, command.words[6], command.words[7])
        moves = new_counts or steps or self._speed_msps or self._phase
        self._at_rest = not moves and _whole_steps(self._owed, self._parts_per_step) == 0
        if steps:
            self.shown_direction = 1 if steps > 0 else -1
            self.axis.pulse(now_ns, self.shown_direction, abs(steps))
            self._owed -= steps * self._parts_per_step

    def _divide_by(self, divisor: int) -> None:
        """Convert the owed steps exactly to fractions with a new divisor."""
        if divisor != self._divisor:
            owed = Fraction(self._owed, self._parts_per_step)
            self._divisor, self._parts_per_step = divisor, lcm(owed.denominator, divisor)
            self._owed = owed.numerator * (self._parts_per_step // owed.denominator)

    def _steps_of_scan(self, elapsed_ns: int, acceleration: int, deceleration: int) -> int:
        """Return the whole steps to make now, CW positive."""
        owed = _whole_steps(self._owed, self._parts_per_step)
        if acceleration == 0 and deceleration == 0:
            self._speed_msps = self._phase = 0
            steps_most = self._top_speed_msps * elapsed_ns // PICO
            return max(-steps_most, min(steps_most, owed))
        self._ramp_speed(owed, elapsed_ns, acceleration, deceleration)
        if owed:
            self.shown_direction = 1 if (self._speed_msps or owed) > 0 else -1  # also between two steps
        self._phase += self._speed_msps * elapsed_ns
        steps = _whole_steps(self._phase, PICO)
        # Never make more than the owed steps; opposite steps remain while the speed still reverses
        if owed >= 0 and self._speed_msps >= 0:
            steps = max(0, min(steps, owed))
        elif owed < 0 and self._speed_msps <= 0:
            steps = min(0, max(steps, owed))
        self._phase -= steps * PICO
        if owed == steps:
            self._phase = 0
        return steps

    def _ramp_speed(self, owed: int, elapsed_ns: int, acceleration: int, deceleration: int) -> None:
        """Ramp the speed toward the allowed speed, within the rates."""
        target = self._allowed_speed(owed, deceleration)
        speed_before = self._speed_msps
        is_growing = abs(target) > abs(speed_before) and target * speed_before >= 0
        rate = acceleration if is_growing else deceleration
        if rate == 0:
            self._speed_msps = target
            return
        change = rate * MILLI * MILLI * elapsed_ns // 1_000_000_000
        self._speed_msps = max(speed_before - change, min(speed_before + change, target))
        if 0 < change <= abs(target - speed_before):  # a smaller change only follows the encoder's speed
            self.shown_ramp = 1 if is_growing else -1

    def _allowed_speed(self, owed: int, deceleration: int) -> int:
        """Return the highest speed that allows a stop in the owed steps; the top speed without a ramp."""
        if deceleration == 0:
            speed = self._top_speed_msps if owed else 0
        else:
            speed = min(self._top_speed_msps, isqrt(2 * deceleration * 1000 * abs(owed) * MILLI * MILLI))
        return speed if owed >= 0 else -speed


def _whole_steps(parts: int, parts_per_step: int) -> int:
    """Return the whole steps in a number of parts, rounded toward zero."""
    return parts // parts_per_step if parts >= 0 else -(-parts // parts_per_step)


def obey_follower(host: Host, now_ns: int, command: CommandWords, previous: CommandWords) -> bool:
    """Enter the mode on the rise of LSW bit 7; return whether the words belong to the follower."""
    if isinstance(host.operation, EncoderFollower):
        return command.msw != RESET or bool(command.lsw & FOLLOW)
    if not host.firmware.follower:
        return False
    has_risen = command.lsw & FOLLOW and (previous.configures or not previous.lsw & FOLLOW)
    if not has_risen or host.state.locked:
        return False
    if refuse_if_broken(host, now_ns, command, FOLLOWER):
        return True
    if not host.refuse_if_unable(now_ns, Feature.FOLLOWER, command):
        host.accept(EncoderFollower(host, now_ns, command))
    return True
