"""Asks the solver how to turn on contacts and coils that were never on, when a search finds nothing new.

The solver gets several questions about each instruction, one at a time:

    near     from power-up, in scans of up to a third of the program's shortest time, at least 20 ms
    on       in scans of that length, from a state in which a corpus entry showed a new feature, newest first
    far      from power-up, in scans of up to 1 s, for slow processes
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from scanrack.io_images.site import Site
from scanrack.ladder import LadderLogic
from scanrack.ladder.prove.questions.points import SEARCH, PointState, RungPoint
from scanrack.ladder.prove.solving.solver import is_installed
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import LoweredProgram

from ...fuzz.aim.corpus import STEP_WORTH, Entry, cut
from ...fuzz.aim.edges import Edges
from ...fuzz.aim.probe import Probe
from ...fuzz.aim.times import times_of
from ...fuzz.campaign.state import State
from ...fuzz.reached import Gap, ProgramReach, reached
from ...fuzz.run import TrialBench
from ...fuzz.scenarios.parts import parts_of, scenario_of
from ...fuzz.scenarios.scenario import ContactPress, Press, Scenario
from ...load.loading import LoadedRack
from ...record.logic_wrapper import unwrapped
from .aims import LONGEST_NS, dead, scenario_to

PATIENCE = 200
"""Number of runs without a new feature before the first question."""

AT_ONCE = 4
"""Number of questions on different rungs before the search continues. An answer can reach other rungs."""

NEAR, FAR = 0, 2
"""Numbers of the near and far questions about an instruction; all others are "on"."""

STATES = 3
"""Maximum number of entries from which "on" begins."""

QUESTIONS = 5
"""Number of questions about each instruction."""

LIMITS = replace(SEARCH, scans=40, work=2_000_000)
"""Limits of a question, for an answer within about 2 s."""

PART = 3
"""Number of scans into which the shortest time of a program is divided."""

FAR_NS = 1_000_000_000
"""Longest scan of a far question, ns."""


class SolverStep:
    """Asks the solver how to reach instructions that a campaign has not reached; asks each question once.

    Call it between two rounds. The questions do not depend on time, so they are the same on every machine.

    Args:
        bench: runs entries of the corpus up to the states from which "on" begins.

    Attributes:
        questions: number of questions asked.
        answered: number of scenarios found.
    """

    def __init__(self, job: LoadedRack, bench: TrialBench, patience: int = PATIENCE) -> None:
        self._job, self._bench, self._patience = job, bench, patience
        self._question_counts: Counter[int] = Counter()  # number of questions about each instruction
        self._begun: set[tuple[int, str]] = set()  # instructions, each with an entry from which "on" began
        self.questions = self.answered = 0

    def __call__(self, state: State) -> tuple[Scenario, ...]:
        """Ask some questions if the last runs found nothing new; return the scenarios found."""
        if state.stale < self._patience or not self.can_ask:
            return ()
        scenarios = tuple(dict.fromkeys(self._answers(state)))
        self.answered += len(scenarios)
        return scenarios

    @property
    def can_ask(self) -> bool:
        """Whether a solver is installed, and the program is ladder logic."""
        return isinstance(self._job.logic, LadderLogic) and is_installed()

    def _answers(self, state: State) -> Iterator[Scenario]:
        """Ask the next question about several open instructions, one for each; yield the scenarios found."""
        entries = _step_entries(state)
        for number in self._open(state):
            question = self._question_counts[number]
            self._question_counts[number] += 1
            scenario = self._solve(number, question, entries)
            if scenario is not None and scenario.size:
                yield scenario

    def _solve(self, number: int, question: int, entries: list[Entry]) -> Scenario | None:
        """Return a scenario that turns an instruction on; None if the solver finds no scenario."""
        point = RungPoint(number, PointState.ON)
        self.questions += 1
        if question in (NEAR, FAR):
            longest_ns = self._near_ns if question == NEAR else FAR_NS
            return scenario_to(self._job, point, limits=LIMITS, longest_ns=longest_ns)
        for entry in entries:
            begin = (number, repr(entry.scenario))
            if begin not in self._begun:
                self._begun.add(begin)
                return self._on_from(entry, point)
        return None

    def _on_from(self, entry: Entry, point: RungPoint) -> Scenario | None:
        """Return an entry's scenario up to its last new feature, extended to turn an instruction on."""
        scans = entry.points[-1] + 1
        at_ns = scans * self._bench.spec.scan_ns
        before = _until(entry.scenario, scans - 1, self._bench.spec.scan_ns)
        engine = _state_after(self._bench, before, scans)
        if engine is None:
            return None
        continuation = scenario_to(self._job, point, engine, at_ns, LIMITS, self._near_ns)
        return None if continuation is None else scenario_of([*parts_of(before), *parts_of(continuation)])

    def _open(self, state: State) -> list[int]:
        """Return the first open instruction of each rung: never on, and not proved dead.

        Instructions with fewer questions so far come first.
        """
        sites = self._lowered.sites
        by_rung: dict[tuple[str, str], int] = {}
        for gap in self.gaps(reached(self._job, state.kept.seen)):
            if gap.number is not None and self._question_counts[gap.number] < QUESTIONS:
                site = sites[gap.number]
                by_rung.setdefault((site.routine, site.place), gap.number)
        return sorted(by_rung.values(), key=lambda number: (self._question_counts[number], number))[:AT_ONCE]

    @cached_property
    def dead_points(self) -> dict[RungPoint, Site]:
        """The points that are proved unreachable, with their places; they are computed once per session."""
        return dead(self._job)

    @cached_property
    def _lowered(self) -> LoweredProgram:
        assert isinstance(self._job.logic, LadderLogic)
        return self._job.logic.compile().lowered

    @cached_property
    def _near_ns(self) -> int:
        """The longest scan that is short compared with the program's times, see `PART`, ns."""
        times = times_of(self._bench.fresh_logic(), self._bench.spec.scan_ns, self._bench.scans)
        return min(FAR_NS, max(LONGEST_NS, min(times, default=0) // PART))

    @property
    def dead(self) -> frozenset[int]:
        """The instructions that are proved to be never on."""
        return frozenset(point.number for point in self.dead_points if point.state is PointState.ON)

    def gaps(self, found: ProgramReach) -> tuple[Gap, ...]:
        """Return the gaps of a campaign without the instructions that are proved dead."""
        return tuple(gap for gap in found.gaps if gap.number is None or gap.number not in self.dead)


def _step_entries(state: State) -> list[Entry]:
    """Return the last entries that showed a new step of the program, newest first."""
    entries = [
        entry for entry in reversed(state.kept.entries) if entry.worth >= STEP_WORTH and entry.points[-1]
    ]
    return entries[:STATES]


def _until(scenario: Scenario, scan: int, scan_ns: int) -> Scenario:
    """Return the parts of a scenario that begin before the end of a scan; presses end with this scan."""
    end_ns = (scan + 1) * scan_ns
    named_parts = []
    for name, part in parts_of(cut(scenario, scan, scan_ns)):
        if isinstance(part, Press | ContactPress):
            part = replace(part, for_ns=min(part.for_ns, end_ns - part.at_ns))
        named_parts.append((name, part))
    return scenario_of(named_parts)


def _state_after(bench: TrialBench, scenario: Scenario, scans: int) -> Engine | None:
    """Run a number of scans; return the engine, or None if an invariant was broken before then."""
    probe = Probe(Edges())
    verdict = replace(bench, scans=scans).run(scenario, probe=probe)
    engine = unwrapped(probe.logic)
    return engine if verdict.broken is None and isinstance(engine, Engine) else None
