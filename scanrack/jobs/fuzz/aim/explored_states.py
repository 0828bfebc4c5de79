"""Ends runs that reach an explored state: one from which another run has already continued to its end.

A state is a digest by `Probe.state`: steps, flags, commands and status, without timers and positions. Every
`CALM` scans after the last event, the state of a run is compared with the explored ones.
"""

from __future__ import annotations

from collections.abc import Callable

from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.cpu import Cpu

from ..scenarios.parts import end_ns, parts_of, timed_parts
from ..scenarios.scenario import Scenario
from .probe import Probe

CALM, RARELY = 100, 1_500
"""Scans between two comparisons: normally, and where repeated scans are skipped at no cost."""

MOST = 100_000
"""Largest number of stored states."""


class ExploredStates:
    """The states of one search, each with the first scan in which a run reached it."""

    def __init__(self) -> None:
        self._firsts: dict[bytes, int] = {}

    def begin(self, scenario: Scenario, spec: RackSpec) -> ExploredStateStop:
        """Return an object that runs a scenario and ends it in an explored state."""
        ends_ns = map(end_ns, timed_parts(scenario))
        timeless_parts = [part for _, part in parts_of(scenario) if not hasattr(part, "at_ns")]
        return ExploredStateStop(
            self._firsts, repr(timeless_parts), max(ends_ns, default=0) // spec.scan_ns + 2
        )


class ExploredStateStop:
    """Runs a CPU to the end of its run, or to a known state.

    Args:
        firsts: first scan of each known state; `learn` adds the states of this run.
        conditions: conditions of the whole run, as text.
        calm_from: first scan after the last event.
    """

    def __init__(self, firsts: dict[bytes, int], conditions: str, calm_from: int) -> None:
        self._firsts, self._conditions, self._calm_from = firsts, conditions, calm_from
        self._passed: dict[bytes, int] = {}
        self.calm = CALM

    def run(self, cpu: Cpu, probe: Probe, scans: int, waits: Callable[[], bool]) -> None:
        """Run the scans; stop early in a known state while no invariant's clock runs.

        Args:
            waits: returns whether an invariant's clock runs.
        """
        cpu.run(min(scans, self._calm_from) if scans > self.calm else scans)
        while cpu.scan < scans and not cpu.stop_requested:
            cpu.run(min(self.calm, scans - cpu.scan))
            state = probe.state(self._conditions)
            if self._firsts.get(state, scans) <= cpu.scan and not waits():
                return
            self._passed.setdefault(state, cpu.scan)

    def learn(self) -> None:
        """Add the states of this run, which broke no invariant."""
        for state, scan in self._passed.items():
            if len(self._firsts) < MOST or state in self._firsts:
                self._firsts[state] = min(scan, self._firsts.get(state, scan))
