"""Chooses the next scenario of a search.

    first run             no events, or the base scenario
    a run per button      holds the button for a time, to see whether the program reacts
    next 150 runs         40 % are entirely random, with events near the edges of earlier runs
    later runs            25 % are entirely random

Another 30 % come from the sweep, as long as it has scenarios. The rest vary an entry of the corpus. A variant
keeps the events of the entry up to a scan with a new feature, and adds random events. Alternatively, it
moves, lengthens or replaces one event, or adds events from another entry.
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
"""Number of runs at the start of a campaign. A larger share of these runs is entirely random."""

FRESH_FIRST, FRESH, SWEPT_FIRST, SWEPT = 0.4, 0.25, 0.3, 0.3
"""Shares of entirely random runs and of sweep runs, each in the first runs and later."""

HELD_AT = 0.3
"""Start of the press in a run with a single contact, as a fraction of the run."""

HELD_MS = 300
"""Duration of this press if the program has no times, ms."""

MOST_HELD = 24
"""Maximum number of runs with a single contact."""

TRIMMING = 0.25
"""Maximum number of trimming runs per other run. Beyond it, trimming is postponed."""

MOST_PARTS = 12
"""Scenarios with more parts are shortened before they are varied."""


class Chooser:
    """Proposes scenarios and learns from their runs.

    Args:
        base: scenario to vary; None = the empty scenario.
        corpus: results of earlier searches. This search adds to it.
    """

    def __init__(
        self, draws: Draws, sweep: Sweep, random: Random, corpus: Corpus, base: Scenario | None
    ) -> None:
        self.corpus = corpus
        self._draws, self._sweep, self._random = draws, sweep, random
        self._base = base
        self._first_edges: Edges | None = None  # changes in the first run
        task_index, task_count = corpus.part
        operated = draws.contacts.operated if base is None and corpus.runs == 0 else []  # in the first round
        # contacts that this search still has to hold: its share, if tasks run in parallel
        self._unheld_contacts = operated[task_index:MOST_HELD:task_count]
        self._held_contact: Contact | None = None  # the single contact of the latest scenario
        for contact in corpus.answered:
            draws.contacts.prefer(contact)
        self._runs = self._trimming = 0  # numbers of runs and of trimming runs in this search

    def next(self, run: Run) -> Scenario:
        """Return the next scenario.

        Args:
            run: runs a scenario to trim an entry.
        """
        self.corpus.runs += 1
        self._runs += 1
        if self._first_edges is None:
            return self._base or Scenario()
        if self._unheld_contacts:
            return self._with_one_contact()
        is_early = self.corpus.runs <= BLIND
        fresh_share, sweep_share = (FRESH_FIRST, SWEPT_FIRST) if is_early else (FRESH, SWEPT)
        draw = self._random.random()
        if not (self.corpus.entries and self._draws.has_events) or draw < fresh_share:
            return self._random_scenario(self._first_edges)
        if draw < fresh_share + sweep_share and (swept_scenario := self._sweep.next()) is not None:
            return swept_scenario
        return self._from_corpus(run)

    def _random_scenario(self, first_edges: Edges) -> Scenario:
        """Return a random scenario with events near the edges of the first run or of an entry."""
        random, entries = self._random, self.corpus.entries
        entry_edges = random.choice(entries).edges if entries else first_edges
        return self._draws.scenario(first_edges if random.random() < 0.5 else entry_edges, self._base)

    def _from_corpus(self, run: Run) -> Scenario:
        """Trim an entry and return a variant of it."""
        entry = self.corpus.choose(self._random)
        if self._trimming < TRIMMING * self._runs:
            trim(entry, self._counted(run), self._draws.scan_ns)
        self._sweep.take(entry)
        if entry.worth >= PATH_WORTH:
            self._prefer_contacts(entry.scenario)
        return self._variant(entry)

    def _counted(self, run: Run) -> Run:
        """Return a function that runs a scenario and counts it as a trimming run."""

        def counted_run(scenario: Scenario) -> Edges | None:
            self._trimming += 1
            return run(scenario)

        return counted_run

    def _with_one_contact(self) -> Scenario:
        """Return a scenario that holds one contact longer than the program's longest time."""
        draws = self._draws
        contact = self._held_contact = self._unheld_contacts.pop()
        run_ns = draws.scans * draws.scan_ns
        for_ns = max((time for time in draws.times if time < run_ns // 2), default=HELD_MS * MS)
        at_ns = int(draws.scans * HELD_AT) * draws.scan_ns
        return with_part(Scenario(), replace(contact, at_ns=at_ns, for_ns=for_ns + 5 * draws.scan_ns))

    def _prefer_contacts(self, scenario: Scenario) -> None:
        """Make later scenarios operate the contacts of this scenario more often."""
        for part in timed_parts(scenario):
            if isinstance(part, Contact):
                self._draws.contacts.prefer(replace(part, at_ns=0, for_ns=0))

    def ran(self, scenario: Scenario, edges: Edges) -> None:
        """Learn from a run that broke no invariant."""
        entry = self.corpus.take(scenario, edges, self._draws.scan_ns)
        if self._first_edges is None:
            self._first_edges = edges
        elif self._held_contact is not None:
            if edges.program_changes() - self._first_edges.program_changes():
                self._draws.contacts.prefer(self._held_contact)
                self.corpus.answered.append(self._held_contact)
            self._held_contact = None
        else:
            return
        if entry is not None:
            entry.new_features = ()  # a single part needs no trimming
            self._sweep.take(entry)

    def _variant(self, entry: Entry) -> Scenario:
        """Return a random variant of an entry, see the module docstring.

        A large entry is shortened first.
        """
        random, draws = self._random, self._draws
        draws.narrow()
        scenario, point = entry.scenario, random.choice(entry.points)
        from_scan = point if random.random() < 0.8 else 0
        if scenario.size > MOST_PARTS:
            scenario = cut(scenario, random.choice(entry.points), draws.scan_ns)
        draw = random.random()
        if draw < 0.5:
            if random.random() < 0.6:
                scenario = cut(scenario, point, draws.scan_ns)
            return self._with_more(scenario, entry.edges, from_scan, random.choice((1, 1, 2, 3)))
        if draw < 0.7:
            return draws.with_one_moved(scenario, entry.edges)
        if draw < 0.8:
            return draws.with_one_longer(scenario, entry.edges)
        if draw < 0.9:
            return self._with_more(draws.with_one_less(scenario), entry.edges, from_scan, 1)
        other = random.choice(self.corpus.entries).scenario
        return draws.joined(scenario, other)

    def _with_more(self, scenario: Scenario, edges: Edges, from_scan: int, count: int) -> Scenario:
        """Return a scenario with more random parts, mostly after the scan `from_scan`."""
        for _ in range(count):
            scenario, from_scan = self._draws.with_one_more(scenario, edges, from_scan)
        return scenario
