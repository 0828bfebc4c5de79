"""Searches for scenarios that make a program fail.

    from scanrack.jobs.fuzz import never, eventually

    @never
    def command_error(now):
        "no COMMAND_ERROR ever"
        return now.slot[1].status.COMMAND_ERROR

    @eventually("5 s", after=lambda now: now.slot[1].status.IN_ESTOP)
    def stands_still(now):
        "at most 5 s from emergency stop to zero speed"
        return not now.slot[1].moving

A search runs random scenarios one after another, each on a new rack with new logic. Module `shrink`
reduces a scenario that breaks an invariant.
"""

from .invariants.goals import maximize, sometimes
from .invariants.invariants import Invariant, InvariantError, always, eventually, load_invariants, never
from .invariants.scan_view import SlotSnapshot, Snapshot
from .invariants.standard import STANDARD
from .run import BrokenInvariant, TrialBench, Verdict
from .scenarios.scenario import Press, Scenario
from .search import Counterexample, NondeterministicError, SearchReport, search, undisturbed

__all__ = [
    "STANDARD",
    "BrokenInvariant",
    "Counterexample",
    "Invariant",
    "InvariantError",
    "NondeterministicError",
    "Press",
    "Scenario",
    "SearchReport",
    "SlotSnapshot",
    "Snapshot",
    "TrialBench",
    "Verdict",
    "always",
    "eventually",
    "load_invariants",
    "maximize",
    "never",
    "search",
    "sometimes",
    "undisturbed",
]
