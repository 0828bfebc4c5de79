"""The motions of a drive: moves, jogs, registration moves, the home search, assembled moves.

A motion lasts from the acceptance of its command to its end. It reacts to words, inputs and Hold, and ends
by calling `MotionHost.finish`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import ClassVar, Protocol, cast

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
    """Return the course of the rate for a jerk word."""
    return Jerk(jerk) if jerk else Shape.CONSTANT


def profile_of(command: DriveCommand, start_sps: int) -> Profile:
    """Return the profile of a command whose ranges hold."""
    assert command.speed is not None
    return Profile(start_sps, command.speed, *command.rates, shape_of(command.jerk))


class MotionHost(Protocol):
    """The interface of the drive to its motions, see `DriveLayer`."""

    axis: StepGenerator
    options: DriveOptions
    status: StatusLatches
    state: DriveState
    held: HeldMove | None

    @property
    def start_sps(self) -> int:
        """The starting speed, steps/s."""

    def fire(self, now_ns: int, rule_id: str) -> None:
        """Set the bits of a rule, and record it."""

    def cut(self, now_ns: int, rule_id: str) -> None:
        """End the motion without a ramp, for a rule."""

    def finish(self, now_ns: int, result: int, how: str) -> None:
        """End the motion with a result bit, or 0, and record it."""


class DriveMotion:
    """A motion of the axis."""

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
        """Refuse Hold, unless the motion can be held [SD p. 23; reading R-15]."""
        self.layer.fire(now_ns, "CMD-06")

    def on_words(self, now_ns: int, command: DriveCommand) -> None:
        """React to changed output words."""

    def on_tick(self, now_ns: int) -> None:
        """Check inputs and counts."""

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the instant of a tick that the motion needs without another event, or None."""
        return None

    def on_end(self, now_ns: int) -> None:
        """React to the regular end of the motion: show MOVE_COMPLETE."""
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
        """Start the axis; a move over no distance is complete at once [reading R-37]."""
        if self.target != self.axis.position:
            self.axis.move(now_ns, self.target - self.axis.position, self.profile)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ramp down into the hold state; a move that ends with its own ramp anyway completes."""
        axis, profile = self.axis, self.profile
        steps_left = abs(self.target - axis.position)
        if (
            self.holding
            or axis.steps_to_stop(now_ns, profile.deceleration_spmss, profile.shape) >= steps_left
        ):
            return
        self.holding = True
        axis.stop(now_ns, profile.deceleration_spmss, profile.shape)

    @override
    def on_end(self, now_ns: int) -> None:
        """Show MOVE_COMPLETE, or HOLD_STATE with the remaining distance kept for Resume."""
        if self.holding and self.axis.position != self.target:
            self.layer.finish(now_ns, StatusBit.HOLD_STATE, "held")
            self.layer.held = HeldMove(self.target, self.name)
        else:
            super().on_end(now_ns)


class DriveEncoderMove(DriveMotion):
    """A move until the encoder has reached a count, and a ramp down from there [K p. 69]."""

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
    """A motion as long as the bit is on; its speed and rates may change [17 p. 84]."""

    name: ClassVar[str] = "jog"

    def __init__(self, layer: MotionHost, now_ns: int, heading: int, command: DriveCommand) -> None:
        super().__init__(layer, now_ns)
        self.heading = heading
        self.profile = profile_of(command, layer.start_sps)
        self.values = command.words[4:8], command.jerk
        self.stopping = False

    def start(self, now_ns: int) -> None:
        """Start the axis, unless the input that stops jogs is active."""
        if not self.layer.state.active & STOP_JOG:
            self.axis.run(now_ns, self.heading, self.profile)

    @override
    def on_words(self, now_ns: int, command: DriveCommand) -> None:
        """Ramp down when the bit is released, or else adopt new values."""
        if not command.bits & JOG_BIT[self.heading]:
            self.stop(now_ns)
        elif not self.stopping and (command.words[4:8], command.jerk) != self.values:
            self.change(now_ns, command)

    def change(self, now_ns: int, command: DriveCommand) -> None:
        """Adopt new values, or report invalid ones [reading R-16]."""
        layer, self.values = self.layer, (command.words[4:8], command.jerk)
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
    """A jog that ends a distance after its input, or after the release of its bit [SMD p. 67; reading R-17].

    Below the minimum distance neither ends it.
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
        """Record the released bit; before the input, adopt a lower speed at the same rates, like a 3601."""
        self.released = self.released or not command.bits & JOG_BIT[self.heading]
        if self.stopping or self.released or (command.words[4:8], command.jerk) == self.values:
            return
        faster = command.speed is None or command.speed > self.profile.speed_sps
        if faster or command.words[6:8] != self.values[0][2:]:
            self.values = command.words[4:8], command.jerk
            self.layer.fire(now_ns, "JOG-01")
        else:
            self.change(now_ns, command)

    @override
    def on_tick(self, now_ns: int) -> None:
        steps_made = abs(self.axis.position - self.started_at)
        waits = self.minimum > 0 and steps_made <= self.minimum
        if not self.stopping and not waits and (self.released or self.layer.state.active & STOP_JOG):
            self.stopping = True
            self.axis.register(now_ns, self.distance, self.profile.deceleration_spmss, self.profile.shape)


class HomeSearch(DriveMotion):
    """A home search: the sequence of a 3601, whose search reads the drive's state [reading R-19]."""

    name: ClassVar[str] = "home"
    stops_at_limits: ClassVar[bool] = False

    def __init__(self, layer: MotionHost, now_ns: int, heading: int, profile: Profile) -> None:
        super().__init__(layer, now_ns)
        # a search uses only members that a drive also has: axis, options, state, finish and abort_homing
        self._search = Homing(cast(Host, layer), now_ns, heading, profile)
        configuration = layer.state.configuration
        most_s = configuration.homing_timeout_s if configuration is not None else 0
        self._ends_ns = now_ns + 1_000_000_000 * most_s if most_s else None

    def start(self, now_ns: int) -> None:
        """Begin with the phase that the inputs require."""
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
        if self._ends_ns is not None and now_ns >= self._ends_ns:
            self.layer.cut(now_ns, "INP-06")  # reading R-44
        else:
            self._search.on_tick(now_ns, NO_COMMAND)

    @override
    def next_wake_ns(self, now_ns: int) -> int | None:
        wakes = (self._search.next_wake_ns(now_ns), self._ends_ns)
        return min((wake_ns for wake_ns in wakes if wake_ns is not None), default=None)

    @override
    def on_end(self, now_ns: int) -> None:
        self._search.on_end(now_ns)


def blend_program(segments: Sequence[DriveCommand], start_sps: int) -> BlendProgram:
    """Return segments as one motion: each ramps at its own rate to its speed [SMD p. 38; reading R-20].

    Raises:
        ValueError: a segment is shorter than its ramps.
    """
    legs: list[BlendLeg] = []
    before_sps = start_sps
    for segment in segments:
        assert segment.target is not None
        assert segment.speed is not None
        rate = segment.rates[0] if segment.speed >= before_sps else segment.rates[1]
        legs.append((abs(segment.target), segment.speed, rate, shape_of(segment.jerk)))
        before_sps = segment.speed
    final = segments[-1]
    check_blend(start_sps, legs, final.rates[1], shape_of(final.jerk))
    return BlendProgram(tuple(legs), final.rates[1], shape_of(final.jerk))


class BlendMove(DriveMotion):
    """An assembled move without pauses [17 p. 80]; Hold ends it, and it can't be resumed [SD p. 23]."""

    name: ClassVar[str] = "blend"

    def __init__(
        self, layer: MotionHost, now_ns: int, heading: int, segments: Sequence[DriveCommand]
    ) -> None:
        super().__init__(layer, now_ns)
        self.heading = heading
        self.segments = segments
        self.program = blend_program(segments, layer.start_sps)
        self._ends = list(accumulate(leg[0] for leg in self.program.segments))
        self.held = False

    def start(self, now_ns: int) -> None:
        """Start the axis."""
        self.axis.blend(now_ns, self.heading, self.program)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ramp down at the deceleration of the present segment."""
        steps_made = abs(self.axis.position - self.started_at)
        index = next((segment_index for segment_index, end in enumerate(self._ends) if steps_made < end), -1)
        self.held = True
        self.axis.stop(now_ns, self.segments[index].rates[1], shape_of(self.segments[index].jerk))

    @override
    def on_end(self, now_ns: int) -> None:
        if self.held and abs(self.axis.position - self.started_at) != self._ends[-1]:
            self.layer.finish(now_ns, StatusBit(0), "held")
        else:
            super().on_end(now_ns)


class DwellMove(DriveMotion):
    """An assembled move with pauses: relative moves one after the other [SMD p. 38; reading R-20]."""

    name: ClassVar[str] = "dwell"

    def __init__(
        self, layer: MotionHost, now_ns: int, segments: Sequence[DriveCommand], pause_ns: int
    ) -> None:
        super().__init__(layer, now_ns)
        self.segments = segments
        self.pause_ns = pause_ns
        self._at = -1
        self._resumes_ns: int | None = None  # the end of a pause
        self._held = False

    def start(self, now_ns: int) -> None:
        """Start the next segment."""
        self._at += 1
        self._resumes_ns = None
        segment = self.segments[self._at]
        assert segment.target is not None
        self.axis.move(now_ns, segment.target, profile_of(segment, self.layer.start_sps))

    @property
    @override
    def over(self) -> bool:
        return not self.axis.moving and (self._held or self._at + 1 == len(self.segments))

    @override
    def on_tick(self, now_ns: int) -> None:
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
        """Ramp down, or end in the pause."""
        self._held, self._resumes_ns = True, None
        rates, shape = self.segments[self._at].rates, shape_of(self.segments[self._at].jerk)
        self.axis.stop(now_ns, rates[1], shape)

    @override
    def on_end(self, now_ns: int) -> None:
        if self._held:
            self.layer.finish(now_ns, StatusBit(0), "held")
        else:
            super().on_end(now_ns)
