"""Claims of a job: assumptions and properties in its rack file and its ladder program."""

from __future__ import annotations

from scanrack.ladder import LadderLogic
from scanrack.ladder.prove.claims import Claim, ClaimKind, claims_in
from scanrack.ladder.prove.monitors import MonitoredProgram, monitored, never_routines
from scanrack.runtime.config.rackspec import RackSpec

from .loading import LoadedRack


def claims_of(spec: RackSpec) -> list[Claim]:
    """Return the assumptions and properties of a rack file, in file order."""
    table = spec.prove
    assumed = [Claim(f"assume {text}", ClaimKind.ASSUME, text) for text in table.assume]
    return assumed + [
        Claim(row.name, ClaimKind(row.claim), row.condition, row.assume) for row in table.property
    ]


NO_LADDER = "{}: the program is in Python; proofs cover only ladder logic and structured text"
"""Error message for a program without ladder logic; the placeholder is the program's path."""


def has_claims(job: LoadedRack) -> bool:
    """Return whether a job has claims in its rack file, in comments, or in a routine named NEVER."""
    if not isinstance(job.logic, LadderLogic):
        return False
    return bool(job.spec.prove.property or claims_in(job.logic.build()) or never_routines(job.logic))


def with_monitors(job: LoadedRack) -> MonitoredProgram:
    """Return a job's ladder program with a monitor for each of its claims.

    Raises:
        ValueError: a claim can't be used, or the program is in Python and so has no claims.
    """
    if not isinstance(job.logic, LadderLogic):
        raise ValueError(NO_LADDER.format(job.program))
    return monitored(job.logic, claims_of(job.spec), [slot.number for slot in job.spec.slot])
