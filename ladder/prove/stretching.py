"""Runs with longer scans than the rack's: what takes a timer of 5 s 500 scans takes five here.

Such a run only suggests one of the rack: the time of each long scan passes in short ones with the inputs
held, and the program decides.
"""

from __future__ import annotations

from typing import Any

from .algebra.numbers import eq, rem
from .algebra.terms import and_, const
from .system import DT, OFF, RETAINED, TURNED, ProgramSystem, ScanBounds

STRETCHED_MS = 1000
"""Longest scan of such a run."""


def stretched(problem: ProgramSystem) -> ProgramSystem:
    """Return the same problem with scans of up to a second, multiples of a fixed scan time."""
    low, high = problem.bounds.low_ms, problem.bounds.high_ms
    step = low if low == high else 1
    bounds = ScanBounds(low, max(high, STRETCHED_MS // step * step), problem.bounds.whole)
    longer = ProgramSystem(problem.program, bounds, beside=problem, **problem.settings)
    if step > 1:
        multiple = eq(rem(longer.machine.dt, const(step)), const(0))
        longer.contract = and_(longer.contract, multiple)
    return longer


def in_short_scans(
    bounds: ScanBounds, longer: ProgramSystem, scans: list[dict[str, Any]], *, inputs_first: bool
) -> list[dict[str, Any]]:
    """Return the scans of the rack for long ones; the inputs change before the first or the last of them."""
    found: list[dict[str, Any]] = []
    before: dict[str, Any] = {}
    for number, values in enumerate(scans):
        pieces = _pieces(values.get(DT, longer.least_ms), bounds) if number else [0]
        now = {name: value for name, value in values.items() if name in longer.key_of}
        told = {name: values[name] for name in (TURNED, RETAINED, OFF) if name in values}
        for place, ms in enumerate(pieces):
            held = now if inputs_first or place == len(pieces) - 1 else before
            behind = told if place == len(pieces) - 1 else {}
            found.append({**held, DT: ms, **behind})
        before = now
    return found


def _pieces(ms: int, bounds: ScanBounds) -> list[int]:
    """Return times within the bounds that add up to a time, as far as they can."""
    count = -(-ms // bounds.high_ms)
    share, rest = divmod(ms, count)
    return [max(bounds.low_ms, share + (number < rest)) for number in range(count)]
