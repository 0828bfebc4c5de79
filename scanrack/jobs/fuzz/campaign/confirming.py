"""Confirms failures. A failure counts if it also occurs in a new process with a different environment."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from .. import Counterexample, NondeterministicError, Scenario
from ..job import Setup, bench_of
from ..nondeterminism import NondeterminismSources
from ..run import HANGS, BrokenInvariant
from ..search import describe_nondeterminism
from .fresh import run_in_other_environment


@dataclass(frozen=True, slots=True)
class Confirmation:
    """Repeats a failure in another process."""

    setup: Setup

    def __call__(self, failure: Counterexample, without: Collection[str]) -> bool:
        """Return whether a failure also occurs in another process; False if the machine may be the reason.

        Raises:
            NondeterministicError: the failure does not occur there because of the program.
        """
        broken, sources = run_in_other_environment(
            run_again, self.setup, failure.scenario, frozenset(without)
        )
        if broken is not None and broken.key == failure.broken.key:
            return True
        if HANGS in (failure.broken.cause, broken and broken.cause):
            return False  # the machine may have been busy during either run
        raise NondeterministicError(describe_nondeterminism(failure, sources))


def run_again(
    setup: Setup, scenario: Scenario, without: frozenset[str]
) -> tuple[BrokenInvariant | None, str]:
    """Run a scenario; return its failure and the program's sources of nondeterminism."""
    sources = NondeterminismSources()
    verdict = sources.recording_bench(bench_of(setup)).run(scenario, without=without)
    return verdict.broken, str(sources)
