"""Searches a user's logic for failures under random conditions.

    from scanrack.jobs.fuzz import never, eventually

    @never
    def command_error(now):
        "no COMMAND_ERROR ever"
        return now.slot[1].status.COMMAND_ERROR

    @eventually("5 s", after=lambda now: now.slot[1].status.IN_ESTOP)
    def stands_still(now):
        "at most 5 s from emergency stop to zero speed"
        return not now.slot[1].moving

Random surroundings (`scenario`) are tried one after the other (`trial`), each with the logic
and the rack is built again; what breaks an invariant is made small by `shrink`.
"""

from .laws.goals import maximise, sometimes
from .laws.invariants import Invariant, InvariantError, always, eventually, load_invariants, never
from .laws.scan_view import Moment, SlotMoment
from .laws.standard import STANDARD
from .run import BrokenInvariant, TrialBench, Verdict
from .scenarios.scenario import Press, Scenario
from .search import Counterexample, SearchReport, UnsteadyError, search, undisturbed

__all__ = [
    "STANDARD",
    "BrokenInvariant",
    "Counterexample",
    "Invariant",
    "InvariantError",
    "Moment",
    "Press",
    "Scenario",
    "SearchReport",
    "SlotMoment",
    "TrialBench",
    "UnsteadyError",
    "Verdict",
    "always",
    "eventually",
    "load_invariants",
    "maximise",
    "never",
    "search",
    "sometimes",
    "undisturbed",
]
