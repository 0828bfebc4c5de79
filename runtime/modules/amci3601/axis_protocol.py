"""The interface between the command layer and an axis.

The command layer applies the manual's rules (edges, ranges, errors, allowed commands). An axis
makes steps: the simulated step generator here, a controller on a serial line in an adapter.
The layer works with either.
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
    """The motion of one motor. Positions are steps as the module counts them, CW positive.

    All methods act at the instant `now_ns`, to which the axis has been advanced.
    """

    capabilities: Capabilities

    @property
    def moving(self) -> bool:
        """Whether a motion is under way; after `cut` until the axis is known to be at rest."""

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
        """Encoder or diagnostic count at the present instant; 0 where neither is configured."""

    def configure(self, configuration: Configuration | None) -> None:
        """Adopt an accepted configuration; None after it was discarded."""

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a motion of a single step at `speed_sps`."""

    def pulse(self, now_ns: int, direction: int, steps: int = 1) -> None:
        """Output step pulses at once; no motion follows."""

    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        """Start a motion that lasts until it is stopped.

        Args:
            registration: the steps that a later `register` will request, None if none will.
        """

    def home(self, now_ns: int, direction: int, profile: Profile) -> None:
        """Search for the home switch and stop where it is left; for an axis that homes itself."""

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Ramp from the present speed to the profile's, which may be below its starting speed."""

    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """End the motion after exactly `steps` more whole steps, deceleration included."""

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Start a blend move over all segments of a stored program."""

    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Begin a controlled stop: ramp down to the starting speed, end on a whole step."""

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the steps that a controlled stop beginning now would still make."""

    def cut(self, now_ns: int) -> None:
        """End the step output at once, or as soon as the axis can be reached; `moving` lasts until then."""

    def watch_steps(self, steps: int) -> None:
        """Request a tick when the motion has made `steps` steps."""

    def watch_counts(self, counts: int, direction: int) -> None:
        """Request a tick when the encoder has reached `counts`, or passed it in `direction`."""

    def watch_marker(self) -> None:
        """Request a tick at the next marker pulse; ignore earlier ones."""

    @property
    def marker_seen(self) -> bool:
        """Whether a marker pulse has occurred since `watch_marker`."""

    def preset_position(self, value: int) -> None:
        """Set the present position to `value`."""

    def preset_encoder(self, value: int) -> None:
        """Set the present encoder count to `value`."""

    def reset_errors(self) -> None:
        """Clear the axis's own errors."""
