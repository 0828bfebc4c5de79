"""Delta debugging: finds the smallest scenario with the same failure.

Two kinds of steps are repeated until neither of them helps:

    parts     remove half of the parts, a quarter, ..., and finally each part
    numbers   make a part's time, duration or count rounder; also choose the simplest input, the newest
              firmware, and the fewest late words that still fail

At the end, no single part can be removed, and no number can be made rounder. A number is rounder if it has
fewer significant decimal digits (166 ms, 170 ms, 200 ms, 0), or the same number of digits and is smaller. The
candidates for a number are 0; 1, 2 or 5 in every decade below it; and its neighbors with fewer digits. Times
stay multiples of the scan time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from types import MappingProxyType
from typing import Any

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.io_images.amci3601.firmware import KNOWN
from scanrack.runtime.loop.incidents import InjectedFault

from .run import BrokenInvariant
from .scenarios.parts import Lasting, Part, Timed, parts_of, scenario_of
from .scenarios.scenario import LostSteps, Press, Scenario, Signal, SwitchOffset, Turn

Inputs = Mapping[int, Sequence[InputBit]]
"""Inputs by slot number, the simplest to press first."""

STEPS = (1, 2, 5)
"""Leading digits of round numbers."""


def smallest(
    scenario: Scenario,
    broken: BrokenInvariant,
    breaks: Callable[[Scenario], BrokenInvariant | None],
    inputs: Inputs = MappingProxyType({}),
    scan_ns: int = 2_000_000,
) -> tuple[Scenario, BrokenInvariant]:
    """Return the smallest scenario with the same failure, and its failure.

    Args:
        breaks: runs a scenario; returns its failure if it is the same failure, else None.
        inputs: inputs that can be pressed, the simplest first, by slot.
        scan_ns: time from scan to scan. Candidate times are multiples of it.
    """
    shrinker = _Shrinker(scenario, broken, breaks, inputs, scan_ns)
    while shrinker.drop_parts() or shrinker.simplify_parts():
        pass
    return shrinker.scenario, shrinker.broken


class _Shrinker:
    """Shrinks a scenario step by step.

    Attributes:
        scenario: the smallest scenario so far.
        broken: its failure.
    """

    def __init__(
        self,
        scenario: Scenario,
        broken: BrokenInvariant,
        breaks: Callable[[Scenario], BrokenInvariant | None],
        inputs: Inputs,
        scan_ns: int,
    ) -> None:
        self.scenario, self.broken = scenario, broken
        self._breaks = breaks
        self._inputs, self._scan_ns = inputs, scan_ns
        self._tried = {scenario}

    def drop_parts(self) -> bool:
        """Remove parts that the failure does not need; return whether any was removed."""
        original = self.scenario
        count = len(parts_of(original)) or 1
        while count:
            start = 0
            while start < len(parts := parts_of(self.scenario)):
                if not self._try_parts([*parts[:start], *parts[start + count :]]):
                    start += count
            count //= 2
        return self.scenario != original

    def simplify_parts(self) -> bool:
        """Make numbers and other values simpler; return whether any was simplified."""
        original = self.scenario
        for index in range(len(parts_of(original))):
            while self._simplify(index):
                pass
        return self.scenario != original

    def _simplify(self, index: int) -> bool:
        """Replace a part by its simplest version that still fails; return whether there is one."""
        parts = parts_of(self.scenario)
        field, part = parts[index]
        return any(
            self._try_parts([*parts[:index], (field, simpler), *parts[index + 1 :]])
            for simpler in simpler_parts(part, self._inputs, self._scan_ns)
        )

    def _try_parts(self, parts: Sequence[Part]) -> bool:
        """Keep the scenario with these parts if it has the same failure; return whether it does."""
        scenario = scenario_of(parts)
        if scenario in self._tried:
            return False
        self._tried.add(scenario)
        broken = self._breaks(scenario)
        if broken is None:
            return False
        self.scenario, self.broken = scenario, broken
        return True


def simpler_parts(part: Any, inputs: Inputs, scan_ns: int) -> Iterator[Any]:
    """Yield simpler versions of a part, the simplest of each kind first."""
    if isinstance(part, tuple):  # a slot and its firmware
        slot, version = part
        yield from ((slot, newer) for newer in _newer(version))
        return
    for kinds, field, values in SIMPLER:
        if isinstance(part, kinds):
            yield from (replace(part, **{field: value}) for value in values(part, inputs, scan_ns))


SIMPLER: tuple[tuple[Any, str, Callable[[Any, Inputs, int], Iterable[Any]]], ...] = (
    (Timed, "at_ns", lambda part, _, scan_ns: _rounder_times(part.at_ns, scan_ns)),
    (Lasting, "for_ns", lambda part, _, scan_ns: filter(None, _rounder_times(part.for_ns, scan_ns))),
    (Press, "input", lambda part, inputs, _: _simpler_inputs(part.input, inputs.get(part.slot, ()))),
    (Signal, "value", lambda part, *_: map(float, rounder(int(part.value)) if part.value % 1 == 0 else ())),
    (Turn, "counts", lambda part, *_: filter(None, rounder(part.counts))),
    (InjectedFault, "late_words", lambda part, *_: _fewer(part.late_words)),
    (LostSteps, "at", lambda part, *_: rounder(part.at)),
    (LostSteps | SwitchOffset, "steps", lambda part, *_: filter(None, rounder(part.steps))),
)
"""Kinds of parts, a field of these parts, and a function that yields simpler values, in the order of use."""


def _simpler_inputs(input_bit: InputBit, inputs: Sequence[InputBit]) -> Iterator[InputBit]:
    """Yield the inputs that come before an input, since they are simpler."""
    return takewhile(lambda bit: bit is not input_bit, inputs)


def _fewer(words: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Yield the late words with one of them left out. A single word is kept."""
    return (words[:index] + words[index + 1 :] for index in range(len(words)) if len(words) > 1)


def _newer(version: str) -> Iterator[str]:
    """Yield the versions that are newer than a version, newest first."""
    names = [str(known) for known in KNOWN]
    if version in names:
        yield from reversed(names[names.index(version) + 1 :])


def digits(number: int) -> int:
    """Return the number of significant decimal digits.

    >>> digits(0), digits(200_000_000), digits(-1_500)
    (0, 1, 2)
    """
    return len(str(abs(number)).rstrip("0")) if number else 0


def _rounder_times(time_ns: int, scan_ns: int) -> Iterator[int]:
    """Yield rounder multiples of the scan time: first rounder times, then rounder numbers of scans."""
    by_time = (candidate_ns for candidate_ns in rounder(time_ns) if candidate_ns % scan_ns == 0)
    by_scans = (count * scan_ns for count in rounder(time_ns // scan_ns))
    for candidate_ns in dict.fromkeys((*by_time, *by_scans)):
        if (digits(candidate_ns), candidate_ns) < (digits(time_ns), time_ns):
            yield candidate_ns


def rounder(number: int) -> Iterator[int]:
    """Yield rounder numbers with the same sign, the roundest first.

    >>> list(rounder(166))
    [0, 1, 2, 5, 10, 20, 50, 100, 200, 160, 170]
    >>> list(rounder(-20)), list(rounder(0))
    ([0, -1, -2, -5, -10], [])
    """
    size, sign = abs(number), -1 if number < 0 else 1
    candidates = [0, *_round_below(size), *_neighbors(size)] if size else []
    yield from (sign * candidate for candidate in dict.fromkeys(candidates))


def _round_below(size: int) -> Iterator[int]:
    """Yield 1, 2 and 5 in every decade below a number."""
    decade = 1
    while decade < size:
        yield from (step * decade for step in STEPS if step * decade < size)
        decade *= 10


def _neighbors(size: int) -> Iterator[int]:
    """Yield the closest numbers with fewer significant digits, below and above."""
    length = len(str(size))
    for digit_count in range(1, digits(size)):
        unit = 10 ** (length - digit_count)
        below = size // unit * unit
        yield from (below, below + unit)
