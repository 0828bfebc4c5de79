"""The programming of a blend profile, block by block [chapter 5, Blend Move Programming]."""

from __future__ import annotations

from dataclasses import field

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.thousands import PARAMETER_MAX

from ...kinematics import MILLI, PICO, BlendLeg, Shape, check_blend, ramp_distance
from .axis_protocol import BlendProgram


@dataclass(slots=True)
class BlendSession:
    """One session of the handshake, from the first block to the fall of the program bit."""

    acknowledged: bool = False
    good: bool = True  # no faulty block so far
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
        """Return the profile if all of its blocks were received and good, else None."""
        if not self.good or not self.complete:
            return None
        return BlendProgram(tuple(self.segments), self.final_deceleration, self.final_shape)

    def too_long_with(self, length: int) -> bool:
        """Whether one more length exceeds the limit of all segments together."""
        return sum(segment[0] for segment in self.segments) + length > PARAMETER_MAX

    def fits(self, start_sps: int) -> bool:
        """Whether the newest segment contains its ramp, and the last one also the final ramp (A-58)."""
        if len(self.segments) == self.announced:
            try:
                check_blend(start_sps, self.segments, self.final_deceleration, self.final_shape)
            except ValueError:
                return False
            return True
        length, speed, rate, shape = self.segments[-1]
        speed_before = self.segments[-2][1] if len(self.segments) > 1 else start_sps
        return ramp_distance(MILLI * speed_before, MILLI * speed, rate, shape) <= length * PICO
