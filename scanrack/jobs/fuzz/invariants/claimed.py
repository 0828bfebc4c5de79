"""Turns the claims of a rack and its program into invariants: a search tests what `scanrack prove` proves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from scanrack.ladder.prove.claims import ClaimKind
from scanrack.ladder.prove.monitors import ClaimWatch, MonitoredProgram

from .invariants import FOREVER_NS, Invariant
from .scan_view import Snapshot


def invariants_in(program: MonitoredProgram) -> Iterator[Invariant]:
    """Yield an invariant for each property of a program that runs with its monitors.

    A run breaks nothing after an assumption has failed.
    """
    for claim in program.properties:
        if claim.claim.kind is not ClaimKind.REACHABLE:
            yield Invariant(claim.claim.name, claim.claim.sentence, partial(_SnapshotWatch, program, claim))


class _SnapshotWatch(ClaimWatch):
    """Watches the snapshots of a run for a claim."""

    def __call__(self, now: Snapshot) -> str | None:
        return "it is broken" if self.is_broken(now.tags) else None

    def same_until_ns(self, _counting: bool) -> int:
        """See `Watch`."""
        return FOREVER_NS
