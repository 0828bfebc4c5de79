"""Factors of acceleration, deceleration and speed, fitted to a scene that the model does not explain.

    factor    500 ......... 905 | 912 ...... 951 | 958 ......... 2000   thousandths
    reads      12    ...    310 |      all       | 301    ...      11   explained

The closer a factor is to the module's factor, the more reads it explains. The search begins with a coarse
series of factors. It continues between the best factors and their neighbors until a factor explains every
read. The nearest contradicted factors on both sides bound the module's factor.
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
"""A factor of 1, in thousandths."""

COARSE = tuple(round(UNIT * 1.05**power) for power in range(-14, 15))
"""Factors that are tried first, in thousandths: 0.5 to 2."""

FARTHEST = 200
"""Largest distance from a factor that explains every read to a contradicted factor, in thousandths."""

Trial = Callable[[Alteration], Search]


@dataclass(frozen=True, slots=True)
class _ScaleKind:
    sentence: str  # beginning of the sentence about the module
    unit: str  # the programmed quantity that the factor multiplies
    fields: tuple[str, ...]  # of `AxisScales`
    rule: str  # the rule that the module departs from


SCALED: Mapping[str, _ScaleKind] = {
    "acceleration": _ScaleKind("It accelerates at", "rate", ("acceleration",), "PRO-03"),
    "deceleration": _ScaleKind("It decelerates at", "rate", ("deceleration",), "PRO-07"),
    "speed": _ScaleKind("It runs at", "speed", ("speed",), "PRO-01"),
    "rates": _ScaleKind(
        "It accelerates and decelerates at", "rate", ("acceleration", "deceleration"), "PRO-07"
    ),
}
"""The quantities to fit, in order."""


@dataclass(frozen=True, slots=True)
class FittedScale:
    """A factor that explains every read of a scene.

    Attributes:
        what: the quantity, a key of `SCALED`.
        low: the nearest lower factor that a read contradicts.
        high: the nearest higher factor that a read contradicts.
    """

    what: str
    low: float
    high: float

    @property
    def rule(self) -> str:
        """The manual's rule from which the module departs."""
        return SCALED[self.what].rule

    @property
    def sentence(self) -> str:
        """A sentence about the module, with the factor and its uncertainty.

        >>> FittedScale("acceleration", 0.924, 0.938).sentence
        'It accelerates at 0.931 ± 0.007 of the programmed rate.'
        """
        row = SCALED[self.what]
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
        return f"{row.sentence} {middle:.3f} ± {half:.3f} of the programmed {row.unit}."

    def within(self, other: FittedScale) -> FittedScale | None:
        """Return the range of the factor that is common to two scenes; None if they contradict each other."""
        low, high = max(self.low, other.low), min(self.high, other.high)
        return FittedScale(self.what, low, high) if self.what == other.what and low < high else None


def either(scales: Sequence[FittedScale]) -> str:
    """Return a sentence about several scales that explain the same reads, joined by "or"."""
    first, *others = (scale.sentence.removesuffix(".") for scale in scales)
    return ", or ".join([first, *(sentence[0].lower() + sentence[1:] for sentence in others)]) + "."


def without_lesser(scenes: Sequence[list[FittedScale]]) -> list[list[FittedScale]]:
    """Return each scene's scales, without quantities that explain fewer scenes than another quantity.

    A short scene can't tell several quantities apart. A quantity that explains the same scenes and others is
    more likely.
    """
    explained: dict[str, set[int]] = {}  # by quantity: numbers of the scenes that it explains
    for number, scales in enumerate(scenes):
        for scale in scales:
            explained.setdefault(scale.what, set()).add(number)
    all_numbers = explained.values()
    lesser = {what for what, numbers in explained.items() if any(numbers < more for more in all_numbers)}
    return [[scale for scale in scales if scale.what not in lesser] for scales in scenes]


def scaled(quantity: str, factor: int) -> Alteration:
    """Return a module with a quantity that is off by a factor, in thousandths."""
    row = SCALED[quantity]
    scales = AxisScales(**dict.fromkeys(row.fields, Fraction(factor, UNIT)))
    return Alteration(f"{row.sentence} {factor / UNIT} of the programmed {row.unit}.", scales=scales)


def fitted(trial: Trial) -> Iterator[FittedScale]:
    """Yield the scales that explain a scene; both rates together only if no single quantity explains it.

    Args:
        trial: judges the scene with an altered module.
    """
    has_single = False
    for quantity, row in SCALED.items():
        if len(row.fields) > 1 and has_single:
            continue
        scale = _Fit(quantity, trial).fit()
        if scale is not None:
            has_single = True
            yield scale


class _Fit:
    """A search for the factor of a quantity."""

    def __init__(self, quantity: str, trial: Trial) -> None:
        self._quantity, self._trial = quantity, trial
        self._results: dict[int, Search] = {}  # by factor

    def _try(self, factor: int) -> Search:
        """Return the search result for a factor. Results are cached."""
        if factor not in self._results:
            self._results[factor] = self._trial(scaled(self._quantity, factor))
        return self._results[factor]

    def fit(self) -> FittedScale | None:
        """Return the factor with its bounds; None if no factor explains every read."""
        for factor in COARSE:
            self._try(factor)
        while not any(result.explains_all for result in self._results.values()):
            between = self._between()
            if not between:
                return None
            for factor in between:
                self._try(factor)
        inside = next(factor for factor, result in self._results.items() if result.explains_all)
        low, high = self._bound(inside, -1), self._bound(inside, 1)
        return None if low is None or high is None else FittedScale(self._quantity, low / UNIT, high / UNIT)

    def _between(self) -> set[int]:
        """Return the factors halfway between factors that explain most reads and their neighbors.

        On one side of the module's factor, the same read may contradict every factor, however far away. The
        module's factor is then at the edge of this range.
        """
        factors = sorted(self._results)
        most = max(self._results[factor].reads for factor in factors)
        halfway = set()
        for low, high in pairwise(factors):
            reads = self._results[low].reads, self._results[high].reads
            if max(reads) == most and min(reads) < most:
                halfway.add((low + high) // 2)
        return halfway - self._results.keys()

    def _bound(self, inside: int, sense: int) -> int | None:
        """Return the nearest contradicted factor on one side, to a thousandth; None if it is too far away.

        Args:
            inside: a factor that explains every read.
            sense: 1 for the side of higher factors, -1 for lower factors.
        """
        distance = 1
        while self._try(inside + sense * distance).unexplained is None:
            if distance > FARTHEST:
                return None
            distance *= 2
        near, far = distance // 2, distance
        while far - near > 1:
            middle = (near + far) // 2
            if self._try(inside + sense * middle).unexplained:
                far = middle
            else:
                near = middle
        return inside + sense * far
