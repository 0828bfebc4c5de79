"""The corpus of a search: scenarios in which something happened for the first time.

worth    at the first appearance of
6        a number or text of a tag or field, a size, a line that waits: a new step of the program
2        a flag, a flag under other steps, the power of a rung, a path of branches
0.3      status bits, a command, a status bit under a command
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from random import Random

from ..scenarios.parts import Timed, parts_of, scenario_of
from ..scenarios.scenario import Scenario
from .contacts import Contact
from .edges import SIZE, STATE, UNDER, Edges

Feature = tuple[str, Hashable]
"""Group and kind of a change."""

STEP_WORTH, PATH_WORTH, PAIR_WORTH = 6.0, 2.0, 0.3

LEAST_WORTH = 1.5
"""Scenarios worth less are not kept, such as ones with only a pair or two."""

MOST_WORTH = 8.0
"""When an entry is chosen, worth above this limit is ignored."""

MOST_ENTRIES, MOST_SEEN = 300, 100_000
"""Memory limits. At the first, the most varied entry is removed; after the second, nothing counts as new."""

FRESH_CHOICES = 80
"""Number of times that an entry with a new step is chosen before older ones."""

LATE, EARLIER = 30, (1.0, 0.6, 0.3)
"""Earliest scan to which trimming moves events, and the shares of that distance that it tries."""

Run = Callable[[Scenario], Edges | None]
"""Runs a scenario; returns its changes, or None if it breaks an invariant."""


@dataclass(slots=True)
class Entry:
    """A scenario of the corpus.

    Attributes:
        points: scans in which a feature was new.
        new_features: the features that were new; empty once the scenario is trimmed.
        chosen: how often it was varied.
        before: value of `chosen` when the entry was shared.
        number: number of the entry in the corpus that shared it, -1 for a new entry.
    """

    scenario: Scenario
    edges: Edges
    points: list[int]
    worth: float
    new_features: tuple[Feature, ...] = ()
    chosen: int = 0
    before: int = 0
    number: int = -1

    def update(self, shared: Entry) -> None:
        """Add how often a shared copy was chosen, and take its scenario if it has been trimmed."""
        self.chosen += shared.chosen - shared.before
        if self.new_features and not shared.new_features:
            self.scenario, self.edges = shared.scenario, shared.edges
            self.points, self.new_features = shared.points, ()


def worth_of(feature: Feature) -> float:
    """Return the worth of a new feature."""
    group, kind = feature
    if group == SIZE:
        return STEP_WORTH
    if group == STATE:
        assert isinstance(kind, tuple)
        return PATH_WORTH if isinstance(kind[-1], bool) else STEP_WORTH
    return PATH_WORTH if group in ("path", UNDER) else PAIR_WORTH


@dataclass(slots=True)
class Corpus:
    """The entries, in order of discovery, and the knowledge from searches.

    Attributes:
        seen: all features seen so far.
        runs: number of runs so far.
        swept: kinds of thin states whose sweep has begun.
        waiting: scenarios of the sweep to try, each with its kind of state; None = from an earlier round.
        answered: contacts to which the program reacts.
        part: which share of the contacts this search operates one by one, and the number of shares.
    """

    entries: list[Entry] = field(default_factory=list)
    seen: set[Feature] = field(default_factory=set)
    runs: int = 0
    numbers: int = 0  # the highest number of a shared entry
    swept: set[Hashable] = field(default_factory=set)
    waiting: list[tuple[Hashable, Scenario]] = field(default_factory=list)
    answered: list[Contact] = field(default_factory=list)
    part: tuple[int, int] = (0, 1)

    def take(self, scenario: Scenario, edges: Edges, scan_ns: int) -> Entry | None:
        """Add a scenario and return its entry if it has a new feature."""
        firsts = edges.firsts()
        fresh = self._note_new(firsts)
        if not fresh:
            return None
        worthy = [feature for feature in fresh if worth_of(feature) > PAIR_WORTH] or fresh
        points = sorted({firsts[feature] for feature in worthy})
        beginning = cut(scenario, points[-1], scan_ns)
        worth = sum(map(worth_of, fresh))
        if worth < LEAST_WORTH:
            return None
        entry = Entry(beginning, edges, points, worth, tuple(worthy))
        self._add(entry)
        return entry

    def merge(self, other: Corpus) -> None:
        """Add the results of a search that began with a share of this corpus."""
        own = {entry.number: entry for entry in self.entries if entry.number >= 0}
        for newcomer in other.entries:
            if newcomer.number in own:
                own[newcomer.number].update(newcomer)
            elif newcomer.number < 0 and self._note_new(newcomer.edges.firsts()):
                self._add(newcomer)
        self.seen |= other.seen
        self.waiting += [entry for entry in other.waiting if entry[0] is None or entry[0] not in self.swept]
        self.swept |= other.swept
        self.answered = list(dict.fromkeys([*self.answered, *other.answered]))

    def share(self, most: int) -> Corpus:
        """Return the corpus for a round: all seen features, the least varied entries, and the sweep."""
        turn = set(map(id, sorted(self.entries, key=_energy)[:most]))
        chosen = [entry for entry in self.entries if id(entry) in turn]
        for chosen_entry in chosen:
            if chosen_entry.number < 0:
                self.numbers += 1
                chosen_entry.number = self.numbers
        waiting: list[tuple[Hashable, Scenario]] = [(None, scenario) for _, scenario in self.waiting]
        self.waiting.clear()
        entries = [replace(entry, before=entry.chosen) for entry in chosen]
        return Corpus(entries, {*self.seen}, self.runs, 0, {*self.swept}, waiting, [*self.answered])

    def for_task(self, place: int, count: int) -> Corpus:
        """Return a copy for one task of a round, with its share of the sweep."""
        return replace(
            self,
            entries=[replace(entry) for entry in self.entries],
            seen=set(self.seen),
            swept=set(self.swept),
            waiting=self.waiting[place::count],
            answered=[*self.answered],
            part=(place, count),
        )

    def _note_new(self, firsts: Mapping[Feature, int]) -> list[Feature]:
        """Return the new features and mark them as seen."""
        fresh = [feature for feature in firsts if feature not in self.seen]
        if len(self.seen) > MOST_SEEN:
            return []
        self.seen.update(fresh)
        return fresh

    def _add(self, entry: Entry) -> None:
        if len(self.entries) >= MOST_ENTRIES:
            self.entries.remove(max(self.entries, key=_energy))
        self.entries.append(entry)

    def choose(self, random: Random) -> Entry:
        """Return an entry to vary: half the time the latest new step, else one varied little so far."""
        latest = next(
            (
                recent
                for recent in reversed(self.entries[-6:])
                if recent.worth >= STEP_WORTH and recent.chosen < FRESH_CHOICES
            ),
            None,
        )
        few = [random.choice(self.entries) for _ in range(3)]
        entry = min(few, key=_energy)
        if latest is not None and random.random() < 0.5:
            entry = latest
        entry.chosen += 1
        return entry


def _energy(entry: Entry) -> float:
    """Return how often an entry was varied relative to its worth; the entry with the least is next."""
    return entry.chosen / min(entry.worth, MOST_WORTH)


def cut(scenario: Scenario, scan: int, scan_ns: int) -> Scenario:
    """Return a scenario without the events that begin after a scan."""
    end_ns = scan * scan_ns
    return scenario_of(
        (name, part)
        for name, part in parts_of(scenario)
        if not isinstance(part, Timed) or part.at_ns <= end_ns
    )


def trim(entry: Entry, run: Run, scan_ns: int) -> None:
    """Remove parts that the new features do not need, and move the rest to the earliest scan."""
    features, entry.new_features = entry.new_features, ()
    if not features or entry.worth < PATH_WORTH:
        return
    for scenario in _shorter(lambda: entry.scenario, scan_ns):
        edges = run(scenario)
        if edges is None:
            continue
        firsts = edges.firsts()
        if all(feature in firsts for feature in features):
            entry.scenario, entry.edges = scenario, edges
            entry.points = sorted({firsts[feature] for feature in features})


def _shorter(present: Callable[[], Scenario], scan_ns: int) -> Iterator[Scenario]:
    """Yield versions without a half, a quarter, or one part of a scenario, which may change in between."""
    size = len(parts_of(present())) // 2
    while size:
        place = 0
        while place < len(parts := parts_of(present())) and len(parts) > size:
            before = present()
            yield scenario_of(parts[:place] + parts[place + size :])
            if present() is before:
                place += size
        size //= 2
    for share in EARLIER:
        before = present()
        if (early := _earlier(before, share, scan_ns)) is not None:
            yield early
            if present() is not before:
                return


def _earlier(scenario: Scenario, share: float, scan_ns: int) -> Scenario | None:
    """Return a scenario with its events moved earlier by a share; None if they already begin early."""
    timed = [part.at_ns for _, part in parts_of(scenario) if isinstance(part, Timed)]
    early = min(timed, default=0) // scan_ns
    if early <= LATE:
        return None
    by_ns = int((early - LATE) * share) * scan_ns
    return scenario_of(
        (name, replace(part, at_ns=part.at_ns - by_ns) if isinstance(part, Timed) else part)
        for name, part in parts_of(scenario)
    )
