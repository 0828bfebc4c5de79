"""The interface between the command layer and an axis.

The command layer applies the manual's rules: edges, ranges, errors and allowed commands. An axis makes steps;
it is the simulated step generator, or an adapter's device on a serial line.
"""

from __future__ import annotations

from typing import Protocol

from scanrack.io_images.amci3601 import Configuration
from scanrack.io_images.dataclass import dataclass

from ...kinematics import AnyShape, BlendLeg, Profile, Rate
from .amci3601_capabilities import Capabilities


@dataclass(frozen=True, slots=True)
class BlendProgram:
    """A stored blend profile [chapter 5, Blend Move Programming]."""

    segments: tuple[BlendLeg, ...]  # 2 to 16: steps, steps/s, steps/ms/s, acceleration type
    final_deceleration: int  # steps/ms/s
    final_shape: AnyShape  # acceleration type of the ramp down at the end


class Axis(Protocol):
    """The motion of one motor. Positions are in the module's steps, CW positive.

    The caller advances the axis to `now_ns` before it calls a method.
    """

    capabilities: Capabilities

    @property
    def moving(self) -> bool:
        """Whether the axis is moving, or is not yet known to be at rest after `cut`."""

    @property
    def direction(self) -> int:
        """+1 CW, -1 CCW while moving, else 0."""

    @property
    def ramp(self) -> int:
        """+1 accelerating, -1 decelerating, 0 constant speed or at rest."""

    @property
    def position(self) -> int:
        """Step count at the present instant."""

    @property
    def encoder(self) -> int:
        """Encoder or diagnostic count at the present instant; 0 without a configured count."""

    def configure(self, configuration: Configuration | None) -> None:
        """Adopt an accepted configuration, or None after a rejected one."""

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a single step at `speed_sps`."""

    def pulse(self, now_ns: int, direction: int, steps: int = 1) -> None:
        """Output step pulses at once, without a motion."""

    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        """Start a motion that lasts until it is stopped.

        Args:
            registration: the number of steps that a later `register` requests, or None.
        """

    def home(self, now_ns: int, direction: int, profile: Profile) -> None:
        """Carry out the axis's own part of homing; see `AxisHoming`."""

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Ramp from the present speed to the profile's speed, which may be below its starting speed."""

    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """End the motion after exactly `steps` more whole steps, deceleration included."""

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Start a blend move through all segments of a stored program."""

    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Begin a controlled stop, which ramps down to the starting speed and ends on a whole step."""

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the number of steps of a controlled stop that begins now."""

    def cut(self, now_ns: int) -> None:
        """End the step output as soon as possible; `moving` stays true until then."""

    def watch_steps(self, steps: int) -> None:
        """Request a tick when the motion has made `steps` steps."""

    def watch_counts(self, counts: int, direction: int) -> None:
        """Request a tick when the encoder reaches `counts`, or passes it in `direction`."""

    def watch_marker(self) -> None:
        """Request a tick at the next marker pulse; ignore earlier pulses."""

    @property
    def marker_seen(self) -> bool:
        """Whether a marker pulse has occurred since `watch_marker`."""

    def preset_position(self, value: int) -> None:
        """Set the present position to `value`."""

    def preset_encoder(self, value: int) -> None:
        """Set the present encoder count to `value`."""

    def reset_errors(self) -> None:
        """Clear the errors of the axis."""
