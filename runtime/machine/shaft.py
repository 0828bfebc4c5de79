"""Converts motor steps to the true position of the shaft, with slips and jams.

The law, for a single motor step in direction d with the shaft at p:

    a jam at p against d            the step is lost
    the first step from p in d      every slip at p that acts in d may begin: its steps are lost
    remaining steps of a slip       the step is lost
    otherwise                       the shaft moves to p + d

A step in the other direction, or against a jam, ends a slip at p. Between the
positions of slips and jams nothing happens, so `follow` goes from one to the next
and `steps_to` adds up the losses on the way. Random numbers are drawn one passage
ahead, so that `steps_to` is exact.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from math import ceil
from random import Random

from .spec import Jam, Slip

FAR = 1 << 63
"""Beyond any shaft's travel, later than any clock (ns: 292 years)."""

_CHANCE_BITS = 32


class _SlipState:
    """A slip, its remaining occurrences, and whether the next passage slips."""

    __slots__ = ("_draw", "_left", "_steps", "_threshold", "_will")

    def __init__(self, slip: Slip, draw: Random) -> None:
        self._draw = draw
        self._steps = slip.steps
        self._left = FAR if slip.times is None else slip.times
        self._threshold = ceil(slip.chance * (1 << _CHANCE_BITS))  # exact: a draw below it is below `chance`
        self._will = self._drawn()

    def _drawn(self) -> bool:
        return self._draw.getrandbits(_CHANCE_BITS) < self._threshold

    def due(self) -> int:
        return self._steps if self._will and self._left else 0

    def begin(self) -> int:
        steps_lost = self.due()
        self._left -= steps_lost > 0
        self._will = self._drawn()
        return steps_lost


class Shaft:
    """The shaft, its slips and its jams.

    Args:
        slips: positions that lose steps.
        seed: seed of the random numbers; the same seed gives the same run.
    """

    __slots__ = ("_departing", "_high", "_jams", "_left", "_low", "_obstacles", "_slips", "position")

    def __init__(self, slips: Sequence[Slip] = (), jams: Sequence[Jam] = (), seed: int = 0) -> None:
        self.position = 0  # true position, steps; 0 at power-up
        self._jams = frozenset((jam.at, jam.direction) for jam in jams)
        self._slips: dict[tuple[int, int], list[_SlipState]] = {}
        for index, slip in enumerate(slips):
            state = _SlipState(slip, Random(f"{seed}/{index}"))
            for direction in (1, -1):
                if slip.direction != -direction:
                    self._slips.setdefault((slip.at, direction), []).append(state)
        self._obstacles = sorted(
            {position for position, _ in self._jams} | {position for position, _ in self._slips}
        )
        self._departing = 0  # direction in which the motor leaves `position`, 0 = not yet
        self._left = 0  # steps still to be lost before the shaft leaves
        self._survey()

    def _survey(self) -> None:
        """Find the obstacles next to the position; at an obstacle, the clear range is empty."""
        index_above = bisect_left(self._obstacles, self.position)
        index_below = bisect_right(self._obstacles, self.position)
        self._high = self._obstacles[index_above] if index_above < len(self._obstacles) else FAR
        self._low = self._obstacles[index_below - 1] if index_below else -FAR

    def follow(self, direction: int, steps: int) -> None:
        """Follow `steps` >= 0 motor steps in `direction` (+1 or -1)."""
        target = self.position + direction * steps
        if self._low < self.position < self._high and self._low <= target <= self._high:
            self.position = target
        else:
            self._follow_past_obstacles(direction, steps)

    def free_steps(self, direction: int) -> int:
        """Return the motor steps in `direction` that the shaft follows one to one; 0 at a slip or jam."""
        if not self._low < self.position < self._high:
            return 0
        return self._high - self.position if direction > 0 else self.position - self._low

    def _follow_past_obstacles(self, direction: int, steps: int) -> None:
        while steps:
            if (self.position, direction) in self._jams:
                self._departing = 0
                break
            steps -= self._lose(direction, steps)
            if steps:
                clear = min(steps, self._clear(direction))
                self.position += direction * clear
                self._departing = 0
                steps -= clear
        self._survey()

    def _lose(self, direction: int, steps: int) -> int:
        if self._departing != direction:
            self._departing = direction
            self._left = sum(slip.begin() for slip in self._slips.get((self.position, direction), ()))
        steps_lost = min(self._left, steps)
        self._left -= steps_lost
        return steps_lost

    def _clear(self, direction: int) -> int:
        if direction > 0:
            index = bisect_right(self._obstacles, self.position)
            return self._obstacles[index] - self.position if index < len(self._obstacles) else FAR
        index = bisect_left(self._obstacles, self.position)
        return self.position - self._obstacles[index - 1] if index else FAR

    def steps_to(self, direction: int, target: int) -> int | None:
        """Return the motor steps in `direction` to `target`; None = other direction, or beyond a jam.

        `follow` with exactly that many steps reaches it, with one fewer it does not.

        >>> shaft = Shaft([Slip(100, 7)], [Jam(500, 1)])
        >>> shaft.steps_to(1, 100), shaft.steps_to(1, 101), shaft.steps_to(1, 501)
        (100, 108, None)
        """
        distance = (target - self.position) * direction
        if distance <= 0:
            return 0 if distance == 0 else None
        steps_lost = 0
        for position in self._obstacles_before(direction, target):
            if (position, direction) in self._jams:
                return None
            steps_lost += self._due(position, direction)
        return distance + steps_lost

    def _obstacles_before(self, direction: int, target: int) -> list[int]:
        if direction > 0:
            return self._obstacles[
                bisect_left(self._obstacles, self.position) : bisect_left(self._obstacles, target)
            ]
        return self._obstacles[
            bisect_right(self._obstacles, target) : bisect_right(self._obstacles, self.position)
        ]

    def _due(self, at: int, direction: int) -> int:
        if at == self.position and self._departing == direction:
            return self._left
        return sum(slip.due() for slip in self._slips.get((at, direction), ()))
