"""Combines every fault and button with every thin state.

An event begins in the first scan of the state, one scan before it, or one scan after it.

If several output words change in a scan, the update is torn, with either one word late or all others late. If
inputs change, a tear moves the change to the middle of the previous scan. Each rung that reads inputs gets
one run with tears at all changes of status, and one run with tears at all changes of positions.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from random import Random

from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault
from scanrack.runtime.modules.record import Trait

from ..scenarios.kinds import Kind, buttons, card_buttons, sensors, with_trait
from ..scenarios.parts import Timed, with_part
from ..scenarios.scenario import ContactPress, Press, Scenario, TornUpdate
from ..scenarios.tearing import Rung
from .corpus import Corpus, Entry
from .edges import BEGINNING, INPUTS, THIN, TOGETHER

LASTING_MS, SHORT_MS = 100, 4
"""Durations of an event, and of a short press, ms."""

DISTANCES = (1, 0, -1)
"""Distances of an event from the first scan of a thin state, scans."""

ANY = 0.5
"""Share of scenarios drawn from all entries instead of the latest entry."""

MOST_TORN, MOST_RUNGS = 8, 24
"""Maximum number of tears for one kind of change, and of rungs with torn inputs."""

MOST_WAITING = 5_000
"""Maximum number of waiting scenarios."""


class Sweep:
    """The untried scenarios of thin states. Each kind of state is swept once.

    The corpus stores the swept kinds and the waiting scenarios.
    """

    def __init__(
        self,
        spec: RackSpec,
        kinds: frozenset[Kind],
        random: Random,
        corpus: Corpus,
        rungs: Sequence[Rung] = (),
    ) -> None:
        self._spec, self._kinds, self._random, self._corpus = spec, kinds, random, corpus
        self._rungs = rungs[1:]  # inputs that change before the first rung are only late

    def take(self, entry: Entry) -> None:
        """Add the scenarios for the thin states of an entry."""
        new_scenarios: list[tuple[Hashable, Scenario]] = []
        swept, waiting = self._corpus.swept, self._corpus.waiting
        for kind, scans in entry.edges.groups.get(THIN, {}).items():
            if kind not in swept:
                swept.add(kind)
                for distance in DISTANCES:
                    at_ns = max(0, scans[0] + distance) * self._spec.scan_ns
                    for part in self._events_at(at_ns):
                        new_scenarios.append((kind, with_part(entry.scenario, part)))
        if Kind.TORN in self._kinds:
            new_scenarios += [(kind, with_part(entry.scenario, part)) for kind, part in self._torn(entry)]
        if Kind.TORN in self._kinds and self._rungs:
            new_scenarios += self._torn_inputs(entry)
        self._random.shuffle(new_scenarios)
        new_scenarios.sort(key=_count_faults)  # `next` takes the scenarios with most faults first
        waiting += new_scenarios
        del waiting[:-MOST_WAITING]

    def next(self) -> Scenario | None:
        """Return a waiting scenario of the latest entry or of any entry; None if none is waiting."""
        waiting = self._corpus.waiting
        if not waiting:
            return None
        if self._random.random() < ANY:
            index = self._random.randrange(len(waiting))
            waiting[index], waiting[-1] = waiting[-1], waiting[index]
        return waiting.pop()[1]

    def _torn(self, entry: Entry) -> Iterator[tuple[Hashable, Timed]]:
        """Yield torn updates for each change of several output words: one word late, or all the others."""
        for kind, scans in entry.edges.groups.get(TOGETHER, {}).items():
            if kind in self._corpus.swept:
                continue
            self._corpus.swept.add(kind)
            assert isinstance(kind, tuple)
            slot_index, words = kind
            at_ns, slot = scans[-1] * self._spec.scan_ns, self._spec.slot[slot_index].number
            for word in words:
                other_words = tuple(other_word for other_word in words if other_word != word)
                yield kind, InjectedFault(at_ns, FaultKind.TORN_UPDATE, slot, 0, (word,))
                yield kind, InjectedFault(at_ns, FaultKind.TORN_UPDATE, slot, 0, other_words)

    def _torn_inputs(self, entry: Entry) -> Iterator[tuple[Hashable, Scenario]]:
        """Yield the scenario with tears before its input changes, at several rungs.

        A change of a number may miss the middle of a scan. An entry with twice as many changes of the same
        kind is therefore tried again.
        """
        for group in INPUTS:
            changes = {
                (group, kind, min(len(scans), MOST_TORN).bit_length()): scans
                for kind, scans in entry.edges.groups.get(group, {}).items()
            }
            new_changes = [scans for key, scans in changes.items() if key not in self._corpus.swept]
            self._corpus.swept.update(changes)
            change_scans = chain.from_iterable(scans[:MOST_TORN] for scans in new_changes)
            tear_scans = sorted({scan - 1 for scan in change_scans if scan > BEGINNING})
            if not tear_scans:
                continue
            for routine, rung in self._random.sample(self._rungs, min(MOST_RUNGS, len(self._rungs))):
                tears = tuple(TornUpdate(routine, rung, scan * self._spec.scan_ns) for scan in tear_scans)
                torn = replace(entry.scenario, tears=(*entry.scenario.tears, *tears))
                yield (group, routine, rung), torn

    def _events_at(self, at_ns: int) -> Iterator[Timed]:
        """Yield every fault and every contact operation at an instant."""
        for_ns = LASTING_MS * 1_000_000
        yield from self._faults_at(at_ns, for_ns)
        if Kind.INPUTS in self._kinds:
            axes = [slot for slot in self._spec.slot if slot.has(Trait.MACHINE)]
            for slot in axes:
                for bit in (*buttons(slot), *sensors(slot)):
                    is_short = bit in buttons(slot) and self._random.random() < 0.5
                    yield Press(slot.number, bit, True, at_ns, SHORT_MS * 1_000_000 if is_short else for_ns)
            for number, name in card_buttons(self._spec):
                yield ContactPress(number, name, at_ns, for_ns)

    def _faults_at(self, at_ns: int, for_ns: int) -> Iterator[InjectedFault]:
        """Yield every fault of the allowed kinds at an instant, for each slot that can have it."""
        if Kind.MODE in self._kinds:
            yield InjectedFault(at_ns, FaultKind.PROGRAM_MODE, 0, for_ns)
        if Kind.LINK in self._kinds:
            for number in with_trait(self._spec, Trait.STOPS_ANSWERING):
                yield InjectedFault(at_ns, FaultKind.LINK_LOST, number, for_ns)
                yield InjectedFault(at_ns, FaultKind.REMOVED, number, for_ns)
        if Kind.POWER in self._kinds:
            for slot in self._spec.slot:
                yield InjectedFault(at_ns, FaultKind.POWER_CYCLE, slot.number)


def _count_faults(waiting: tuple[Hashable, Scenario]) -> int:
    _, scenario = waiting
    return len(scenario.incidents) + len(scenario.tears)
