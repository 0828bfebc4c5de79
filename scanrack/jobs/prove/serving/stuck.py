"""Questions of a search that finds nothing new: how contacts and coils that were never on come on.

The solver gets several questions about an instruction, one at a time:

    near     from power-up, in scans of a third of the program's shortest time, 20 ms at least
    on       from where an entry of the corpus showed something new, for the newest of them, in such scans
    far      from power-up, in scans of up to a second: what lasts long
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from scanrack.ladder import LadderLogic
from scanrack.ladder.prove.questions.points import SEARCH, PointState, RungPoint
from scanrack.ladder.prove.solving.solver import is_installed
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import LoweredProgram
from scanrack.runtime.loop.scan import ScanLogic

from ...fuzz.aim.corpus import STEP_WORTH, Entry, cut
from ...fuzz.aim.times import times_of
from ...fuzz.campaign.state import State
from ...fuzz.reached import Gap, ProgramReach, reached
from ...fuzz.run import TrialBench
from ...fuzz.scenarios.parts import parts_of, scenario_of
from ...fuzz.scenarios.scenario import ContactPress, Press, Scenario
from ...load.loading import LoadedRack
from ...record.logic_wrapper import unwrapped
from .aims import LONGEST_NS, DeadPoint, dead, scenario_to

PATIENCE = 200
"""Runs without anything new before a question."""

AT_ONCE = 4
"""Questions before the search continues, each about another rung: answers reach others, too."""

NEAR, FAR, STATES = 0, 2, 3
"""Places of two kinds of questions, all others are "on"; and the number of entries from which "on" begins."""

WAYS = 5
"""Number of questions about an instruction."""

LIMITS = replace(SEARCH, scans=40, work=2_000_000)
"""Limits of a question: a second or two."""

PART = 3
"""Scans that the shortest time of a program lasts at least."""

FAR_NS = 1_000_000_000
"""Longest scan of a far question."""


class SolverStep:
    """Asks the solver how to reach an instruction that a campaign has not reached; each question once.

    Call it between two rounds. Nothing depends on time: the questions are the same on every machine.

    Args:
        bench: runs the entries of the corpus up to the states from which "on" begins.

    Attributes:
        questions: their number.
        answered: number of scenarios in the answers.
    """

    def __init__(self, job: LoadedRack, bench: TrialBench, patience: int = PATIENCE) -> None:
        self._job, self._bench, self._patience = job, bench, patience
        self._tried: Counter[int] = Counter()  # questions about each instruction
        self._begun: set[tuple[int, str]] = set()  # instructions with the entries that "on" began from
        self.questions = self.answered = 0

    def __call__(self, state: State) -> tuple[Scenario, ...]:
        """Return scenarios to run if the last runs have brought nothing new; () otherwise."""
        if state.stale < self._patience or not self.can_ask:
            return ()
        found = tuple(dict.fromkeys(self._answers(state)))
        self.answered += len(found)
        return found

    @property
    def can_ask(self) -> bool:
        """Whether there are rungs to ask about, and a solver."""
        return isinstance(self._job.logic, LadderLogic) and is_installed()

    def _answers(self, state: State) -> Iterator[Scenario]:
        begin = _steps(state)
        for number in self._open(state):
            way = self._tried[number]
            self._tried[number] += 1
            scenario = self._solve(number, way, begin)
            if scenario is not None and scenario.size:
                yield scenario

    def _solve(self, number: int, way: int, entries: list[Entry]) -> Scenario | None:
        """Return a scenario in which an instruction comes on; None if the solver finds none."""
        point = RungPoint(number, PointState.ON)
        self.questions += 1
        if way in (NEAR, FAR):
            longest_ns = self._near_ns if way == NEAR else FAR_NS
            found = scenario_to(self._job, point, limits=LIMITS, longest_ns=longest_ns)
            return None if found is None else found.scenario
        fresh = (each for each in entries if (number, repr(each.scenario)) not in self._begun)
        entry = next(fresh, None)
        if entry is None:
            return None
        self._begun.add((number, repr(entry.scenario)))
        return self._on_from(entry, point)

    def _on_from(self, entry: Entry, point: RungPoint) -> Scenario | None:
        """Return an entry's scenario up to its last new feature, with what then brings an instruction on."""
        scans = entry.points[-1] + 1
        at_ns = scans * self._bench.spec.scan_ns
        before = _until(entry.scenario, scans - 1, self._bench.spec.scan_ns)
        engine = _state_after(self._bench, before, scans)
        if engine is None:
            return None
        found = scenario_to(self._job, point, engine, at_ns, LIMITS, self._near_ns)
        return None if found is None else scenario_of([*parts_of(before), *parts_of(found.scenario)])

    def _open(self, state: State) -> list[int]:
        """Return instructions that were never on and are not proved dead, the first ones of their rungs.

        Those with fewer questions so far come first.
        """
        sites = self._lowered.sites
        rungs: dict[tuple[str, str], int] = {}
        for each in self.gaps(reached(self._job, state.kept.seen)):
            if each.number is not None and self._tried[each.number] < WAYS:
                site = sites[each.number]
                rungs.setdefault((site.routine, site.place), each.number)
        return sorted(rungs.values(), key=lambda number: (self._tried[number], number))[:AT_ONCE]

    @cached_property
    def dead_points(self) -> tuple[DeadPoint, ...]:
        """The states that are proved impossible: one proof for a session."""
        return dead(self._job)

    @cached_property
    def _lowered(self) -> LoweredProgram:
        assert isinstance(self._job.logic, LadderLogic)
        return self._job.logic.compile().lowered

    @cached_property
    def _near_ns(self) -> int:
        """The longest scan that tells apart what happens within the program's times."""
        times = times_of(self._bench.fresh_logic(), self._bench.spec.scan_ns, self._bench.scans)
        return min(FAR_NS, max(LONGEST_NS, min(times, default=0) // PART))

    @property
    def dead(self) -> frozenset[int]:
        """The instructions that are proved never to be on."""
        return frozenset(each.point.number for each in self.dead_points if each.state is PointState.ON)

    def gaps(self, found: ProgramReach) -> tuple[Gap, ...]:
        """Return the gaps of a campaign, without those that are proved dead."""
        return tuple(each for each in found.gaps if each.number is None or each.number not in self.dead)


def _steps(state: State) -> list[Entry]:
    """Return the entries with a new step of the program, the newest first."""
    entries = [each for each in reversed(state.kept.entries) if each.worth >= STEP_WORTH and each.points[-1]]
    return entries[:STATES]


def _until(scenario: Scenario, scan: int, scan_ns: int) -> Scenario:
    """Return what has begun until a scan; contacts are released then."""
    end_ns = (scan + 1) * scan_ns
    return scenario_of(
        (name, replace(part, for_ns=min(part.for_ns, end_ns - part.at_ns)) if _is_held(part) else part)
        for name, part in parts_of(cut(scenario, scan, scan_ns))
    )


def _is_held(part: object) -> bool:
    return isinstance(part, Press | ContactPress)


def _state_after(bench: TrialBench, scenario: Scenario, scans: int) -> Engine | None:
    """Run a number of scans; return the engine, None if something is broken until then."""
    made: list[ScanLogic] = []

    def fresh_logic() -> ScanLogic:
        made.append(bench.fresh_logic())
        return made[-1]

    verdict = replace(bench, fresh_logic=fresh_logic, scans=scans).run(scenario)
    inside = unwrapped(made[0])
    return inside if verdict.broken is None and isinstance(inside, Engine) else None
