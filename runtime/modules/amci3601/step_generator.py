"""The simulated axis; its steps are computed from formulas and move a machine.

The generator has at most one motion, a piecewise polynomial of time. It never loops over steps:
it calculates the instant of its next change, and the position at any instant.

The machine has its own true position, which is updated whenever the generator is advanced.
The switches and the encoder therefore follow the shaft, not the module's count.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from ...kinematics import FOREVER, PICO, AnyShape, Motion, Profile, Rate, Segment, stopping_distance
from ...kinematics import blend as plan_blend
from ...kinematics import change_speed as plan_speed_change
from ...kinematics import move as plan_move
from ...kinematics import register as plan_register
from ...kinematics import run as plan_run
from ...kinematics import single_step as plan_single_step
from ...kinematics import stop as plan_stop
from ...machine import Machine
from .amci3601_capabilities import Capabilities
from .axis_protocol import BlendProgram

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from scanrack.io_images.image import Image

    from ...loop.module import Words

NEVER = FOREVER


class AxisConfiguration(Protocol):
    """The part of a configuration that a step generator needs."""

    @property
    def starting_speed(self) -> int:
        """Starting speed, steps/s."""

    @property
    def encoder_counted(self) -> bool:
        """Whether the encoder words are updated."""

    @property
    def diagnostic_feedback(self) -> bool:
        """Whether the step outputs are counted instead of the encoder."""


class StepGenerator:
    """An `Axis` with computed steps that turn a `Machine`.

    Args:
        diagnostic_wiring: the step outputs are wired to the encoder inputs
            [chapter 1, Diagnostic Feedback Wiring].
    """

    capabilities = Capabilities()

    def __init__(self, machine: Machine, *, diagnostic_wiring: bool = False) -> None:
        self.machine = machine
        self._diagnostic_wiring = diagnostic_wiring
        self._configuration: AxisConfiguration | None = None
        self._start_sps = 1  # starting speed, steps/s
        # State at the last `advance`
        self.now_ns = 0
        self.position = 0  # steps
        self.motion: Motion | None = None
        self.segment: Segment | None = None  # segment of the motion at `now_ns`
        self._steps_made = 0  # steps of the present motion, as reported to the machine
        self._encoder_offset = 0  # encoder count of the image - count of the source
        self._last_encoder = 0  # encoder count when the encoder was last configured
        # Events of the present motion that an operation has requested
        self._watched_steps: int | None = None
        self._watched_counts: tuple[int, int] | None = None  # count and direction
        self._marker_watched = False
        self.marker_seen = False

    # -- present activity ---------------------------------------------------------------------

    @property
    def moving(self) -> bool:
        """Whether a motion is in progress."""
        return self.motion is not None

    @property
    def direction(self) -> int:
        """+1 CW, -1 CCW while moving, else 0."""
        return 0 if self.motion is None else self.motion.direction

    @property
    def ramp(self) -> int:
        """+1 accelerating, -1 decelerating, 0 constant speed or at rest."""
        return 0 if self.segment is None else self.segment.ramp

    @property
    def counting(self) -> bool:
        """Whether the encoder words of the image are updated."""
        return self._configuration is not None and self._configuration.encoder_counted

    @property
    def encoder(self) -> int:
        """Encoder or diagnostic count now; 0 if neither is configured (reading A-89)."""
        return self._source_counts() + self._encoder_offset if self.counting else 0

    def _source_counts(self) -> int:
        return self.position if self._counts_itself else self.machine.encoder_counts(self.now_ns)

    @property
    def _counts_itself(self) -> bool:
        """Whether the step outputs are counted instead of the encoder."""
        configuration = self._configuration
        return configuration is not None and configuration.diagnostic_feedback and self._diagnostic_wiring

    # -- time ---------------------------------------------------------------------------------

    def advance(self, now_ns: int) -> bool:
        """Advance count, machine and segment to `now_ns`; return whether the motion has ended."""
        self._look_for_markers(now_ns)
        self.now_ns = now_ns
        motion = self.motion
        if motion is None:
            return False
        steps = motion.steps_at(now_ns)
        self._make_steps(motion, steps)
        if motion.end_ns is not None and now_ns >= motion.end_ns:
            self._end(now_ns)
            return True
        self.segment = motion.segment_at(now_ns)
        return False

    def _make_steps(self, motion: Motion, steps: int) -> None:
        """Update the machine and the position to a total of `steps` steps of the motion."""
        new_steps = steps - self._steps_made
        if new_steps:
            if self._marker_watched and not self.marker_seen:
                marker_steps = self.machine.steps_to_marker(motion.direction)
                self.marker_seen = marker_steps is not None and marker_steps <= new_steps
            self.machine.follow(motion.direction, new_steps, self.now_ns)
            self._steps_made = steps
            self.position = motion.origin + motion.direction * steps

    def _look_for_markers(self, now_ns: int) -> None:
        """Detect marker pulses from the bench; pulses from the shaft are detected as it turns."""
        if self._marker_watched and not self.marker_seen:
            pulse_ns = self.machine.next_marker_ns(self.now_ns)
            self.marker_seen = pulse_ns is not None and pulse_ns <= now_ns

    def _end(self, now_ns: int) -> None:
        """Forget the motion and the events requested in it, and let the machine rest."""
        self.motion = None
        self.segment = None
        self._steps_made = 0
        self._watched_steps = self._watched_counts = None
        self._marker_watched = False
        self.machine.rest(now_ns)

    def next_change_ns(self) -> int:
        """Return the instant at which the ramp state next changes or the motion ends, or NEVER."""
        return NEVER if self.segment is None else self.segment.until_ns

    def next_input_ns(self) -> int:
        """Return the instant of the next change of an input or of a watched event."""
        now_ns, machine = self.now_ns, self.machine
        instants = [machine.next_change_ns(now_ns)]
        if self.motion is not None:
            direction = self.motion.direction
            instants.append(self._instant_after(machine.steps_to_switch(direction)))
            if self._watched_steps is not None:
                instants.append(self._instant_after(self._watched_steps - self._steps_made))
            if self._watched_counts is not None:
                instants += self._instants_of_counts(*self._watched_counts)
            if self._marker_watched:
                instants.append(self._instant_after(machine.steps_to_marker(direction)))
                instants.append(machine.next_marker_ns(now_ns))
        return min((instant for instant in instants if instant is not None), default=NEVER)

    def _instant_after(self, steps: int | None) -> int | None:
        """Return the instant at which the motion has made `steps` more steps, None if it never does."""
        if steps is None or self.motion is None or steps <= 0:
            return None
        return self.motion.instant_of(self._steps_made + steps)

    def _instants_of_counts(self, counts: int, direction: int) -> list[int | None]:
        """Return the instants at which the encoder reaches `counts`, or must be checked again."""
        goal_counts = counts - self._encoder_offset
        if (self._source_counts() - goal_counts) * direction >= 0:
            return []
        if self.machine.turning(self.now_ns):
            return [self.now_ns + 1]  # motor and hand turn the shaft together: check at every tick
        assert self.motion is not None
        steps = self.machine.steps_to_counts(self.motion.direction, goal_counts, self.now_ns)
        return [self._instant_after(steps)]

    def watch_steps(self, steps: int) -> None:
        """Request a tick as soon as the motion has made `steps` steps."""
        self._watched_steps = steps

    def watch_counts(self, counts: int, direction: int) -> None:
        """Request a tick as soon as the encoder reaches `counts`, or passes it in `direction`."""
        self._watched_counts = counts, direction

    def watch_marker(self) -> None:
        """Request a tick at the next marker pulse; ignore earlier pulses."""
        self._marker_watched = True
        self.marker_seen = False

    def instant_after(self, steps: int | None) -> int:
        """Return the instant at which the motion has made `steps` more steps, or NEVER."""
        instant = self._instant_after(steps)
        return NEVER if instant is None else instant

    # -- prediction ---------------------------------------------------------------------------

    def counts_calm_until_ns(self) -> int:
        """Return an instant before which the counts follow the motor one to one, or 0 if they don't."""
        if self._counts_itself:
            return NEVER
        turns_ns = self.machine.turns_ns(self.now_ns)
        if turns_ns == self.now_ns:
            return 0
        calm_until_ns = NEVER if turns_ns is None else turns_ns
        if self.motion is None:
            return calm_until_ns
        free_steps = self.machine.free_steps(self.motion.direction)
        slip_ns = self._instant_after(free_steps + 1) if free_steps else 0
        return calm_until_ns if slip_ns is None else min(slip_ns, calm_until_ns)

    def shaft_calm_until_ns(self, first: int | None, last: int | None) -> int:
        """Return an instant before which the shaft does not enter or leave positions `first` to `last`."""
        if self.motion is None:
            return NEVER
        direction, shaft = self.motion.direction, self.machine.shaft
        bounds = [] if first is None else [first]
        if last is not None:
            bounds.append(last + 1)
        if direction > 0:
            nearest = min((bound for bound in bounds if bound > shaft), default=None)
        else:
            nearest = max((bound - 1 for bound in bounds if bound <= shaft), default=None)
        return (
            NEVER if nearest is None else self.instant_after(self.machine.steps_to_shaft(direction, nearest))
        )

    def levels_calm_until_ns(self) -> int:
        """Return an instant before which no input's level changes."""
        acts_ns = self.machine.acts_next_ns
        if self.motion is None:
            return acts_ns
        return min(acts_ns, self.instant_after(self.machine.steps_to_switch(self.motion.direction)))

    def positions_at_all(self, first_ns: int, every_ns: int, count: int) -> NDArray[np.int64]:
        """Return the positions at many instants within the present segment, or at rest."""
        from ...kinematics.series import steps_at_all

        assert self.motion is not None
        assert self.segment is not None
        steps = steps_at_all(self.segment, first_ns, every_ns, count)
        return self.motion.origin + self.motion.direction * steps

    def encoders_at_all(self, positions: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the counts at positions that are reached before `counts_calm_until_ns`."""
        if self._counts_itself:
            return positions + self._encoder_offset
        shafts = positions + (self.machine.shaft - self.position)
        return self.machine.encoder_counts_all(shafts, self.now_ns) + self._encoder_offset

    # -- commands -----------------------------------------------------------------------------

    def configure(self, configuration: AxisConfiguration | None) -> None:
        """Adopt an accepted configuration; the encoder continues from its last count."""
        if self.counting:
            self._last_encoder = self.encoder
        self._configuration = configuration
        if configuration is not None:
            self._start_sps = configuration.starting_speed
        self._encoder_offset = self._last_encoder - self._source_counts()

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""
        self._begin(plan_move(now_ns, self.position, distance, profile))

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a single step at `speed_sps`."""
        self._begin(plan_single_step(now_ns, self.position, direction, speed_sps))

    def pulse(self, now_ns: int, direction: int, steps: int = 1) -> None:
        """Output step pulses at once."""
        self.machine.follow(direction, steps, now_ns)
        self.position += direction * steps
        self.machine.rest(now_ns)

    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        """Start a motion that lasts until it is stopped; `registration` has no effect."""
        self._begin(plan_run(now_ns, self.position, direction, profile))

    def _begin(self, motion: Motion) -> None:
        self.machine.depart(motion.start_ns)
        self.motion = motion
        self._steps_made = 0
        self.segment = motion.segment_at(motion.start_ns)

    def home(self, now_ns: int, direction: int, profile: Profile) -> None:
        """Raise NotImplementedError, because the command layer finds home with the other motions."""
        raise NotImplementedError

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Ramp from the present speed to the profile's speed."""
        if self.motion is not None:
            self._replace(
                now_ns,
                plan_speed_change(
                    self.motion,
                    now_ns,
                    profile.speed_sps,
                    profile.acceleration_spmss,
                    profile.deceleration_spmss,
                    profile.shape,
                ),
            )

    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """End the motion after exactly `steps` more whole steps, deceleration included."""
        if self.motion is not None:
            start, speed = self._start_sps, self.motion.speed_at(now_ns)
            stopping_steps = -(-stopping_distance(speed, start, deceleration_spmss, shape) // PICO)
            steps = max(steps, stopping_steps)  # the ramp's rounded time can need one step more
            self._replace(now_ns, plan_register(self.motion, now_ns, steps, start, deceleration_spmss, shape))

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Start a blend move through all segments of a stored program."""
        self._begin(
            plan_blend(
                now_ns,
                self.position,
                direction,
                self._start_sps,
                program.segments,
                program.final_deceleration,
                program.final_shape,
            )
        )

    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Begin a controlled stop on a whole step.

        A motion on its last ramp continues with this ramp, unless the new ramp ends sooner. Every other
        motion begins to brake now, even if it needs more steps than the move had left (reading A-111).
        """
        if self.motion is None:
            return
        stopped = plan_stop(self.motion, now_ns, self._start_sps, deceleration_spmss, shape)
        planned_steps = self.motion.final_steps
        assert stopped.final_steps is not None
        ends_sooner = planned_steps is None or stopped.final_steps < planned_steps
        if ends_sooner or not self.motion.on_last_ramp(now_ns):
            self._replace(now_ns, stopped)

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the number of steps of a controlled stop that begins now."""
        if self.motion is None:
            return 0
        stopped = plan_stop(self.motion, now_ns, self._start_sps, deceleration_spmss, shape)
        assert stopped.final_steps is not None
        return stopped.final_steps - self._steps_made

    def _replace(self, now_ns: int, motion: Motion) -> None:
        """Continue the present motion with a new plan; its step count continues."""
        self.motion = motion
        if motion.end_ns is not None and now_ns >= motion.end_ns:
            self._end(now_ns)
        else:
            self.segment = motion.segment_at(now_ns)

    def cut(self, now_ns: int) -> None:
        """End the step output at once; the steps made so far remain counted."""
        if self.motion is not None:
            self._end(now_ns)

    def preset_position(self, value: int) -> None:
        """Set the present position to `value`; the encoder or diagnostic count is not changed."""
        encoder_count = self.encoder
        self.position = value
        self.preset_encoder(encoder_count)

    def preset_encoder(self, value: int) -> None:
        """Set the present encoder count to `value`."""
        self._encoder_offset = value - self._source_counts()

    def reset_errors(self) -> None:
        """Do nothing, because a step generator has no errors."""


class SteppedModule:
    """The machine and the predictions of a module with a step generator; see `ForeseeingModule`."""

    axis: StepGenerator
    machine: Machine
    before_change: Callable[[], None]
    _now_ns: int  # the last `update`
    _tick_ns: int  # the module's scan
    _due_ns: int  # until this instant only position and count change
    _counting: bool  # whether the image shows the encoder's counts
    _segment: Segment | None  # the segment whose position the image shows
    _acted_on: bytes | None  # the output words that were obeyed

    def calm_until_ns(self, outputs: Image) -> int:
        """Return an instant before which only position and count change."""
        if outputs.raw.tobytes() != self._acted_on:
            return 0
        return min(self._due_ns, self.axis.counts_calm_until_ns()) if self._counting else self._due_ns

    def foretell(self, first_ns: int, every_ns: int, count: int) -> Words:
        """Return position and count at instants before `calm_until_ns`."""
        if self._segment is None:
            return {}
        positions = self.axis.positions_at_all(first_ns, every_ns, count)
        words = dict(zip((2, 3), self._split_all(positions), strict=True))
        if self._counting:
            words |= zip((4, 5), self._split_all(self.axis.encoders_at_all(positions)), strict=True)
        return words

    def _split_all(self, values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the upper and the lower words of positions or counts."""
        raise NotImplementedError

    def machine_at(self, now_ns: int) -> Machine:
        """Return the machine in its state at `now_ns`, the instant of the last `update`."""
        self.axis.advance(now_ns)
        return self.machine

    def figures(self) -> tuple[int, int, int]:
        """Return shaft position, encoder counts and energized inputs at the last `update`."""
        self.before_change()
        machine = self.machine_at(self._now_ns)
        return machine.shaft, machine.encoder_counts(self._now_ns), machine.shown

    def _tick_at_or_after(self, instant_ns: int) -> int:
        return -(-instant_ns // self._tick_ns) * self._tick_ns

    def shaft_calm_until_ns(self, first: int | None, last: int | None) -> int:
        """Return an instant before which the shaft does not enter or leave positions `first` to `last`."""
        self.axis.advance(self._now_ns)
        return self.axis.shaft_calm_until_ns(first, last)

    def levels_calm_until_ns(self) -> int:
        """Return an instant before which no level of the machine's inputs changes."""
        self.axis.advance(self._now_ns)
        return self.axis.levels_calm_until_ns()
