"""Searches a user's logic for failures under random conditions.

    from scanrack.runtime.app.fuzz import never, within

    @never
    def command_error(now):
        "no COMMAND_ERROR ever"
        return now.slot[1].status.COMMAND_ERROR

    @within("5 s", after=lambda now: now.slot[1].status.IN_ESTOP)
    def stands_still(now):
        "at most 5 s from emergency stop to zero speed"
        return not now.slot[1].moving

Random surroundings (`scenario`) are tried one after the other (`trial`), each with the logic
and the rack is built again; what breaks an invariant is shrunk by Hypothesis (`search`).
"""

from .invariants import Invariant, InvariantError, always, load_invariants, never, within
from .run import Bench, Broken, Verdict
from .scan_view import Moment, SlotMoment
from .scenario import Press, Scenario
from .search import Found, Report, UnsteadyError, search, undisturbed
from .standard import STANDARD

__all__ = [
    "STANDARD",
    "Bench",
    "Broken",
    "Found",
    "Invariant",
    "InvariantError",
    "Moment",
    "Press",
    "Report",
    "Scenario",
    "SlotMoment",
    "UnsteadyError",
    "Verdict",
    "always",
    "load_invariants",
    "never",
    "search",
    "undisturbed",
    "within",
]
