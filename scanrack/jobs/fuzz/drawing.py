"""Provides scenarios as a Hypothesis strategy for tests of a program. `scanrack fuzz` does not use it."""

from __future__ import annotations

from collections.abc import Collection

from hypothesis import strategies as st
from scanrack.runtime.config.rackspec import RackSpec

from .aim.draws import Draws
from .scenarios.kinds import Kind
from .scenarios.scenario import Scenario


def scenarios(
    spec: RackSpec, scans: int, kinds: Collection[Kind], *, base: Scenario | None = None
) -> st.SearchStrategy[Scenario]:
    """Return a strategy of scenarios for a rack.

    Args:
        scans: length of a run.
        kinds: kinds of random events. Impossible kinds are ignored.
        base: scenario to vary. Some of its parts are kept, and others are added.
    """
    randoms = st.randoms(use_true_random=False)
    return randoms.map(lambda random: Draws(spec, scans, kinds, random).scenario(base=base))
