"""What a search tries next.

    the first run             no events, or the scenario that is varied
    then 150 runs             nine of ten begin from nothing, aimed at the edges of the first run
    later                     of ten, two or three begin from nothing; of the others four are of the sweep,
                              as long as it has any, and six vary an entry of the corpus

A child of an entry keeps its beginning up to a point where something was new, and draws what follows; or it
moves a part, lengthens one, replaces one, or joins another entry.
"""

from __future__ import annotations

from random import Random

from ..scenarios.scenario import Scenario
from .corpus import Corpus, Entry, Run, cut, trim
from .draws import Draws
from .edges import Edges
from .sweep import Sweep

BLIND = 150
"""Number of runs of a campaign that begin from nothing, as a rule."""

FRESH_FIRST, FRESH, SWEPT = 0.9, 0.25, 0.4
"""Shares of runs that begin from nothing, in the first runs and later, and of the sweep."""

MOST_PARTS = 12
"""A scenario with more parts is cut before it is varied."""


class Chooser:
    """Proposes scenarios and learns from their runs.

    Args:
        base: scenario that is varied in place of an empty one.
        corpus: what other searches have found; it grows.
    """

    def __init__(
        self, draws: Draws, sweep: Sweep, random: Random, corpus: Corpus, base: Scenario | None
    ) -> None:
        self.corpus = corpus
        self._draws, self._sweep, self._random = draws, sweep, random
        self._base = base
        self._first: Edges | None = None

    def next(self, run: Run) -> Scenario:
        """Return the next scenario.

        Args:
            run: for the runs that trim an entry.
        """
        self.corpus.runs += 1
        random, draws = self._random, self._draws
        if self._first is None:
            return self._base or Scenario()
        blind = self.corpus.runs <= BLIND
        if not self.corpus.entries or random.random() < (FRESH_FIRST if blind else FRESH):
            return draws.scenario(self._first, self._base)
        if not blind and random.random() < SWEPT and (swept := self._sweep.next()) is not None:
            return swept
        entry = self.corpus.choose(random)
        trim(entry, run, draws.scan_ns)
        self._sweep.take(entry)
        return self._child(entry)

    def ran(self, scenario: Scenario, edges: Edges) -> None:
        """Learn from a run in which nothing was broken."""
        entry = self.corpus.take(scenario, edges, self._draws.scan_ns)
        if self._first is None:
            self._first = edges
            if entry is not None:
                entry.wanted = ()
                self._sweep.take(entry)

    def _child(self, entry: Entry) -> Scenario:
        random, draws = self._random, self._draws
        scenario, point = entry.scenario, random.choice(entry.points)
        first = point if random.random() < 0.8 else 0
        if scenario.size > MOST_PARTS:
            scenario = cut(scenario, random.choice(entry.points), draws.scan_ns)
        way = random.random()
        if way < 0.5:
            if random.random() < 0.6:
                scenario = cut(scenario, point, draws.scan_ns)
            return self._more(scenario, entry.edges, first, random.choice((1, 1, 2, 3)))
        if way < 0.7:
            return draws.with_one_moved(scenario, entry.edges)
        if way < 0.8:
            return draws.with_one_longer(scenario, entry.edges)
        if way < 0.9:
            return self._more(draws.with_one_less(scenario), entry.edges, first, 1)
        other = random.choice(self.corpus.entries).scenario
        return draws.joined(scenario, other)

    def _more(self, scenario: Scenario, edges: Edges, first: int, count: int) -> Scenario:
        for _ in range(count):
            scenario, _at = self._draws.with_one_more(scenario, edges, first)
        return scenario
