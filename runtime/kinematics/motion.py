"""A motion: travel as a closed form of time, from its first step to its last.

    travel_at      picosteps since the start, never negative
    steps_at       whole steps: floor(travel)
    position_at    origin + direction * steps
    instant_of     the first instant at which a number of steps has been made

A motion never changes. Where two segments meet, the later one applies; from `end_ns` on the axis is at rest.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence

from .segment import Segment


class Motion:
    """The plan of a step generator, from `start_ns` until another plan replaces it.

    Queries for instants before `start_ns` are not allowed.

    Attributes:
        direction: +1 or -1.
        origin: step count at which the travel was 0.
        segments: in chronological order, without gaps; empty if the motion ends when it begins.
        end_ns: the instant of the last step, or None for an endless motion.
        final_steps: whole steps of the complete motion, or None for an endless motion.

    Args:
        standstill: the segment after the last one, or None for an endless motion.

    Raises:
        ValueError: the direction is invalid.
    """

    __slots__ = (
        "_ends",
        "_first_steps",
        "_latest",
        "_track",
        "direction",
        "end_ns",
        "final_steps",
        "origin",
        "segments",
        "start_ns",
    )

    def __init__(
        self,
        direction: int,
        origin: int,
        start_ns: int,
        segments: Sequence[Segment],
        standstill: Segment | None = None,
    ) -> None:
        if direction not in (1, -1):
            raise ValueError(f"direction {direction}: must be 1 (CW) or -1 (CCW)")
        self.direction = direction
        self.origin = origin
        self.start_ns = start_ns
        self.segments = tuple(segments)
        self.end_ns: int | None = None
        self.final_steps: int | None = None
        self._track = self.segments  # and the standstill
        if standstill is not None:
            self.end_ns = standstill.start_ns
            self.final_steps = standstill.steps_at(standstill.start_ns)
            self._track += (standstill,)
        self._ends = tuple(segment.until_ns for segment in self._track)
        self._first_steps = tuple(segment.steps_at(segment.start_ns) for segment in self._track)
        self._latest = self._track[0]  # the segment of the last query, which the next query probably needs

    def __repr__(self) -> str:
        steps = "endless" if self.final_steps is None else f"{self.final_steps} steps"
        return (
            f"<Motion {self.direction:+d} from {self.origin}, {steps}, "
            f"{self.start_ns} to {self.end_ns} ns, {len(self.segments)} segments>"
        )

    def segment_at(self, t_ns: int) -> Segment:
        """Return the segment that applies at an instant; from `end_ns` on, a standstill."""
        segment = self._latest
        if not segment.start_ns <= t_ns < segment.until_ns:
            segment = self._latest = self._track[bisect_right(self._ends, t_ns)]
        return segment

    def travel_at(self, t_ns: int) -> int:
        """Return the unsigned travel in picosteps since the travel was 0."""
        return self.segment_at(t_ns).travel_at(t_ns)

    def steps_at(self, t_ns: int) -> int:
        """Return the unsigned number of whole steps since the travel was 0."""
        return self.segment_at(t_ns).steps_at(t_ns)

    def position_at(self, t_ns: int) -> int:
        """Return the step count: origin + direction * steps."""
        segment = self._latest
        if not segment.start_ns <= t_ns < segment.until_ns:
            segment = self.segment_at(t_ns)
        return self.origin + self.direction * segment.steps_at(t_ns)

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s, rounded down; 0 from `end_ns` on."""
        return self.segment_at(t_ns).speed_at(t_ns)

    def ramp_at(self, t_ns: int) -> int:
        """Return +1 while accelerating, -1 while decelerating, 0 at constant speed and from `end_ns` on."""
        return self.segment_at(t_ns).ramp

    def on_last_ramp(self, t_ns: int) -> bool:
        """Return whether only deceleration is left; False for an endless or ended motion."""
        ramps_left = [segment.ramp for segment in self.segments if segment.until_ns > t_ns]
        return self.end_ns is not None and bool(ramps_left) and all(ramp < 0 for ramp in ramps_left)

    def instant_of(self, steps: int) -> int | None:
        """Return the first instant at which a number of whole steps has been made.

        Args:
            steps: counted from the point where the travel was 0.

        Returns:
            `start_ns` if the steps had already been made by then, None if the motion never makes them.
        """
        index = bisect_left(self._first_steps, steps)
        if index == 0:
            return self.start_ns
        if index == len(self._track) and self.end_ns is not None:
            return None
        return self._track[index - 1].instant_of(steps)
