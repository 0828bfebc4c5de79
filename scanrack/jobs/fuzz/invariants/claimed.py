"""Turns the claims of a rack and its program into invariants: a search tests what `scanrack prove` proves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from scanrack.ladder.prove.claims import ClaimKind
from scanrack.ladder.prove.monitors import MonitoredProgram, WatchedClaim

from .invariants import FOREVER_NS, Invariant
from .scan_view import Snapshot


def invariants_in(program: MonitoredProgram) -> Iterator[Invariant]:
    """Yield an invariant for each property of a program that runs with its monitors.

    A run breaks nothing after an assumption has failed.
    """
    for each in program.properties:
        if each.claim.kind is not ClaimKind.REACHABLE:
            yield Invariant(each.claim.name, each.claim.sentence, partial(_ClaimWatch, program, each))


class _ClaimWatch:
    """Watches a run for the bit of a monitor until an assumption fails."""

    def __init__(self, program: MonitoredProgram, watched: WatchedClaim) -> None:
        self._assumed = [name for name, _ in (*program.assume, *watched.assume)]
        self._bit = watched.bit[0]
        self._holds = True

    def __call__(self, now: Snapshot) -> str | None:
        self._holds = self._holds and all(now.tags[name] for name in self._assumed)
        return "it is broken" if self._holds and now.tags[self._bit] else None

    def same_until_ns(self, _counting: bool) -> int:
        """See `Watch`."""
        return FOREVER_NS
