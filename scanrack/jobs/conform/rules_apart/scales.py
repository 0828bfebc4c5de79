"""Factors of acceleration, deceleration and speed, fitted to a scene that the model does not explain.

    factor    500 ......... 905 | 912 ...... 951 | 958 ......... 2000   thousandths
    reads      12    ...    310 |      all       | 301    ...      11   explained

The closer a factor is to the module's own, the more reads it explains. The search begins with a coarse row of
factors and continues between the best ones and their neighbors, until one explains every read. The nearest
contradicted factors below and above it bound the module's own factor.
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
"""The factor 1, in thousandths."""

COARSE = tuple(round(UNIT * 1.05**power) for power in range(-14, 15))
"""Factors that are tried first, in thousandths: 0.5 to 2."""

FARTHEST = 200
"""Largest distance searched from a factor that explains every read to a contradicted one, in thousandths."""

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
"""The quantities to fit, in order, each with its fields of `AxisScales` and the rule that it departs from."""


@dataclass(frozen=True, slots=True)
class FittedScale:
    """A factor that explains every read of a scene.

    Attributes:
        what: a key of `SCALED`.
        low: the largest smaller factor that a read contradicts.
        high: the smallest larger factor that a read contradicts.
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
        """What the module does, with the factor and its uncertainty, as a sentence.

        >>> FittedScale("acceleration", 0.924, 0.938).sentence
        'It accelerates at 0.931 ± 0.007 of the programmed rate.'
        """
        row = SCALED[self.what]
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
        return f"{row.sentence} {middle:.3f} ± {half:.3f} of the programmed {row.of}."

    def within(self, other: FittedScale) -> FittedScale | None:
        """Return the range of the factor that two scenes leave; None if they contradict each other."""
        low, high = max(self.low, other.low), min(self.high, other.high)
        return FittedScale(self.what, low, high) if self.what == other.what and low < high else None


def either(scales: Sequence[FittedScale]) -> str:
    """Return a sentence about several scales that explain the same reads, joined by "or"."""
    first, *others = (scale.sentence.removesuffix(".") for scale in scales)
    return ", or i".join([first, *(sentence[1:] for sentence in others)]) + "."


def without_lesser(scenes: Sequence[list[FittedScale]]) -> list[list[FittedScale]]:
    """Return the scales of each scene, without kinds that explain fewer scenes than another kind.

    A short scene can't tell several kinds apart. A kind that explains the same scenes and more is likelier.
    """
    explains: dict[str, set[int]] = {}
    for number, scales in enumerate(scenes):
        for scale in scales:
            explains.setdefault(scale.what, set()).add(number)
    lesser = {
        kind for kind, explained in explains.items() if any(explained < other for other in explains.values())
    }
    return [[kept_scale for kept_scale in scales if kept_scale.what not in lesser] for scales in scenes]


def scaled(what: str, factor: int) -> Alteration:
    """Return a module that is off by a factor, in thousandths; its sentence is like that of `FittedScale`."""
    row = SCALED[what]
    scales = AxisScales(**dict.fromkeys(row.fields, Fraction(factor, UNIT)))
    return Alteration(f"{row.sentence} {factor / UNIT} of the programmed {row.of}.", scales=scales)


def fitted(trial: Trial) -> Iterator[FittedScale]:
    """Yield the scales that explain a scene; both rates together only if neither alone explains it.

    Args:
        trial: judges the scene with an altered module.
    """
    alone = False
    for quantity, row in SCALED.items():
        if len(row.fields) > 1 and alone:
            continue
        scale = _Fit(quantity, trial).found()
        if scale is not None:
            alone = True
            yield scale


class _Fit:
    """A search for one factor."""

    def __init__(self, what: str, trial: Trial) -> None:
        self._what, self._trial = what, trial
        self._known: dict[int, Search] = {}

    def _at(self, factor: int) -> Search:
        if factor not in self._known:
            self._known[factor] = self._trial(scaled(self._what, factor))
        return self._known[factor]

    def found(self) -> FittedScale | None:
        """Return the factor with its bounds; None if no factor explains every read."""
        for candidate in COARSE:
            self._at(candidate)
        while not any(fit.explains_all for fit in self._known.values()):
            between = self._between()
            if not between:
                return None
            for candidate in between:
                self._at(candidate)
        inner_factor = next(factor for factor, fit in self._known.items() if fit.explains_all)
        low, high = self._bound(inner_factor, -1), self._bound(inner_factor, 1)
        return None if low is None or high is None else FittedScale(self._what, low / UNIT, high / UNIT)

    def _between(self) -> set[int]:
        """Return the factors halfway between those that explain most reads and their neighbors.

        On one side of the module's factor, the same read may contradict every factor, however far off. The
        factor is then at the edge of such a row.
        """
        factors = sorted(self._known)
        reads = [self._known[factor].reads for factor in factors]
        most = max(reads)
        edges = [
            pair
            for place, pair in enumerate(pairwise(factors))
            if most in (counts := reads[place : place + 2]) and min(counts) < most
        ]
        return {(low + high) // 2 for low, high in edges} - self._known.keys()

    def _bound(self, inside: int, sense: int) -> int | None:
        """Return the nearest contradicted factor on one side, to a thousandth; None if it is too far off."""
        step = 1
        while self._at(inside + sense * step).unexplained is None:
            if step > FARTHEST:
                return None
            step *= 2
        near_step, far = step // 2, step
        while far - near_step > 1:
            middle = (near_step + far) // 2
            near_step, far = (
                (near_step, middle) if self._at(inside + sense * middle).unexplained else (middle, far)
            )
        return inside + sense * far
