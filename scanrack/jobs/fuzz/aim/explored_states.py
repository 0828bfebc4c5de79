"""Ends runs that reach an explored state, that is, one from which another run has continued to its end.

A state is a digest of steps, flags, commands and status, without timers and positions (`Probe.state`). After
the last event, the state of a run is compared with the explored states every `CALM` scans.
"""

from __future__ import annotations

from collections.abc import Callable

from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.cpu import Cpu

from ..scenarios.parts import end_ns, parts_of, timed_parts
from ..scenarios.scenario import Scenario
from .probe import Probe

CALM, RARELY = 100, 1_500
"""Scans between two comparisons: normally, and if the CPU skips repeated scans."""

MOST = 100_000
"""Maximum number of stored states."""


class ExploredStates:
    """The explored states of a search, each with the earliest scan in which a run reached it."""

    def __init__(self) -> None:
        self._first_scans: dict[bytes, int] = {}

    def begin(self, scenario: Scenario, spec: RackSpec) -> ExploredStateStop:
        """Return an object that runs a scenario until it reaches an explored state."""
        last_end_ns = max(map(end_ns, timed_parts(scenario)), default=0)
        timeless_parts = [part for _, part in parts_of(scenario) if not hasattr(part, "at_ns")]
        return ExploredStateStop(self._first_scans, repr(timeless_parts), last_end_ns // spec.scan_ns + 2)


class ExploredStateStop:
    """Runs a CPU to the end of its run, or to a known state.

    Args:
        firsts: first scan of each known state; `learn` adds the states of this run.
        conditions: conditions of the whole run, as text.
        calm_from: first scan after the last event.
    """

    def __init__(self, first_scans: dict[bytes, int], conditions: str, calm_from: int) -> None:
        self._first_scans, self._conditions, self._calm_from = first_scans, conditions, calm_from
        self._visited: dict[bytes, int] = {}
        self.calm = CALM

    def run(self, cpu: Cpu, probe: Probe, scans: int, has_running_clock: Callable[[], bool]) -> None:
        """Run the scans. Stop early in an explored state if no invariant has a running clock."""
        cpu.run(min(scans, self._calm_from) if scans > self.calm else scans)
        while cpu.scan < scans and not cpu.stop_requested:
            cpu.run(min(self.calm, scans - cpu.scan))
            state = probe.state(self._conditions)
            if self._first_scans.get(state, scans) <= cpu.scan and not has_running_clock():
                return
            self._visited.setdefault(state, cpu.scan)

    def learn(self) -> None:
        """Mark the states of this run as explored."""
        for state, scan in self._visited.items():
            if len(self._first_scans) < MOST or state in self._first_scans:
                self._first_scans[state] = min(scan, self._first_scans.get(state, scan))
