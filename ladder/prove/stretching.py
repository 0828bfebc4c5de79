"""Runs with longer scans than the rack's, so a timer of 5 s needs 5 scans instead of 500.

A long run only suggests a run of the rack. Each long scan is split into several short scans with unchanged
inputs, and the compiled program checks the result.
"""

from __future__ import annotations

from typing import Any

from .algebra.numbers import eq, rem
from .algebra.terms import and_, const
from .system import DT, OFF, RETAINED, TURNED, ProgramSystem, ScanBounds, ms_of
from .system.transition import MS

STRETCHED_MS = 1000
"""Longest scan of a long run, in ms."""


def stretched(problem: ProgramSystem) -> ProgramSystem:
    """Return the same problem with scans of up to a second; a fixed scan time may become any multiple."""
    (low, high), tick_ns = problem.bounds.ticks, problem.bounds.tick_ns
    step = low if low == high else 1
    most = max(high, STRETCHED_MS * MS // tick_ns // step * step)
    bounds = ScanBounds(problem.bounds.low_ms, ms_of(most, tick_ns), tick_ns)
    longer = ProgramSystem(problem.program, bounds, beside=problem, **problem.settings)
    if step > 1:
        multiple = eq(rem(longer.machine.dt, const(step)), const(0))
        longer.contract = and_(longer.contract, multiple)
    return longer


def in_short_scans(
    bounds: ScanBounds, longer: ProgramSystem, scans: list[dict[str, Any]], *, inputs_first: bool
) -> list[dict[str, Any]]:
    """Split long scans into scans of the rack's length; inputs change before the first or the last one."""
    short_scans: list[dict[str, Any]] = []
    previous: dict[str, Any] = {}
    for number, values in enumerate(scans):
        pieces = _pieces(values.get(DT, longer.least), bounds) if number else [0]
        current = {name: value for name, value in values.items() if name in longer.key_of}
        events = {name: values[name] for name in (TURNED, RETAINED, OFF) if name in values}
        held = current if inputs_first else previous
        short_scans += [{**held, DT: time} for time in pieces[:-1]]
        short_scans.append({**current, DT: pieces[-1], **events})
        previous = current
    return short_scans


def _pieces(time: int, bounds: ScanBounds) -> list[int]:
    """Split a time into scan times within the bounds; their sum is as close to the time as possible."""
    low, high = bounds.ticks
    count = -(-time // high)
    share, remainder = divmod(time, count)
    return [max(low, share + (number < remainder)) for number in range(count)]
