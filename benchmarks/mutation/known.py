"""Mutants that can't be told from the original, each with its reason; and those that CI tries."""

from __future__ import annotations

from typing import NamedTuple

from .operators import Mutant


class Equivalent(NamedTuple):
    """A mutant that behaves like the original.

    Attributes:
        path: the file's name.
        scope: function or table.
        old: the text that is replaced.
        new: the text in its place.
        reason: why nobody can tell.
    """

    path: str
    scope: str
    old: str
    new: str
    reason: str


EQUIVALENT: tuple[Equivalent, ...] = ()


def reason_for(mutant: Mutant) -> str | None:
    """Return why a mutant is equivalent, or None if it is not known to be."""
    for known in EQUIVALENT:
        here = (mutant.path.rsplit("/", 1)[-1], mutant.scope, mutant.old, mutant.new)
        if here == known[:4]:
            return known.reason
    return None


class Smoke(NamedTuple):
    """A mutant that SMOKE_TESTS have to kill: path, scope, old and new text."""

    path: str
    scope: str
    old: str
    new: str


SMOKE_TESTS = "tests/manual/test_moves_in_time.py"

SMOKE: tuple[Smoke, ...] = (
    Smoke("runtime/amci3601/profile_move.py", "ProfileMove.on_end", "HOLD_STATE", "0"),
    Smoke("runtime/amci3601/command_layer.py", "CommandLayer.cut", "self.axis.cut(now_ns)", "pass"),
    Smoke("runtime/amci3601/manual_move.py", "ManualMove._stop", "not self.stopping", "self.stopping"),
)
