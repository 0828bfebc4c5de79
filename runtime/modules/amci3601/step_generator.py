"""The simulated axis: steps in closed form, and a machine that they move.

The generator holds at most one motion (a piecewise polynomial of time) and
never loops over steps: it gives the instant of its next change, and the position
at any instant.

The machine keeps its own, true position. It is updated whenever the
generator is advanced, so that switches and encoder follow the shaft and not
the module's count.
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
        """Whether the encoder words are live."""

    @property
    def diagnostic_feedback(self) -> bool:
        """Whether the step outputs give the counts."""


class StepGenerator:
    """An `Axis` whose steps are computed and whose motor turns a `Machine`.

    Args:
        diagnostic_wiring: the step outputs are wired to the encoder inputs
            [chapter 1, Diagnostic Feedback Wiring].
    """

    capabilities = Capabilities()

    def __init__(self, machine: Machine, *, diagnostic_wiring: bool = False) -> None:
        self.machine = machine
        self.position = 0
        self.motion: Motion | None = None
        self.segment: Segment | None = None
        self._diagnostic_wiring = diagnostic_wiring
        self._configuration: AxisConfiguration | None = None
        self._start_sps = 1
        self._steps_made = 0  # steps of the present motion, as reported to the machine
        self.now_ns = 0
        self._encoder_offset = 0
        self._encoder_held = 0
        self._watched_steps: int | None = None
        self._watched_counts: tuple[int, int] | None = None
        self._marker_watched = False
        self.marker_seen = False

    # -- present activity ---------------------------------------------------------------------

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
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
        """Whether the encoder words of the image are live."""
        return self._configuration is not None and self._configuration.encoder_counted

    @property
    def encoder(self) -> int:
        """Encoder or diagnostic count now; 0 where neither is configured (reading A-89)."""
        return self._source_counts() + self._encoder_offset if self.counting else 0

    def _source_counts(self) -> int:
        return self.position if self._counts_itself else self.machine.encoder_counts(self.now_ns)

    @property
    def _counts_itself(self) -> bool:
        """Whether the step outputs, instead of the shaft, give the counts."""
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
        self._count(motion, steps)
        if motion.end_ns is not None and now_ns >= motion.end_ns:
            self._end(now_ns)
            return True
        self.segment = motion.segment_at(now_ns)
        return False

    def _count(self, motion: Motion, steps: int) -> None:
        new_steps = steps - self._steps_made
        if new_steps:
            if self._marker_watched:
                marker_steps = self.machine.steps_to_marker(motion.direction)
                self.marker_seen = self.marker_seen or (
                    marker_steps is not None and marker_steps <= new_steps
                )
            self.machine.follow(motion.direction, new_steps, self.now_ns)
            self._steps_made = steps
            self.position = motion.origin + motion.direction * steps

    def _look_for_markers(self, now_ns: int) -> None:
        """Detect marker pulses from the bench; pulses of the shaft are detected as it turns."""
        if self._marker_watched and not self.marker_seen:
            pulse_ns = self.machine.next_marker_ns(self.now_ns)
            self.marker_seen = pulse_ns is not None and pulse_ns <= now_ns

    def _end(self, now_ns: int) -> None:
        self.motion = None
        self.segment = None
        self._steps_made = 0
        self._watched_steps = self._watched_counts = None
        self._marker_watched = False
        self.machine.rest(now_ns)

    def next_change_ns(self) -> int:
        """Instant of the next change of the ramp state or of the motion's end, or NEVER."""
        return NEVER if self.segment is None else self.segment.until_ns

    def next_input_ns(self) -> int:
        """Return the instant of the next change of an input or of a watched event."""
        now_ns, machine = self.now_ns, self.machine
        instants = [machine.next_change_ns(now_ns)]
        if self.motion is not None:
            direction = self.motion.direction
            instants.append(self._when_made(machine.steps_to_switch(direction)))
            if self._watched_steps is not None:
                instants.append(self._when_made(self._watched_steps - self._steps_made))
            if self._watched_counts is not None:
                instants += self._when_counted(*self._watched_counts)
            if self._marker_watched:
                instants.append(self._when_made(machine.steps_to_marker(direction)))
                instants.append(machine.next_marker_ns(now_ns))
        return min((instant for instant in instants if instant is not None), default=NEVER)

    def _when_made(self, steps: int | None) -> int | None:
        if steps is None or self.motion is None or steps <= 0:
            return None
        return self.motion.instant_of(self._steps_made + steps)

    def _when_counted(self, counts: int, direction: int) -> list[int | None]:
        """Return the instants at which the encoder reaches `counts`, or must be checked again."""
        source_counts = counts - self._encoder_offset
        if (self._source_counts() - source_counts) * direction >= 0:
            return []
        if self.machine.turning(self.now_ns):
            return [self.now_ns + 1]  # by hand and by the shaft at once: check at every tick
        assert self.motion is not None
        sense = self.motion.direction
        return [self._when_made(self.machine.steps_to_counts(sense, source_counts, self.now_ns))]

    def watch_steps(self, steps: int) -> None:
        """Request a tick when the motion has made `steps` steps."""
        self._watched_steps = steps

    def watch_counts(self, counts: int, direction: int) -> None:
        """Request a tick when the encoder has reached `counts`, or passed it in `direction`."""
        self._watched_counts = counts, direction

    def watch_marker(self) -> None:
        """Request a tick at the next marker pulse; ignore earlier ones."""
        self._marker_watched = True
        self.marker_seen = False

    def instant_after(self, steps: int) -> int:
        """Return the instant at which the motion will have made a number of steps more, or NEVER."""
        instant = self._when_made(steps)
        return NEVER if instant is None else instant

    # -- prediction ---------------------------------------------------------------------------

    def counts_calm_until_ns(self) -> int:
        """Return the instant before which the counts follow the motor one to one; 0 if they don't."""
        if self._counts_itself:
            return NEVER
        turns_ns = self.machine.turns_ns(self.now_ns)
        if turns_ns == self.now_ns:
            return 0
        still_ns = NEVER if turns_ns is None else turns_ns
        if self.motion is None:
            return still_ns
        free_steps = self.machine.free_steps(self.motion.direction)
        slip_ns = self._when_made(free_steps + 1) if free_steps else 0
        return still_ns if slip_ns is None else min(slip_ns, still_ns)

    def shaft_calm_until_ns(self, first: int | None, last: int | None) -> int:
        """Return the instant before which the shaft does not enter or leave positions `first` to `last`."""
        if self.motion is None:
            return NEVER
        direction, shaft = self.motion.direction, self.machine.shaft
        bounds = [bound for bound in (first, None if last is None else last + 1) if bound is not None]
        if direction > 0:
            end_positions = [bound for bound in bounds if bound > shaft]
        else:
            end_positions = [bound - 1 for bound in bounds if bound <= shaft]
        nearest = min(end_positions, key=lambda end: abs(end - shaft), default=None)
        steps = None if nearest is None else self.machine.steps_to_shaft(direction, nearest)
        instant = self._when_made(steps)
        return NEVER if instant is None else instant

    def levels_calm_until_ns(self) -> int:
        """Return the instant before which no input's level changes."""
        instant = None
        if self.motion is not None:
            instant = self._when_made(self.machine.steps_to_switch(self.motion.direction))
        acts_ns = self.machine.acts_next_ns
        return acts_ns if instant is None else min(instant, acts_ns)

    def positions_at_all(self, first_ns: int, every_ns: int, count: int) -> NDArray[np.int64]:
        """Return the positions at many instants within the present segment, or at rest."""
        from ...kinematics.series import steps_at_all

        assert self.motion is not None
        assert self.segment is not None
        steps = steps_at_all(self.segment, first_ns, every_ns, count)
        return self.motion.origin + self.motion.direction * steps

    def encoders_at_all(self, positions: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the counts at positions, all before `counts_calm_until_ns`."""
        if self._counts_itself:
            return positions + self._encoder_offset
        shafts = positions + (self.machine.shaft - self.position)
        return self.machine.encoder_counts_all(shafts, self.now_ns) + self._encoder_offset

    # -- commands -----------------------------------------------------------------------------

    def configure(self, configuration: AxisConfiguration | None) -> None:
        """Adopt an accepted configuration; the encoder continues from its last count."""
        self._encoder_held = self.encoder if self.counting else self._encoder_held
        self._configuration = configuration
        if configuration is not None:
            self._start_sps = configuration.starting_speed
        self._encoder_offset = self._encoder_held - self._source_counts()

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""
        self._begin(plan_move(now_ns, self.position, distance, profile))

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a motion of a single step at `speed_sps`."""
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
        """Raise: the generator only makes steps; the command layer finds home."""
        raise NotImplementedError

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Ramp from the present speed to the profile's."""
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
            enough = max(steps, stopping_steps)  # rounding of the ramp's time never costs the move
            self._replace(
                now_ns, plan_register(self.motion, now_ns, enough, start, deceleration_spmss, shape)
            )

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Start a blend move over all segments of a stored program."""
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

        A motion on its last ramp continues with it, unless another ramp ends sooner; any other begins to
        brake now, even if that takes more steps than it had left (reading A-111).
        """
        if self.motion is None:
            return
        stopped = plan_stop(self.motion, now_ns, self._start_sps, deceleration_spmss, shape)
        by_itself = self.motion.final_steps
        assert stopped.final_steps is not None
        if by_itself is None or stopped.final_steps < by_itself or not self.motion.on_last_ramp(now_ns):
            self._replace(now_ns, stopped)

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the steps that a controlled stop beginning now would still make."""
        if self.motion is None:
            return 0
        stopped = plan_stop(self.motion, now_ns, self._start_sps, deceleration_spmss, shape)
        assert stopped.final_steps is not None
        return stopped.final_steps - self._steps_made

    def _replace(self, now_ns: int, motion: Motion) -> None:
        """Continue with another plan of the same motion, whose step count continues."""
        self.motion = motion
        if motion.end_ns is not None and now_ns >= motion.end_ns:
            self._end(now_ns)
        else:
            self.segment = motion.segment_at(now_ns)

    def cut(self, now_ns: int) -> None:
        """End the step output at once; steps already made stay counted."""
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
        """Do nothing: a step generator has no errors."""


class SteppedModule:
    """A module with a step generator: its machine, and its predictions, see `ForeseeingModule`."""

    axis: StepGenerator
    machine: Machine
    before_change: Callable[[], None]
    _now_ns: int
    _tick_ns: int
    _due_ns: int  # before this instant only position and count change
    _counting: bool
    _segment: Segment | None  # the segment whose position the image shows
    _acted_on: bytes | None  # the output words that were obeyed

    def calm_until_ns(self, outputs: Image) -> int:
        """Return the instant before which only position and count change."""
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
        """Return the upper and the lower words of numbers."""
        raise NotImplementedError

    def machine_at(self, now_ns: int) -> Machine:
        """Return the machine as it is at `now_ns`, the instant of the last `update`."""
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
        """Return the instant before which the shaft does not enter or leave positions `first` to `last`."""
        self.axis.advance(self._now_ns)
        return self.axis.shaft_calm_until_ns(first, last)

    def levels_calm_until_ns(self) -> int:
        """Return the instant before which no level of the machine's inputs changes."""
        self.axis.advance(self._now_ns)
        return self.axis.levels_calm_until_ns()
