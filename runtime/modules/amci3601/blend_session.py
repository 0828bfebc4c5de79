"""The programming of a blend profile, block by block [chapter 5, Blend Move Programming]."""

from __future__ import annotations

from dataclasses import field

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.thousands import PARAMETER_MAX

from ...kinematics import MILLI, PICO, BlendLeg, Shape, check_blend, ramp_distance
from .axis_protocol import BlendProgram


@dataclass(slots=True)
class BlendSession:
    """A session of the handshake, from the first block until the program bit is cleared."""

    acknowledged: bool = False
    is_good: bool = True  # no faulty block so far
    blocks: int = 0  # number of received blocks, including the header
    announced: int = 0  # segments announced by the header
    types: list[Shape] = field(default_factory=list)  # acceleration type of each segment, from the header
    segments: list[BlendLeg] = field(default_factory=list)  # received segments
    final_deceleration: int = 1  # deceleration of the ramp at the end, steps/ms/s
    final_shape: Shape = Shape.CONSTANT

    @property
    def complete(self) -> bool:
        """Whether all segments have been received."""
        return len(self.segments) >= self.announced

    def program(self) -> BlendProgram | None:
        """Return the profile, or None if a block is missing or faulty."""
        if not self.is_good or not self.complete:
            return None
        return BlendProgram(tuple(self.segments), self.final_deceleration, self.final_shape)

    def too_long_with(self, length: int) -> bool:
        """Return whether another segment would make the total length of all segments exceed its maximum."""
        return sum(steps for steps, *_ in self.segments) + length > PARAMETER_MAX

    def newest_segment_fits(self, start_sps: int) -> bool:
        """Return whether the ramp fits the newest segment; for the last, also the final ramp (A-58)."""
        if len(self.segments) == self.announced:
            try:
                check_blend(start_sps, self.segments, self.final_deceleration, self.final_shape)
            except ValueError:
                return False
            return True
        length, speed, rate, shape = self.segments[-1]
        speed_before = start_sps
        if len(self.segments) > 1:
            _, speed_before, _, _ = self.segments[-2]
        return ramp_distance(MILLI * speed_before, MILLI * speed, rate, shape) <= length * PICO
