"""Turns the claims of a rack and its program into invariants, so that a search tests them without a proof."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from scanrack.ladder.prove.claims import ClaimKind
from scanrack.ladder.prove.monitors import ClaimWatch, MonitoredProgram

from .invariants import FOREVER_NS, Invariant
from .scan_view import Snapshot


def invariants_in(program: MonitoredProgram) -> Iterator[Invariant]:
    """Yield an invariant for each property of a program with monitors.

    No property counts as broken after an assumption has failed.
    """
    for claim in program.properties:
        if claim.claim.kind is not ClaimKind.REACHABLE:
            yield Invariant(claim.claim.name, claim.claim.sentence, partial(_SnapshotWatch, program, claim))


class _SnapshotWatch(ClaimWatch):
    """Checks a property in every scan of a run."""

    def __call__(self, now: Snapshot) -> str | None:
        return "the property is false" if self.is_broken(now.tags) else None

    def same_until_ns(self, _counting: bool) -> int:
        """See `Watch`."""
        return FOREVER_NS
