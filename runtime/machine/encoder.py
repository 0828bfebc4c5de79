"""The encoder: counts from the shaft, counts from turns by hand, and the Z line.

    counts of the shaft  c = direction * floor(shaft * counts_per_step)
    counts               c + counts turned by hand

The Z line is at the counts m = marker_at + n * marker_every. A step on which c reaches or passes m from
either side makes a Z pulse: when going up from c0 to c1 if c0 < m <= c1, and when going down if c1 <= m < c0.
Neither resting at m nor a step away from m makes a pulse.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections import deque
from typing import TYPE_CHECKING

from scanrack.io_images.dataclass import dataclass

from .spec import EncoderSpec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_INT64_LIMIT = 1 << 63


class ShaftEncoder:
    """The encoder's counts from the shaft's travel.

    Args:
        spec: None for no encoder; the counts are then always 0.
    """

    __slots__ = ("_denominator", "_marker_at", "_marker_every", "_numerator", "direction")

    def __init__(self, spec: EncoderSpec | None) -> None:
        self.direction = spec.direction if spec else 0
        self._numerator = spec.counts_per_step.numerator if spec else 0
        self._denominator = spec.counts_per_step.denominator if spec else 1
        self._marker_every = spec.marker_every if spec else None
        self._marker_at = spec.marker_at if spec else 0

    def counts(self, shaft: int) -> int:
        """Return the counts at a shaft position.

        >>> from fractions import Fraction
        >>> encoder = ShaftEncoder(EncoderSpec(Fraction(5, 2)))
        >>> [encoder.counts(shaft) for shaft in (-1, 0, 1, 2)]
        [-3, 0, 2, 5]
        """
        return self.direction * (shaft * self._numerator // self._denominator)

    def counts_all(self, shafts: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the counts at many shaft positions."""
        if int(abs(shafts).max(initial=0)) * self._numerator < _INT64_LIMIT:
            return self.direction * (shafts * self._numerator // self._denominator)
        shafts[:] = [self.counts(shaft) for shaft in shafts.tolist()]
        return shafts

    def shaft_reaching(self, direction: int, counts: int) -> int:
        """Return the shaft position at which the counts reach or pass `counts`, turning in `direction`.

        `counts` must be ahead in that direction, and the shaft must turn the encoder.
        """
        shaft_counts = self.direction * counts
        if direction > 0:  # the lowest position with floor(position * ratio) >= shaft_counts
            return -(-shaft_counts * self._denominator // self._numerator)
        # the highest position with floor(position * ratio) <= shaft_counts
        return -(-(shaft_counts + 1) * self._denominator // self._numerator) - 1

    def next_marker(self, direction: int, shaft: int) -> int | None:
        """Return the count of the next Z pulse in `direction`, or None if there is no Z line."""
        if self._marker_every is None:
            return None
        sense = direction * self.direction
        markers_passed = sense * (self.counts(shaft) - self._marker_at) // self._marker_every + 1
        return self._marker_at + sense * markers_passed * self._marker_every


@dataclass(frozen=True, slots=True)
class _Turn:
    """One turn of the encoder by hand: `counts` spread evenly from `start_ns` to `end_ns`."""

    start_ns: int
    end_ns: int
    counts: int

    def counted(self, now_ns: int) -> int:
        """Return the counts made by `now_ns`, rounded toward zero."""
        if now_ns >= self.end_ns:
            return self.counts
        if now_ns <= self.start_ns:
            return 0
        counts_made = abs(self.counts) * (now_ns - self.start_ns) // (self.end_ns - self.start_ns)
        return counts_made if self.counts > 0 else -counts_made


class HandTurning:
    """Counts and Z pulses made by hand."""

    __slots__ = ("_counts_done", "_end_ns", "_markers", "_turns")

    def __init__(self) -> None:
        self._counts_done = 0  # of the turns that have ended
        self._end_ns = 0  # end of the last turn
        self._turns: deque[_Turn] = deque()  # turns that have not ended, in order of time
        self._markers: list[int] = []  # instants of Z pulses, sorted

    def turn(self, counts: int, start_ns: int, end_ns: int) -> None:
        """Plan a turn; raise ValueError if it ends before it starts, or overlaps the previous turn."""
        if end_ns < start_ns:
            raise ValueError(f"turn_encoder: end_ns {end_ns}: must be {start_ns} (start_ns) or more")
        if self._turns and start_ns < self._end_ns:
            raise ValueError(
                f"turn_encoder: start_ns {start_ns}: must be {self._end_ns} (end of the last turn) or more"
            )
        if counts:
            self._turns.append(_Turn(start_ns, end_ns, counts))
            self._end_ns = end_ns

    def counts(self, now_ns: int) -> int:
        """Return the counts turned by `now_ns`; calls must be in chronological order."""
        while self._turns and now_ns >= self._turns[0].end_ns:
            self._counts_done += self._turns.popleft().counts
        return self._counts_done + self._turns[0].counted(now_ns) if self._turns else self._counts_done

    def turning(self, now_ns: int) -> bool:
        """Return whether a turn is in progress or planned."""
        self.counts(now_ns)
        return bool(self._turns)

    def turns_ns(self, now_ns: int) -> int | None:
        """Return `now_ns` during a turn, otherwise the start of the next turn, or None."""
        self.counts(now_ns)
        return max(now_ns, self._turns[0].start_ns) if self._turns else None

    def mark(self, at_ns: int) -> None:
        """Plan a Z pulse."""
        insort(self._markers, at_ns)

    def next_marker_ns(self, now_ns: int) -> int | None:
        """Return the instant of the next Z pulse after `now_ns`, or None; drop earlier pulses."""
        del self._markers[: bisect_right(self._markers, now_ns)]
        return self._markers[0] if self._markers else None

    def let_go(self, now_ns: int) -> None:
        """Cancel turns and Z pulses after `now_ns`."""
        self._counts_done = self.counts(now_ns)
        self._turns.clear()
        del self._markers[bisect_right(self._markers, now_ns) :]
