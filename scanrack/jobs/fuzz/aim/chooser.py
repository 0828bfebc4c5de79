"""Chooses the next scenario of a search.

    the first run             no events, or the scenario that is varied
    a run for each button     holds it for a time, to see whether the program reacts
    then 150 runs             two in five begin from nothing, aimed at the edges of a run of the corpus
    later                     a quarter begin from nothing

Three in ten come from the sweep while it has any; the others vary an entry of the corpus. A child of an entry
keeps its beginning up to a point where something was new, and draws what follows. Or it moves a part,
lengthens one, replaces one, or adds the events of another entry.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

from ..scenarios.parts import timed_parts, with_part
from ..scenarios.scenario import Scenario
from .contacts import Contact
from .corpus import PATH_WORTH, Corpus, Entry, Run, cut, trim
from .draws import Draws
from .edges import Edges
from .sweep import Sweep
from .times import MS

BLIND = 150
"""Number of first runs of a campaign, which usually begin from nothing."""

FRESH_FIRST, FRESH, SWEPT_FIRST, SWEPT = 0.4, 0.25, 0.3, 0.3
"""Shares of the runs that begin from nothing, and of the sweep, in the first runs and later."""

HELD_AT, HELD_MS, MOST_HELD = 0.3, 300, 24
"""For runs with a single contact: its start, as a share of the run; its duration if the program has no times,
ms; and the largest number of such runs."""

TRIMMING = 0.25
"""Greatest number of trimming runs per other run; beyond it, entries wait."""

MOST_PARTS = 12
"""Scenarios with more parts are cut before they are varied."""


class Chooser:
    """Proposes scenarios and learns from their runs.

    Args:
        base: scenario to vary instead of an empty one.
        corpus: results of earlier searches; this search adds to it.
    """

    def __init__(
        self, draws: Draws, sweep: Sweep, random: Random, corpus: Corpus, base: Scenario | None
    ) -> None:
        self.corpus = corpus
        self._draws, self._sweep, self._random = draws, sweep, random
        self._base = base
        self._first: Edges | None = None
        place, count = corpus.part
        tried = base is not None or corpus.runs > 0  # in the first round of a campaign
        self._untried = [] if tried else draws.contacts.operated[place:MOST_HELD:count]
        for contact in corpus.answered:
            draws.contacts.answered(contact)
        self._tried: Contact | None = None
        self._runs = self._trimming = 0  # counts in this search

    def next(self, run: Run) -> Scenario:
        """Return the next scenario.

        Args:
            run: runs a scenario; used to trim an entry.
        """
        self.corpus.runs += 1
        self._runs += 1
        if self._first is None:
            return self._base or Scenario()
        if self._untried:
            return self._with_one_contact()
        blind = self.corpus.runs <= BLIND
        from_nothing, swept = (FRESH_FIRST, SWEPT_FIRST) if blind else (FRESH, SWEPT)
        way = self._random.random()
        if not (self.corpus.entries and self._draws.has_events) or way < from_nothing:
            return self._from_nothing(self._first)
        if way < from_nothing + swept and (thin := self._sweep.next()) is not None:
            return thin
        return self._of_corpus(run)

    def _from_nothing(self, first: Edges) -> Scenario:
        """Return a random scenario, aimed at the edges of the first run or of an entry."""
        random, entries = self._random, self.corpus.entries
        entry_edges = random.choice(entries).edges if entries else first
        return self._draws.scenario(first if random.random() < 0.5 else entry_edges, self._base)

    def _of_corpus(self, run: Run) -> Scenario:
        """Trim an entry and return a child of it."""
        entry = self.corpus.choose(self._random)
        if self._trimming < TRIMMING * self._runs:
            trim(entry, self._counted(run), self._draws.scan_ns)
        self._sweep.take(entry)
        if entry.worth >= PATH_WORTH:
            self._prefer_contacts(entry.scenario)
        return self._child(entry)

    def _counted(self, run: Run) -> Run:
        def counted(scenario: Scenario) -> Edges | None:
            self._trimming += 1
            return run(scenario)

        return counted

    def _with_one_contact(self) -> Scenario:
        """Return a scenario with one contact, held for the longest time in the program."""
        draws = self._draws
        contact = self._tried = self._untried.pop()
        run_ns = draws.scans * draws.scan_ns
        for_ns = max((time for time in draws.times if time < run_ns // 2), default=HELD_MS * MS)
        at_ns = int(draws.scans * HELD_AT) * draws.scan_ns
        return with_part(Scenario(), replace(contact, at_ns=at_ns, for_ns=for_ns + 5 * draws.scan_ns))

    def _prefer_contacts(self, scenario: Scenario) -> None:
        """Make later scenarios operate the contacts of this one more often."""
        for part in timed_parts(scenario):
            if isinstance(part, Contact):
                self._draws.contacts.answered(replace(part, at_ns=0, for_ns=0))

    def ran(self, scenario: Scenario, edges: Edges) -> None:
        """Learn from a run that broke no invariant."""
        entry = self.corpus.take(scenario, edges, self._draws.scan_ns)
        alone = self._first is None or self._tried is not None
        if self._tried is not None:
            if self._first is not None and edges.answers() - self._first.answers():
                self._draws.contacts.answered(self._tried)
                self.corpus.answered.append(self._tried)
            self._tried = None
        elif self._first is None:
            self._first = edges
        if alone and entry is not None:
            entry.new_features = ()
            self._sweep.take(entry)

    def _child(self, entry: Entry) -> Scenario:
        random, draws = self._random, self._draws
        draws.narrow()
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
            scenario, first = self._draws.with_one_more(scenario, edges, first)
        return scenario
