"""The claims of a rack and its program as invariants: a search asks what `scanrack prove` proves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from scanrack.ladder.prove.claims import ClaimKind
from scanrack.ladder.prove.monitors import MonitoredProgram, WatchedClaim

from .invariants import Invariant, Watch
from .scan_view import Snapshot


def invariants_in(program: MonitoredProgram) -> Iterator[Invariant]:
    """Yield an invariant for each property of a program that runs with its monitors.

    A run in which an assumption has not held breaks nothing.
    """
    for each in program.properties:
        if each.claim.kind is not ClaimKind.REACHABLE:
            yield Invariant(each.claim.name, each.claim.sentence, partial(_watch, program, each))


def _watch(program: MonitoredProgram, asked: WatchedClaim) -> Watch:
    bits = [name for name, _ in (*program.assume, *asked.assume)]
    assumed = True

    def watch(now: Snapshot) -> str | None:
        nonlocal assumed
        assumed = assumed and all(now.tags[name] for name in bits)
        return "it is broken" if assumed and now.tags[asked.bit[0]] else None

    return watch
