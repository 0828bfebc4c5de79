"""Combines every fault and button with every thin state: one scan before, in it, and one scan after.

Where several output words change in a scan, an update is torn: one of the words is late, or all others are.
Where inputs change, a tear makes them change in the middle of the scan before. Each rung that reads inputs
gets one run with tears at all changes of status, and one with tears at all changes of positions.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
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

DISTANCES = (1, 0, -1)

ANY = 0.5
"""Share of the scenarios that are drawn from all entries instead of the latest one."""

MOST_TORN, MOST_RUNGS = 8, 24
"""Largest number of tears at one kind of change, and of rungs at which inputs are torn."""

MOST_WAITING = 5_000
"""Largest number of waiting scenarios."""


class Sweep:
    """The untried scenarios of thin states; each kind of state is swept once.

    The corpus keeps the swept kinds and the waiting scenarios.
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
        fresh: list[tuple[Hashable, Scenario]] = []
        swept, waiting = self._corpus.swept, self._corpus.waiting
        for kind, scans in entry.edges.groups.get(THIN, {}).items():
            if kind not in swept:
                swept.add(kind)
                for distance in DISTANCES:
                    at_ns = max(0, scans[0] + distance) * self._spec.scan_ns
                    fresh += [(kind, with_part(entry.scenario, part)) for part in self._events_at(at_ns)]
        if Kind.TORN in self._kinds:
            fresh += [(kind, with_part(entry.scenario, part)) for kind, part in self._torn(entry)]
        if Kind.TORN in self._kinds and self._rungs:
            fresh += self._torn_inputs(entry)
        self._random.shuffle(fresh)
        fresh.sort(key=lambda each: len(each[1].incidents) + len(each[1].tears))  # torn scenarios come first
        waiting += fresh
        del waiting[:-MOST_WAITING]

    def next(self) -> Scenario | None:
        """Return a waiting scenario, of the latest entry or any; None if none waits."""
        waiting = self._corpus.waiting
        if not waiting:
            return None
        if self._random.random() < ANY:
            place = self._random.randrange(len(waiting))
            waiting[place], waiting[-1] = waiting[-1], waiting[place]
        return waiting.pop()[1]

    def _torn(self, entry: Entry) -> Iterator[tuple[Hashable, Timed]]:
        """Yield torn updates where several output words change: one of them is late, or all others are."""
        for kind, scans in entry.edges.groups.get(TOGETHER, {}).items():
            if kind in self._corpus.swept:
                continue
            self._corpus.swept.add(kind)
            assert isinstance(kind, tuple)
            place, words = kind
            at_ns, slot = scans[-1] * self._spec.scan_ns, self._spec.slot[place].number
            for word in words:
                others = tuple(word_before for word_before in words if word_before != word)
                yield kind, InjectedFault(at_ns, FaultKind.TORN_UPDATE, slot, 0, (word,))
                yield kind, InjectedFault(at_ns, FaultKind.TORN_UPDATE, slot, 0, others)

    def _torn_inputs(self, entry: Entry) -> Iterator[tuple[Hashable, Scenario]]:
        """Yield the scenario with its input changes moved to the middle of a scan, before a rung.

        A change of a number may miss the middle of a scan. It is tried again where it takes twice as many
        steps.
        """
        for group in INPUTS:
            changes = {
                (group, kind, min(len(scans), MOST_TORN).bit_length()): scans
                for kind, scans in entry.edges.groups.get(group, {}).items()
            }
            fresh = [scans for key, scans in changes.items() if key not in self._corpus.swept]
            self._corpus.swept.update(changes)
            scans = sorted({scan - 1 for run in fresh for scan in run[:MOST_TORN] if scan > BEGINNING})
            for routine, rung in self._some_rungs() if scans else ():
                tears = tuple(TornUpdate(routine, rung, scan * self._spec.scan_ns) for scan in scans)
                torn = replace(entry.scenario, tears=(*entry.scenario.tears, *tears))
                yield (group, routine, rung), torn

    def _some_rungs(self) -> Sequence[Rung]:
        most = min(MOST_RUNGS, len(self._rungs))
        return self._random.sample(self._rungs, most)

    def _events_at(self, at_ns: int) -> Iterator[Timed]:
        """Yield every fault and every contact operation at an instant."""
        for_ns = LASTING_MS * 1_000_000
        yield from self._faults_at(at_ns, for_ns)
        if Kind.INPUTS in self._kinds:
            for slot in (slot_spec for slot_spec in self._spec.slot if slot_spec.has(Trait.MACHINE)):
                for bit in (*buttons(slot), *sensors(slot)):
                    short = bit in buttons(slot) and self._random.random() < 0.5
                    yield Press(slot.number, bit, True, at_ns, SHORT_MS * 1_000_000 if short else for_ns)
            for number, name in card_buttons(self._spec):
                yield ContactPress(number, name, at_ns, for_ns)

    def _faults_at(self, at_ns: int, for_ns: int) -> Iterator[InjectedFault]:
        if Kind.MODE in self._kinds:
            yield InjectedFault(at_ns, FaultKind.PROGRAM_MODE, 0, for_ns)
        if Kind.LINK in self._kinds:
            for number in with_trait(self._spec, Trait.STOPS_ANSWERING):
                yield InjectedFault(at_ns, FaultKind.LINK_LOST, number, for_ns)
                yield InjectedFault(at_ns, FaultKind.REMOVED, number, for_ns)
        if Kind.POWER in self._kinds:
            for slot in self._spec.slot:
                yield InjectedFault(at_ns, FaultKind.POWER_CYCLE, slot.number)
