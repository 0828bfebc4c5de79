"""Converts motor steps to the true position of the shaft, with slips and jams.

The rules for a single motor step in direction d with the shaft at p:

    a jam at p against d            the step is lost
    the first step from p in d      every slip at p in d may begin, and then loses its steps
    remaining steps of a slip       the step is lost
    otherwise                       the shaft moves to p + d

A step in the opposite direction, or against a jam, ends a slip at p. The shaft moves freely between slips and
jams, so `follow` advances from one to the next, and `steps_to` adds up the losses. Random numbers are drawn
one passage ahead, so `steps_to` is exact.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from math import ceil
from random import Random

from .spec import Jam, Slip

FAR = 1 << 63
"""A position beyond any travel, in steps, and an instant after any run, in ns (292 years)."""

_CHANCE_BITS = 32


class _SlipState:
    """A slip, its remaining occurrences, and whether the next passage slips."""

    __slots__ = ("_occurrences_left", "_random", "_slips_next", "_steps", "_threshold")

    def __init__(self, slip: Slip, random: Random) -> None:
        self._random = random
        self._steps = slip.steps
        self._occurrences_left = FAR if slip.times is None else slip.times
        self._threshold = ceil(slip.chance * (1 << _CHANCE_BITS))  # exact: a draw below it is below `chance`
        self._slips_next = self._draw_next()

    def _draw_next(self) -> bool:
        """Draw whether the next passage slips."""
        return self._random.getrandbits(_CHANCE_BITS) < self._threshold

    def due(self) -> int:
        """Return the steps that the next passage loses."""
        return self._steps if self._slips_next and self._occurrences_left else 0

    def begin(self) -> int:
        """Begin a passage; return the steps that it loses."""
        steps_lost = self.due()
        if steps_lost:
            self._occurrences_left -= 1
        self._slips_next = self._draw_next()
        return steps_lost


class Shaft:
    """The shaft, its slips and its jams.

    Args:
        slips: positions that lose steps.
        seed: seed of the random numbers; the same seed produces the same run.
    """

    __slots__ = ("_departing", "_high", "_jams", "_low", "_obstacles", "_slips", "_steps_to_lose", "position")

    def __init__(self, slips: Sequence[Slip] = (), jams: Sequence[Jam] = (), seed: int = 0) -> None:
        self.position = 0  # true position, steps; 0 at power-up
        self._jams = frozenset((jam.at, jam.direction) for jam in jams)
        self._slips: dict[tuple[int, int], list[_SlipState]] = {}  # by position and direction
        for index, slip in enumerate(slips):
            state = _SlipState(slip, Random(f"{seed}/{index}"))
            for direction in (1, -1):
                if slip.direction != -direction:  # 0 slips in both directions
                    self._slips.setdefault((slip.at, direction), []).append(state)
        self._obstacles = sorted(
            {position for position, _ in self._jams} | {position for position, _ in self._slips}
        )
        self._departing = 0  # direction in which the motor leaves `position`, 0 before it does
        self._steps_to_lose = 0  # remaining steps to lose before the shaft leaves
        self._find_neighbors()

    def _find_neighbors(self) -> None:
        """Find the obstacles next to the position; at an obstacle, the range between them is empty."""
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
        """Follow motor steps from obstacle to obstacle; slips and jams lose some of them."""
        while steps:
            if (self.position, direction) in self._jams:
                self._departing = 0
                break
            steps -= self._lose_steps(direction, steps)
            if steps:
                steps_made = min(steps, self._clear_steps(direction))
                self.position += direction * steps_made
                self._departing = 0
                steps -= steps_made
        self._find_neighbors()

    def _lose_steps(self, direction: int, steps: int) -> int:
        """Begin or continue the slips at the position; return how many steps are lost, at most `steps`."""
        if self._departing != direction:
            self._departing = direction
            slips = self._slips.get((self.position, direction), ())
            self._steps_to_lose = sum(slip.begin() for slip in slips)
        steps_lost = min(self._steps_to_lose, steps)
        self._steps_to_lose -= steps_lost
        return steps_lost

    def _clear_steps(self, direction: int) -> int:
        """Return the number of steps from the position to the next obstacle in a direction."""
        if direction > 0:
            index = bisect_right(self._obstacles, self.position)
            return self._obstacles[index] - self.position if index < len(self._obstacles) else FAR
        index = bisect_left(self._obstacles, self.position)
        return self.position - self._obstacles[index - 1] if index else FAR

    def steps_to(self, direction: int, target: int) -> int | None:
        """Return the motor steps in `direction` to `target`, or None if the shaft can't reach it that way.

        `follow` reaches the target with exactly this number of steps.

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
        """Return the obstacles from the position up to but not including `target`."""
        bisect, low, high = bisect_left, self.position, target
        if direction < 0:
            bisect, low, high = bisect_right, target, self.position
        return self._obstacles[bisect(self._obstacles, low) : bisect(self._obstacles, high)]

    def _due(self, position: int, direction: int) -> int:
        """Return the number of steps lost the next time the shaft passes a position."""
        if position == self.position and self._departing == direction:
            return self._steps_to_lose
        return sum(slip.due() for slip in self._slips.get((position, direction), ()))
