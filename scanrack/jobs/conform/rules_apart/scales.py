"""Factors of acceleration, deceleration and speed, fitted to a scene that the model does not explain.

    factor    500 ......... 905 | 912 ...... 951 | 958 ......... 2000   thousandths
    reads      12    ...    310 |      all       | 301    ...      11   explained

The nearer a factor is to the module's, the longer it explains what is read. From a coarse row the search
continues between the best factors and their neighbors, to one that explains every read; the first ones
below and above it that a read contradicts bound the module's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from scanrack.runtime.modules.amci3601.altered import Alteration
from scanrack.runtime.modules.amci3601.scaled_axis import AxisScales

from ..hypotheses import Search

UNIT = 1000
"""A factor of 1."""

COARSE = tuple(round(UNIT * 1.05**power) for power in range(-14, 15))
"""Factors that are tried first, in thousandths: from 0.5 to 2."""

FARTHEST = 200
"""Longest way from a factor that explains all to one that is contradicted."""

Trial = Callable[[Alteration], Search]


@dataclass(frozen=True, slots=True)
class _ScaleKind:
    sentence: str
    of: str
    fields: tuple[str, ...]
    rule: str


SCALED: Mapping[str, _ScaleKind] = {
    "acceleration": _ScaleKind("It accelerates at", "rate", ("acceleration",), "PRO-03"),
    "deceleration": _ScaleKind("It decelerates at", "rate", ("deceleration",), "PRO-07"),
    "speed": _ScaleKind("It runs at", "speed", ("speed",), "PRO-01"),
    "rates": _ScaleKind(
        "It accelerates and decelerates at", "rate", ("acceleration", "deceleration"), "PRO-07"
    ),
}
"""What is fitted, in order: its fields of `AxisScales`, and the rule that it departs from."""


@dataclass(frozen=True, slots=True)
class FittedScale:
    """A factor that explains every read of a scene.

    Attributes:
        what: of `SCALED`.
        low: the largest factor below it that a read contradicts.
        high: the smallest factor above it that a read contradicts.
    """

    what: str
    low: float
    high: float

    @property
    def rule(self) -> str:
        """The rule of the manual that the module departs from."""
        return SCALED[self.what].rule

    @property
    def sentence(self) -> str:
        """What the module does, with the factor and its uncertainty.

        >>> FittedScale("acceleration", 0.924, 0.938).sentence
        'It accelerates at 0.931 ± 0.007 of the programmed rate.'
        """
        row = SCALED[self.what]
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
        return f"{row.sentence} {middle:.3f} ± {half:.3f} of the programmed {row.of}."

    def within(self, other: FittedScale) -> FittedScale | None:
        """Return what two scenes leave of a factor; None if they contradict each other."""
        low, high = max(self.low, other.low), min(self.high, other.high)
        return FittedScale(self.what, low, high) if self.what == other.what and low < high else None


def either(scales: Sequence[FittedScale]) -> str:
    """Return what a module does, as a sentence: one of several scales that explain the same reads."""
    first, *more = (each.sentence.removesuffix(".") for each in scales)
    return ", or i".join([first, *(each[1:] for each in more)]) + "."


def without_lesser(scenes: Sequence[list[FittedScale]]) -> list[list[FittedScale]]:
    """Return the scales of each scene without a kind that explains less than another one does.

    A short scene leaves several kinds; one that explains all that another explains, and more, is likelier.
    """
    explains: dict[str, set[int]] = {}
    for number, scales in enumerate(scenes):
        for each in scales:
            explains.setdefault(each.what, set()).add(number)
    lesser = {what for what, mine in explains.items() if any(mine < other for other in explains.values())}
    return [[each for each in scales if each.what not in lesser] for scales in scenes]


def scaled(what: str, factor: int) -> Alteration:
    """Return a module that is off by a factor, in thousandths; it speaks of itself as `FittedScale` does."""
    row = SCALED[what]
    scales = AxisScales(**dict.fromkeys(row.fields, Fraction(factor, UNIT)))
    return Alteration(f"{row.sentence} {factor / UNIT} of the programmed {row.of}.", scales=scales)


def fitted(trial: Trial) -> Iterator[FittedScale]:
    """Yield the scales that explain a scene; both rates together only if neither of them alone does.

    Args:
        trial: judges the scene with an alteration.
    """
    alone = False
    for what, row in SCALED.items():
        if len(row.fields) > 1 and alone:
            continue
        found = _Fit(what, trial).found()
        if found is not None:
            alone = True
            yield found


class _Fit:
    """The search for one factor."""

    def __init__(self, what: str, trial: Trial) -> None:
        self._what, self._trial = what, trial
        self._known: dict[int, Search] = {}

    def _at(self, factor: int) -> Search:
        if factor not in self._known:
            self._known[factor] = self._trial(scaled(self._what, factor))
        return self._known[factor]

    def found(self) -> FittedScale | None:
        """Return the factor; None if none explains every read."""
        for each in COARSE:
            self._at(each)
        while not any(each.explains_all for each in self._known.values()):
            between = self._between()
            if not between:
                return None
            for each in between:
                self._at(each)
        inside = next(factor for factor, each in self._known.items() if each.explains_all)
        low, high = self._bound(inside, -1), self._bound(inside, 1)
        return None if low is None or high is None else FittedScale(self._what, low / UNIT, high / UNIT)

    def _between(self) -> set[int]:
        """Return the factors half-way from those with most reads to their neighbors with fewer.

        On one side of the module's factor the scale may be contradicted by the same read however far it is
        off; the factor is at the edge of such a row.
        """
        known = sorted(self._known)
        reads = [self._known[each].reads for each in known]
        most = max(reads)
        edges = [
            pair
            for place, pair in enumerate(pairwise(known))
            if most in (counts := reads[place : place + 2]) and min(counts) < most
        ]
        return {(low + high) // 2 for low, high in edges} - self._known.keys()

    def _bound(self, inside: int, sense: int) -> int | None:
        """Return the nearest factor on one side that a read contradicts, to a thousandth; None if far off."""
        step = 1
        while self._at(inside + sense * step).unexplained is None:
            if step > FARTHEST:
                return None
            step *= 2
        near, far = step // 2, step
        while far - near > 1:
            middle = (near + far) // 2
            near, far = (near, middle) if self._at(inside + sense * middle).unexplained else (middle, far)
        return inside + sense * far
