"""The motions of a drive: moves, jogs, registration moves, home searches and assembled moves.

A motion lasts from the acceptance of its command to its end. It reacts to words, inputs and Hold, and ends
by calling `MotionHost.finish`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate
from typing import ClassVar, NamedTuple, Protocol, cast

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.bits import CommandBit, StatusBit
from scanrack.io_images.drives.command import DriveCommand
from typing_extensions import override

from ...kinematics import AnyShape, BlendLeg, Jerk, Profile, Shape, check_blend
from ..amci3601.axis_protocol import BlendProgram
from ..amci3601.operation import Host
from ..amci3601.operations.homing import Homing
from ..amci3601.state import NO_COMMAND, HeldMove
from ..amci3601.step_generator import StepGenerator
from .drive_options import DriveOptions
from .state import DriveState, StatusLatches

STOP_JOG = InputBit.EXTERNAL.value
JOG_BIT = {1: CommandBit.JOG_CW, -1: CommandBit.JOG_CCW}


def shape_of(jerk: int) -> AnyShape:
    """Return the shape of a ramp for a jerk word; 0 is a constant rate."""
    return Jerk(jerk) if jerk else Shape.CONSTANT


def profile_of(command: DriveCommand, start_sps: int) -> Profile:
    """Return the profile of a command whose values are within their ranges."""
    assert command.speed is not None
    return Profile(start_sps, command.speed, *command.rates, shape_of(command.jerk))


class MotionHost(Protocol):
    """The drive's interface for its motions; see `DriveLayer`."""

    axis: StepGenerator
    options: DriveOptions
    status: StatusLatches
    state: DriveState
    held: HeldMove | None

    @property
    def start_sps(self) -> int:
        """The starting speed, steps/s."""

    def fire(self, now_ns: int, rule_id: str) -> None:
        """Set the bits of a rule, and report the rule."""

    def cut(self, now_ns: int, rule_id: str) -> None:
        """End the motion without a ramp, and report the rule that requires it."""

    def finish(self, now_ns: int, result: int, outcome: str) -> None:
        """End the motion, set the status bit of its result (0 for none), and report the motion."""


class JogValues(NamedTuple):
    """The values of a jog that may change while it runs."""

    speed: tuple[int, ...]  # two words
    rates: tuple[int, ...]  # acceleration and deceleration
    jerk: int


def jog_values(command: DriveCommand) -> JogValues:
    """Return the values of a command that a running jog adopts."""
    return JogValues(command.words[4:6], command.words[6:8], command.jerk)


class DriveMotion:
    """A motion of the axis.

    Attributes:
        name: name of the motion in events.
        stops_at_limits: whether a limit cuts the motion.
        started_at: position at the start, steps.
    """

    name: ClassVar[str] = ""
    stops_at_limits: ClassVar[bool] = True

    def __init__(self, layer: MotionHost, now_ns: int) -> None:
        self.layer = layer
        self.axis = layer.axis
        self.started_ns = now_ns
        self.started_at = self.axis.position

    @property
    def over(self) -> bool:
        """Whether the motion has ended."""
        return not self.axis.moving

    @property
    def direction(self) -> int:
        """+1 CW, -1 CCW, 0 while the axis pauses."""
        return self.axis.direction

    @property
    def ramp(self) -> int:
        """+1 accelerating, -1 decelerating, 0 at constant speed."""
        return self.axis.ramp

    def on_hold(self, now_ns: int) -> None:
        """Refuse Hold; a motion that can be held overrides this [SD p. 23; interpretation R-15]."""
        self.layer.fire(now_ns, "CMD-06")

    def on_words(self, now_ns: int, command: DriveCommand) -> None:
        """React to changed output words."""

    def on_tick(self, now_ns: int) -> None:
        """Check inputs and counts."""

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the instant at which the motion needs a tick even without an event, or None."""
        return None

    def on_end(self, now_ns: int) -> None:
        """Finish a motion that has made its last step, with MOVE_COMPLETE."""
        self.layer.finish(now_ns, StatusBit.MOVE_COMPLETE, "complete")


class Move(DriveMotion):
    """An absolute or relative move; it can be held and resumed."""

    def __init__(self, layer: MotionHost, now_ns: int, name: str, target: int, profile: Profile) -> None:
        super().__init__(layer, now_ns)
        self.name = name  # type: ignore[misc]  # two commands share the class
        self.target = target
        self.profile = profile
        self.holding = False

    def start(self, now_ns: int) -> None:
        """Start the axis; a move of zero distance is complete at once [interpretation R-37]."""
        if self.target != self.axis.position:
            self.axis.move(now_ns, self.target - self.axis.position, self.profile)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ramp down into the hold state, unless the move is already on its last ramp."""
        axis, profile = self.axis, self.profile
        rate, shape = profile.deceleration_spmss, profile.shape
        steps_left = abs(self.target - axis.position)
        if not self.holding and axis.steps_to_stop(now_ns, rate, shape) < steps_left:
            self.holding = True
            axis.stop(now_ns, rate, shape)

    @override
    def on_end(self, now_ns: int) -> None:
        """Finish with MOVE_COMPLETE, or with HOLD_STATE and a held move for Resume."""
        if self.holding and self.axis.position != self.target:
            self.layer.finish(now_ns, StatusBit.HOLD_STATE, "held")
            self.layer.held = HeldMove(self.target, self.name)
        else:
            super().on_end(now_ns)


class DriveEncoderMove(DriveMotion):
    """A move that runs until the encoder reaches a count, and then ramps down [K p. 69]."""

    name: ClassVar[str] = "encoder"

    def __init__(self, layer: MotionHost, now_ns: int, target: int, profile: Profile) -> None:
        super().__init__(layer, now_ns)
        self.target = target
        self.heading = 1 if target >= self.axis.encoder else -1
        self.profile = profile
        self.stopping = False

    def start(self, now_ns: int) -> None:
        """Start the axis and watch its encoder."""
        if self.axis.encoder != self.target:
            self.axis.run(now_ns, self.heading, self.profile)
            self.axis.watch_counts(self.target, self.heading)

    @override
    def on_tick(self, now_ns: int) -> None:
        if not self.stopping and (self.axis.encoder - self.target) * self.heading >= 0:
            self.stopping = True
            self.axis.stop(now_ns, self.profile.deceleration_spmss, self.profile.shape)


class Jog(DriveMotion):
    """A motion that runs while its bit is on; its speed and rates may change [17 p. 84]."""

    name: ClassVar[str] = "jog"

    def __init__(self, layer: MotionHost, now_ns: int, heading: int, command: DriveCommand) -> None:
        super().__init__(layer, now_ns)
        self.heading = heading
        self.profile = profile_of(command, layer.start_sps)
        self.values = jog_values(command)
        self.stopping = False

    def start(self, now_ns: int) -> None:
        """Start the axis, unless the input that stops jogs is active."""
        if not self.layer.state.active & STOP_JOG:
            self.axis.run(now_ns, self.heading, self.profile)

    @override
    def on_words(self, now_ns: int, command: DriveCommand) -> None:
        """Ramp down when the bit is released; otherwise adopt new values."""
        if not command.bits & JOG_BIT[self.heading]:
            self.stop(now_ns)
        elif not self.stopping and jog_values(command) != self.values:
            self.change(now_ns, command)

    def change(self, now_ns: int, command: DriveCommand) -> None:
        """Adopt new values, or report invalid values [interpretation R-16]."""
        layer, self.values = self.layer, jog_values(command)
        if command.is_in_range(layer.start_sps):
            self.stopping = False
            self.profile = profile_of(command, layer.start_sps)
            self.axis.change_speed(now_ns, self.profile)
            layer.status.clear(StatusBit.INVALID_JOG_CHANGE)
        else:
            layer.fire(now_ns, "JOG-01")
            if layer.options.jog_stops_on_bad_values:
                self.stop(now_ns)

    def stop(self, now_ns: int) -> None:
        """Ramp down."""
        if not self.stopping:
            self.stopping = True
            self.axis.stop(now_ns, self.profile.deceleration_spmss, self.profile.shape)

    @override
    def on_tick(self, now_ns: int) -> None:
        if self.layer.state.active & STOP_JOG:
            self.stop(now_ns)

    @override
    def on_end(self, now_ns: int) -> None:
        self.layer.finish(now_ns, StatusBit(0), "stopped")


class DriveRegistrationMove(Jog):
    """A jog that stops at a distance after its input, or after its bit is released.

    Before the minimum distance, neither stops it [SMD p. 67; interpretation R-17].
    """

    name: ClassVar[str] = "registration"

    def __init__(self, layer: MotionHost, now_ns: int, heading: int, command: DriveCommand) -> None:
        super().__init__(layer, now_ns, heading, command)
        assert command.target is not None
        assert command.minimum_distance is not None
        self.distance, self.minimum = command.target, command.minimum_distance
        self.released = False

    @override
    def start(self, now_ns: int) -> None:
        """Start the axis, and watch for the end of the minimum distance."""
        self.axis.run(now_ns, self.heading, self.profile)
        self.axis.watch_steps(self.minimum + 1)

    @override
    def on_words(self, now_ns: int, command: DriveCommand) -> None:
        """Note the release of the bit; until then, adopt new values.

        As on a 3601, only a lower speed at the same rates is valid.
        """
        self.released = self.released or not command.bits & JOG_BIT[self.heading]
        values = jog_values(command)
        if self.stopping or self.released or values == self.values:
            return
        is_slower = command.speed is not None and command.speed <= self.profile.speed_sps
        if is_slower and values.rates == self.values.rates:
            self.change(now_ns, command)
        else:
            self.values = values
            self.layer.fire(now_ns, "JOG-01")

    @override
    def on_tick(self, now_ns: int) -> None:
        """Plan the exact end after the bit's release or the input, but not before the minimum distance."""
        steps_made = abs(self.axis.position - self.started_at)
        waits = self.minimum > 0 and steps_made <= self.minimum
        if not self.stopping and not waits and (self.released or self.layer.state.active & STOP_JOG):
            self.stopping = True
            self.axis.register(now_ns, self.distance, self.profile.deceleration_spmss, self.profile.shape)


class HomeSearch(DriveMotion):
    """A home search that follows the sequence of a 3601 [interpretation R-19]."""

    name: ClassVar[str] = "home"
    stops_at_limits: ClassVar[bool] = False

    def __init__(self, layer: MotionHost, now_ns: int, heading: int, profile: Profile) -> None:
        super().__init__(layer, now_ns)
        # the 3601's search uses only members that a drive has: axis, options, state, finish, abort_homing
        self._search = Homing(cast(Host, layer), now_ns, heading, profile)
        configuration = layer.state.configuration
        timeout_s = configuration.homing_timeout_s if configuration is not None else 0
        self._timeout_ns = now_ns + 1_000_000_000 * timeout_s if timeout_s else None

    def start(self, now_ns: int) -> None:
        """Begin the search."""
        self._search.start(now_ns)

    @property
    @override
    def over(self) -> bool:
        return self._search.over

    @property
    @override
    def direction(self) -> int:
        return self.axis.direction or self._search.shown_direction

    @property
    @override
    def ramp(self) -> int:
        return self.axis.ramp if self.axis.direction else self._search.shown_ramp

    @override
    def on_tick(self, now_ns: int) -> None:
        if self._timeout_ns is not None and now_ns >= self._timeout_ns:
            self.layer.cut(now_ns, "INP-06")  # interpretation R-44
        else:
            self._search.on_tick(now_ns, NO_COMMAND)

    @override
    def next_wake_ns(self, now_ns: int) -> int | None:
        instants = self._search.next_wake_ns(now_ns), self._timeout_ns
        return min((instant for instant in instants if instant is not None), default=None)

    @override
    def on_end(self, now_ns: int) -> None:
        self._search.on_end(now_ns)


def blend_program(segments: Sequence[DriveCommand], start_sps: int) -> BlendProgram:
    """Return segments as one motion; each segment ramps to its speed at its own rate.

    See SMD p. 38, interpretation R-20.

    Raises:
        ValueError: a segment is shorter than its ramps.
    """
    legs: list[BlendLeg] = []
    speed_before = start_sps
    for segment in segments:
        assert segment.target is not None
        assert segment.speed is not None
        acceleration, deceleration = segment.rates
        rate = acceleration if segment.speed >= speed_before else deceleration
        legs.append((abs(segment.target), segment.speed, rate, shape_of(segment.jerk)))
        speed_before = segment.speed
    final_shape = shape_of(segments[-1].jerk)
    _, final_deceleration = segments[-1].rates
    check_blend(start_sps, legs, final_deceleration, final_shape)
    return BlendProgram(tuple(legs), final_deceleration, final_shape)


class BlendMove(DriveMotion):
    """An assembled move without pauses [17 p. 80]; Hold ends it without Resume [SD p. 23]."""

    name: ClassVar[str] = "blend"

    def __init__(
        self, layer: MotionHost, now_ns: int, heading: int, segments: Sequence[DriveCommand]
    ) -> None:
        super().__init__(layer, now_ns)
        self.heading = heading
        self.segments = segments
        self.program = blend_program(segments, layer.start_sps)
        self._segment_ends = list(accumulate(length for length, *_ in self.program.segments))
        self._is_held = False

    def start(self, now_ns: int) -> None:
        """Start the axis."""
        self.axis.blend(now_ns, self.heading, self.program)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ramp down at the deceleration of the present segment."""
        steps_made = abs(self.axis.position - self.started_at)
        last_index = len(self.segments) - 1
        segment = self.segments[min(bisect_right(self._segment_ends, steps_made), last_index)]
        self._is_held = True
        self.axis.stop(now_ns, segment.rates[1], shape_of(segment.jerk))

    @override
    def on_end(self, now_ns: int) -> None:
        if self._is_held and abs(self.axis.position - self.started_at) != self._segment_ends[-1]:
            self.layer.finish(now_ns, StatusBit(0), "held")
        else:
            super().on_end(now_ns)


class DwellMove(DriveMotion):
    """An assembled move with pauses between relative moves [SMD p. 38; interpretation R-20]."""

    name: ClassVar[str] = "dwell"

    def __init__(
        self, layer: MotionHost, now_ns: int, segments: Sequence[DriveCommand], pause_ns: int
    ) -> None:
        super().__init__(layer, now_ns)
        self.segments = segments
        self.pause_ns = pause_ns
        self._index = -1  # of the present segment
        self._resumes_ns: int | None = None  # the end of a pause
        self._is_held = False

    def start(self, now_ns: int) -> None:
        """Start the next segment."""
        self._index += 1
        self._resumes_ns = None
        segment = self.segments[self._index]
        assert segment.target is not None
        self.axis.move(now_ns, segment.target, profile_of(segment, self.layer.start_sps))

    @property
    @override
    def over(self) -> bool:
        return not self.axis.moving and (self._is_held or self._index + 1 == len(self.segments))

    @override
    def on_tick(self, now_ns: int) -> None:
        """When the axis comes to rest, begin a pause; when the pause is over, start the next segment."""
        if self.axis.moving or self.over:
            return
        if self._resumes_ns is None:
            self._resumes_ns = now_ns + self.pause_ns
        if now_ns >= self._resumes_ns:
            self.start(now_ns)

    @override
    def next_wake_ns(self, now_ns: int) -> int | None:
        return self._resumes_ns

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ramp down, or end at once during a pause."""
        self._is_held, self._resumes_ns = True, None
        segment = self.segments[self._index]
        self.axis.stop(now_ns, segment.rates[1], shape_of(segment.jerk))

    @override
    def on_end(self, now_ns: int) -> None:
        if self._is_held:
            self.layer.finish(now_ns, StatusBit(0), "held")
        else:
            super().on_end(now_ns)
