"""The corpus of a search: scenarios with features that no earlier run had.

worth    of a new
6        number or text in a tag or field, size, waiting line: a new step of the program
2        flag, flag under other steps, power of a rung, path of branches
0.3      set of status bits, command, status bit under a command
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
"""Minimum worth of an entry. Scenarios with only one to four pairs are discarded."""

MOST_WORTH = 8.0
"""Maximum worth that counts when an entry is chosen."""

MOST_ENTRIES = 300
"""Maximum number of entries. Beyond it, the entry that was varied most often is removed."""

MOST_SEEN = 100_000
"""Maximum number of known features. Beyond it, no feature counts as new."""

FRESH_CHOICES = 80
"""Number of times that an entry with a new step is preferred to older entries."""

LATE = 30
"""Earliest scan for the first event after trimming."""

EARLIER = (1.0, 0.6, 0.3)
"""Shares of the distance to scan `LATE` by which trimming moves the events."""

Run = Callable[[Scenario], Edges | None]
"""Runs a scenario. Returns its changes, or None if it breaks an invariant."""


@dataclass(slots=True)
class Entry:
    """A scenario of the corpus.

    Attributes:
        points: scans with a new feature.
        new_features: the new features; empty once the scenario is trimmed.
        chosen: number of variants drawn from it.
        chosen_when_shared: value of `chosen` when a campaign shared the entry with a task.
        number: number of the entry in the campaign's corpus; -1 for a new entry.
    """

    scenario: Scenario
    edges: Edges
    points: list[int]
    worth: float
    new_features: tuple[Feature, ...] = ()
    chosen: int = 0
    chosen_when_shared: int = 0
    number: int = -1

    def update(self, shared: Entry) -> None:
        """Add the choices of a shared copy. Copy its scenario if a task has trimmed it."""
        self.chosen += shared.chosen - shared.chosen_when_shared
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
    """The entries in order of discovery, and other results of searches.

    Attributes:
        seen: all known features.
        runs: number of runs so far.
        numbers: highest number of a shared entry.
        swept: kinds of thin states that the sweep has begun.
        waiting: untried scenarios of the sweep, each with its kind of state; None = from an earlier round.
        answered: contacts to which the program has reacted.
        part: index of the task of this search, and the number of tasks.
    """

    entries: list[Entry] = field(default_factory=list)
    seen: set[Feature] = field(default_factory=set)
    runs: int = 0
    numbers: int = 0
    swept: set[Hashable] = field(default_factory=set)
    waiting: list[tuple[Hashable, Scenario]] = field(default_factory=list)
    answered: list[Contact] = field(default_factory=list)
    part: tuple[int, int] = (0, 1)

    def take(self, scenario: Scenario, edges: Edges, scan_ns: int) -> Entry | None:
        """Add a scenario with new features; return its entry, or None if its worth is too low."""
        firsts = edges.firsts()
        new_features = self._note_new(firsts)
        if not new_features:
            return None
        worth = sum(map(worth_of, new_features))
        if worth < LEAST_WORTH:
            return None
        main_features = [feature for feature in new_features if worth_of(feature) > PAIR_WORTH]
        main_features = main_features or new_features
        points = sorted({firsts[feature] for feature in main_features})
        entry = Entry(cut(scenario, points[-1], scan_ns), edges, points, worth, tuple(main_features))
        self._add(entry)
        return entry

    def merge(self, other: Corpus) -> None:
        """Add the results of a task that began with a share of this corpus."""
        entries_by_number = {entry.number: entry for entry in self.entries if entry.number >= 0}
        for their_entry in other.entries:
            if their_entry.number in entries_by_number:
                entries_by_number[their_entry.number].update(their_entry)
            elif their_entry.number < 0 and self._note_new(their_entry.edges.firsts()):
                self._add(their_entry)
        self.seen |= other.seen
        self.waiting += [
            (kind, scenario) for kind, scenario in other.waiting if kind is None or kind not in self.swept
        ]
        self.swept |= other.swept
        self.answered = list(dict.fromkeys([*self.answered, *other.answered]))

    def share(self, max_entries: int) -> Corpus:
        """Return the corpus for a round: all known features, the least varied entries, and the sweep."""
        chosen_ids = set(map(id, sorted(self.entries, key=_energy)[:max_entries]))
        chosen = [entry for entry in self.entries if id(entry) in chosen_ids]
        for entry in chosen:
            if entry.number < 0:
                self.numbers += 1
                entry.number = self.numbers
        waiting: list[tuple[Hashable, Scenario]] = [(None, scenario) for _, scenario in self.waiting]
        self.waiting.clear()
        return Corpus(
            entries=[replace(entry, chosen_when_shared=entry.chosen) for entry in chosen],
            seen=set(self.seen),
            runs=self.runs,
            swept=set(self.swept),
            waiting=waiting,
            answered=[*self.answered],
        )

    def for_task(self, task_index: int, task_count: int) -> Corpus:
        """Return a copy for one task of a round, with its share of the sweep."""
        return replace(
            self,
            entries=[replace(entry) for entry in self.entries],
            seen=set(self.seen),
            swept=set(self.swept),
            waiting=self.waiting[task_index::task_count],
            answered=[*self.answered],
            part=(task_index, task_count),
        )

    def _note_new(self, firsts: Mapping[Feature, int]) -> list[Feature]:
        """Add the new features to `seen` and return them."""
        if len(self.seen) > MOST_SEEN:
            return []
        new_features = [feature for feature in firsts if feature not in self.seen]
        self.seen.update(new_features)
        return new_features

    def _add(self, entry: Entry) -> None:
        if len(self.entries) >= MOST_ENTRIES:
            self.entries.remove(max(self.entries, key=_energy))
        self.entries.append(entry)

    def choose(self, random: Random) -> Entry:
        """Return an entry to vary: half the time the latest new step, otherwise a rarely varied entry."""
        recent_steps = [
            entry for entry in self.entries[-6:] if entry.worth >= STEP_WORTH and entry.chosen < FRESH_CHOICES
        ]
        candidates = [random.choice(self.entries) for _ in range(3)]
        entry = min(candidates, key=_energy)
        if recent_steps and random.random() < 0.5:
            entry = recent_steps[-1]
        entry.chosen += 1
        return entry


def _energy(entry: Entry) -> float:
    """Return the number of variants of an entry in proportion to its worth."""
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
    """Remove the parts that the new features do not need, and move the remaining parts earlier."""
    features, entry.new_features = entry.new_features, ()
    if not features or entry.worth < PATH_WORTH:
        return
    for scenario in _simpler_scenarios(entry, scan_ns):
        edges = run(scenario)
        if edges is None:
            continue
        firsts = edges.firsts()
        if all(feature in firsts for feature in features):
            entry.scenario, entry.edges = scenario, edges
            entry.points = sorted({firsts[feature] for feature in features})


def _simpler_scenarios(entry: Entry, scan_ns: int) -> Iterator[Scenario]:
    """Yield simpler versions of an entry's scenario: without half, a quarter or one of its parts, or earlier.

    The caller sets the entry's scenario to the yielded one to accept it. The next version is based on it.
    """
    size = len(parts_of(entry.scenario)) // 2
    while size:
        start = 0
        while start < len(parts := parts_of(entry.scenario)) and len(parts) > size:
            scenario = entry.scenario
            yield scenario_of(parts[:start] + parts[start + size :])
            if entry.scenario is scenario:  # not accepted
                start += size
        size //= 2
    for share in EARLIER:
        scenario = entry.scenario
        if (earlier_scenario := _earlier(scenario, share, scan_ns)) is not None:
            yield earlier_scenario
            if entry.scenario is not scenario:  # accepted
                return


def _earlier(scenario: Scenario, share: float, scan_ns: int) -> Scenario | None:
    """Return a scenario with all events moved a share of the way to `LATE`; None if already earlier."""
    instants_ns = [part.at_ns for _, part in parts_of(scenario) if isinstance(part, Timed)]
    first_scan = min(instants_ns, default=0) // scan_ns
    if first_scan <= LATE:
        return None
    moved_by_ns = int((first_scan - LATE) * share) * scan_ns
    return scenario_of(
        (name, replace(part, at_ns=part.at_ns - moved_by_ns) if isinstance(part, Timed) else part)
        for name, part in parts_of(scenario)
    )
