"""Finds the instant from which a failure is inevitable.

The beginning of the failing run is kept, and the actions after it are drawn many times. The search narrows
the interval in which the share of failing futures rises most, until it lies between two scans.

    scan          -1    2    4    5    6   12
    fail of 40     0    0    0   37   38   40        inevitable from scan 5

Only inputs are drawn, not links or power: a power cycle would end most failures and hide the step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from random import Random
from typing import Any

from scanrack.io_images.times import seconds

from ..aim.corpus import cut
from ..aim.draws import Draws
from ..run import BrokenInvariant, TrialBench
from ..scenarios.kinds import Kind
from ..scenarios.parts import Lasting, parts_of, scenario_of, with_part
from ..scenarios.scenario import Scenario
from ..search import Counterexample, all_but
from .changes import changes_in

FUTURES = 40
"""Number of futures that are run after a scan."""

PILOT = 10
"""Number of futures per scan during the search; the two scans around the rise get `FUTURES`."""

CLEAR = 30
"""Least rise of failing futures in one scan that counts as a clear instant."""

MOST_SAMPLED = 24
"""Largest number of scans after which futures are drawn."""

FAR, MOST_EVENTS = 300, 4
"""Scans within which the events of a future begin, most of them early; and the most events."""

LEAST_JUDGED = 20
"""Fewest scans that a future runs past the scan of the failure; otherwise half the way there."""

ENDS = (1, 2, 10, 100, 1000)
"""Numbers of scans after which an active event may end."""


@dataclass(frozen=True, slots=True)
class PointOfNoReturn:
    """The rise in the share of failing futures.

    Attributes:
        before: the last scan after which few futures fail; -1 is the time before power-up.
        scan: the first scan after which many futures fail; `before` + 1 unless the search hit its limit.
        now_ns: time of `scan`, ns since power-up.
        few, many: number of futures that fail after `before` and after `scan`.
        first: number of futures that fail after power-up; equal to `few` if the instant is clear.
        changes: sentences about the changes in `scan`.
    """

    before: int
    scan: int
    now_ns: int
    few: int
    many: int
    first: int
    changes: tuple[str, ...] = ()

    @property
    def is_from_the_start(self) -> bool:
        """Whether most futures fail right after power-up."""
        return self.first >= CLEAR

    @property
    def is_clear(self) -> bool:
        """Whether there is a clear instant: in one scan, most of the futures begin to fail."""
        return self.scan == self.before + 1 and self.many - self.few >= CLEAR

    @property
    def lines(self) -> list[str]:
        """The lines of a report."""
        if self.is_from_the_start:
            return [f"from power-up on {self.many} of {FUTURES} futures break it"]
        if not self.is_clear:
            since = f"{self.first} of {FUTURES} futures break it from 0 s"
            return [f"no single instant: {since}, {self.many} from {seconds(self.now_ns)} s on"]
        few = f"{self.few or 'no'} future{'s' if self.few > 1 else ''} of {FUTURES}"
        breaks = "break" if self.few > 1 else "breaks"
        text = f"up to scan {self.before} {few} {breaks} it, from scan {self.scan}"
        text += f" ({seconds(self.now_ns)} s) on {self.many} do"
        return [text + (":" if self.changes else ""), *(f"  {change}" for change in self.changes)]


class _OutOfTimeError(Exception):
    """Raised when time runs out in the search for the instant."""


def find_point_of_no_return(
    bench: TrialBench, found: Counterexample, seed: int = 1, has_time: Callable[[], bool] = lambda: True
) -> PointOfNoReturn | None:
    """Return where a failure became inevitable, after 100 to 250 runs; None if there was no time for them.

    Args:
        seed: the same seed draws the same futures.
        has_time: returns whether there is time left; called before every run.
    """
    try:
        return _locate(bench, found, _Futures(bench, found, seed, has_time))
    except _OutOfTimeError:
        return None


def _locate(bench: TrialBench, found: Counterexample, futures: _Futures) -> PointOfNoReturn:
    failing = {-1: futures.failing_after(-1, PILOT), found.broken.scan: PILOT}
    if failing[-1] * FUTURES >= CLEAR * PILOT and (first := futures.failing_after(-1)) >= CLEAR:
        return PointOfNoReturn(-1, 0, 0, 0, first, first)
    while len(failing) < MOST_SAMPLED:
        before, scan = _steepest(failing)
        if scan - before == 1:
            break
        middle = (before + scan) // 2
        failing[middle] = futures.failing_after(middle, PILOT)
    before, scan = _steepest(failing)
    few = futures.failing_after(before)
    many = FUTURES if scan == found.broken.scan else futures.failing_after(scan)
    first = few if many - few >= CLEAR else futures.failing_after(-1)
    changes = changes_in(bench, found.scenario, scan)
    return PointOfNoReturn(before, scan, scan * bench.spec.scan_ns, few, many, first, changes)


def _steepest(failing: dict[int, int]) -> tuple[int, int]:
    """Return the two scans between which the share rises most; of equal rises, the widest apart."""
    pairs = list(pairwise(sorted(failing)))
    return max(pairs, key=lambda pair: (failing[pair[1]] - failing[pair[0]], pair[1] - pair[0]))


class _Futures:
    """The futures of a failing run."""

    def __init__(
        self, bench: TrialBench, found: Counterexample, seed: int, has_time: Callable[[], bool]
    ) -> None:
        self._bench, self._found, self._seed, self._has_time = bench, found, seed, has_time
        self._others = all_but(bench, found.broken, ()) - {found.broken.key}

        self._fail: dict[int, list[bool]] = {}
        self._futures: dict[int, Iterator[bool]] = {}

    def failing_after(self, scan: int, futures: int = FUTURES) -> int:
        """Return how many futures after a scan break the same invariant; run futures that have not run yet.

        Args:
            futures: number of futures; a larger number adds futures to the same sequence.
        """
        known_outcomes = self._fail.setdefault(scan, [])
        outcomes = self._futures.setdefault(scan, self._run_after(scan))
        known_outcomes += islice(outcomes, max(0, futures - len(known_outcomes)))
        return sum(known_outcomes[:futures])

    def _run_after(self, scan: int) -> Iterator[bool]:
        """Run one future after the other and yield whether it fails; the first has no new events."""
        broken: BrokenInvariant = self._found.broken
        judged = broken.scan + max(LEAST_JUDGED, (broken.scan - scan) // 2)
        bench = replace(self._bench, scans=min(self._bench.scans, judged))
        random = Random(self._seed * 1_000_003 + scan)
        draws = Draws(bench.spec, bench.scans, (Kind.INPUTS,), random)
        future = beginning = cut(self._found.scenario, scan, bench.spec.scan_ns)
        while True:
            if not self._has_time():
                raise _OutOfTimeError
            yield bench.run(future, without=self._others).broken is not None
            future = _with_future(beginning, scan, draws, random)


def _with_future(beginning: Scenario, scan: int, draws: Draws, random: Random) -> Scenario:
    """Return a beginning with a random future: active events end at random times, and others begin."""
    future = scenario_of((name, _ended(part, scan, draws, random)) for name, part in parts_of(beginning))
    for _ in range(random.randint(0, MOST_EVENTS)):
        later = scan + int(FAR ** random.random())
        if later < draws.scans and (part := draws.event(later)) is not None:
            future = with_part(future, part)
    return future


def _ended(part: Any, scan: int, draws: Draws, random: Random) -> Any:
    now_ns = scan * draws.scan_ns
    if not isinstance(part, Lasting) or part.at_ns + part.for_ns <= now_ns or not part.for_ns:
        return part
    return replace(part, for_ns=now_ns + random.choice(ENDS) * draws.scan_ns - part.at_ns)
