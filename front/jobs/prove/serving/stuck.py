"""What a search asks when it finds nothing new: how contacts and coils that were never on come on."""

from __future__ import annotations

from collections.abc import Iterator

from ....ladder import LadderLogic
from ....ladder.prove.questions.points import PointState, RungPoint
from ....ladder.prove.solving.solver import is_installed
from ...fuzz.campaign.state import State
from ...fuzz.reached import Gap, reached
from ...fuzz.scenarios.scenario import Scenario
from ...load.loading import Job
from .aims import dead, scenario_to

PATIENCE = 200
"""Runs that bring nothing new before something is asked."""

AT_ONCE = 4
"""Instructions that are asked for before the search goes on: their answers may bring others."""


class SolverStep:
    """Asks for what a campaign has not reached, one instruction after the other; each once.

    Call it between two rounds. Nothing depends on time: the same campaign asks the same on every machine.

    Attributes:
        asked: number of instructions that were asked for.
        answered: number of scenarios that came of it.
    """

    def __init__(self, job: Job, patience: int = PATIENCE) -> None:
        self._job, self._patience = job, patience
        self._done: set[int] = set()
        self._dead: frozenset[int] | None = None
        self.asked = self.answered = 0

    def __call__(self, state: State) -> tuple[Scenario, ...]:
        """Return scenarios to run if the last runs have brought nothing new; () otherwise."""
        if state.stale < self._patience or not self.can_ask:
            return ()
        found = tuple(self._answers(state))
        self.answered += len(found)
        return found

    @property
    def can_ask(self) -> bool:
        """Whether there are rungs to ask about, and a solver."""
        return isinstance(self._job.logic, LadderLogic) and is_installed()

    def _answers(self, state: State) -> Iterator[Scenario]:
        for number in self._open(state)[:AT_ONCE]:
            self._done.add(number)
            self.asked += 1
            answer = scenario_to(self._job, RungPoint(number, PointState.ON))
            if answer is not None and answer.scenario.size:
                yield answer.scenario

    def _open(self, state: State) -> list[int]:
        """Return the instructions that were never on, are not proved dead and were not asked for."""
        gaps = reached(self._job, state.kept.seen).gaps
        numbers = [each.number for each in gaps if each.number is not None]
        return [each for each in numbers if each not in self._done and each not in self.dead]

    @property
    def dead(self) -> frozenset[int]:
        """The instructions that are proved never to be on."""
        if self._dead is None:
            proved = dead(self._job) if self.can_ask else ()
            self._dead = frozenset(each.point.number for each in proved if each.state is PointState.ON)
        return self._dead

    def gaps(self, state: State) -> tuple[Gap, ...]:
        """Return what a campaign has not reached, without what is proved dead."""
        gaps = reached(self._job, state.kept.seen).gaps
        return tuple(each for each in gaps if each.number is None or each.number not in self.dead)
