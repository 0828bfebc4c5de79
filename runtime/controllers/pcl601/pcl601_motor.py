"""The axis: motions from start to end, and how they react to limits, switches and marks.

The table in `activities` lists the activities and how they end.

Nothing is sampled. `next_event_ns` returns the next instant at which the caller must call `settle`: a step at
which an input can change, the end of a motion, or a timer. Between events, a motion is a closed form of time.
"""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.pcl601 import POSITION_LIMIT, Error, Register
from scanrack.io_images.pcl601.terminals import HARD_LIMITS, SOFT_LIMITS

from ...kinematics import Motion, go_on, move, run
from .activities import HOMING, SLOWED_ONCE, AxisActivity
from .autocorrect import Autocorrect
from .fly import OutputOnFly
from .jog import JogInputs
from .motor import Motor
from .pins import Pcl601Pins
from .register_values import Values
from .speeds import Pcl601Speeds

MSPS = 1000
"""Number of motion speed units (1e-3 step/s) in one step/s."""


class SimulatedPcl601Axis:
    """The axis of a PCL601.

    Attributes:
        activity: the current activity, None when idle.
        direction: direction of the current or last motion, +1 or -1.

    Args:
        values: the registers, which contain position and encoder count.
        report: function that sets an error bit.
        retries_failed: function that switches output 8 on.
    """

    def __init__(
        self,
        values: Values,
        pins: Pcl601Pins,
        motor: Motor,
        report: Callable[[Error], None],
        retries_failed: Callable[[], None],
    ) -> None:
        self.activity: AxisActivity | None = None
        self.direction = 1
        self.fly = OutputOnFly()
        self.jog = JogInputs(pins, motor)
        self.speeds = Pcl601Speeds(values)
        self._values, self._pins, self._motor = values, pins, motor
        self._report, self._retries_failed = report, retries_failed
        self._motion: Motion | None = None
        self._registration = 0  # steps of a slew after its mark, 0 without a mark
        self._jog_sps = 0  # present speed of a jog
        self._clear()

    def _clear(self) -> None:
        """Reset the state of a motion."""
        self._steps_made = 0
        self._halt_steps: int | None = None  # steps after which the motion is cut
        self._slowed = False  # a soft limit or soft stop has slowed the motion
        self._timer_ns = 0  # end of the encoder's delay
        self._autocorrect: Autocorrect | None = None
        self._has_met_home = False  # HOME_1_BACK has seen the home limit closed

    # commands

    @property
    def busy(self) -> bool:
        """Whether a motion is in progress, including the encoder's delay and corrections."""
        return self.activity is not None

    def steps_in_range(self, direction: int) -> int:
        """Return the steps to the end of the position's range in a direction; 0 outside the range."""
        position = self._values[Register.POSITION]
        return POSITION_LIMIT - direction * position if abs(position) <= POSITION_LIMIT else 0

    def index(self, now_ns: int, distance: int) -> None:
        """Begin an index move over a nonzero distance in steps, unless a hard limit blocks it."""
        direction = 1 if distance > 0 else -1
        self._set_direction(direction)
        if self._at_limit(HARD_LIMITS, direction):
            return
        self._begin(AxisActivity.INDEX, direction, move(now_ns, 0, distance, self.speeds.profile()))
        self._motor.begin_index()
        self.fly.begin(self._values, direction)
        if self._values[Register.ENCODER_AUTOCORRECT]:
            self._autocorrect = Autocorrect(self._values, distance)

    def slew(self, now_ns: int) -> None:
        """Start to slew in the direction set by the direction register."""
        self._begin_endless(now_ns, AxisActivity.SLEW)
        values = self._values
        self._registration = values[Register.STEPS] if values[Register.INDEX_ON_FLY] else 0

    def home(self, now_ns: int, activity: AxisActivity) -> None:
        """Start homing, as `HOME_0` or `HOME_1`, in the direction set by the direction register."""
        self._begin_endless(now_ns, activity)

    def stop_hard(self) -> None:
        """End any motion at once."""
        if self.activity is AxisActivity.JOG:
            self.jog.wait_for_release()
        self._end()

    def stop_soft(self, now_ns: int) -> None:
        """Slow down to base speed; the activity decides how the motion ends."""
        if self.activity is AxisActivity.JOG:
            self.jog.wait_for_release()
        elif self.activity in SLOWED_ONCE and not self._slowed:
            self._slow(now_ns)

    def power_off(self) -> None:
        """Stop at the current position, as a loss of power does."""
        self._end()
        self.fly.power_off()
        self.jog.wait_for_release(False)

    # time

    def advance(self, now_ns: int) -> None:
        """Make the steps up to `now_ns`, which must not be after `next_event_ns`."""
        if self._motion is not None:
            steps = self._motion.steps_at(now_ns)
            if self._halt_steps is not None:
                steps = min(steps, self._halt_steps)
            if steps > self._steps_made:
                self._turn(steps - self._steps_made)
                self._steps_made = steps

    def _turn(self, steps: int) -> None:
        """Turn the motor by clock pulses; update the position and encoder registers."""
        self._values[Register.ENCODER_POSITION] += self._motor.turn(self.direction, steps)
        if self.activity is not AxisActivity.CORRECTION:  # the register keeps the commanded position
            self._values[Register.POSITION] += self.direction * steps

    def next_event_ns(self) -> int | None:
        """Return the instant at which `settle` must run again, or None."""
        instants = [self.fly.until_ns]
        if self.activity is AxisActivity.SETTLING:
            instants.append(self._timer_ns)
        elif self._motion is not None:
            instants.append(self._motion.end_ns)
            instants += [self._motion.instant_of(steps) for steps in self._steps_with_events()]
        return min((instant for instant in instants if instant is not None), default=None)

    def _steps_with_events(self) -> list[int]:
        """Return the step numbers of the motion at which an event is possible."""
        steps = []
        edge = self._pins.next_edge(self._motor.position, self.direction)
        if edge is not None:
            steps.append(self._steps_made + self._motor.steps_to(edge))
        if self.activity is not AxisActivity.CORRECTION:
            steps.append(self._steps_made + self.steps_in_range(self.direction))
        if self.fly.next_position is not None:
            steps.append(self._steps_made + abs(self.fly.next_position - self._values[Register.POSITION]))
        if self.activity is AxisActivity.SLEW and self._steps_made == 0:
            steps.append(1)  # a mark that is active at the start acts at the first step
        if self._halt_steps is not None:
            steps.append(self._halt_steps)
        return steps

    def settle(self, now_ns: int) -> bool:
        """Handle one event if due; return whether one was due."""
        if self.fly.settle(now_ns, self._values[Register.POSITION]):
            return True
        if self.activity is None:
            return self._jog_from_rest(now_ns)
        if self.activity is AxisActivity.SETTLING:
            return self._check_encoder(now_ns)
        if self._is_over(now_ns):
            self._finish(now_ns)
            return True
        if self._at_limit(HARD_LIMITS, self.direction):
            self._hit_hard_limit(now_ns)
            return True
        if self.activity is not AxisActivity.CORRECTION and self.steps_in_range(self.direction) == 0:
            self._report(Error.RANGE)
            self.stop_hard()
            return True
        return self._react_to_inputs(now_ns)

    def _is_over(self, now_ns: int) -> bool:
        """Return whether the motion has made its last step, or has reached the step at which it is cut."""
        if self._halt_steps is not None:
            return self._steps_made >= self._halt_steps
        end_ns = self._motion.end_ns if self._motion is not None else now_ns
        return end_ns is not None and now_ns >= end_ns

    # events during a motion

    def _react_to_inputs(self, now_ns: int) -> bool:
        """React to home, the mark, a soft limit or a jog input; return whether there was a reaction."""
        activity = self.activity
        if activity is AxisActivity.JOG:
            return self._continue_jog(now_ns)
        if activity in HOMING and self._react_to_home(now_ns):
            return True
        if activity is AxisActivity.SLEW and not self._slowed and self._mark_is_active():
            self._register(now_ns)
            return True
        if activity in SLOWED_ONCE and not self._slowed and self._at_limit(SOFT_LIMITS, self.direction):
            self._slow(now_ns)
            return True
        return False

    def _react_to_home(self, now_ns: int) -> bool:
        """React to the home limit; return whether this ended or slowed the motion.

        `HOME_1_BACK` ends where the limit opens after it has been closed, since the motor may have overshot
        it.
        """
        at_home = self._pins.grounded("home", self._motor.position)
        if self.activity is AxisActivity.HOME_0 and at_home:
            self._end()
            return True
        if self.activity is AxisActivity.HOME_1 and at_home:
            self._stop(now_ns, AxisActivity.HOME_1_STOP)
            return True
        if self.activity is AxisActivity.HOME_1_BACK:
            if not at_home and self._has_met_home:
                self._end()
                return True
            self._has_met_home = at_home or self._has_met_home
        return False

    def _mark_is_active(self) -> bool:
        """Return whether input 2 is active in a slew with registration, after its first step."""
        grounded = self._pins.grounded("in2", self._motor.position)
        return grounded and self._registration > 0 and self._steps_made > 0

    def _register(self, now_ns: int) -> None:
        """Continue for a set number of steps after the mark, ramp included; cut a ramp that does not fit."""
        self.activity = AxisActivity.REGISTERED
        try:
            self._motion = go_on(self._running, now_ns, self._registration, self.speeds.profile())
        except ValueError:  # the steps are fewer than the ramp down needs
            self._motion = self.speeds.change(self._running, now_ns, self.speeds.base_sps)
            self._halt_steps = self._steps_made + self._registration

    def _slow(self, now_ns: int) -> None:
        """Ramp down to base speed and continue as the activity requires."""
        self._slowed = True
        if self.activity is AxisActivity.SLEW:
            self._stop(now_ns, AxisActivity.STOPPING)
        elif self.activity in HOMING:
            self._motion = self.speeds.change(self._running, now_ns, self.speeds.base_sps)
        elif self._halt_steps is None:
            self._motion = self.speeds.creep(self._running, now_ns)

    def _stop(self, now_ns: int, activity: AxisActivity) -> None:
        """Ramp down to base speed and stop; at base speed, stop at once."""
        self.activity = activity
        if self._running.speed_at(now_ns) <= self.speeds.base_sps * MSPS:
            self._halt_steps = self._steps_made
        else:
            self._motion = self.speeds.stop(self._running, now_ns)

    def _hit_hard_limit(self, now_ns: int) -> None:
        """End the motion; after a correction, check the encoder again."""
        if self.activity is AxisActivity.CORRECTION:
            self._begin_settling(now_ns)
        else:
            self._end()

    def _finish(self, now_ns: int) -> None:
        """Continue after the last step: back off from home, check the encoder, or end."""
        if self.activity is AxisActivity.HOME_1_STOP:
            back_off = run(now_ns, 0, -self.direction, self.speeds.at_base())
            self._begin(AxisActivity.HOME_1_BACK, -self.direction, back_off)
        elif self._autocorrect is not None:
            self._begin_settling(now_ns)
        else:
            self._end()

    # encoder

    def _begin_settling(self, now_ns: int) -> None:
        """End the motion, and wait for the encoder's delay before the check."""
        autocorrect = self._autocorrect
        self._end()
        if autocorrect is not None:
            self._autocorrect = autocorrect
            self.activity = AxisActivity.SETTLING
            self._timer_ns = now_ns + autocorrect.delay_ns

    def _check_encoder(self, now_ns: int) -> bool:
        """After the delay, end the move or correct it; return whether the delay is over."""
        if now_ns < self._timer_ns or self._autocorrect is None:
            return False
        autocorrect = self._autocorrect
        steps_missing = autocorrect.missing(self._values[Register.ENCODER_POSITION])
        if steps_missing is None:
            self._end()
        elif autocorrect.retries_left == 0:
            self._report(Error.ENCODER_FAILED)
            self._retries_failed()
            self._end()
        else:
            autocorrect.retries_left -= 1
            self._report(Error.ENCODER_CORRECTED)
            self._correct_by(now_ns, steps_missing)
        return True

    def _correct_by(self, now_ns: int, steps: int) -> None:
        """Begin a correction by signed steps at base speed.

        Without steps, or against a hard limit, wait for the next check, which counts as a retry.
        """
        autocorrect = self._autocorrect
        self._values[Register.STEPS] = abs(steps)  # the STEPS register shows the correction
        direction = 1 if steps > 0 else -1
        if steps == 0 or self._at_limit(HARD_LIMITS, direction):
            self._begin_settling(now_ns)
            return
        self._begin(AxisActivity.CORRECTION, direction, move(now_ns, 0, steps, self.speeds.at_base()))
        self._autocorrect = autocorrect  # `_begin` has cleared it

    # jog

    def _jog_from_rest(self, now_ns: int) -> bool:
        """Begin to jog if an input selects a direction and nothing prevents it; return whether it began."""
        direction = self.jog.selected()
        if direction == 0:
            return False
        if self.steps_in_range(direction) == 0:
            self._report(Error.RANGE)
            return False
        if not self.speeds.fit(Register.JOG_SPEED):
            self._report(Error.MOTOR)
            return False
        self._set_direction(direction)
        self._begin(AxisActivity.JOG, direction, run(now_ns, 0, direction, self.speeds.at_base()))
        self._jog_sps = self.speeds.base_sps
        return True

    def _continue_jog(self, now_ns: int) -> bool:
        """Stop a jog whose direction has changed, or change its speed; return whether either was due."""
        if self.jog.selected() != self.direction:
            self._stop(now_ns, AxisActivity.STOPPING)
            return True
        speed_sps = self.speeds.jog_sps if self.jog.fast else self.speeds.base_sps
        if speed_sps == self._jog_sps:
            return False
        self._motion = self.speeds.change(self._running, now_ns, speed_sps)
        self._jog_sps = speed_sps
        return True

    # parts

    def _begin_endless(self, now_ns: int, activity: AxisActivity) -> None:
        """Begin a motion in the direction of the register, unless a hard limit blocks it."""
        direction = 1 if self._values[Register.DIRECTION] else -1
        if not self._at_limit(HARD_LIMITS, direction):
            self._begin(activity, direction, run(now_ns, 0, direction, self.speeds.profile()))

    def _begin(self, activity: AxisActivity, direction: int, motion: Motion) -> None:
        """Begin a motion with a cleared state."""
        self._clear()
        self.activity, self.direction, self._motion = activity, direction, motion

    def _end(self) -> None:
        """End the motion; the current pulse on the fly continues."""
        self._motor.end_motion()
        self.fly.end()
        self._clear()
        self.activity = self._motion = None

    def _set_direction(self, direction: int) -> None:
        self._values[Register.DIRECTION] = int(direction > 0)

    def _at_limit(self, limits: dict[int, str], direction: int) -> bool:
        return self._pins.grounded(limits[direction], self._motor.position)

    @property
    def _running(self) -> Motion:
        """The current motion; reading it at rest is an error."""
        if self._motion is None:
            raise AssertionError("no motion is running")
        return self._motion
